"""What uniform noise would change, in place of the Gaussian noise of the paper."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import over_replicas
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import SINGLE, panels, points
from dpd.report.text import with_error
from paper_figures.nikunen_2007.shared import LABELS, bond_statistics, criterion

LAST_DIGIT = shown_by(__file__)["noise_r_min"].rival  # of Table II

TITLE = "What changes with uniform noise in place of Gaussian noise, a 100, k 200."
PAPER_SHOWS = (
    "Not a figure of the paper, which has Gaussian noise, as all other runs here have. Uniform "
    "noise of the same variance is cheaper. Drawn: the value with uniform noise less that with "
    "Gaussian noise, of (a) kT, and (b) r_min, l_max, the mean bond length and its rms deviation. "
    "Shaded: half of the last digit that Table II prints."
)
ERRORS = "Bars: 95 % intervals of the difference; blocks of both runs."
NAMES = {"kT": r"$k_BT$"} | LABELS
WORDS = {
    "kT": "kT, set to 1", "r_min": "r_min / r_c", "l_max": "l_max / r_c",
    "mean_bond": "mean bond length / r_c", "rms": "rms deviation of bonds / r_c",
}  # fmt: skip


def compute(sweeps):
    """The five quantities with both noises."""
    runs = sweeps["noise"]
    rows = [_quantities(runs.sel(noise=noise)) for noise in runs.noise.values]
    values, errors = np.moveaxis(np.array(rows), -1, 0)
    along, units = ("noise", "quantity"), {"units": "kT, and r_c"}
    return xr.Dataset(
        {"value": (along, values, units), "error": (along, errors, units)},
        {"noise": runs.noise, "quantity": list(NAMES)},
        {"length": len(first_scene(runs).molecules[0].beads)},
    )


def _quantities(at):
    """(value, standard error) of each, in the order of `NAMES`."""
    heat = over_replicas(at.kT.values, at.kT_error.values, -1)
    return [heat, *criterion(at), *bond_statistics(at)]


def difference(data):
    """Uniform less Gaussian, and its standard error, over the quantities."""
    uniform, gaussian = data.sel(noise="uniform"), data.sel(noise="gaussian")
    return uniform.value - gaussian.value, np.hypot(uniform.error, gaussian.error)


def measured(data):
    """Each difference, which should be zero."""
    change, error = difference(data)
    return {
        f"noise_{name}": Measured(
            float(change.sel(quantity=name)), float(error.sel(quantity=name)),
            f"N {data.attrs['length']}",
        )
        for name in NAMES
    }  # fmt: skip


def table(data):
    """Both values of each quantity."""
    rows = []
    for name in NAMES:
        at = data.sel(quantity=name)
        both = (at.sel(noise=noise) for noise in ("uniform", "gaussian"))
        texts = (with_error(float(one.value), float(one.error)) for one in both)
        rows.append((WORDS[name], *texts))
    return pd.DataFrame(rows, columns=["quantity", "uniform", "Gaussian"])


def describe(data):
    """What is seen."""
    change, error = difference(data)
    largest = int(np.argmax(np.abs(change.values) / error.values))
    return (
        f"Five differences with error bars around zero; the largest is that of "
        f"{data['quantity'].values[largest]}, {float(change[largest]):.4f} with a standard error "
        f"of {float(error[largest]):.4f}."
    )


def draw(data):
    """Differences in thousandths: kT, which a run knows less well, and lengths."""
    figure, (left, right) = panels(2, height=2.2, width=SINGLE, width_ratios=(1, 3))
    change, error = (1e3 * part for part in difference(data))
    at = np.arange(len(NAMES))
    half = 1e3 * LAST_DIGIT / 2
    right.axhspan(-half, half, color="0.9", linewidth=0)
    for panel, part, unit in ((left, at < 1, "k_BT"), (right, at >= 1, "r_c")):
        panel.axhline(0, color="0.5", linewidth=0.6)
        points(panel, at[part], change[part], error[part])
        panel.set_xticks(at[part], np.array(list(NAMES.values()))[part])
        panel.set_xlim(at[part][0] - 0.5, at[part][-1] + 0.5)
        panel.set_ylabel(f"uniform less Gaussian / $10^{{-3}}$ ${unit}$")
    return figure
