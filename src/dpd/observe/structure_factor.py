import math
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from dpd.observe.common.bins import species_pairs
from dpd.page import Change, Observable, Refusals, once, setting

MOST_WAVES = 5 * 10**5  # wave vectors times pairs of species, each with numbers for 50 blocks
MOST_SUMS = 10**11  # terms of a sample: minutes for each
PER_STEP = 50  # wave vectors that are summed over all beads in the time of a step


def wave_numbers(box: tuple[float, ...], most: float) -> np.ndarray:
    """(n, dimension) whole numbers m: one of q and -q, q = 2 pi m / L up to a length."""
    axes = [np.arange(-count, count + 1) for count in _farthest(box, most)]
    numbers = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    numbers = numbers[len(numbers) // 2 + 1 :]  # behind 0 stand the opposites of those before it
    return numbers[_length(numbers, box) <= most * (1 + 1e-12)]


def _farthest(box, most):
    """The largest whole number along each axis."""
    return [int(most * edge / (2 * math.pi) * (1 + 1e-12)) for edge in box]


def _length(numbers, box):
    return np.sqrt(((2 * np.pi * numbers / np.array(box)) ** 2).sum(axis=1))


class StructureFactor(Observable, key="structure_factor"):
    """Partial structure factors S_ab(q) = Re <rho_a(q) rho_b(-q)> / sqrt(N_a N_b).

    Here rho_a(q) is the sum of exp(-i q r) over the N_a beads of species a (Ashcroft and Langreth,
    Phys. Rev. 156, 685 (1967)). An ideal gas has S_aa = 1 and S_ab = 0 at all q, as every fluid of
    single beads has at large q. The factor of all beads, whatever their species, is the sum of
    x_a S_aa and of 2 sqrt(x_a x_b) S_ab over pairs a < b, with the shares x = N_a / N.

    For every wave vector q = 2 pi m / L of the box up to ``max``, and averaged over shells of |q|:
    shell k reaches from k - 1/2 to k + 1/2 times 2 pi over the longest edge.
    """

    stands = frozenset(Change) - {Change.SLIDES, Change.ENDS}
    cannot = {Change.STRETCHES: "belongs to the wave vectors of a box, and those change"}
    interval = 6.0
    gives = {
        "structure_factor": (("block", "species_pair", "q"), "1", "partial structure factor"),
        "structure_factor_wave": (("block", "species_pair", "wave"), "1", "at each wave vector"),
    }

    max: float = setting(
        "Largest length of a wave vector; the work grows with its third power (in two dimensions, "
        "its square) times volume and beads.", 4.0, unit="1 / r_c", gt=0, le=1000,
    )  # fmt: skip

    def cost_in(self, scene: Any) -> float:
        half_ball = {2: math.pi / 2, 3: 2 * math.pi / 3}[scene.dimension]
        waves = half_ball * math.prod(self.max * edge / (2 * math.pi) for edge in scene.box)
        return waves / PER_STEP

    @once
    def waves(self, scene: Any) -> np.ndarray:
        """(waves, dimension) array: whole numbers of the wave vectors."""
        return wave_numbers(scene.box, self.max)

    @once
    def shells(self, scene: Any) -> tuple[np.ndarray, np.ndarray]:
        """The shell of each wave vector, and their number in each shell."""
        step = 2 * np.pi / max(scene.box)
        shell = np.rint(_length(self.waves(scene), scene.box) / step).astype(np.int64)
        return np.unique(shell, return_inverse=True, return_counts=True)[1:]

    def axes(self, scene: Any) -> Any:
        pairs = combinations_with_replacement(range(len(scene.species)), 2)
        waves, (shell, members) = self.waves(scene), self.shells(scene)
        mean = np.bincount(shell, _length(waves, scene.box)) / members
        text = "mean length of the wave vectors in a shell, which is 2 pi / longest edge wide"
        vectors, about = 2 * np.pi * waves / np.array(scene.box), "wave vector, one of q and -q"
        return {
            "species_pair": species_pairs(scene, pairs),
            "q": (mean, "1 / r_c", text),
            "q_waves": (2 * members, "1", "wave vectors in a shell, q and -q", ("q",)),
            "wave": len(waves),
            "wave_vector": (vectors, "1 / r_c", about, ("wave", "axis")),
        }

    def refuses(self, scene: Any) -> Refusals:
        most, longest = self.max, max(scene.box)
        least = 2 * np.pi / longest
        if most < least:
            text = f"{most:g} is below the smallest wave number of the box, 2 pi / {longest:g}"
            yield "max", f"{text}; allowed: >= {least:.4g}"
        # Their number, before they are all written down.
        around = math.prod(2 * count + 1 for count in _farthest(scene.box, most)) // 2
        pairs = len(scene.species) * (len(scene.species) + 1) // 2
        allowed = min(MOST_WAVES // pairs, MOST_SUMS // scene.beads)
        if around > allowed:
            text = f"{most:g} makes up to {around:.3g} wave vectors for {scene.beads} beads"
            yield "max", f"{text}; allowed: <= {allowed} vectors. Take a smaller max"

    def measure(self, now: Any) -> Any:
        from dpd.engine.measure import density_waves

        scene, (shell, members) = now.scene, self.shells(now.scene)
        counts = np.bincount(scene.kinds, minlength=len(scene.species))
        order = np.argsort(scene.kinds, kind="stable")
        begins = np.concatenate([[0], np.cumsum(counts)])
        waves = density_waves(now.coordinates[:, order], scene.box, begins, self.waves(scene))
        by_wave = [
            (waves[:, a] * waves[:, b]).sum(axis=0) / np.sqrt(counts[a] * counts[b])
            for a, b in combinations_with_replacement(range(len(counts)), 2)
        ]
        by_shell = [np.bincount(shell, each) / members for each in by_wave]
        return {"structure_factor": by_shell, "structure_factor_wave": by_wave}
