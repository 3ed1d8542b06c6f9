"""Which kernels a study needs, compiled before its runs."""

from dpd.engine.simulation import Simulation
from dpd.observe import observables
from dpd.physics.core import Core
from dpd.stages import start_terms, terms_of
from dpd.start.make import system_of
from dpd.start.quick import compile_start


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
        simulation = Simulation(system, compile_start(scene))
        for observer in observables(scene, system):
            observer.sample(simulation, simulation.measure())
    return [", ".join(variant) for variant in smallest]


def with_terms(scenes, terms):
    """The scenes in which just these terms of the physics act; or only as they start, if none.

    Parameters
    ----------
    scenes : list of Scene
    terms : frozenset of str
        Keys of `dpd.stages.TERMS`.

    Returns
    -------
    list of Scene
    """
    acting = [scene for scene in scenes if terms_of(scene) == terms]
    return acting or [scene for scene in scenes if start_terms(scene) == terms]


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
