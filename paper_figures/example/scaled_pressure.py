"""A figure to copy: the excess pressure of the DPD fluid over its density.

It needs ``TITLE``, ``compute`` and ``draw``. What else it may have is said in `load_module` of
src/dpd/report/figures.py. ``measured`` gives the numbers that are held against those in the
file published.yaml beside this one.
"""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import over_replicas
from dpd.analysis.verdicts import Measured
from dpd.report.style import panels, points

TITLE = "Excess pressure of the DPD fluid with repulsion 25, over repulsion and squared density."
REPULSION = 25.0  # kT / r_c


def compute(sweeps):
    """The plotted numbers, from sweeps by name: each has the runs on its axes and ``replica``."""
    runs = sweeps["pressure"]
    pressure, error = over_replicas(
        runs.excess_conservative.values, runs.excess_conservative_error.values, axis=-1
    )
    density = runs.density.values.astype(float)
    scale, units = REPULSION * density**2, {"units": "r_c^4"}
    return xr.Dataset(
        {
            "scaled": ("density", pressure / scale, units),
            "scaled_error": ("density", error / scale, units),  # standard error
        },
        {"density": ("density", density, {"units": "1 / r_c^3"})},
    )


def measured(numbers):
    """Our number for the published one; its error is how densities scatter about the law."""
    dense = numbers.scaled.sel(density=slice(3, None)).values
    error = dense.std(ddof=1) / np.sqrt(len(dense))
    return {"scaled_pressure": Measured(float(dense.mean()), float(error))}


def describe(numbers):
    """The figure in words, for those who cannot see it."""
    low, high = float(np.nanmin(numbers.scaled)), float(np.nanmax(numbers.scaled))
    return f"The scaled pressure lies between {low:.3f} and {high:.3f} at all densities."


def draw(numbers):
    """The figure, from these numbers."""
    figure, axes = panels()
    points(axes, numbers.density, numbers.scaled, numbers.scaled_error, "this work")
    top = 1.2 * float(np.nanmax(numbers.scaled))
    axes.set(xlabel=r"density $\rho$", ylabel=r"$(p - \rho k_BT) / a\rho^2$", ylim=(0, top))
    axes.legend(loc="lower right")
    return figure
