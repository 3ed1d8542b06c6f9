"""An engine with the code of every feature cut out, to see what the whole one pays for them.

Numba compiles a kernel with what its globals are at that moment. In a process of its own,
before anything is compiled, the parts of all features that a bare fluid does not use are
replaced by empty ones; what is compiled then is a loop over steps that knows nothing else.
"""

from __future__ import annotations

import os
from contextlib import contextmanager
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.connection import Connection
    from pathlib import Path

    from dpd.engine.state import State
    from dpd.scene.scene import Scene


class Engine:
    """A simulation in a process of its own.

    Parameters
    ----------
    scene : Scene
        A bare fluid, where the engine is stripped.
    start : State
    stripped : bool
        Whether to cut the features out first.
    folder : path
        Of compiled kernels, for engines of one kind only. Where it is empty the first answer
        waits for them.
    """

    def __init__(self, scene: Scene, start: State, stripped: bool, folder: str | Path) -> None:
        here = get_context("spawn")
        self._pipe, theirs = here.Pipe()
        self._process = here.Process(target=serve, args=(theirs, scene, start, stripped))
        with _cache_in(folder):
            self._process.start()
        theirs.close()

    def _ask(self, question, *arguments):
        self._pipe.send((question, *arguments))
        return self._pipe.recv()

    def advance(self, steps: int) -> float:
        """Seconds that so many steps took."""
        return self._ask("advance", steps)

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, velocities and identities, in storage order."""
        return self._ask("state")

    def code_size(self) -> int:
        """Bytes of machine code of the loop over steps; of the engine that compiled it only."""
        return self._ask("code_size")

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join()


@contextmanager
def _cache_in(folder):
    """Let processes that start now keep their compiled kernels there."""
    kept = os.environ["NUMBA_CACHE_DIR"]
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    try:
        yield
    finally:
        os.environ["NUMBA_CACHE_DIR"] = kept


def serve(pipe: Connection, scene: Scene, start: State, stripped: bool) -> None:
    """Answer an `Engine` until it closes the pipe."""
    if stripped:
        strip()
    from dpd.benchmark.timing import seconds_of, simulation_of
    from dpd.engine.step import advance

    simulation = simulation_of(scene, start)
    while True:
        try:
            question, *arguments = pipe.recv()
        except EOFError:
            return
        state = simulation.state
        if question == "advance":
            pipe.send(seconds_of(simulation.advance, *arguments))
        elif question == "state":
            pipe.send((state.position, state.velocity, state.identity))
        else:
            pipe.send(code_size(advance))


def code_size(kernel: Any) -> int:
    """Bytes of the object code of the variants of a kernel that this process has compiled."""
    return sum(len(variant.library._get_compiled_object()) for variant in kernel.overloads.values())


def strip() -> None:
    """Put empty parts in the place of every feature; before any kernel is compiled."""
    from dpd.engine import moves, pair_forces, second_friction, step, thermostats
    from dpd.engine.neighbours import cells, lists

    for module in (step, moves, pair_forces, second_friction, thermostats, cells, lists):
        for name, replacement in empty_parts().items():
            if hasattr(module, name):
                setattr(module, name, replacement)


def empty_parts() -> dict[str, Callable[..., Any]]:
    """Name to what takes its place: for species, bonds, core, lists, baths, virial, teams."""
    from dpd.jit import inlined

    @inlined()
    def nothing(*arguments):
        return None

    @inlined()
    def no_number(*arguments):
        return 0

    @inlined()
    def no_limit(*arguments):
        return np.inf

    @inlined()
    def given_velocity(velocity, predicted):
        return velocity

    @inlined()
    def one_repulsion(pairs, p, species, pair):
        return pair.repulsion[0, 0]

    empty = (
        "add_bonds", "find_slots",  # bonds
        "gather_repulsion", "copy_species",  # species
        "add_langevin",  # a thermostat on single beads
        "add_external",  # walls and body forces
        "gaussian_noise",
        "empty_list", "renewed_list", "add_listed",  # lists
        "empty_touching", "emptied", "with_pairs", "close_phase",  # pairs that are needed again
        "take_friction_again", "copy_predicted", "predict", "exchange_momentum",  # other schemes
        "measure_pairs",  # virial
        "slide_to", "drift_with_flow", "add_flow_between",  # shear
        "meet",  # threads
    )  # fmt: skip
    return dict.fromkeys(empty, nothing) | {
        "batches": no_number,
        "farthest_move": no_limit,
        "velocity_of_friction": given_velocity,
        "repulsion_of": one_repulsion,
    }
