"""What figures of Groot and Warren 1997 share."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import (
    UNLIKELY,
    block_mean_and_error,
    jackknife,
    linear_fit,
    over_replicas,
)
from dpd.analysis.verdicts import Measured
from dpd.analysis.viscosity import shear_components
from dpd.report.style import BLUE, GREEN, RED, Look

BESIDE = 11  # slices whose errors have their median taken
EVEN = (
    "One slice fixes its own correlation time poorly, so the error is the median of those of "
    "eleven slices beside each other."
)
MEAN_FIELD = 3.0  # chi above which the paper trusts Flory-Huggins theory
REPULSIONS = {15.0: (BLUE, "X"), 25.0: (GREEN, "s"), 30.0: (RED, "o")}  # drawn as in the paper
NOT_FITTED = (
    "the slabs have mixed, so that no interface is found in part of the run, the composition "
    "drifted by more than 2 standard errors between the halves of the run, its relative error is "
    "above 30 %, or the run is worth fewer than 5 independent samples or too short for an error."
)


def misfit(p, shape, consequence):
    """Why numbers of a fit are not judged: the points do not follow it; empty if they do.

    ``p``: probability of points that lie worse about the fit, if it is right. ``shape``,
    ``consequence``: what was fitted, and what is uncertain for that.
    """
    if not p < UNLIKELY:
        return ""
    return (
        f"the points do not lie on {shape} (p = {p:.1g}), so {consequence} on which of them are "
        "fitted"
    )


def look_of(repulsion):
    """How the runs of one repulsion are drawn."""
    color, marker = REPULSIONS.get(float(repulsion), (BLUE, "D"))
    return Look(f"$a$ = {repulsion:g}", color, marker)


class Segregation(NamedTuple):
    """The monomers of one density that segregate: their sweep, published slope, and look."""

    sweep: str
    slope: str
    look: Look


SEGREGATION = {
    3: Segregation("segregation_3", "chi_slope_rho_3", Look(r"$\rho$ = 3", BLUE, "o")),
    5: Segregation("segregation_5", "chi_slope_rho_5", Look(r"$\rho$ = 5", RED, "s")),
}


def monomer_slope(data):
    """Fit chi = s Delta a to the runs of monomers that have settled and whose chi is above 3.

    ``data``: from `dpd.analysis.interfaces.sweep_chi` over ``excess``, which is Delta a. Result:
    ``fitted``: (n,) array of bool. ``fit``: none where no run is good enough.
    """
    fitted = ((data.chi > MEAN_FIELD) & (data.settled == 1)).values
    if not fitted.any():
        return fitted, None
    excess = data.excess.values.astype(float)[fitted]
    return fitted, linear_fit([excess], data.chi.values[fitted], data.chi_error.values[fitted])


def excess_by(runs, forces):
    """Excess pressure by the virial of some forces, replicas taken together.

    ``forces``: ``conservative`` or ``all``. Returns ``value``, ``error``.
    """
    name = f"excess_{forces}"
    return over_replicas(runs[name].values, runs[f"{name}_error"].values, -1)


def mean_and_even_error(profile):
    """Mean over blocks and its standard error, which changes evenly from slice to slice.

    The true error does; that of a single slice is scattered, as its correlation time is, and one
    in a hundred is several times too large. So the median over neighbours is taken, across the
    periodic edge too. NaN next to a slice that has none.
    """
    mean, error = block_mean_and_error(profile)
    away = range(-(BESIDE // 2), BESIDE // 2 + 1)
    return mean, np.median([np.roll(error, n, axis=-1) for n in away], axis=0)


PART = 4.0  # tau, a part of a run that is long beside the memory of the stress


def put_stress_noise(data, runs, which):
    """Put into a dataset the error of a normal stress difference with noise over that without.

    As ``stress_noise`` of single samples of virials: Eq. 15 has rho kT in the place of the momenta,
    whose part, of a variance of rho (kT)^2 / V, is taken off. With it, as ``with_momenta_noise``,
    and of means of all samples, as ``every_step_noise``.

    ``runs``: replicas of one point, with both pressure tensors as series. ``which``: of the five
    components of `dpd.analysis.viscosity.shear_components`; the last is the difference across
    layers along z.
    """
    both = []
    for name in ("pressure_tensor_all_series", "pressure_tensor_series"):
        tensors = runs[name].transpose("replica", "time", "axis", "axis2").values
        both.append(np.concatenate([shear_components(part)[:, which] for part in tensors], axis=1))
    scene = first_scene(runs)
    momenta = scene.beads * float(runs.kT.mean()) ** 2 / float(np.prod(scene.box)) ** 2
    for name, found in (
        ("stress_noise", noise_ratio(*both, 1, momenta)),
        ("with_momenta_noise", noise_ratio(*both, 1)),
        ("every_step_noise", noise_ratio(*both, max(1, round(PART / float(runs.time[0]))))),
    ):
        data[name] = ((), found.value, {"units": "1", "long_name": "ratio of errors"})
        data[f"{name}_error"] = ((), found.error, {"units": "1", "long_name": "standard error"})


def noise_of_stress(data):
    """What `put_stress_noise` has put there, for the table; NaN where it has not."""
    if "stress_noise" not in data:
        return Measured(np.nan, np.nan)
    return Measured(
        float(data.stress_noise), float(data.stress_noise_error),
        f"single samples of virials; with momenta {float(data.with_momenta_noise):.2f}; means of "
        f"all samples over {PART:g} tau, with momenta {float(data.every_step_noise):.2f}",
    )  # fmt: skip


def noise_ratio(
    one: npt.ArrayLike, other: npt.ArrayLike, size: int, shared: float = 0.0
) -> Measured:
    """Error of the mean of one series over that of another one, from means of parts.

    ``one``, ``other``: (n,) or (n, k) arrays; sampled together; k of the same kind are taken
    together. ``size``: samples of a part, which must be long beside the memory of both series.
    ``shared``: variance of means over a part that is in both series and does not count.
    """
    squares = []
    for series in (other, one):
        x = np.asarray(series, dtype=float).reshape(len(np.asarray(series)), -1)
        parts = x[: len(x) // size * size].reshape(-1, size, x.shape[1]).mean(axis=1)
        squares.append(((parts - parts.mean(axis=0)) ** 2).mean(axis=1))

    def ratio(mean):
        return np.sqrt((mean[1] - shared) / (mean[0] - shared))

    return Measured(*jackknife(np.stack(squares, axis=1), ratio))
