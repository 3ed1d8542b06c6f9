"""Static structure factor of each pair of species."""

import math
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from dpd.page import Change, Observable, Refusals, once, setting

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
    gives = {
        "structure_factor": (
            ("block", "species_pair", "q"), "1",
            "partial structure factor (Ashcroft and Langreth) in shells, blocks of the run",
        ),
        "structure_factor_wave": (
            ("block", "species_pair", "wave"), "1",
            "partial structure factor at each wave vector in blocks of the run",
        ),
    }  # fmt: skip

    max: float = setting(
        "Largest length of a wave vector; the work grows with its third power (in two dimensions, "
        "its square) times volume and beads.",
        4.0,
        unit="1 / r_c",
        gt=0,
        le=1000,
    )

    @once
    def waves(self, scene: Any) -> np.ndarray:
        """(waves, dimension) array: whole numbers of the wave vectors."""
        return wave_numbers(scene.box, self.max)

    @once
    def shells(self, scene: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The shell of each wave vector, their number in each shell, and the length of each."""
        vectors = 2 * np.pi * self.waves(scene) / np.array(scene.box)
        length = np.sqrt((vectors**2).sum(axis=1))
        shell = np.rint(length / (2 * np.pi / max(scene.box))).astype(np.int64)
        _, number, members = np.unique(shell, return_inverse=True, return_counts=True)
        return number, members, length

    def axes(self, scene: Any) -> Any:
        names = [f"{one} {other}" for one, other in combinations_with_replacement(scene.species, 2)]
        number, members, length = self.shells(scene)
        mean = np.bincount(number, length) / members
        text = "mean length of the wave vectors in a shell, which is 2 pi / longest edge wide"
        vectors = 2 * np.pi * self.waves(scene) / np.array(scene.box)
        return {
            "species_pair": (np.array(names), "1", "pair of species"),
            "q": (mean, "1 / r_c", text),
            "q_waves": (2 * members, "1", "wave vectors in a shell, q and -q", ("q",)),
            "wave": len(vectors),
            "wave_vector": (
                vectors, "1 / r_c", "wave vector, one of q and -q", ("wave", "axis"),
            ),
        }  # fmt: skip

    def refuses(self, scene: Any) -> Refusals:
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

    @once
    def by_species(self, scene: Any) -> tuple[np.ndarray, np.ndarray]:
        """The beads, species after species, and where each species begins and the last ends."""
        counts = np.bincount(scene.kinds, minlength=len(scene.species))
        return np.argsort(scene.kinds, kind="stable"), np.concatenate([[0], np.cumsum(counts)])

    def measure(self, now: Any) -> Any:
        from dpd.engine.queries.waves import density_waves

        scene = now.scene
        (order, begins), (shell, members, _) = self.by_species(scene), self.shells(scene)
        waves = density_waves(now.coordinates[:, order], scene.box, begins, self.waves(scene))
        counts = np.diff(begins)
        by_wave = [
            (waves[:, a] * waves[:, b]).sum(axis=0) / np.sqrt(counts[a] * counts[b])
            for a, b in combinations_with_replacement(range(len(counts)), 2)
        ]
        by_shell = [np.bincount(shell, each) / members for each in by_wave]
        return {"structure_factor": by_shell, "structure_factor_wave": by_wave}
