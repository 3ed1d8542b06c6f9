"""Surface tension and the profile of the pressure, this engine beside LAMMPS."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.statistics import COVERAGE, block_mean_and_error, mean_and_error
from dpd.report.style import BLACK, BLUE, ORANGE, panels, points
from dpd.report.text import with_error

TITLE = "Normal less tangential pressure across two slabs, of this engine and of LAMMPS."
PAPER_SHOWS = (
    "The slabs of Groot and Warren 1997, Fig. 6. Each pair's pressure is spread along the straight "
    "line between its beads (Irving and Kirkwood), in both codes. The integral over the box, "
    "halved, is the surface tension. Both bulks are isotropic: there the difference vanishes. "
    "Table: the tension of both codes, their difference in standard errors, and of the profile the "
    "largest difference of all slices in the same measure, with the mean square over slices, which "
    "is 1 or less where only noise differs."
)
ERRORS = "Band and bars: 95 % intervals, from blocks of the run."
OWN, LAMMPS = "own", "lammps"
INTERFACES = 2  # of two slabs in a periodic box


def compute(data):
    """Profiles with errors, and the tension of each code."""
    source = data["tension"]
    missing = (source.normal - source.tangential).transpose("code", "block", "slice").values
    length = float(source.slice[0] + source.slice[-1])
    found = [mean_and_error(part.mean(axis=1) * length / INTERFACES)[:2] for part in missing]
    profiles = [block_mean_and_error(part) for part in missing]
    tension, profile = {"units": "kT / r_c^2"}, {"units": "kT / r_c^3"}
    return xr.Dataset(
        {
            "missing": (("code", "slice"), [mean for mean, _ in profiles], profile),
            "missing_error": (("code", "slice"), [error for _, error in profiles], profile),
            "tension": ("code", [mean for mean, _ in found], tension),
            "tension_error": ("code", [error for _, error in found], tension),
        },
        {"code": source.code, "slice": source.slice},
    )


def deviation(numbers, name):
    """Difference of the codes over its standard error."""
    value, error = numbers[name], numbers[f"{name}_error"]
    return (value.sel(code=OWN) - value.sel(code=LAMMPS)) / np.sqrt((error**2).sum("code"))


def measured(data):
    """None: nobody has published these numbers."""
    return {}


def table(data):
    """Tensions and profiles side by side."""
    row = [
        with_error(*(float(data[name].sel(code=code)) for name in ("tension", "tension_error")))
        for code in (OWN, LAMMPS)
    ]
    row.append(f"{float(deviation(data, 'tension')):+.1f}")
    slices = deviation(data, "missing").values
    row.append(f"{np.abs(slices).max():.1f} of {len(slices)} slices; {np.mean(slices**2):.2f}")
    columns = ["tension / kT r_c^-2", "LAMMPS", "difference", "profile: largest; mean square"]
    return pd.DataFrame([["–" if "nan" in cell else cell for cell in row]], columns=columns)


def describe(data):
    """What is seen."""
    return (
        "The difference of normal and tangential pressure is zero in both bulks and has a peak at "
        "each of two interfaces; the points of LAMMPS lie on the band of this engine. The tension "
        f"is {float(data.tension.sel(code=OWN)):.2f}."
    )


def draw(data):
    """The profile of both codes."""
    figure, axes = panels(1)
    own, other = (data.sel(code=code) for code in (OWN, LAMMPS))
    reach = COVERAGE * own.missing_error
    axes.fill_between(data.slice, own.missing - reach, own.missing + reach, color=BLUE, alpha=0.3,
                      lw=0)  # fmt: skip
    axes.plot(data.slice, own.missing, color=BLUE, label="this engine")
    if np.isfinite(other.missing).all():
        points(axes, data.slice, other.missing, other.missing_error, "LAMMPS", ORANGE, markersize=2)
    axes.axhline(0, color=BLACK, lw=0.5)
    axes.set(xlim=(0, float(data.slice[0] + data.slice[-1])), xlabel="$z$ / $r_c$",
             ylabel=r"$p_N - p_T$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure
