"""What a scene says of its first configuration: what decides it, what it costs, who makes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dpd.digest import value_digest

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

FLIGHT = 0.8  # r_c, a step of a random flight where bonds have no rest length
SMALL = 0.1  # of a run's steps: a start that takes no more is made by the run itself


def start_description(scene: Scene) -> dict[str, Any]:
    """The part of a scene that decides its first configuration, as plain data.

    Runs whose descriptions agree share one start.
    """
    data, start = scene.data, scene.data["start"]
    kept = {
        "dimension": data["dimension"],
        "box": list(scene.box),
        "molecules": data["molecules"],
        "method": start["method"],
        "kT": start.get("kT", data["thermostat"]["kT"]),
        "seed": start.get("seed", data["seed"]),
    }
    if grows(scene):
        kept["polymerize"] = start["polymerize"]
    elif "bond" in data:
        kept["flight"] = float(data["bond"]["length"]) or FLIGHT
    if "relax" in start:
        kept["relax"] = start["relax"]
    if "relax" in start or grows(scene):
        kept["forces"] = start_forces(scene)
        kept["thermostat"] = data["thermostat"]["kT"]
    return kept


def start_digest(scene: Scene) -> str:
    """Digest of what decides the first configuration of a scene."""
    return value_digest(start_description(scene))


def start_forces(scene: Scene) -> dict[str, Any]:
    """Forces of growth and relaxation: those of the scene, but for start.forces."""
    data, changed = scene.data, scene.data["start"]["forces"]
    forces = {"repulsion": data["repulsion"]}
    for name in ("core", "bond"):
        if name in data or name in changed:
            forces[name] = data.get(name, {}) | changed.get(name, {})
    forces["gamma"] = changed.get("gamma", data["thermostat"]["gamma"])
    return forces


def start_work(scene: Scene) -> int:
    """Beads to bond and steps to relax, which progress counts; 0 if beads are only placed."""
    return (scene.beads if grows(scene) else 0) + _relaxing(scene)


def start_is_shared(scene: Scene) -> bool:
    """Whether a job of its own makes the first configuration, for all runs that begin with it.

    So it is where chains grow, or where it takes more than a tenth of the run's steps. Less is
    not worth a job: the run makes its own. This looks at the one scene alone: that other runs
    come and go leaves what was run as it is.
    """
    return grows(scene) or _relaxing(scene) > SMALL * sum(scene.steps)


def grows(scene: Scene) -> bool:
    """Whether the chains of a scene grow from monomers."""
    return scene.data["start"]["method"] == "polymerize"


def _relaxing(scene):
    """Steps of relaxation."""
    return scene.data["start"].get("relax", {}).get("steps", 0)
