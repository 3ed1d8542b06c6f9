"""What a simulation is made of: the system, which stays, and the state, which moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.physics.common.forces import Forces
from dpd.physics.thermostat import Friction

if TYPE_CHECKING:
    from dpd.physics.body_force import BodyForce
    from dpd.physics.core import Core
    from dpd.physics.integrator import Scheme
    from dpd.physics.many_body import ManyBody
    from dpd.physics.pressure import Pressure
    from dpd.physics.repulsion import Soft
    from dpd.physics.shear import Shear
    from dpd.physics.walls import Walls


class Beads(NamedTuple):
    """Beads as kernels have them, in storage order: a row each of position and velocities."""

    position: np.ndarray
    velocity: np.ndarray
    predicted: np.ndarray | None  # what the friction sees; None where that is the velocity itself
    identity: np.ndarray  # (n,) uint32: number of the bead in each slot
    species: np.ndarray | None  # (n,) uint8
    peculiar: np.ndarray | None  # (n,): see `State`
    reference: np.ndarray | None  # rows: the places that the list of pairs is made of


# Places in the arrays of `Sums`.
CONSERVATIVE, ALL_FORCES = 0, 1
OF_PAIRS, OF_BONDS = 0, 1


class Sums(NamedTuple):
    """Sums over all beads and pairs, at each of some steps."""

    step: np.ndarray  # (samples,) int64
    volume: np.ndarray  # (samples,): of the box at that step, see `dpd.engine.simulation.Snapshot`
    # (samples, cells): beads in each cell across a flow, see `dpd.engine.beads.Across`
    beads: np.ndarray
    # (samples, cells, q, q): the sum of m w w over the beads of a cell, with w = (v, 1, s): see
    # `dpd.engine.beads.add_moments`
    moments: np.ndarray
    # (samples, 2, dimension, dimension): sum over pairs, bonds and angles of r_ij F_ij: of the
    # `CONSERVATIVE` and of `ALL_FORCES`. None where forces are not measured, as what follows.
    virial: np.ndarray = None  # type: ignore[assignment]  # forces are measured where it is read
    # (samples, 2): `OF_PAIRS` and `OF_BONDS`; of bonds and the angles between them
    energy: np.ndarray = None  # type: ignore[assignment]
    # (samples, walls, 2 + dimension): sums over what each wall does to beads, see
    # `dpd.engine.step.Shared`; no part of the virial. None without walls.
    walls: np.ndarray | None = None

    def of(self, samples: np.ndarray | slice | int) -> Sums:
        """Some samples of it; of one sample, given by its number, without that axis."""
        return Sums._make(None if array is None else array[samples] for array in self)

    @classmethod
    def joined(cls, parts: Sequence[Sums]) -> Sums:
        """Samples of several, one after the other, of what all of them have."""
        return cls._make(
            None if any(one is None for one in each) else np.concatenate(each)
            for each in zip(*parts)
        )


@dataclass(frozen=True)
class System:
    """What does not change during a run."""

    # one edge of the periodic box per dimension, in r_c. Along an axis with walls it is longer than
    # the distance of the planes, see `Walls`. At constant pressure it is that of the start.
    box: tuple
    pair: Soft | Core  # the conservative force between pairs
    kT: float  # temperature
    # gamma in kT tau / r_c^2; sigma^2 = 2 gamma kT; or one for each pair of species, (species,
    # species), or, for a thermostat that acts on each bead, for each species, (species,)
    friction: float | np.ndarray
    gaussian: bool  # Gaussian noise instead of uniform
    dt: float  # time step in tau
    scheme: Scheme  # from `dpd.physics.integrator.scheme_named`
    seed: int  # seed of the noise
    members: np.ndarray | None = None  # (n, 2) uint32: identities of the two ends of each bond
    # the law of all bonds, or of each, see `dpd.physics.common.forces.bond_record`
    bond: Any = None
    # (n, 3) uint32: identities of the three beads of each angle, the middle one in between
    angle_members: np.ndarray | None = None
    angle: Any = None  # the law of all angles, or of each
    # 0 for cells sorted every step; otherwise pairs are listed within 1 + skin and the list is kept
    # until a bead has moved half the skin
    skin: float = 0.0
    # the thermostat acts on each bead on its own (Langevin) instead of on pairs; momentum is not
    # conserved
    per_bead: bool = False
    many_body: ManyBody | None = None
    masses: np.ndarray | None = None  # (species,): None where all are 1
    walls: Walls | None = None  # without the friction, which follows from ``wall_friction``
    wall_friction: float = 0.0  # gamma of beads with the walls; 0 for none
    body_force: BodyForce | None = None
    shear: Shear | None = None  # steady flow, with Lees-Edwards boundary conditions
    # held by a box that changes, which is then part of the `State`
    pressure: Pressure | None = None
    # axes across which a flow changes, each with the largest thickness of layers in which sums over
    # beads are kept apart, see `dpd.engine.beads`; none in a fluid at rest
    flow: tuple[tuple[int, float], ...] = ()

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def extent(self) -> tuple[float, ...]:
        """Edges of the space that beads fill: of the box, or the distance of two planes."""
        return tuple(high - low for low, high in zip(self.origin, self._ends(-1.0, self.box)))

    @property
    def origin(self) -> tuple[float, ...]:
        """Where that space begins in the box."""
        return self._ends(1.0, [0.0] * self.dimension)

    def _ends(self, inward, places):
        """The places along each axis, or of the wall there with that normal."""
        found = list(places)
        if self.walls is not None:
            for axis, normal, place in zip(self.walls.axis, self.walls.inward, self.walls.place):
                found[axis] = place if normal == inward else found[axis]
        return tuple(map(float, found))

    @property
    def volume(self) -> float:
        return float(np.prod(self.extent))

    def layers(self, axis: int, thickness: float) -> tuple[float, float, int]:
        """Equal layers of at most a thickness in r_c: begin of the first, length of all, how many.

        They fill the box, or the space from behind one wall to behind the other.
        """
        walls = self.walls
        reach = 0.0 if walls is None or axis not in walls.axis else walls.reach
        length = self.extent[axis] + 2 * reach
        return self.origin[axis] - reach, length, int(np.ceil(length / thickness))

    @property
    def forces(self) -> Forces:
        repulsion = np.ascontiguousarray(self.pair.repulsion, dtype=np.float64)
        walls, gamma = self.walls, float(self.wall_friction)
        if walls is not None and gamma != 0.0:
            amplitude = float(np.sqrt(2.0 * gamma * self.kT / self.dt))
            walls = walls._replace(friction=Friction(gamma, amplitude, bool(self.gaussian)))
        return Forces(
            self.pair._replace(repulsion=repulsion), self.many_body, self.bond, self.angle,
            **self._thermostat(), walls=walls, body_force=self.body_force,
        )  # fmt: skip

    def _thermostat(self):
        """The term that holds the temperature, by its name; nothing without friction."""
        gamma, shares, gaussian = self.friction, None, bool(self.gaussian)
        if not np.any(gamma):
            return {}
        if np.ndim(gamma):
            gamma, shares = 1.0, np.ascontiguousarray(gamma, dtype=np.float64)
        gamma = float(gamma)
        if self.scheme.exchange is not None:
            from dpd.physics.integrator import Exchange

            kind, kT = self.scheme.exchange, float(self.kT)
            return {"exchange": Exchange(kind, gamma, kT, gaussian, shares)}
        amplitude = float(np.sqrt(2.0 * gamma * self.kT / self.dt))
        name = "langevin" if self.per_bead else "friction"
        return {name: Friction(gamma, amplitude, gaussian, shares)}

    def mass_of(self, species: np.ndarray | None) -> np.ndarray | float:
        """Mass of each bead, (n,); a number where all have the same."""
        if self.masses is None:
            return 1.0
        return float(self.masses[0]) if species is None else self.masses[species]

    def momenta(self, state: State) -> np.ndarray:
        """(dimension, n) array: the momentum of each bead, in storage order."""
        if self.masses is None:
            return state.velocity
        return self.mass_of(state.species) * state.velocity


@dataclass
class State:
    """What a checkpoint holds, in storage order (sorted by cell)."""

    # (dimension, n): after an advance, views of the rows of kernels
    position: np.ndarray
    velocity: np.ndarray  # under shear about the flow, see `dpd.physics.shear`
    force: np.ndarray | None  # over the mass; None where it is yet to be evaluated
    identity: np.ndarray  # (n,) uint32: number of the bead in each slot
    species: np.ndarray | None  # (n,) uint8: None where there is one species
    step: int
    # (dimension, n): places that the pair list is made of, see `dpd.engine.integrate.look_ahead`;
    # None without a list
    reference: np.ndarray | None = None
    slid: int | None = None  # parts of an edge by which images had slid at step 0, under shear
    box: tuple[float, ...] | None = None  # edges in r_c; None for those of the system, which stay
    # (dimension, n) int32, by identity: boxes by which each bead is further than its position says,
    # along the vectors of the lattice; zeros if not given
    image: np.ndarray = None  # type: ignore[assignment]  # never so after the start
    # (n,): how far each bead has gone along the flow of a shear by its velocity about it, in r_c
    peculiar: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.image is None:
            self.image = np.zeros(self.position.shape, np.int32)

    def by_identity(self, array: np.ndarray) -> np.ndarray:
        """An array in storage order (last axis beads) reordered by bead identity."""
        places = np.empty(len(self.identity), np.intp)
        places[self.identity] = np.arange(len(places))
        return array.take(places, axis=-1)  # 2 to 4 times as fast as to fill places
