"""Density waves, and displacements over many times: sums over beads, without pairs."""

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

    Waves that differ in the last axis alone, and follow each other, share half of the work; of
    those that differ in its sign one costs nothing.

    Parameters
    ----------
    position : (dimension, n) array
        Species after species.
    begins : (species + 1,) int64 array
        The first bead of each species; last, the number of beads.
    numbers : (waves, dimension) int64 array
        Whole numbers m of q = 2 pi m / L.

    Returns
    -------
    (2, species, waves) array
    """
    share, most = position / np.array(box)[:, None], int(np.abs(numbers).max(initial=0))
    # A row for each head, all axes but the last, with the place of the wave of each last number.
    differs = (np.diff(numbers[:, :-1], axis=0, prepend=most + 1) != 0).any(axis=1)
    place = np.full((differs.sum(), 2 * most + 1), -1)
    place[np.cumsum(differs) - 1, numbers[:, -1] + most] = np.arange(len(numbers))
    found = np.zeros((2, len(begins) - 1, len(numbers)))
    waves = np.empty((2, len(box), most + 1, CHUNK))
    _add_waves(found, share, begins, numbers[differs], place, *waves, np.empty((2, CHUNK)))
    return found


@kernel()
def _add_waves(found, share, begins, heads, place, cosine, sine, head):
    last, most = len(share) - 1, cosine.shape[1] - 1
    for species in range(len(begins) - 1):
        for first in range(begins[species], begins[species + 1], CHUNK):
            n = min(CHUNK, begins[species + 1] - first)
            _waves_along_axes(share, first, n, cosine, sine)
            for row in range(len(heads)):
                _put_head(head, heads[row], n, cosine, sine)
                for m in range(most + 1):
                    up, down = place[row, most + m], place[row, most - m]
                    if up < 0 and down < 0:
                        continue
                    rc, rs, ic, js = 0.0, 0.0, 0.0, 0.0
                    for p in range(n):
                        c, s = cosine[last, m, p], sine[last, m, p]
                        rc += head[0, p] * c
                        rs += head[0, p] * s
                        ic += head[1, p] * c
                        js += head[1, p] * s
                    if up >= 0:
                        found[0, species, up] += rc - js
                        found[1, species, up] += ic + rs
                    if down >= 0 and m > 0:
                        found[0, species, down] += rc + js
                        found[1, species, down] += ic - rs


@inlined()
def _waves_along_axes(share, first, n, cosine, sine):
    """cos and sin of 2 pi m x / L of some beads, for each axis and each m from 0 on."""
    for k in range(len(share)):
        for p in range(n):
            angle = 2.0 * np.pi * share[k, first + p]
            cosine[k, 0, p], sine[k, 0, p] = 1.0, 0.0
            if cosine.shape[1] > 1:
                cosine[k, 1, p], sine[k, 1, p] = np.cos(angle), np.sin(angle)
        for m in range(2, cosine.shape[1]):  # by halves, so that rounding hardly adds up
            a, b = m // 2, m - m // 2
            for p in range(n):
                cosine[k, m, p] = cosine[k, a, p] * cosine[k, b, p] - sine[k, a, p] * sine[k, b, p]
                sine[k, m, p] = sine[k, a, p] * cosine[k, b, p] + cosine[k, a, p] * sine[k, b, p]


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


def squared_displacements(now: np.ndarray, then: np.ndarray) -> np.ndarray:
    """(earlier, points, n): |now - then|^2 of (dimension, points, n) and one more for each time."""
    found = np.empty((len(then), *now.shape[1:]))
    _squared_displacements(found, now, then)
    return found


# Loops one inside the other in this order vectorise: a tenth of the time of NumPy's temporaries.
@kernel()
def _squared_displacements(found, now, then):
    points, n = found.shape[1:]
    for i in range(len(then)):
        for p in range(points):
            for m in range(n):
                apart = now[0, p, m] - then[i, 0, p, m]
                found[i, p, m] = apart * apart
            for axis in range(1, len(now)):
                for m in range(n):
                    apart = now[axis, p, m] - then[i, axis, p, m]
                    found[i, p, m] += apart * apart


@kernel()
def add_lags(sums, means, found):
    """Add what was found for each lag, and its mean over molecules.

    To ``sums``, (lags, quantities, molecules), and ``means``, (lags, quantities), from the shortest
    lag on; ``found``, (lags, quantities or 1, molecules), is from the longest on.
    """
    lags, quantities, molecules = sums.shape
    for lag in range(lags):
        for quantity in range(quantities):
            q = min(quantity, found.shape[1] - 1)
            total = 0.0
            for m in range(molecules):
                one = found[lags - 1 - lag, q, m]
                sums[lag, quantity, m] += one
                total += one
            means[lag, quantity] += total / molecules
