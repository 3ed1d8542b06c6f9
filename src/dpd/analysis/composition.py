"""Compositions of coexisting phases, and the chi parameter that they stand for."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import jackknife, mean_and_error
from dpd.theory.flory_huggins import chi_of_composition, chi_slope

CLEAR = 3.5  # r_c from either interface at which the bulk begins
TAIL = 2.5  # r_c from either interface beyond which its tail is an exponential
DECAY = (0.2, 1.5)  # r_c, lengths that the tail may have
STEADY = 2.0  # standard errors by which the halves of a run may differ
ENOUGH = 5.0  # independent samples without which an error is a guess
PRECISE = 0.3  # largest relative error of a fraction whose logarithm still has a linear error


class Composition(NamedTuple):
    """Minority fraction of a pair of coexisting phases.

    ``drift`` is the change of the fraction from the first to the second half of the run,
    in standard errors of that change; ``samples`` how many independent ones the run is
    worth; ``counted`` the mean number of minority beads in the windows.
    """

    fraction: float
    error: float
    drift: float
    samples: float
    counted: float

    @property
    def settled(self):
        """Whether the run was in equilibrium and long enough to give chi an error."""
        steady = abs(self.drift) <= STEADY and self.samples >= ENOUGH
        return steady and self.error < PRECISE * self.fraction


def bulk_windows(z, length):
    """Masks of the slices deep in the two slabs, which meet at 0 and at half the length.

    Parameters
    ----------
    z : (n,) array
        Middles of slices.
    length : float
        Of the box along z; slab A fills the first half.

    Returns
    -------
    in_a, in_b : (n,) bool arrays
    """
    from_interface = np.minimum.reduce([np.abs(z), np.abs(z - length / 2), np.abs(z - length)])
    bulk = from_interface >= min(CLEAR, 0.8 * length / 4)
    return bulk & (z < length / 2), bulk & (z > length / 2)


def composition(density, z, length, slice_volume):
    """Minority fraction from a density profile, both phases taken together.

    Interfaces between chains reach far: where a tail is left in the middle of the slabs,
    an average there is no bulk value. So the folded profile beyond `TAIL` is fitted by
    phi + A cosh((L/4 - d) / xi), d the distance from the nearer interface, which is the
    form of two small tails, and phi is the fraction.

    Parameters
    ----------
    density : (block, 2, n) array
        Of A and B in consecutive blocks of the run.
    z : (n,) array
    length, slice_volume : float

    Returns
    -------
    Composition
        The error is that of an average over the bulk, or that of the fit, by leaving out groups
        of blocks in turn: the larger. NaN, and so not settled, where the run is too short for it.
    """
    in_a, in_b = bulk_windows(z, length)
    minority = density[:, 1, in_a].sum(axis=1) + density[:, 0, in_b].sum(axis=1)
    series = minority / density[:, :, in_a | in_b].sum(axis=(1, 2))
    mean, error, tau = mean_and_error(series)
    fraction, fitted = jackknife(density, lambda mean: bulk_fraction(mean, z, length))
    # Each half's mean has sqrt(2) times the error of the whole run's, their difference twice.
    half = len(series) // 2
    change = series[half:].mean() - series[:half].mean()
    drift = float(change / (2 * error)) if error != 0 else 0.0
    relative = error / mean if mean > 0 else 0.0
    error = float(np.maximum(relative * fraction, fitted))
    samples = len(series) / (2 * tau)
    return Composition(fraction, error, drift, samples, float(minority.mean() * slice_volume))


def bulk_fraction(profile, z, length):
    """Minority fraction far from interfaces, their tails fitted and taken off.

    Parameters
    ----------
    profile : (2, n) array
        Densities of A and B; slab A fills the first half.
    z : (n,) array
    length : float

    Returns
    -------
    float
        Not below 0.
    """
    apart = np.minimum.reduce([np.abs(z), np.abs(z - length / 2), np.abs(z - length)])
    fraction = np.where(z < length / 2, profile[1], profile[0]) / profile.sum(axis=0)
    use = apart > min(TAIL, 0.6 * length / 4)
    y, inward = fraction[use], length / 4 - apart[use]

    def fit(decay):
        basis = np.stack([np.ones_like(y), np.cosh(inward / decay) / np.cosh(inward.max() / decay)])
        coefficients = np.linalg.lstsq(basis.T, y, rcond=None)[0]
        if coefficients[1] < 0:  # a tail of the other phase cannot be negative
            coefficients = np.array([y.mean(), 0.0])
        return coefficients, np.sum((y - coefficients @ basis) ** 2)

    best = minimize_scalar(lambda decay: fit(decay)[1], bounds=DECAY, method="bounded").x
    return max(0.0, float(fit(best)[0][0]))


def chi_and_error(fraction, error, length=1):
    """chi by Groot and Warren 1997, Eq. 18, with the error of the fraction carried over.

    Returns
    -------
    chi, error : float
        NaN where no minority bead was seen, or where the phases have mixed.
    """
    if not 0 < fraction < 0.5:
        return np.nan, np.nan
    chi = float(chi_of_composition(fraction, length))
    return chi, float(abs(chi_slope(fraction, length)) * error)


def sweep_chi(sweep, axis):
    """chi of every point of a sweep of slabs, replicas taken together.

    Parameters
    ----------
    sweep : xarray.Dataset
        Collected runs of two species in slabs, with profiles; one axis besides ``replica``.
    axis : str
        Name of that axis.

    Returns
    -------
    xarray.Dataset
        ``chi`` and ``chi_error`` (standard error), per segment, ``fraction``, ``drift``,
        ``samples``, ``counted``, ``settled`` (1 or 0), and ``excess_repulsion``
        a_AB - a_AA, over the axis.
    """
    table = []
    for place in range(sweep.sizes[axis]):
        at = sweep.isel({axis: place})
        scene = first_scene(at)
        length, box = len(scene.molecules[0].beads), scene.box
        slice_volume = float(np.prod(box)) / at.sizes["z"]
        parts = [
            composition(profile, at.z.values, max(box), slice_volume)
            for profile in at.density_profile.transpose("replica", "block", "species", "z").values
        ]
        fraction = float(np.mean([part.fraction for part in parts]))
        error = float(np.sqrt(sum(part.error**2 for part in parts))) / len(parts)
        drift = max((part.drift for part in parts), key=abs)
        counted = float(np.mean([part.counted for part in parts]))
        repulsion = scene.data["repulsion"]
        excess = repulsion["A B"] - repulsion["A A"]
        samples = float(sum(part.samples for part in parts))
        settled = Composition(fraction, error, drift, samples, counted).settled
        chi = chi_and_error(fraction, error, length)
        table.append((*chi, fraction, drift, samples, counted, float(settled), excess))
    columns = np.array(table).T
    names = ("chi", "chi_error", "fraction", "drift", "samples", "counted", "settled")
    units = dict.fromkeys(names, "1") | {"excess_repulsion": "kT / r_c"}
    variables = {
        name: (axis, column, {"units": unit, "long_name": name.replace("_", " ")})
        for (name, unit), column in zip(units.items(), columns)
    }
    return xr.Dataset(variables, {axis: sweep[axis]})
