"""Static structure factor of each pair of species."""

from __future__ import annotations

import math
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable, Refusals, setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

MOST_WAVES = 5 * 10**5  # wave vectors times pairs of species, each with numbers for 50 blocks
MOST_SUMS = 10**11  # terms of a sample: minutes for each


def wave_numbers(box: tuple[float, ...], most: float) -> np.ndarray:
    """The wave vectors that a periodic box has up to a length, one of each pair q and -q.

    Parameters
    ----------
    box : tuple of float
        Edges L in r_c.
    most : float
        Largest |q| in 1 / r_c.

    Returns
    -------
    (n, dimension) int64 array
        Whole numbers m of q = 2 pi m / L; the last axis changes first.
    """
    reach = [_farthest(edge, most) for edge in box]
    axes = [np.arange(-count, count + 1) for count in reach]
    numbers = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    numbers = numbers[len(numbers) // 2 + 1 :]  # behind 0 stand the opposites of those before it
    length = np.sqrt(((2 * np.pi * numbers / np.array(box)) ** 2).sum(axis=1))
    return numbers[length <= most * (1 + 1e-12)]


def _farthest(edge, most):
    """The largest whole number along an axis."""
    return int(most * edge / (2 * np.pi) * (1 + 1e-12))


class StructureFactor(Observable, key="structure_factor"):
    """Partial structure factors S_ab(q) = Re <rho_a(q) rho_b(-q)> / sqrt(N_a N_b).

    Here rho_a(q) is the sum of exp(-i q r) over the N_a beads of species a (Ashcroft and Langreth,
    Phys. Rev. 156, 685 (1967)). An ideal gas has S_aa = 1 and S_ab = 0 at all q, as every fluid of
    single beads has at large q. The factor of all beads, whatever their species, is the sum of
    x_a S_aa and of 2 sqrt(x_a x_b) S_ab over pairs a < b, with the shares x = N_a / N.

    The sums are over beads, without a grid, for every wave vector q = 2 pi m / L of the box up to
    ``max``. They are kept for each wave vector, and averaged over shells of |q|: shell k reaches
    from k - 1/2 to k + 1/2 times 2 pi over the longest edge.
    """

    stands = frozenset(Change) - {Change.SLIDES, Change.ENDS}
    cannot = {Change.STRETCHES: "belongs to the wave vectors of a box, and those change"}
    interval = 2.0

    max: float = setting(
        "Largest length of a wave vector; the work grows with its third power (in two dimensions, "
        "its square) times volume and beads.",
        4.0,
        unit="1 / r_c",
        gt=0,
        le=1000,
    )

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        self._names = scene.species
        self._numbers = wave_numbers(system.box, self.max)
        self._pairs = list(combinations_with_replacement(range(len(self._names)), 2))
        self._order = np.argsort(scene.kinds, kind="stable")  # species after species
        counts = np.bincount(scene.kinds, minlength=len(self._names))
        self._begins = np.concatenate([[0], np.cumsum(counts)])
        self.averages = BlockSums((len(self._pairs), len(self._numbers)))
        self.arrays = self.averages.arrays

    def refuses(self, scene: Scene) -> Refusals:
        """Wave vectors that the box has not, or that are too many."""
        most, longest = self.max, max(scene.box)
        least = 2 * np.pi / longest
        if most < least:
            yield (
                "max",
                f"{most:g} is below the smallest wave number of the box, 2 pi / {longest:g}; "
                f"allowed: >= {least:.4g}",
            )
        # Their number, before they are all written down.
        around = math.prod(2 * _farthest(edge, most) + 1 for edge in scene.box) // 2
        pairs = len(scene.species) * (len(scene.species) + 1) // 2
        if around * pairs > MOST_WAVES or around * scene.beads > MOST_SUMS:
            yield (
                "max",
                f"{most:g} makes up to {around:.3g} wave vectors for {scene.beads} beads; "
                f"allowed: <= {min(MOST_WAVES // pairs, MOST_SUMS // scene.beads)} vectors. Take "
                "a smaller max",
            )

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.waves import density_waves

        state = simulation.state
        position = state.by_identity(state.position)[:, self._order]
        waves = density_waves(position, self._system.box, self._begins, self._numbers)
        counts = np.diff(self._begins)
        self.averages.add([
            (waves[:, a] * waves[:, b]).sum(axis=0) / np.sqrt(counts[a] * counts[b])
            for a, b in self._pairs
        ])  # fmt: skip

    def variables(self) -> Variables:
        """Structure factors in blocks for the file, by shells and by wave vectors."""
        vectors = 2 * np.pi * self._numbers / np.array(self._system.box)
        length = np.sqrt((vectors**2).sum(axis=1))
        width = 2 * np.pi / max(self._system.box)
        shell = np.rint(length / width).astype(np.int64)
        _, number, members = np.unique(shell, return_inverse=True, return_counts=True)
        by_wave = self.averages.means()
        shells = [by_wave[..., number == k].mean(axis=2) for k in range(len(members))]
        by_shell = np.stack(shells, axis=2)
        names = [f"{self._names[a]} {self._names[b]}" for a, b in self._pairs]
        along = ("block", "species_pair")
        return {
            "species_pair": (("species_pair",), np.array(names), "1", "pair of species"),
            "q": (
                ("q",), np.bincount(number, length) / members, "1 / r_c",
                "mean length of the wave vectors in a shell, which is 2 pi / longest edge wide",
            ),
            "q_waves": (("q",), 2 * members, "1", "wave vectors in a shell, q and -q"),
            "structure_factor": (
                (*along, "q"), by_shell, "1",
                "partial structure factor (Ashcroft and Langreth) in shells, blocks of the run",
            ),
            "wave_vector": (("wave", "axis"), vectors, "1 / r_c", "wave vector, one of q and -q"),
            "structure_factor_wave": (
                (*along, "wave"), by_wave, "1",
                "partial structure factor at each wave vector in blocks of the run",
            ),
        }  # fmt: skip
