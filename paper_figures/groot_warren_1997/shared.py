"""What figures of Groot and Warren 1997 share."""

from typing import NamedTuple

from dpd.analysis.statistics import linear_fit, over_replicas
from dpd.report.style import BLUE, GREEN, RED, Look

CROOKED = 0.01  # p-value below which points do not follow a law, and its numbers are not judged
MEAN_FIELD = 3.0  # chi above which the paper trusts Flory-Huggins theory
REPULSIONS = {15.0: (BLUE, "X"), 25.0: (GREEN, "s"), 30.0: (RED, "o")}  # drawn as in the paper
NOT_FITTED = (
    "the slabs have mixed, so that no interface is found in part of the run, the composition "
    "drifted by more than 2 standard errors between the halves of the run, its relative error is "
    "above 30 %, or the run is worth fewer than 5 independent samples or too short for an error."
)


def misfit(p, shape, consequence):
    """Why numbers of a fit are not judged: the points do not follow it; empty if they do.

    Parameters
    ----------
    p : float
        Probability of points that lie worse about the fit, if it is right.
    shape, consequence : str
        What was fitted, and what is uncertain for that.
    """
    if not p < CROOKED:
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

    Parameters
    ----------
    data : xarray.Dataset
        From `dpd.analysis.composition.sweep_chi` over ``excess``, which is Delta a.

    Returns
    -------
    fitted : (n,) array of bool
    fit : dpd.analysis.statistics.Fit or None
        None where no run is good enough.
    """
    fitted = ((data.chi > MEAN_FIELD) & (data.settled == 1)).values
    if not fitted.any():
        return fitted, None
    excess = data.excess.values.astype(float)[fitted]
    return fitted, linear_fit([excess], data.chi.values[fitted], data.chi_error.values[fitted])


def excess_by(runs, forces):
    """Excess pressure by the virial of some forces, replicas taken together.

    Parameters
    ----------
    runs : xarray.Dataset
    forces : str
        ``conservative`` or ``all``.

    Returns
    -------
    value, error : arrays
    """
    name = f"excess_{forces}"
    return over_replicas(runs[name].values, runs[f"{name}_error"].values, -1)
