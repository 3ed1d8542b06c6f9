"""What figures of the dynamics of Groot and Warren 1997 share: D and nu of runs."""

from typing import NamedTuple

import numpy as np

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.statistics import linear_fit
from dpd.analysis.viscosity import viscosities, viscosity_of_two_flows
from paper_figures.groot_warren_1997.transport_theory import slowed_by_images

AFTER = 5.0  # units of time, beyond which displacements grow in proportion to time


class Found(NamedTuple):
    """A value and its standard error."""

    value: float
    error: float

    def over(self, other):
        """This value over an independent one."""
        ratio = self.value / other.value
        relative = np.hypot(self.error / self.value, other.error / other.value)
        return Found(ratio, abs(ratio) * float(relative))


def density_of(runs):
    """Beads per r_c^3."""
    scene = first_scene(runs)
    return scene.beads / scene.volume


class Sheared(NamedTuple):
    """Kinematic viscosities at some shear rates, and without shear."""

    rate: np.ndarray
    nu: np.ndarray
    error: np.ndarray
    at_rest: Found
    slope: float  # over the square of the rate


def sheared(runs):
    """Kinematic viscosity over the shear rate, and without shear.

    ``runs``: over ``rate``. Result: without shear: the constant of a straight line in the square of
    the rate, as both signs of a rate give the same.
    """
    eta, rates = viscosities(runs), runs.rate.values.astype(float)
    nu, error = (eta[name].values / density_of(runs) for name in ("viscosity", "viscosity_error"))
    known = np.isfinite(error) & (error > 0)
    if known.sum() < 2:
        return Sheared(rates, nu, error, Found(np.nan, np.nan), np.nan)
    basis = [np.ones(known.sum()), rates[known] ** 2]
    fit = linear_fit(basis, nu[known], error[known])
    at_rest = Found(float(fit.values[0]), float(fit.errors[0]))
    return Sheared(rates, nu, error, at_rest, float(fit.values[1]))


def of_two_flows(runs):
    """Kinematic viscosity of one point of two opposite flows."""
    scene = first_scene(runs)
    eta = viscosity_of_two_flows(
        runs.isel(replica=0), scene.data["body_force"]["strength"], scene.box[2]
    )
    return Found(eta.value / density_of(runs), eta.error / density_of(runs))


def in_a_cube(runs):
    """Self-diffusion constant of one point, by displacements in its own periodic box.

    Result: without an error where displacements end before they grow in proportion to time.
    """
    moved = displacements(runs, "centre")
    value, error = diffusion_constant(moved, 3, min(AFTER, moved.time[-1] / 4))
    return Found(value, error if moved.time[-1] >= 2 * AFTER else np.nan)


def in_an_infinite_box(found, edge, nu, density, kT):
    """A self-diffusion constant without the drag of a bead's own images.

    ``found``: in a periodic cube. ``edge``: of the cube in r_c. ``nu``: kinematic viscosity.
    Result: the error is that of both D and nu.
    """
    slowed = float(slowed_by_images(edge, density, nu.value, found.value, kT))
    # What D adds to this error is small beside D's own.
    of_nu = slowed * nu.error / (nu.value + found.value)
    return Found(found.value + slowed, float(np.hypot(found.error, of_nu)))
