"""Slabs of A and of B: their interfaces, compositions and chi.

Slabs move by some tenths of r_c in a run, so positions are found block by block, and densities are
taken at distances from them.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import curve_fit, minimize_scalar

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import jackknife, mean_and_error, taped

FARTHEST = 1 / 8  # of the box that an interface may be away from where it began
WIDTH = 2.0  # r_c, of an interface, to begin a fit
START = (WIDTH, 0.95, 0.05)  # and with it the fraction of A in both slabs
CLEAR = 3.5  # r_c from either interface at which the bulk begins
SHARE = 0.8  # of the way to the middle of a slab, at which its bulk begins in a short box
TAIL = 2.0  # r_c from either interface beyond which its tail is an exponential
SHORTEST, LONGEST = 0.1, 1.5  # r_c, the decay lengths between which that of any tail lies
STEADY = 2.0  # standard errors by which the halves of a run may differ
ENOUGH = 5.0  # independent samples without which an error is a guess
PRECISE = 0.3  # largest relative error of a fraction whose logarithm still has a linear error

# What `sweep_chi` gives, with units; ``drift`` is between halves, in standard errors.
FOUND = {
    "chi": "1", "chi_error": "1", "fraction": "1", "drift": "1", "settled": "1", "width": "r_c",
    "width_error": "r_c", "excess_repulsion": "kT / r_c",
}  # fmt: skip


class Slabs(NamedTuple):
    """Densities at distances from the nearer interface, in blocks of a run."""

    # (block, 2), in r_c: where A begins, near 0, and where it ends, near half the box
    position: np.ndarray
    distance: np.ndarray  # (n,), from the nearer interface in r_c, up to a quarter of the box
    # (block, 2, n), of the minority and of the majority, mean of both sides of both interfaces
    density: np.ndarray
    # Whether an interface was not found within `FARTHEST` of where it began, in some block: near
    # the critical point slabs mix, and what is seen at a distance from there means nothing.
    lost: bool


@taped
def slabs(density: np.ndarray, z: np.ndarray, length: float) -> Slabs:
    """Densities of two slabs as seen from their interfaces.

    ``density``: (block, 2, n) array; of A and B in consecutive blocks of the run; A began in the
    first half. ``z``: (n,) array; middles of slices of equal width. ``length``: of the box along z.
    """
    position, thickness = interfaces(density, z, length), z[1] - z[0]
    distance = np.arange(0.5 * thickness, length / 4, thickness)
    seen = []
    for block, (first, second) in zip(density, position):
        # On both sides of both interfaces: two in the slab of A, two in that of B.
        places = [first + distance, second - distance, first - distance, second + distance]
        a, b = (np.interp(places, z, profile, period=length) for profile in block)
        minority, majority = [*b[:2], *a[2:]], [*a[:2], *b[2:]]
        seen.append([np.mean(minority, axis=0), np.mean(majority, axis=0)])
    lost = bool((np.abs(position - [0.0, length / 2]) >= FARTHEST * length).any())
    return Slabs(position, distance, np.array(seen), lost)


def interfaces(density: np.ndarray, z: np.ndarray, length: float) -> np.ndarray:
    """Positions of both interfaces in each block, (block, 2); arguments as of `slabs`.

    Two hyperbolic tangents are fitted to the fraction of A: all parameters to the mean of the run,
    then the positions alone to each block, no farther off than `FARTHEST`.
    """
    fraction = density[:, 0] / density.sum(axis=1)
    began = np.array([0.0, length / 2])

    def whole(z, first, second, width, inside, outside):
        share = np.zeros_like(z)  # 2 inside of the slab, 0 outside, in a periodic box
        for shift in (-length, 0.0, length):
            share += np.tanh(2 * (z - first - shift) / width)
            share -= np.tanh(2 * (z - second - shift) / width)
        return outside + (inside - outside) * (share / 2)

    def fitted(function, y, start):
        try:
            return curve_fit(function, z, y, p0=start)[0]
        except RuntimeError:  # no fit: the slabs have mixed
            return start

    held = fitted(whole, fraction.mean(axis=0), (*began, *START))[2:]
    found = [fitted(lambda z, *ends: whole(z, *ends, *held), block, began) for block in fraction]
    reach = FARTHEST * length
    return np.clip(found, began - reach, began + reach)


def interface_width(seen: Slabs) -> tuple[float, float]:
    """Width xi of m tanh(2 d / xi) through the difference of both densities, and its error, in r_c.

    This is Groot and Warren 1997, Eq. 34, with a density that does not vanish in the other phase.
    Slices of width h, and lines between their middles, widen a profile by a variance of h^2 / 12
    and h^2 / 6; that of the slope of tanh(2 d / xi) is pi^2 xi^2 / 48. So 12 h^2 / pi^2 is taken
    off xi^2.
    """
    slice_width = seen.distance[1] - seen.distance[0]

    def profile(d, m, xi):
        return m * np.tanh(2 * d / xi)

    def width(mean):
        depth = mean[1] - mean[0]
        try:
            _, xi = curve_fit(profile, seen.distance, depth, p0=(depth[-1], WIDTH))[0]
        except RuntimeError:
            return np.nan
        return np.sqrt(max(0.0, xi**2 - 12 * slice_width**2 / np.pi**2))

    return jackknife(seen.density, width)


class Composition(NamedTuple):
    """Minority fraction of a pair of coexisting phases."""

    fraction: float
    error: float
    drift: float  # from the first to the second half of the run, in standard errors of that
    samples: float  # independent ones that the run is worth
    mixed: bool  # whether an interface was lost, or the fraction cannot be told from one half

    @property
    def steady(self) -> bool:
        """Whether both slabs stayed, and the fraction changed by less than its error allows."""
        return not self.mixed and abs(self.drift) <= STEADY

    @property
    def settled(self) -> bool:
        """Whether the run was in equilibrium and long enough to give chi an error."""
        precise = self.samples >= ENOUGH and self.error < PRECISE * self.fraction
        return self.steady and precise


def composition(seen: Slabs) -> Composition:
    """Minority fraction far from the interfaces, both phases taken together.

    Tails of interfaces between chains reach to the middle of the slabs. So the fraction beyond
    `TAIL` is fitted by phi + A cosh((L/4 - d) / xi), d the distance from the nearer interface, and
    phi is what is asked for. A hyperbolic tangent of width w has xi = w / 4; up to twice that is
    allowed, beyond it noise of the bulk would pass for a tail.

    The error is that of an average over the bulk or that of the fit, the larger. NaN, and so not
    settled, where the run is too short for it.
    """
    density = seen.density[:, :, in_bulk(seen.distance)].sum(axis=2)
    series = density[:, 0] / density.sum(axis=1)
    mean, error, tau = mean_and_error(series)
    width, _ = interface_width(seen)
    widest = LONGEST if np.isnan(width) else np.clip(width / 2, 2 * SHORTEST, LONGEST)
    fraction, fitted = jackknife(
        seen.density, lambda mean: bulk_fraction(mean, seen.distance, widest)
    )
    # Each half's mean has sqrt(2) times the error of the whole run's, their difference twice.
    half = len(series) // 2
    change = series[half:].mean() - series[:half].mean()
    drift = float(change / (2 * error)) if error != 0 else 0.0
    relative = error / mean if mean > 0 else 0.0
    error = float(np.maximum(relative * fraction, fitted))
    samples = len(series) / (2 * tau)
    mixed = seen.lost or bool(fraction + STEADY * error >= 0.5)
    return Composition(fraction, error, drift, samples, mixed)


def in_bulk(distance: np.ndarray) -> np.ndarray:
    """Mask of the distances from an interface at which the bulk is taken to begin."""
    return distance >= min(CLEAR, SHARE * distance[-1])


def bulk_fraction(profile: np.ndarray, distance: np.ndarray, widest: float) -> float:
    """Minority fraction, 0 or more, far from interfaces, their tails fitted and taken off.

    ``profile``: (2, n) array; densities of minority and majority. ``distance``: (n,) array; from
    the nearer interface in r_c. ``widest``: longest decay length xi that a tail may have, in r_c.
    """
    middle = distance[-1] + 0.5 * (distance[1] - distance[0])
    use = distance > min(TAIL, 0.6 * middle)
    y, inward = (profile[0] / profile.sum(axis=0))[use], middle - distance[use]

    def fit(decay):
        tail = np.cosh(inward / decay) / np.cosh(inward.max() / decay)
        about = tail - (level := tail.mean())  # a line by sums: a fifth of the time of a solver
        height = max(0.0, about @ (y - y.mean()) / (about @ about))  # none of the other phase
        constant = y.mean() - height * level
        return constant, np.sum((y - constant - height * tail) ** 2)

    best = minimize_scalar(lambda decay: fit(decay)[1], bounds=(SHORTEST, widest), method="bounded")
    return max(0.0, float(fit(best.x)[0]))


def chi_and_error(fraction: float, error: float, length: int = 1) -> tuple[float, float]:
    """chi from the minority fraction of two phases (Groot and Warren 1997, Eq. 18), and its error.

    NaN of a fraction of none, or where the phases have mixed.
    """
    if not 0 < fraction < 0.5:
        return np.nan, np.nan
    odds, skew = np.log((1 - fraction) / fraction), 1 - 2 * fraction
    slope = (2 * odds / skew**2 - 1 / (fraction * (1 - fraction) * skew)) / length
    return float(odds / skew / length), float(abs(slope)) * error


def sweep_chi(sweep: xr.Dataset, axis: str) -> xr.Dataset:
    """chi per segment of every point of a sweep of slabs over one axis, replicas taken together.

    ``sweep``: collected runs of two species in slabs, with profiles. Result: `FOUND` over the axis.
    """
    sweep = sweep[["scene", "density_profile"]]  # choosing runs costs for each variable there is
    rows = []
    for place in range(sweep.sizes[axis]):
        runs = sweep.isel({axis: place})
        scene = first_scene(runs)
        profiles = runs.density_profile.transpose("replica", "block", "species", "z").values
        a = scene.species.index(scene.molecules[0].beads[0])  # which began in the first half
        seen = [slabs(each[:, [a, 1 - a]], runs.z.values, max(scene.box)) for each in profiles]
        parts = [composition(part) for part in seen]
        widths, width_errors = np.transpose([interface_width(part) for part in seen])
        together = Composition(
            float(np.mean([part.fraction for part in parts])),
            float(np.sqrt(sum(part.error**2 for part in parts))) / len(parts),
            max((part.drift for part in parts), key=abs),
            float(sum(part.samples for part in parts)),
            any(part.mixed for part in parts),
        )
        chi = chi_and_error(together.fraction, together.error, len(scene.molecules[0].beads))
        rows.append(together._asdict() | {
            "chi": chi[0],
            "chi_error": chi[1],
            "settled": float(together.settled),
            "width": float(widths.mean()),
            "width_error": float(np.sqrt((width_errors**2).sum())) / len(widths),
            "excess_repulsion": scene.repulsion[a, 1 - a] - scene.repulsion[a, a],
        })  # fmt: skip
    variables = {  # put in at once: one by one each would be aligned with all others
        name: (axis, [row[name] for row in rows], {"units": u, "long_name": name.replace("_", " ")})
        for name, u in FOUND.items()
    }
    return xr.Dataset(variables, {axis: sweep[axis]})
