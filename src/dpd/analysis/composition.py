"""Compositions of coexisting phases, and the chi parameter that they stand for."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import minimize_scalar

from dpd.analysis.collect import first_scene
from dpd.analysis.interfaces import interface_width, slabs
from dpd.analysis.statistics import jackknife, mean_and_error

if TYPE_CHECKING:
    from dpd.analysis.interfaces import Slabs

CLEAR = 3.5  # r_c from either interface at which the bulk begins
TAIL = 2.0  # r_c from either interface beyond which its tail is an exponential
SHORTEST, LONGEST = 0.1, 1.5  # r_c, the decay lengths between which that of any tail lies
STEADY = 2.0  # standard errors by which the halves of a run may differ
ENOUGH = 5.0  # independent samples without which an error is a guess
PRECISE = 0.3  # largest relative error of a fraction whose logarithm still has a linear error

LONG_NAMES = {
    "chi": "chi by Eq. 18",
    "chi_error": "standard error",
    "fraction": "minority fraction",
    "drift": "change between halves in standard errors",
    "samples": "independent samples in a run",
    "counted": "minority beads in the bulk",
    "settled": "whether in equilibrium",
    "width": "width of the interfaces",
    "width_error": "standard error",
    "moved": "largest distance between two places of one interface",
    "excess_repulsion": "a_AB - a_AA",
}


class Composition(NamedTuple):
    """Minority fraction of a pair of coexisting phases.

    ``drift`` is the change of the fraction from the first to the second half of the run,
    in standard errors of that change; ``samples`` how many independent ones the run is
    worth; ``counted`` the mean number of minority beads in the windows; ``mixed`` whether the
    slabs are gone: an interface was lost, see `dpd.analysis.interfaces.Slabs`, or the fraction
    cannot be told from one half.
    """

    fraction: float
    error: float
    drift: float
    samples: float
    counted: float
    mixed: bool

    @property
    def steady(self) -> bool:
        """Whether both slabs stayed, and the fraction changed by less than its error allows."""
        return not self.mixed and abs(self.drift) <= STEADY

    @property
    def settled(self) -> bool:
        """Whether the run was in equilibrium and long enough to give chi an error."""
        precise = self.samples >= ENOUGH and self.error < PRECISE * self.fraction
        return self.steady and precise


def composition(seen: Slabs, slice_volume: float) -> Composition:
    """Minority fraction far from the interfaces, both phases taken together.

    Interfaces between chains reach far: where a tail is left in the middle of the slabs,
    an average there is no bulk value. So the fraction beyond `TAIL` is fitted by
    phi + A cosh((L/4 - d) / xi), d the distance from the nearer interface, which is the
    form of two small tails, and phi is what is asked for. A hyperbolic tangent of width w has
    xi = w / 4; up to twice that is allowed, beyond it noise of the bulk would pass for a tail.

    ``slice_volume``: of one slice of the profile. Result: the error is that of an average over the
    bulk, or that of the fit, by leaving out groups of blocks in turn: the larger. NaN, and so not
    settled, where the run is too short for it.
    """
    bulk = in_bulk(seen.distance)
    minority = seen.density[:, 0, bulk].sum(axis=1)
    series = minority / seen.total[:, bulk].sum(axis=1)
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
    counted = 4 * float(minority.mean()) * slice_volume  # on both sides of two interfaces
    return Composition(fraction, error, drift, samples, counted, mixed)


def in_bulk(distance: np.ndarray) -> np.ndarray:
    """Mask of the distances from an interface at which the bulk is taken to begin."""
    return distance >= min(CLEAR, 0.8 * distance[-1])


def bulk_fraction(profile: np.ndarray, distance: np.ndarray, widest: float) -> float:
    """Minority fraction far from interfaces, their tails fitted and taken off.

    ``profile``: (2, n) array; densities of minority and majority. ``distance``: (n,) array; from
    the nearer interface in r_c, up to the middle of a slab. ``widest``: longest decay length xi
    that a tail may have, in r_c. Result: not below 0.
    """
    middle = distance[-1] + 0.5 * (distance[1] - distance[0])
    use = distance > min(TAIL, 0.6 * middle)
    y, inward = (profile[0] / profile.sum(axis=0))[use], middle - distance[use]

    def fit(decay):
        basis = np.stack([np.ones_like(y), np.cosh(inward / decay) / np.cosh(inward.max() / decay)])
        coefficients = np.linalg.lstsq(basis.T, y, rcond=None)[0]
        if coefficients[1] < 0:  # a tail of the other phase cannot be negative
            coefficients = np.array([y.mean(), 0.0])
        return coefficients, np.sum((y - coefficients @ basis) ** 2)

    def misfit(decay):
        _, squares = fit(decay)
        return squares

    best = minimize_scalar(misfit, bounds=(SHORTEST, widest), method="bounded").x
    (bulk, _), _ = fit(best)
    return max(0.0, float(bulk))


def chi_of_composition(phi: npt.ArrayLike, length: float = 1) -> float | np.ndarray:
    """chi from the minority fraction of two coexisting phases, Eq. 18."""
    phi = np.asarray(phi, dtype=float)
    return np.log((1 - phi) / phi) / (1 - 2 * phi) / length


def chi_slope(phi: npt.ArrayLike, length: float = 1) -> float | np.ndarray:
    """d chi / d phi of `chi_of_composition`, to carry errors."""
    phi = np.asarray(phi, dtype=float)
    odds = np.log((1 - phi) / phi)
    skew = 1 - 2 * phi
    return (2 * odds / skew**2 - 1 / (phi * (1 - phi) * skew)) / length


def chi_and_error(fraction: float, error: float, length: int = 1) -> tuple[float, float]:
    """chi by Groot and Warren 1997, Eq. 18, with the error of the fraction carried over.

    Returns ``chi``, ``error``: NaN where no minority bead was seen, or where the phases have mixed.
    """
    if not 0 < fraction < 0.5:
        return np.nan, np.nan
    chi = float(chi_of_composition(fraction, length))
    return chi, abs(float(chi_slope(fraction, length))) * error


def sweep_chi(sweep: xr.Dataset, axis: str) -> xr.Dataset:
    """chi of every point of a sweep of slabs, replicas taken together.

    ``sweep``: collected runs of two species in slabs, with profiles; one axis besides ``replica``.
    ``axis``: name of that axis. Result: the names of `LONG_NAMES` over the axis; chi is per
    segment, ``settled`` is 1 or 0.
    """
    rows = [_chi_of_point(sweep.isel({axis: place})) for place in range(sweep.sizes[axis])]
    units = dict.fromkeys(rows[0], "1")
    units |= {"excess_repulsion": "kT / r_c", "width": "r_c", "width_error": "r_c", "moved": "r_c"}
    variables = {
        name: (axis, [row[name] for row in rows], {"units": unit, "long_name": LONG_NAMES[name]})
        for name, unit in units.items()
    }
    return xr.Dataset(variables, {axis: sweep[axis]})


def _chi_of_point(runs):
    """What `sweep_chi` says of one point, by name."""
    scene = first_scene(runs)
    length, box = len(scene.molecules[0].beads), scene.box
    slice_volume = float(np.prod(box)) / runs.sizes["z"]
    profiles = runs.density_profile.transpose("replica", "block", "species", "z").values
    seen = [slabs(profile, runs.z.values, max(box)) for profile in profiles]
    parts = [composition(part, slice_volume) for part in seen]
    widths = np.array([interface_width(part) for part in seen])
    together = Composition(
        float(np.mean([part.fraction for part in parts])),
        float(np.sqrt(sum(part.error**2 for part in parts))) / len(parts),
        max((part.drift for part in parts), key=abs),
        float(sum(part.samples for part in parts)),
        float(np.mean([part.counted for part in parts])),
        any(part.mixed for part in parts),
    )
    chi, chi_error = chi_and_error(together.fraction, together.error, length)
    a, b = scene.species.index("A"), scene.species.index("B")
    return {
        "chi": chi,
        "chi_error": chi_error,
        "fraction": together.fraction,
        "drift": together.drift,
        "samples": together.samples,
        "counted": together.counted,
        "settled": float(together.settled),
        "width": float(widths[:, 0].mean()),
        "width_error": float(np.sqrt((widths[:, 1] ** 2).sum())) / len(widths),
        "moved": float(max(np.ptp(part.position, axis=0).max() for part in seen)),
        "excess_repulsion": scene.repulsion[a, b] - scene.repulsion[a, a],
    }
