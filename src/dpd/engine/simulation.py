"""A system in motion: its parameters, its state, and the steps between."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Barrier
from typing import NamedTuple

import numpy as np

from dpd.engine.advance import Shared, advance
from dpd.engine.bonds import batches, make_bonds, no_slots
from dpd.engine.neighbours.cells import cell_buffers, grid
from dpd.engine.periodic import wrapped
from dpd.engine.threads.team import new_team
from dpd.engine.vectors.arrays import axes_of, empty_rows, rows_of
from dpd.errors import UserError
from dpd.physics.schemes import Coefficients

CUTOFF = 1.0


class Unstable(UserError):
    """A bead moved further than the cutoff along an axis in one step, or to no number."""

    def __init__(self, bead, step, distance, dt):
        self.bead, self.step, self.distance = bead, step, distance
        super().__init__(
            f"the run blew up: bead {bead} moved {distance:.3g} r_c along an axis in one step at "
            f"step {step} (limit: 1 r_c). "
            f"dt {dt:g} is too large for this scene: lower integrator.dt, or the friction, "
            "repulsion or bond stiffness that asks for it (Groot and Warren use dt 0.04 with "
            "repulsion 25 and gamma 4.5)."
        )


@dataclass(frozen=True)
class System:
    """What does not change during a run.

    Attributes
    ----------
    box : tuple of float
        One edge per dimension, in r_c.
    repulsion : (species, species) array
        a_ij in kT / r_c.
    kT, friction : float
        Temperature, and gamma in kT tau / r_c^2; sigma^2 = 2 gamma kT.
    per_bead : bool
        The thermostat acts on each bead on its own (Langevin) instead of on pairs; momentum
        is not conserved.
    gaussian : bool
        Gaussian noise instead of uniform.
    bonds : None or (members, stiffness, length)
        (n, 2) uint32 identities, C in kT / r_c^2, rest length in r_c.
    dt : float
        Time step in tau.
    scheme : Coefficients
        From `dpd.physics.schemes.coefficients`.
    seed : int
        Seed of the noise.
    core : None or (diameter, force, width)
        Rigid core: below the diameter (2 r_s, in r_c) the repulsion is the force F_max; within
        the width beyond, None for a jump, it goes over into the soft repulsion.
    skin : float
        0 for cells sorted every step; otherwise pairs are listed within 1 + skin and the
        list is kept until a bead has moved half the skin.
    """

    box: tuple
    repulsion: np.ndarray
    kT: float
    friction: float
    gaussian: bool
    bonds: tuple | None
    dt: float
    scheme: Coefficients
    seed: int
    core: tuple | None = None
    skin: float = 0.0
    per_bead: bool = False

    @property
    def dimension(self):
        return len(self.box)

    @property
    def volume(self):
        return float(np.prod(self.box))


@dataclass
class State:
    """What a checkpoint holds, in storage order (sorted by cell).

    Attributes
    ----------
    position, velocity, force : (dimension, n) arrays
        After an advance, views of the rows that the kernels work on.
    identity : (n,) uint32 array
        Number of the bead in each slot.
    species : (n,) uint8 array or None
        None where there is one species.
    step : int
    reference : (dimension, n) array or None
        Positions when the pair list was made; None without a list.
    """

    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    identity: np.ndarray
    species: np.ndarray | None
    step: int
    reference: np.ndarray | None = None

    def by_identity(self, array):
        """An array in storage order (last axis beads) reordered by bead identity."""
        ordered = np.empty(array.shape, array.dtype)
        ordered[..., self.identity] = array
        return ordered


class Sums(NamedTuple):
    """Virials and energies of one force evaluation.

    Attributes
    ----------
    virial : (2, dimension, dimension) array
        Sum over pairs and bonds of r_ij F_ij: conservative force only, and all forces.
    energy : (2,) array
        Pair and bond energy.
    """

    virial: np.ndarray
    energy: np.ndarray


def _refuse_nowhere(state):
    for name in ("position", "velocity"):
        bad = ~np.isfinite(getattr(state, name)).all(axis=0)
        if bad.any():
            raise UserError(
                f"bead {state.identity[np.argmax(bad)]} of the start has a {name} that is not a "
                f"finite number ({bad.sum()} beads have); make the start anew"
            )


def _empty_like(array):
    """A buffer to sort rows or numbers into; None for None."""
    if array is None:
        return None
    return np.empty_like(array) if array.ndim == 1 else empty_rows(*array.shape)


def _started(threads):
    """Threads that are there when they are needed: the others would wait for one that is not."""
    pool, meeting = ThreadPoolExecutor(threads), Barrier(threads + 1)
    try:
        for _ in range(threads):
            pool.submit(meeting.wait)
        meeting.wait()
    except RuntimeError as problem:
        meeting.abort()
        raise UserError(f"{threads + 1} threads: {problem}; take fewer") from None
    return pool


class Simulation:
    """A `System` and its `State`, advanced by the compiled loop.

    Parameters
    ----------
    system : System
    state : State
        Beads outside the box are put to their image inside. With a force of None, or for a
        list without a reference, the force is evaluated where the beads are.
    threads : int
        That share the work; their number does not change a bit of the result.

    Raises
    ------
    UserError
        If a coordinate or a velocity is not a finite number; for more than one thread with a
        scheme whose pairs exchange momentum one after the other.
    """

    def __init__(self, system, state, threads=1):
        self.system = system
        self.state = state
        _refuse_nowhere(state)
        # In rows, whatever they came in: each layout would compile kernels of its own.
        state.position = np.ascontiguousarray(wrapped(state.position, system.box))
        state.velocity = np.ascontiguousarray(state.velocity)
        self._grid = grid(system.box, CUTOFF + system.skin)
        noise = np.sqrt(2.0 * system.friction * system.kT / system.dt)
        thermostat = (float(system.friction), float(noise))
        split = system.scheme.exchange is not None
        if split and threads > 1:
            raise UserError(
                f"{threads} threads: in this scheme pairs exchange momentum one after the other, "
                "so it runs on one thread; take gw-vv or dpd-vv, or threads 1"
            )
        self._others = _started(threads - 1) if threads > 1 else None
        self._exchange = None
        if split:
            self._exchange = (system.scheme.exchange, float(system.friction), float(system.kT))
        self._fields = (
            np.ascontiguousarray(system.repulsion, dtype=np.float64),
            (0.0, 0.0) if system.per_bead or split else thermostat,
            bool(system.gaussian),
            None if system.bonds is None else make_bonds(*system.bonds),
            system.core,
            thermostat if system.per_bead else None,
        )
        self._threads = threads
        unlisted = system.skin > 0 and state.reference is None
        if state.force is None or unlisted:
            state.force = np.zeros_like(state.position)
            self._call(0, measure=False)

    def advance(self, steps, measure=False):
        """Advance by ``steps`` >= 1 steps.

        Parameters
        ----------
        steps : int
        measure : bool
            Add up virial and energy where the beads are in the end: in the last step, or, where a
            scheme has its force in the middle of a step, once more after it.

        Returns
        -------
        Sums
            Zero unless measured.

        Raises
        ------
        Unstable
            With the state as it was before the call.
        """
        if measure and self.system.scheme.middle:
            self._call(steps, measure=False)
            return self.measure()
        return self._call(steps, measure)

    def measure(self):
        """Virials and energies where the beads are, leaving the state alone."""
        kept = self.state
        try:
            return self._call(0, measure=True)
        finally:
            self.state = kept

    def _shared(self):
        """What the threads share during a call."""
        bonds, beads = self._fields[3], self.state.position.shape[1]
        tasks = batches(bonds) + len(self._grid.blocks.piece) - 1
        return Shared(
            cell_buffers(self._grid, beads, self._threads),
            no_slots(bonds, beads),
            np.zeros((tasks, 2, self.system.dimension, self.system.dimension)),
            np.zeros((tasks, 2)),
            np.zeros(self._threads),
            np.zeros((self._threads, 2)),
        )

    def _call(self, steps, measure):
        system, state = self.system, self.state
        # Copies: the loop works in place, and a former state must stay as it was.
        species = None if state.species is None else state.species.copy()
        predicted = None if system.scheme.prediction is None else rows_of(state.velocity)
        beads = (
            rows_of(state.position), rows_of(state.velocity), predicted, state.identity.copy(),
            species,
        )  # fmt: skip
        spare = tuple(map(_empty_like, beads))
        reference = None
        if system.skin > 0:
            reference = rows_of(state.position if state.reference is None else state.reference)
        force = rows_of(state.force if steps else np.zeros_like(state.force))
        shared = self._shared()
        beads, lost = self._all_threads(
            beads, spare, shared, reference, force, self._fields, self._exchange, system.box,
            self._grid, float(system.skin), system.dt, system.scheme, np.uint64(system.seed),
            state.step, steps, measure,
        )  # fmt: skip
        bead, step, distance = lost
        if bead >= 0:
            raise Unstable(bead, step, distance, system.dt)
        position, velocity, _, identity, species = beads
        if reference is not None:
            reference = axes_of(reference, system.dimension)
        position, velocity, force = (
            axes_of(rows, system.dimension) for rows in (position, velocity, force)
        )
        step = state.step + steps
        self.state = State(position, velocity, force, identity, species, step, reference)
        return Sums(shared.virial.sum(axis=0), shared.energy.sum(axis=0))

    def _all_threads(self, *arguments):
        """What `advance` returns, run by all threads together."""
        first, *rest = new_team(self._threads)
        others = [self._others.submit(advance, team, *arguments) for team in rest]
        found = advance(first, *arguments)
        for other in others:
            other.result()
        return found
