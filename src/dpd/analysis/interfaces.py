"""The two interfaces between slabs of A and of B: where they are, and how wide.

A slab may move while a run goes on, by some tenths of r_c, and beads of the minority then come
nearer to a window that stays in place. So positions are found block by block, and densities are
taken at distances from them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from dpd.analysis.degrees import taped
from dpd.analysis.statistics import jackknife

FARTHEST = 1 / 8  # of the box that an interface may be away from where it began
WIDTH = 2.0  # r_c, of an interface, to begin a fit
START = (WIDTH, 0.95, 0.05)  # and with it the fraction of A in both slabs


class Slabs(NamedTuple):
    """Densities at distances from the nearer interface, in blocks of a run.

    - ``position``: (block, 2) array; of the interfaces in r_c: where A begins, near 0, and where it
      ends, near half the box.
    - ``distance``: (n,) array; from the nearer interface in r_c, up to a quarter of the box.
    - ``density``: (block, 2, n) array; of the minority and of the majority at that distance, mean
      of both sides of both interfaces.
    - ``lost``: whether an interface was not found within `FARTHEST` of where it began, in some
      block: near the critical point slabs mix, and what is seen at a distance from there means
      nothing.
    """

    position: np.ndarray
    distance: np.ndarray
    density: np.ndarray
    lost: bool

    @property
    def total(self) -> np.ndarray:
        """(block, n) density of all beads."""
        return self.density.sum(axis=1)


@taped
def slabs(density: np.ndarray, z: np.ndarray, length: float) -> Slabs:
    """Densities of two slabs as seen from their interfaces.

    ``density``: (block, 2, n) array; of A and B in consecutive blocks of the run; A began in the
    first half. ``z``: (n,) array; middles of slices of equal width. ``length``: of the box along z.
    """
    position = interfaces(density, z, length)
    thickness = z[1] - z[0]
    distance = np.arange(0.5 * thickness, length / 4, thickness)
    seen = [_seen_from(block, z, length, at, distance) for block, at in zip(density, position)]
    lost = bool((np.abs(position - _beginning(length)) >= FARTHEST * length).any())
    return Slabs(position, distance, np.array(seen), lost)


def interfaces(density: np.ndarray, z: np.ndarray, length: float) -> np.ndarray:
    """Positions of both interfaces in each block.

    Two hyperbolic tangents are fitted to the fraction of A: all parameters to the mean of the
    run, then, with width and compositions held, the positions to each block.

    ``density``, ``z``, ``length``: as for `slabs`. Result: (block, 2) array; an interface that the
    fit puts farther off than `FARTHEST` stays there, as near the critical point, where there is
    none.
    """
    fraction = density[:, 0] / density.sum(axis=1)
    began = _beginning(length)

    def whole(z, first, second, width, inside, outside):
        return outside + (inside - outside) * _slab(z, length, first, second, width)

    try:
        held = curve_fit(whole, z, fraction.mean(axis=0), p0=(*began, *START))[0][2:]
    except RuntimeError:  # no fit: the slabs have mixed
        held = START

    def moved(z, first, second):
        return whole(z, first, second, *held)

    found = []
    for block in fraction:
        try:
            found.append(curve_fit(moved, z, block, p0=began)[0])
        except RuntimeError:
            found.append(began)
    reach = FARTHEST * length
    return np.clip(found, began - reach, began + reach)


def _beginning(length):
    """Where both interfaces are at the beginning of a run."""
    return np.array([0.0, length / 2])


def _slab(z, length, first, second, width):
    """1 inside a slab between two interfaces, 0 outside, in a periodic box."""
    inside = np.zeros_like(z)
    for shift in (-length, 0.0, length):
        inside += np.tanh(2 * (z - first - shift) / width)
        inside -= np.tanh(2 * (z - second - shift) / width)
    return inside / 2


def _seen_from(density, z, length, position, distance):
    """(2, n) densities of minority and majority at distances from the interfaces."""
    first, second = position
    a, b = density

    def at(profile, place):
        return np.interp(place, z, profile, period=length)

    in_a = (first + distance, second - distance)
    in_b = (first - distance, second + distance)
    minority = [at(b, place) for place in in_a] + [at(a, place) for place in in_b]
    majority = [at(a, place) for place in in_a] + [at(b, place) for place in in_b]
    return np.array([np.mean(minority, axis=0), np.mean(majority, axis=0)])


def interface_width(seen: Slabs) -> tuple[float, float]:
    """Width xi of m tanh(2 d / xi) through the difference of both densities.

    This is Groot and Warren 1997, Eq. 34, with a density that does not vanish in the other phase.
    Slices of width h, and lines between their middles, widen a profile by a variance of h^2 / 12
    and h^2 / 6; that of the slope of tanh(2 d / xi) is pi^2 xi^2 / 48. So 12 h^2 / pi^2 is taken
    off xi^2.

    Returns ``width``, ``error``: in r_c, by leaving out blocks.
    """

    slice_width = seen.distance[1] - seen.distance[0]

    def width(mean):
        minority, majority = mean
        depth = majority[-1] - minority[-1]
        try:
            _, xi = curve_fit(
                lambda d, m, xi: m * np.tanh(2 * d / xi),
                seen.distance, majority - minority, p0=(depth, WIDTH),
            )[0]  # fmt: skip
        except RuntimeError:
            return np.nan
        return np.sqrt(max(0.0, xi**2 - 12 * slice_width**2 / np.pi**2))

    return jackknife(seen.density, width)
