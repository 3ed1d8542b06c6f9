"""What a simulation is made of: the system, which stays, and the state, which moves."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dpd.errors import UserError
from dpd.physics.bond import Bond
from dpd.physics.core import Core
from dpd.physics.exchange import Exchange
from dpd.physics.forces import Forces
from dpd.physics.friction import Friction
from dpd.physics.langevin import Langevin
from dpd.physics.pressure import Pressure
from dpd.physics.schemes import Scheme
from dpd.physics.soft import Soft


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
    """

    position: np.ndarray
    velocity: np.ndarray
    predicted: np.ndarray | None
    identity: np.ndarray
    species: np.ndarray | None


# Places in the arrays of `Sums`.
CONSERVATIVE, ALL_FORCES = 0, 1
OF_PAIRS, OF_BONDS = 0, 1


class Sums(NamedTuple):
    """Virials and energies of one evaluation of the forces.

    Attributes
    ----------
    virial : (2, dimension, dimension) array
        Sum over pairs and bonds of r_ij F_ij: of the `CONSERVATIVE` and of `ALL_FORCES`.
    energy : (2,) array
        `OF_PAIRS` and `OF_BONDS`.
    """

    virial: np.ndarray
    energy: np.ndarray


@dataclass(frozen=True)
class System:
    """What does not change during a run.

    Attributes
    ----------
    box : tuple of float
        One edge per dimension, in r_c; at constant pressure, that of the start.
    pair : Soft or Core
        The conservative force between pairs.
    kT, friction : float
        Temperature, and gamma in kT tau / r_c^2; sigma^2 = 2 gamma kT.
    gaussian : bool
        Gaussian noise instead of uniform.
    dt : float
        Time step in tau.
    scheme : Scheme
        From `dpd.physics.schemes.scheme_named`.
    seed : int
        Seed of the noise.
    members : (n, 2) uint32 array or None
        Identities of the two ends of each bond.
    bond : Bond or None
        The law of all bonds.
    skin : float
        0 for cells sorted every step; otherwise pairs are listed within 1 + skin and the
        list is kept until a bead has moved half the skin.
    per_bead : bool
        The thermostat acts on each bead on its own (Langevin) instead of on pairs; momentum
        is not conserved.
    pressure : Pressure or None
        Held by stretching the box, which is then part of the `State`.
    """

    box: tuple
    pair: Soft | Core
    kT: float
    friction: float
    gaussian: bool
    dt: float
    scheme: Scheme
    seed: int
    members: np.ndarray | None = None
    bond: Bond | None = None
    skin: float = 0.0
    per_bead: bool = False
    pressure: Pressure | None = None

    @property
    def dimension(self) -> int:
        return len(self.box)

    @property
    def volume(self) -> float:
        return float(np.prod(self.box))

    @property
    def forces(self) -> Forces:
        """All that acts on beads, as kernels take it."""
        repulsion = np.ascontiguousarray(self.pair.repulsion, dtype=np.float64)
        return Forces(self.pair._replace(repulsion=repulsion), self.bond, **self._thermostat())

    def _thermostat(self):
        """The term that holds the temperature, by its name; nothing without friction."""
        gamma, gaussian = float(self.friction), bool(self.gaussian)
        if gamma == 0.0:
            return {}
        if self.scheme.exchange is not None:
            return {"exchange": Exchange(self.scheme.exchange, gamma, float(self.kT), gaussian)}
        amplitude = float(np.sqrt(2.0 * self.friction * self.kT / self.dt))
        term = Langevin if self.per_bead else Friction
        return {term.__name__.lower(): term(gamma, amplitude, gaussian)}


@dataclass
class State:
    """What a checkpoint holds, in storage order (sorted by cell).

    Attributes
    ----------
    position, velocity : (dimension, n) arrays
        After an advance, views of the rows that the kernels work on.
    force : (dimension, n) array or None
        The same; None where it is yet to be evaluated.
    identity : (n,) uint32 array
        Number of the bead in each slot.
    species : (n,) uint8 array or None
        None where there is one species.
    step : int
    reference : (dimension, n) array or None
        Positions when the pair list was made; None without a list.
    box : tuple of float or None
        Edges in r_c; None for those of the system, which stay.
    """

    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray | None
    identity: np.ndarray
    species: np.ndarray | None
    step: int
    reference: np.ndarray | None = None
    box: tuple[float, ...] | None = None

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
