"""Which kernels a study needs, compiled before its runs."""

from dpd.engine.simulation import Simulation
from dpd.observe import observables
from dpd.physics.core import Core
from dpd.scene.scene import Scene
from dpd.start.make import make_start, system_of


def compile_for(scenes):
    """Compile every variant of the kernels that some scenes need, into the disk cache.

    All in one process: most of what a variant is made of is that of others, and what a process
    has compiled once it does not compile again.

    Parameters
    ----------
    scenes : list of Scene

    Returns
    -------
    list of str
        One line per variant.
    """
    smallest = {}
    for scene in scenes:
        variant = (*_kernels(scene), *scene.observe)
        if scene.beads < smallest.setdefault(variant, scene).beads:
            smallest[variant] = scene
    for scene in smallest.values():
        system = system_of(scene)
        simulation = Simulation(system, make_start(_barely_relaxed(quick_to_start(scene))))
        for observer in observables(scene, system):
            observer.sample(simulation, simulation.measure())
    return [", ".join(variant) for variant in smallest]


def _kernels(scene):
    """What decides which kernels of the engine a scene needs, in words."""
    system = system_of(scene)
    core = "core" if isinstance(system.pair, Core) else "no core"
    return (
        f"{scene.dimension} dimensions",
        "several species" if len(scene.species) > 1 else "one species",
        "bonds" if "bond" in scene.data else "no bonds",
        f"smooth {core}" if getattr(system.pair, "width", None) else core,
        scene.data["thermostat"]["kind"],
        _friction(scene, system),
        "list" if scene.skin else "cells",
    )


def _friction(scene, system):
    """How the scheme takes friction, as far as it is compiled apart."""
    if system.scheme.exchange is not None:
        return scene.data["integrator"]["scheme"]
    if system.scheme.renewal:
        return "friction twice"
    return "friction once" if system.scheme.prediction is None else "predicted friction"


def _barely_relaxed(scene):
    """A scene whose start takes one step where it takes any, which is enough to compile it."""
    start = scene.data["start"]
    if "relax" not in start:
        return scene
    return Scene(
        scene.data | {"start": start | {"relax": start["relax"] | {"steps": 1}}}, scene.where
    )


def quick_to_start(scene, grow=True):
    """A scene with a start that needs no growth; where there is one, grow a small melt apart.

    Parameters
    ----------
    scene : Scene
    grow : bool
        Whether to grow the small melt, which compiles growth.
    """
    start = scene.data["start"]
    if start["method"] != "polymerize":
        return scene
    if grow:
        kinds = [
            {"architecture": " ".join(sorted(set(kind.beads)) * 2), "count": 32}
            for kind in scene.molecules
        ]
        small = {"box": 8, "molecules": kinds, "observe": ["thermo"]}
        make_start(Scene(scene.data | small, scene.where))
    random = {"method": "random", "seed": start.get("seed", 1)}
    return Scene(scene.data | {"start": random}, scene.where)
