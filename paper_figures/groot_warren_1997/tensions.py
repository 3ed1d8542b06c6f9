"""What Figures 9 to 13 of Groot and Warren 1997 share: tensions as their laws take them."""

import numpy as np

from dpd.analysis.tension_laws import tension_law
from dpd.analysis.tension_sweeps import sweep_tension
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLUE, GREEN, ORANGE, PURPLE, RED, SKY
from paper_figures.groot_warren_1997.shared import misfit

VAN_DER_WAALS = {"critical": 2.0, "mu": 1.5}  # mean field: Flory-Huggins, and its exponent
SCALED = r"$\sigma / (\rho k_BT r_c)$"
FEW = "fewer than four settled runs"
NOT_SETTLED = (
    "Open points are not fitted: the slabs have mixed, the composition drifted by more than 2 "
    "standard errors between the halves of the run, or the run is too short for an error"
)
# chi N in which the laws of chains are fitted. The paper gives no list of N and Delta a: from a
# little above the critical point up to N = 10 at its reference, chi = 1.53.
LEAST_SEGREGATED, MOST_SEGREGATED = 2.2, 15.3
OUTSIDE = f"or chi N is not between {LEAST_SEGREGATED:g} and {MOST_SEGREGATED:g}"
GROUPS = tuple(zip((BLUE, ORANGE, GREEN, RED, PURPLE, SKY), ("o", "s", "^", "D", "v", "P")))


def scaled_tensions(sweep, slope):
    """Tensions of a sweep over rho kT r_c, with the chi that a published slope gives.

    Parameters
    ----------
    sweep : xarray.Dataset
        Collected slabs.
    slope : float
        chi kT / Delta a.

    Returns
    -------
    xarray.Dataset
        What `dpd.analysis.tension_sweeps.sweep_tension` gives, and ``chi``, ``segregation``
        (chi N), ``scaled``, ``scaled_error``, and ``fitted``, which runs have settled.
    """
    data = sweep_tension(sweep)
    one = {"units": "1"}
    data["chi"] = (slope * data.excess_repulsion).assign_attrs(one, long_name="chi of Delta a")
    data["segregation"] = (data.chi * data.beads).assign_attrs(one, long_name="chi N")
    for name in ("tension", "tension_error"):
        scaled = data[name] / data.density
        data[name.replace("tension", "scaled")] = scaled.assign_attrs(
            one, long_name=f"{data[name].long_name}, over rho kT r_c"
        )
    data["fitted"] = (data.settled == 1) & (data.scaled_error > 0)
    return data


def tensions_of_chains(sweep, slope):
    """The same of chains, of which those with chi N inside the window are fitted.

    Parameters
    ----------
    sweep, slope
        As for `scaled_tensions`.

    Returns
    -------
    xarray.Dataset
    """
    data = scaled_tensions(sweep, slope)
    inside = (data.segregation >= LEAST_SEGREGATED) & (data.segregation <= MOST_SEGREGATED)
    data["fitted"] = data.fitted & inside
    return data


def law_of(parts, **held):
    """Fit the law of tensions to all settled runs of some datasets.

    Parameters
    ----------
    parts : list of xarray.Dataset
        From `scaled_tensions`.
    **held : float
        Numbers of the law that are not fitted.

    Returns
    -------
    dpd.analysis.tension_laws.TensionLaw
    """
    columns = [
        np.concatenate([part[name].values[part.fitted.values] for part in parts])
        for name in ("chi", "beads", "scaled", "scaled_error")
    ]
    return tension_law(*columns, **held)


def put_law(data, name, law):
    """Put the numbers of a law into a dataset, as NAME_prefactor, NAME_prefactor_error and so on.

    Parameters
    ----------
    data : xarray.Dataset
    name : str
    law : dpd.analysis.tension_laws.TensionLaw
    """
    for part in ("prefactor", "alpha", "critical", "mu"):
        found = getattr(law, part)
        data[f"{name}_{part}"] = ((), found.value, {"units": "1"})
        data[f"{name}_{part}_error"] = ((), found.error, {"units": "1"})
    data[f"{name}_reduced_chi_square"] = ((), law.reduced_chi_square, {"units": "1"})
    data[f"{name}_p_value"] = ((), law.p_value, {"units": "1"})
    data[f"{name}_points"] = ((), law.points, {"units": "1"})


def curve(data, name, chi, length=1.0):
    """The law that `put_law` has put into a dataset, as scaled tensions at some chi.

    Parameters
    ----------
    data : xarray.Dataset
    name : str
    chi, length : float or array
    """
    k, alpha, critical, mu = (
        float(data[f"{name}_{part}"]) for part in ("prefactor", "alpha", "critical", "mu")
    )
    return k * chi**alpha * np.maximum(1 - critical / (chi * length), 0) ** mu


def measured_part(data, name, part):
    """One number of a law for the table of verdicts.

    Parameters
    ----------
    data : xarray.Dataset
    name, part : str

    Returns
    -------
    dpd.analysis.verdicts.Measured
        Not to be judged where the points do not follow the law.
    """
    points, quality = int(data[f"{name}_points"]), float(data[f"{name}_reduced_chi_square"])
    return Measured(
        float(data[f"{name}_{part}"]), float(data[f"{name}_{part}_error"]),
        how_well(points, quality),
        off_the_law(data, name) if points > 3 else FEW,
    )  # fmt: skip


def off_the_law(data, name):
    """Why the numbers of a law in a dataset are not judged; empty if the points follow it."""
    return misfit(float(data[f"{name}_p_value"]), "one curve of this law", "its numbers depend")


def how_well(points, quality):
    """How many runs a law was fitted to, and how well they lie on it."""
    return f"{points} settled runs, reduced chi-square {quality:.2f}"
