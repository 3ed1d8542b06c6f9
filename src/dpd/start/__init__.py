"""First configurations: what decides one, what it costs, and who makes it."""

from typing import Any

from dpd.digests import value_digest
from dpd.page import PairForce
from dpd.scene.scene import Scene

BYTES_PER_BEAD = 312  # of memory in a run, measured; with DPD-VV and a list 750


def start_description(scene: Scene) -> dict[str, Any]:
    """What decides the first configuration of a scene; where this agrees, runs share it."""
    data, start = scene.data, scene.start
    decides = {
        "dimension": data["dimension"],
        "box": list(scene.box),
        "molecules": data["molecules"],
        "method": start.method,
        "kT": scene.kT if start.kT is None else start.kT,
        "seed": data["seed"] if start.seed is None else start.seed,
    }
    if "mass" in data:
        decides["mass"] = data["mass"]
    if scene.ended:
        decides["between"] = [list(scene.ended), *(scene.origin[axis] for axis in scene.ended)]
    decides |= start.decides(scene)
    module = type(start).__module__
    if not module.startswith("dpd."):  # of a user's own, whose name ends with the file's digest
        decides["page"] = module.rpartition("_")[2]
    if start.relax:
        decides["relax"] = data["start"]["relax"]
    if start.acts:
        own = {key: each for key, each in scene.start_terms.items() if isinstance(each, PairForce)}
        if own:
            decides["own"] = {key: term.content() for key, term in own.items()}
        forces = {key: each.plain() for key, each in scene.start_terms.items() if key not in own}
        gamma = data["thermostat"]["gamma"] if start.forces.gamma is None else start.forces.gamma
        decides["forces"] = {"repulsion": scene.repulsions, "gamma": gamma} | forces
        decides["thermostat"] = scene.kT
    return decides


def start_digest(scene: Scene) -> str:
    """Digest of what decides the first configuration of a scene."""
    return value_digest(start_description(scene))


def start_work(scene: Scene) -> int:
    """Beads to bond and steps to relax, which progress counts; 0 if beads are only placed."""
    return (scene.beads if scene.start.work else 0) + scene.relaxing
