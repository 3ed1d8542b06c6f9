"""Density waves: sums of exp(-i q r) over beads, as exact as the positions are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.jit import inlined, kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

CHUNK = 256  # beads that are worked on together: their waves along each axis stay in cache


def density_waves(
    position: np.ndarray, box: Sequence[float], begins: np.ndarray, numbers: np.ndarray
) -> np.ndarray:
    """Real part and negative imaginary part of rho(q) = sum_j exp(-i q r_j), of each species.

    Parameters
    ----------
    position : (dimension, n) array
        Species after species.
    box : tuple
        Edges L in r_c.
    begins : (species + 1,) int64 array
        The first bead of each species; last, the number of beads.
    numbers : (waves, dimension) int64 array
        Whole numbers m of q = 2 pi m / L. Those that differ in the last axis alone should follow
        each other, which saves half of the work.

    Returns
    -------
    (2, species, waves) array
    """
    share, most = position / np.array(box)[:, None], int(np.abs(numbers).max(initial=0))
    cosine, sine = (np.empty((len(box), most + 1, CHUNK)) for _ in range(2))
    found = np.zeros((2, len(begins) - 1, len(numbers)))
    _add_waves(found, share, begins, numbers, cosine, sine, np.empty((2, CHUNK)))
    return found


@kernel()
def _add_waves(found, share, begins, numbers, cosine, sine, head):
    dimension = len(share)
    for species in range(len(begins) - 1):
        for first in range(begins[species], begins[species + 1], CHUNK):
            n = min(CHUNK, begins[species + 1] - first)
            _waves_along_axes(share, first, n, cosine, sine)
            for wave in range(len(numbers)):
                if wave == 0 or _head_differs(numbers, wave):
                    _put_head(head, numbers[wave], n, cosine, sine)
                last = abs(numbers[wave, dimension - 1])
                sign = 1.0 if numbers[wave, dimension - 1] >= 0 else -1.0
                real, imaginary = 0.0, 0.0
                for p in range(n):
                    c, s = cosine[dimension - 1, last, p], sign * sine[dimension - 1, last, p]
                    real += head[0, p] * c - head[1, p] * s
                    imaginary += head[0, p] * s + head[1, p] * c
                found[0, species, wave] += real
                found[1, species, wave] += imaginary


@inlined()
def _waves_along_axes(share, first, n, cosine, sine):
    """cos and sin of 2 pi m x / L of some beads, for each axis and each m from 0 on."""
    for k in range(len(share)):
        for p in range(n):
            cosine[k, 0, p], sine[k, 0, p] = 1.0, 0.0
        for m in range(1, cosine.shape[1]):
            for p in range(n):
                angle = 2.0 * np.pi * m * share[k, first + p]
                cosine[k, m, p], sine[k, m, p] = np.cos(angle), np.sin(angle)


@inlined()
def _head_differs(numbers, wave):
    """Whether a wave differs from the one before it in another axis than the last."""
    differs = False
    for k in range(numbers.shape[1] - 1):
        differs |= numbers[wave, k] != numbers[wave - 1, k]
    return differs


@inlined()
def _put_head(head, number, n, cosine, sine):
    """The product of the waves along all axes but the last."""
    for p in range(n):
        head[0, p], head[1, p] = 1.0, 0.0
    for k in range(len(number) - 1):
        m, sign = abs(number[k]), 1.0 if number[k] >= 0 else -1.0
        for p in range(n):
            c, s = cosine[k, m, p], sign * sine[k, m, p]
            real = head[0, p] * c - head[1, p] * s
            head[1, p] = head[0, p] * s + head[1, p] * c
            head[0, p] = real
