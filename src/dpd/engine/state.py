"""What a simulation is made of: the system, which stays, and the state, which moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.errors import UserError
from dpd.physics.common.forces import Forces
from dpd.physics.thermostat import Friction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.physics.body_force import BodyForce
    from dpd.physics.core import Core
    from dpd.physics.integrator import Scheme
    from dpd.physics.many_body import ManyBody
    from dpd.physics.pressure import Pressure
    from dpd.physics.repulsion import Soft
    from dpd.physics.shear import Shear
    from dpd.physics.walls import Walls


class Beads(NamedTuple):
    """Beads as kernels have them, in storage order.

    Attributes
    ----------
    position, velocity : arrays with a row for each bead
    predicted : array with a row for each bead, or None
        The velocity that the friction sees; None where that is the velocity itself.
    identity : (n,) uint32 array
        Number of the bead in each slot.
    species : (n,) uint8 array or None
    peculiar : (n,) array or None
        See `State`.
    """

    position: np.ndarray
    velocity: np.ndarray
    predicted: np.ndarray | None
    identity: np.ndarray
    species: np.ndarray | None
    peculiar: np.ndarray | None


# Places in the arrays of `Sums`.
CONSERVATIVE, ALL_FORCES = 0, 1
OF_PAIRS, OF_BONDS = 0, 1


class Sums(NamedTuple):
    """Sums over all beads and pairs, at each of some steps.

    Attributes
    ----------
    step : (samples,) int64 array
    volume : (samples,) array
        Of the box at that step, see `dpd.engine.simulation.Snapshot`.
    beads : (samples, cells) array
        Beads in each cell across a flow, see `dpd.engine.sampling.Across`.
    moments : (samples, cells, q, q) array
        The sum of m w w over the beads of a cell, with w = (v, 1, s): velocity, one, and the place
        in the cell along each axis across the flow, in layers from the middle.
    virial : (samples, 2, dimension, dimension) array or None
        Sum over pairs, bonds and angles of r_ij F_ij: of the `CONSERVATIVE` and of `ALL_FORCES`.
        None where forces are not measured, as what follows.
    energy : (samples, 2) array or None
        `OF_PAIRS` and `OF_BONDS`; of bonds and the angles between them.
    walls : (samples, walls, 2 + dimension) array or None
        Sums over what each wall does to beads, see `dpd.engine.external.AtWalls`; no part of the
        virial. None without walls.
    """

    step: np.ndarray
    volume: np.ndarray
    beads: np.ndarray
    moments: np.ndarray
    virial: np.ndarray = None  # type: ignore[assignment]  # forces are measured where it is read
    energy: np.ndarray = None  # type: ignore[assignment]
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
    """What does not change during a run.

    Attributes
    ----------
    box : tuple of float
        One edge of the periodic box per dimension, in r_c. Along an axis with walls it is longer
        than the distance of the planes, see `Walls`. At constant pressure it is that of the start.
    pair : Soft or Core
        The conservative force between pairs.
    kT : float
        Temperature.
    friction : float or array
        gamma in kT tau / r_c^2; sigma^2 = 2 gamma kT. A (species, species) array has one for each
        pair of species; for a thermostat that acts on each bead, a (species,) array one for each.
    gaussian : bool
        Gaussian noise instead of uniform.
    dt : float
        Time step in tau.
    scheme : Scheme
        From `dpd.physics.integrator.scheme_named`.
    seed : int
        Seed of the noise.
    members : (n, 2) uint32 array or None
        Identities of the two ends of each bond.
    bond : record or None
        See `dpd.physics.common.records.bond_record`.
        The law of all bonds, or of each.
    angle_members : (n, 3) uint32 array or None
        Identities of the three beads of each angle, the middle one in between.
    angle : record or None
        The law of all angles, or of each.
    skin : float
        0 for cells sorted every step; otherwise pairs are listed within 1 + skin and the
        list is kept until a bead has moved half the skin.
    per_bead : bool
        The thermostat acts on each bead on its own (Langevin) instead of on pairs; momentum
        is not conserved.
    many_body : ManyBody or None
    masses : (species,) array or None
        None where all are 1.
    walls : Walls or None
        Without the friction, which follows from ``wall_friction``.
    wall_friction : float
        Gamma of beads with the walls; 0 for none.
    body_force : BodyForce or None
    shear : Shear or None
        Steady flow, with Lees-Edwards boundary conditions.
    pressure : Pressure or None
        Held by stretching the box, which is then part of the `State`.
    flow : tuple of (int, float)
        Axes across which a flow changes, each with the largest thickness of layers in which sums
        over beads are kept apart, see `dpd.engine.sampling`; none in a fluid at rest.
    """

    box: tuple
    pair: Soft | Core
    kT: float
    friction: float | np.ndarray
    gaussian: bool
    dt: float
    scheme: Scheme
    seed: int
    members: np.ndarray | None = None
    bond: Any = None
    angle_members: np.ndarray | None = None
    angle: Any = None
    skin: float = 0.0
    per_bead: bool = False
    many_body: ManyBody | None = None
    masses: np.ndarray | None = None
    walls: Walls | None = None
    wall_friction: float = 0.0
    body_force: BodyForce | None = None
    shear: Shear | None = None
    pressure: Pressure | None = None
    flow: tuple[tuple[int, float], ...] = ()

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def extent(self) -> tuple[float, ...]:
        """Edges of the space that beads fill: of the box, or the distance of two planes."""
        edges = list(self.box)
        if self.walls is not None:
            for axis, inward, place in zip(self.walls.axis, self.walls.inward, self.walls.place):
                edges[axis] = place - self.origin[axis] if inward < 0 else edges[axis]
        return tuple(map(float, edges))

    @property
    def origin(self) -> tuple[float, ...]:
        """Where that space begins in the box."""
        low = [0.0] * self.dimension
        if self.walls is not None:
            for axis, inward, place in zip(self.walls.axis, self.walls.inward, self.walls.place):
                low[axis] = place if inward > 0 else low[axis]
        return tuple(map(float, low))

    @property
    def volume(self) -> float:
        return float(np.prod(self.extent))

    def layers(self, axis: int, thickness: float) -> tuple[float, float, int]:
        """Equal layers: where the first begins, the length of all, and how many there are.

        Parameters
        ----------
        axis : int
            Layers fill the box, or the space from behind one wall to behind the other.
        thickness : float
            Largest thickness of a layer in r_c.
        """
        walls = self.walls
        reach = 0.0 if walls is None or axis not in walls.axis else walls.reach
        length = self.extent[axis] + 2 * reach
        return self.origin[axis] - reach, length, int(np.ceil(length / thickness))

    @property
    def forces(self) -> Forces:
        """All that acts on beads, as kernels take it."""
        repulsion = np.ascontiguousarray(self.pair.repulsion, dtype=np.float64)
        return Forces(
            self.pair._replace(repulsion=repulsion), self.many_body, self.bond, self.angle,
            **self._thermostat(), walls=self._walls(), body_force=self.body_force,
        )  # fmt: skip

    def _walls(self):
        """The walls with their friction, if they have any."""
        gamma = float(self.wall_friction)
        if self.walls is None or gamma == 0.0:
            return self.walls
        from dpd.physics.walls import WallFriction

        amplitude = float(np.sqrt(2.0 * gamma * self.kT / self.dt))
        return self.walls._replace(friction=WallFriction(gamma, amplitude, bool(self.gaussian)))

    def _thermostat(self):
        """The term that holds the temperature, by its name; nothing without friction."""
        gamma, shares, gaussian = self.friction, None, bool(self.gaussian)
        if not np.any(gamma):
            return {}
        if np.ndim(gamma):
            gamma, shares = 1.0, np.ascontiguousarray(gamma, dtype=np.float64)
        gamma = float(gamma)
        if self.scheme.exchange is not None:
            from dpd.physics.common.exchange import Exchange

            kind, kT = self.scheme.exchange, float(self.kT)
            return {"exchange": Exchange(kind, gamma, kT, gaussian, shares)}
        amplitude = float(np.sqrt(2.0 * gamma * self.kT / self.dt))
        if not self.per_bead:
            return {"friction": Friction(gamma, amplitude, gaussian, shares)}
        from dpd.physics.common.langevin import Langevin

        return {"langevin": Langevin(gamma, amplitude, gaussian, shares)}

    def mass_of(self, species: np.ndarray | None) -> np.ndarray | float:
        """Mass of each bead.

        Parameters
        ----------
        species : (n,) uint8 array or None
            None where there is one species.

        Returns
        -------
        (n,) array or float
            A number where all have the same mass.
        """
        if self.masses is None:
            return 1.0
        return float(self.masses[0]) if species is None else self.masses[species]

    def momenta(self, state: State) -> np.ndarray:
        """(dimension, n) array: the momentum of each bead, in storage order.

        It is the array of the velocities itself where all masses are 1.
        """
        if self.masses is None:
            return state.velocity
        return self.mass_of(state.species) * state.velocity


@dataclass
class State:
    """What a checkpoint holds, in storage order (sorted by cell).

    Attributes
    ----------
    position, velocity : (dimension, n) arrays
        After an advance, views of the rows that the kernels work on. Under shear velocities are
        those about the flow, see `dpd.physics.shear`.
    force : (dimension, n) array or None
        The same; None where it is yet to be evaluated. Where the system has masses, it is the force
        over the mass.
    identity : (n,) uint32 array
        Number of the bead in each slot.
    species : (n,) uint8 array or None
        None where there is one species.
    step : int
    reference : (dimension, n) array or None
        Positions when the pair list was made; None without a list.
    slid : int or None
        Parts of an edge by which images had slid at step 0, see `dpd.engine.space`; None without
        shear.
    box : tuple of float or None
        Edges in r_c; None for those of the system, which stay.
    image : (dimension, n) int32 array
        Boxes by which each bead is further than its position says; of images that slide, along the
        vectors of their lattice. In the order of identities: a sort need not move what seldom
        changes. Zeros if not given.
    peculiar : (n,) array or None
        How far each bead has gone along the flow of a shear by its velocity about it, in r_c; None
        without shear.
    """

    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray | None
    identity: np.ndarray
    species: np.ndarray | None
    step: int
    reference: np.ndarray | None = None
    slid: int | None = None
    box: tuple[float, ...] | None = None
    image: np.ndarray = None  # type: ignore[assignment]  # never so after the start
    peculiar: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.image is None:
            self.image = np.zeros(self.position.shape, np.int32)

    def by_identity(self, array: np.ndarray) -> np.ndarray:
        """An array in storage order (last axis beads) reordered by bead identity."""
        ordered = np.empty(array.shape, array.dtype)
        ordered[..., self.identity] = array
        return ordered

    def refuse_nowhere(self) -> None:
        """Refuse a state with a position or a velocity that is no finite number.

        Raises
        ------
        UserError
        """
        for name in ("position", "velocity"):
            bad = ~np.isfinite(getattr(self, name)).all(axis=0)
            if bad.any():
                raise UserError(
                    f"bead {self.identity[np.argmax(bad)]} of the start has a {name} that is not a "
                    f"finite number ({bad.sum()} beads have); make the start anew"
                )
