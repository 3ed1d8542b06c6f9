"""What a page sees at a sample: beads in the order of the scene, in plain arrays."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from dpd.engine.simulation import Simulation
from dpd.engine.simulation import Snapshot as Configuration
from dpd.engine.space import nearest, unfolded
from dpd.errors import UserError
from dpd.scene.scene import Scene


class Pairs(NamedTuple):
    """Pairs of beads that are near each other, as (pairs,) arrays."""

    i: np.ndarray  # the number of one bead
    j: np.ndarray  # of the other, i < j
    distance: np.ndarray  # in r_c, to the nearest image


def fixed(array: np.ndarray) -> np.ndarray:
    """A view that cannot be written to: what a page sees is shared with others and the run."""
    view = array.view()
    view.flags.writeable = False
    return view


class Snapshot:
    """A configuration, molecule after molecule as the scene has them, valid for its step."""

    def __init__(self, scene: Scene, simulation: Configuration) -> None:
        # Of the engine, whose functions take them; the box with its images where they are now.
        self.system, self.state, self.lattice = simulation.system, simulation.state, simulation.box
        self.step, self.whole = self.state.step, scene  # since the run began, all included
        # With the values that hold now.
        self.scene = scene.during(self.step - 1, max(self.step, 1))[-1]
        self.sample = 0  # how many the page that looks has taken before
        self.kept: dict[str, np.ndarray] = {}  # what it keeps, and may write to
        self.file: Any = None  # its own
        self._near = -1.0

    @property
    def time(self) -> float:
        """tau since the run began."""
        return float(self.whole.tau(self.step))

    @cached_property
    def box(self) -> np.ndarray:
        """(dimension,) array of edges as they are now; between walls with the gaps behind both."""
        return fixed(np.array(self.lattice))

    @cached_property
    def volume(self) -> float:
        """In r_c^dimension; between walls that of the fluid."""
        return Configuration(self.system, self.state).volume

    @property
    def dimension(self) -> int:
        return self.scene.dimension

    @property
    def beads(self) -> int:
        """Their number."""
        return self.scene.beads

    @cached_property
    def coordinates(self) -> np.ndarray:
        """(dimension, beads) array of positions, as the engine's functions take them."""
        return fixed(self.state.by_identity(self.state.position))

    @property
    def positions(self) -> np.ndarray:
        """(beads, dimension) array in r_c, within the box."""
        return self.coordinates.T

    @cached_property
    def velocities(self) -> np.ndarray:
        """(beads, dimension) array in r_c / tau; under shear about the flow."""
        return fixed(self.state.by_identity(self.state.velocity).T)

    @cached_property
    def images(self) -> np.ndarray:
        """(beads, dimension) int array: the boxes that beads have crossed."""
        return fixed(self.state.image.T)

    @cached_property
    def unwrapped(self) -> np.ndarray:
        """(beads, dimension) array of positions that go on where beads leave the box."""
        return fixed(unfolded(self.coordinates, self.state.image, self.lattice).T)

    @property
    def masses(self) -> np.ndarray:
        """(beads,) array."""
        return np.broadcast_to(self.system.mass_of(self.scene.kinds), (self.beads,))

    @property
    def species(self) -> np.ndarray:
        """(beads,) array of names."""
        return np.array(self.scene.species)[self.scene.kinds]

    def of(self, *names: str) -> np.ndarray:
        """(beads,) bool array: which beads are of some species."""
        return np.isin(self.species, names)

    @property
    def molecules(self) -> np.ndarray:
        """(beads,) int array: the number of the molecule of each bead, from 0."""
        return np.repeat(np.arange(len(self.scene.lengths)), self.scene.lengths)

    @property
    def bonds(self) -> np.ndarray:
        """(bonds, 2) int array of bonded beads."""
        return self.scene.bonded.astype(np.int64)

    @cached_property
    def bond_vectors(self) -> np.ndarray:
        """(bonds, dimension) array in r_c, from the first bead of each bond to the second one."""
        one, other = self.scene.bonded.T
        apart = self.coordinates.take(other, axis=1) - self.coordinates.take(one, axis=1)
        return fixed(nearest(apart, self.lattice).T)

    @cached_property
    def in_one_piece(self) -> list[np.ndarray]:
        """(dimension, molecules, length) arrays: the molecules of each kind, each in one piece."""
        found, bead, bond, vectors = [], 0, 0, self.bond_vectors.T
        for kind in self.scene.molecules:
            count, length = kind.count, len(kind.beads)
            first = self.coordinates[:, bead : bead + count * length : length, None]
            steps = vectors[:, bond : bond + count * len(kind.bonds)]
            steps = steps.reshape(self.dimension, count, -1)[:, :, : length - 1]
            found.append(kind.summed(np.concatenate([first, steps], axis=2)))
            bead, bond = bead + count * length, bond + count * len(kind.bonds)
        return found

    @cached_property
    def bond_lengths(self) -> np.ndarray:
        """(bonds,) array in r_c."""
        return fixed(np.sqrt((self.bond_vectors.T**2).sum(axis=0)))

    def pairs(self, within: float) -> Pairs:
        """All pairs of beads within a distance in r_c, at nearest images, found once a sample.

        A `UserError` refuses more than half the box, and than a shear allows.
        """
        ends = np.isin(np.arange(self.dimension), self.scene.ended)  # where images do not repeat
        half = min(self.box.min(where=~ends, initial=np.inf) / 2, *self.scene.room)
        if not 0 < within <= half:
            text = f"allowed: > 0, and half the box, {half:g}"
            raise UserError(f"pairs within {within:g} r_c: {text}")
        if within > self._near:
            from dpd.engine.measure import near_beads

            box = tuple(self.box + within * ends) if ends.any() else self.lattice
            *found, distance = near_beads(self.state.position, box, within)
            i, j = np.sort(self.state.identity[np.stack(found)].astype(np.int64), axis=0)
            self._near, self._pairs = within, Pairs(i, j, distance)
        near = self._pairs.distance <= within
        return Pairs(*(each[near] for each in self._pairs))

    def by_species(self, within: float, of: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """(species, species) sums over pairs within a distance, of a function of distances."""
        near, count = self.pairs(within), len(self.scene.species)
        i, j = (self.scene.kinds[beads].astype(np.int64) for beads in (near.i, near.j))
        sums = np.bincount(count * i + j, of(near.distance), count**2).reshape(count, count)
        return sums + sums.T * ~np.eye(count, dtype=bool)


def snapshot_of(scene: Scene, simulation: Simulation) -> Snapshot:
    """The snapshot of a simulation at its step, made once for all pages that look."""
    last = simulation.snapshot
    if last is None or last.state is not simulation.state or last.step != simulation.state.step:
        last = simulation.snapshot = Snapshot(scene, simulation)
    return last
