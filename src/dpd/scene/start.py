"""What a scene says of its first configuration: what decides it, what it costs, who makes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dpd.digest import value_digest

if TYPE_CHECKING:
    from dpd.page import BondForce
    from dpd.scene.scene import Scene

SMALL = 0.1  # of a run's steps: a start that takes no more is made by the run itself


def start_description(scene: Scene) -> dict[str, Any]:
    """The part of a scene that decides its first configuration, as plain data.

    Runs whose descriptions agree share one start.
    """
    data, start = scene.data, scene.start
    seed, kT = (
        given if given is not None else of_run
        for given, of_run in ((start.seed, data["seed"]), (start.kT, data["thermostat"]["kT"]))
    )
    kept = {
        "dimension": data["dimension"],
        "box": list(scene.box),
        "molecules": data["molecules"],
        "method": start.method,
        "kT": kT,
        "seed": seed,
    }
    if "mass" in data:
        kept["mass"] = data["mass"]
    if scene.ended:
        kept["between"] = [list(scene.ended), *(scene.origin[axis] for axis in scene.ended)]
    kept |= start.decides(scene)
    module = type(start).__module__
    if not module.startswith("dpd."):  # of a user's own, whose name ends with the file's digest
        kept["page"] = module.rpartition("_")[2]
    if start.relax:
        kept["relax"] = data["start"]["relax"]
    if start.acts:
        if scene.own_forces:
            kept["own"] = {term.key: term.content() for term in scene.own_forces}
        kept["forces"] = start_forces(scene)
        kept["thermostat"] = data["thermostat"]["kT"]
    return kept


def start_digest(scene: Scene) -> str:
    """Digest of what decides the first configuration of a scene."""
    return value_digest(start_description(scene))


def start_forces(scene: Scene) -> dict[str, Any]:
    """Forces of growth and relaxation: those of the scene, but for start.forces."""
    data, changed = scene.data, scene.data["start"]["forces"]
    forces = {"repulsion": scene.repulsions}
    forces |= {key: data[key] for key, term in scene.terms.items() if term.in_start}
    if "core" in data or "core" in changed:
        forces["core"] = data.get("core", {}) | changed.get("core", {})
    if (bond := start_bond(scene)) is not None:
        forces[bond.key] = bond.plain()
    if "angle" in data and "angle" not in scene.start.without:
        forces["angle"] = data["angle"]
    forces["gamma"] = changed.get("gamma", data["thermostat"]["gamma"])
    return forces


def start_bond(scene: Scene) -> BondForce | None:
    """What acts along bonds while chains grow or relax: that of the scene, with its changes."""
    bond = scene.bond_force
    if bond is None or bond.key not in (changes := scene.data["start"]["forces"]):
        return bond
    changed = bond.changed(changes[bond.key])
    return bond.model_validate({bond.bare: changed} if bond.bare else changed)


def start_work(scene: Scene) -> int:
    """Beads to bond and steps to relax, which progress counts; 0 if beads are only placed."""
    return (scene.beads if scene.start.work else 0) + relaxing(scene)


def start_is_shared(scene: Scene) -> bool:
    """Whether a job of its own makes the first configuration, for all runs that begin with it.

    So it is where it takes `work`, as where chains grow, or more than a tenth of the run's steps.
    Less is not worth a job: the run makes its own. This looks at the one scene alone: that other
    runs come and go leaves what was run as it is.
    """
    return bool(scene.start.work) or relaxing(scene) > SMALL * sum(scene.steps)


def relaxing(scene: Scene) -> int:
    """Steps of relaxation of a scene's first configuration."""
    return scene.start.relax.steps if scene.start.relax else 0
