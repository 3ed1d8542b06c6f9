"""Static structure factor of each pair of species."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.queries.waves import density_waves
from dpd.observe.blocks import BlockSums
from dpd.scene.grids import wave_numbers

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class StructureFactor:
    """Partial structure factors S_ab(q) = Re <rho_a(q) rho_b(-q)> / sqrt(N_a N_b).

    Here rho_a(q) is the sum of exp(-i q r) over the N_a beads of species a (Ashcroft and Langreth,
    Phys. Rev. 156, 685 (1967)). An ideal gas has S_aa = 1 and S_ab = 0 at all q, as every fluid of
    single beads has at large q. The factor of all beads, whatever their species, is the sum of
    x_a S_aa and of 2 sqrt(x_a x_b) S_ab over pairs a < b, with the shares x = N_a / N.

    The sums are over beads, without a grid, for every wave vector q = 2 pi m / L of the box up to
    ``max``. They are kept for each wave vector, and averaged over shells of |q|: shell k reaches
    from k - 1/2 to k + 1/2 times 2 pi over the longest edge.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    max : float
        Largest |q| in 1 / r_c.
    """

    def __init__(self, scene: Scene, system: System, every: int, max: float) -> None:
        self.every = every
        self._system = system
        self._names = scene.species
        self._numbers = wave_numbers(system.box, max)
        self._pairs = list(combinations_with_replacement(range(len(self._names)), 2))
        self._order = np.argsort(scene.kinds, kind="stable")  # species after species
        counts = np.bincount(scene.kinds, minlength=len(self._names))
        self._begins = np.concatenate([[0], np.cumsum(counts)])
        self.averages = BlockSums(
            (len(self._pairs), len(self._numbers)), scene.steps.sample // every
        )
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
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
