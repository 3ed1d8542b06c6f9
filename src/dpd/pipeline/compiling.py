"""Which kernels a study needs, compiled before its runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.observe.common.measured import observables
from dpd.stages import kernels_name
from dpd.start.common.make import compile_start, system_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from dpd.scene.scene import Scene


def compile_for(scenes: Iterable[Scene]) -> list[str]:
    """Compile every variant of the kernels that some scenes need; a line on each.

    All in one process: most of what a variant is made of is that of others, and what a process
    has compiled once it does not compile again.
    """
    smallest: dict[tuple[str, ...], Scene] = {}
    for scene in [stage.scene for each in scenes for stage in each.stages]:
        variant = (*_kernels(scene), *scene.observe)
        if scene.beads < smallest.setdefault(variant, scene).beads:
            smallest[variant] = scene
    for scene in smallest.values():
        simulation = Simulation(system_of(scene), compile_start(scene))
        for observer in observables(scene, simulation.system, None, simulation.state):
            if hasattr(observer, "record"):  # sums, which the loop adds up
                continue
            observer.sample(simulation)
            if 2 * observer.every <= scene.steps.sample:  # some compare a sample with that before
                observer.sample(simulation)
    return [", ".join(variant) for variant in smallest]


def with_kernels(scenes: Sequence[Scene], name: str) -> list[Scene]:
    """The scenes that need the kernels of a name; or whose starts do, if none."""
    for of_start in (False, True):
        if found := [scene for scene in scenes if kernels_name(scene, of_start) == name]:
            return found
    raise UserError(f"--kernels: no scene needs {name!r}; leave it out, and all are compiled")


def _kernels(scene):
    """What decides which kernels of the engine a scene needs, in words.

    Numba compiles a kernel for each class of a record, and for which of its fields are None.
    """
    system = system_of(scene)
    return (
        f"{scene.dimension} dimensions",
        "several species" if len(scene.species) > 1 else "one species",
        *(_kind(term) for term in system.forces if term is not None),
        _kind(system.scheme),
        "list" if scene.skin else "cells",
    )


def _kind(record):
    """The class of a record, and what it goes without."""
    absent = [name for name, value in record._asdict().items() if value is None]
    name = type(record).__name__
    return f"{name} without {' and '.join(absent)}" if absent else name
