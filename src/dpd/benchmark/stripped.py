"""An engine with the code of every feature cut out, to see what the whole one pays for them.

Numba compiles a kernel with what its globals are at that moment. In a process of its own,
before anything is compiled, the parts of all features that a bare fluid does not use are
replaced by empty ones; what is compiled then is a loop over steps that knows nothing else.
"""

import os
from contextlib import contextmanager
from multiprocessing import get_context

import numpy as np


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

    def __init__(self, scene, start, stripped, folder):
        here = get_context("spawn")
        self._pipe, theirs = here.Pipe()
        self._process = here.Process(target=serve, args=(theirs, scene, start, stripped))
        with _cache_in(folder):
            self._process.start()
        theirs.close()

    def _ask(self, question, *arguments):
        self._pipe.send((question, *arguments))
        return self._pipe.recv()

    def advance(self, steps):
        """Seconds that so many steps took."""
        return self._ask("advance", steps)

    def state(self):
        """Positions, velocities and identities, in storage order."""
        return self._ask("state")

    def code_size(self):
        """Bytes of machine code of the loop over steps; of the engine that compiled it only."""
        return self._ask("code_size")

    def close(self):
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


def serve(pipe, scene, start, stripped):
    """Answer an `Engine` until it closes the pipe."""
    if stripped:
        strip()
    from dpd.benchmark.timing import seconds_of, simulation_of
    from dpd.engine import advance

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
            pipe.send(code_size(advance.advance))


def code_size(kernel):
    """Bytes of the object code of the variants of a kernel that this process has compiled."""
    return sum(len(variant.library._get_compiled_object()) for variant in kernel.overloads.values())


def strip():
    """Put empty parts in the place of every feature; before any kernel is compiled."""
    from dpd.engine import advance, cells, forces

    for module in (advance, cells, forces):
        for name, replacement in empty_parts().items():
            if hasattr(module, name):
                setattr(module, name, replacement)


def empty_parts():
    """Name to what takes its place: for species, bonds, bath, core, lists, noise, virial, teams."""
    from dpd.jit import part

    @part()
    def nothing(*arguments):
        return None

    @part()
    def no_number(*arguments):
        return 0

    @part()
    def no_limit(*arguments):
        return np.inf

    @part()
    def none_kept(*arguments):
        return None, 0

    @part()
    def given_velocity(velocity, predicted):
        return velocity

    @part()
    def soft_force(strength, r, w, core):
        return strength * w

    @part()
    def one_strength(strength, p, species, repulsion):
        return repulsion[0, 0]

    empty = (
        "add_bond_forces", "find_slots", "no_slots",  # bonds
        "pair_repulsion", "copy_species",  # species
        "add_bath_forces", "renew_bath_friction",  # bath
        "gaussian_noise",
        "no_list", "listing",  # lists
        "kept_buffers", "change_of", "close_phase", "renew_friction", "renew",  # friction twice
        "copy_predicted", "predict", "exchange_momentum",  # other schemes
        "measure_pairs",  # virial
        "meet",  # threads
    )  # fmt: skip
    return dict.fromkeys(empty, nothing) | {
        "batches": no_number,
        "listed_pairs": no_number,
        "farthest_move": no_limit,
        "keep_pairs": none_kept,
        "seen": given_velocity,
        "conservative_force": soft_force,
        "strength_of": one_strength,
    }
