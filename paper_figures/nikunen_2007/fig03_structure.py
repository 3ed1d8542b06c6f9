"""Figure 3: g(r) and bond lengths of the parameter sets, and the criterion that they decide."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.statistics import jackknife
from dpd.analysis.structure import (
    AROUND,
    blocks_of,
    peak,
    radial_distribution,
)
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels
from dpd.report.text import with_error
from paper_figures.nikunen_2007.shared import CONTROL, MAIN, SETS, criterion, in_words, repulsion

PUBLISHED = shown_by(__file__)

TITLE = "Radial distribution function (a) and bond lengths (b) for the parameter sets, k = 2 a."
PAPER_SHOWS = (
    "The paper shows both for N = 256 and four sets, takes r_min where g(r) = 0.05 and l_max "
    "where the bond length density, normalised to unit area, falls to 0.05, and holds that bonds "
    "cannot cross if sqrt(2) r_min > l_max. Insets: the ends of the curves; dots: our r_min and "
    "l_max; ticks above: those of Table II. The control a 25, k 50 has no published numbers. Here: "
    "the longest chains of this study; what their length changes is in the figure of Table II. "
    "Table: the criterion, the peak of g(r), of which bonds are a part, beside the highest peak of "
    "the pairs that no bond connects (for a 25 that of the second shell), and the neighbours up to "
    "the first minimum of g(r)."
)
ERRORS = (
    "Errors of g(r) and of densities are smaller than the lines; those of numbers by leaving out "
    "blocks."
)
LEVEL = 0.05


def compute(sweeps):
    """Curves and numbers of the longest chains, for each set."""
    every = sweeps["statics"]
    runs = every.sel(length=every.length.max())
    n = int(runs.length)
    rows, curves = [], []
    for name in runs.set.values:
        at = runs.sel(set=name)
        rows.append([*_criterion_ratio(at), *_shell(at, n)])
        curves.append((radial_distribution(at)[0], blocks_of(at.bond_density).mean(axis=0)))
    data = xr.Dataset(
        {
            "g": (("set", "r"), [g for g, _ in curves], {"units": "1"}),
            "density": (("set", "bond_length"), [d for _, d in curves], {"units": "1 / r_c"}),
        },
        {"set": runs.set, "r": runs.r, "bond_length": runs.bond_length},
        {"length": n},
    )
    names = ("r_min", "l_max", "ratio", "first_peak", "unbonded_peak", "coordination")
    for name, column in zip(names, np.moveaxis(np.array(rows), 1, 0)):
        units = "1" if name in ("ratio", "coordination") else "r_c"
        data[name] = ("set", column[:, 0], {"units": units, "long_name": name.replace("_", " ")})
        data[f"{name}_error"] = ("set", column[:, 1], {"units": units})
    return data


def _criterion_ratio(at):
    """r_min, l_max and sqrt(2) r_min / l_max, each with its standard error."""
    (near, near_error), (far, far_error) = criterion(at)
    ratio = np.sqrt(2) * near / far
    return (
        (near, near_error),
        (far, far_error),
        (ratio, ratio * np.hypot(near_error / near, far_error / far)),
    )


def _shell(at, n):
    """Peak of g(r), peak of the pairs without a bond, and neighbours in the first shell."""
    r, length = at.r.values, at.bond_length.values
    bonds, density = blocks_of(at.bond_density).mean(axis=0), float(at.number_density.mean())

    def free_peak(g):
        return peak(r, unbonded(r, g, length, bonds, 2 * (n - 1) / n, density))

    blocks = blocks_of(at.rdf)
    return (
        jackknife(blocks, lambda g: peak(r, g)),
        jackknife(blocks, free_peak),
        jackknife(blocks, lambda g: neighbours(r, g, density)),
    )


def measured(data):
    """The criterion for each set, and the first shell."""
    found = {}
    for name in SETS:
        found[f"criterion_{name}"] = _measured(data, name, "ratio")
    others = (
        f"{in_words(name)}: {float(data.coordination.sel(set=name)):.1f}"
        for name in data.set.values
    )
    found["coordination"] = _measured(data, MAIN, "coordination", "; ".join(others))
    note = ""
    if MAIN in data.set.values:
        note = f"of all pairs: {float(data.first_peak.sel(set=MAIN)):.3f}"
    found["first_peak"] = _measured(data, MAIN, "unbonded_peak", note)
    return found


def _measured(data, name, quantity, note=""):
    if name not in data.set.values:
        return Measured(np.nan, np.nan)
    at = data.sel(set=name)
    length = f"N {data.attrs['length']}"
    return Measured(
        float(at[quantity]), float(at[f"{quantity}_error"]), "; ".join(filter(None, (length, note)))
    )


def table(data):
    """The criterion and the first shell of each set."""
    rows = [
        (
            in_words(name),
            *(
                with_error(float(data[q].sel(set=name)), float(data[f"{q}_error"].sel(set=name)))
                for q in ("ratio", "first_peak", "unbonded_peak", "coordination")
            ),
        )
        for name in data.set.values
    ]
    return pd.DataFrame(rows, columns=[
        "set", "sqrt(2) r_min / l_max", "peak of g(r) / r_c", "the same, pairs without a bond",
        "neighbours in the first shell",
    ])  # fmt: skip


def describe(data):
    """What is seen."""
    meets = [in_words(name) for name in data.set.values if data.ratio.sel(set=name) > 1]
    return (
        "Peaks of g(r) near 0.96 and of bond lengths grow higher and narrower with a; r_min rises "
        f"from {float(data.r_min.min()):.3f} to {float(data.r_min.max()):.3f} and l_max falls from "
        f"{float(data.l_max.max()):.3f} to {float(data.l_max.min()):.3f}. The criterion is met by "
        f"{', '.join(meets) or 'none'}."
    )


def draw(data):
    """Two panels with insets."""
    figure, (left, right) = panels(2, height=3.0)
    inner = left.inset_axes([0.52, 0.5, 0.46, 0.47])
    outer = right.inset_axes([0.56, 0.36, 0.42, 0.47])
    for name in data.set.values:
        at, color = data.sel(set=name), SETS.get(str(name), BLACK)
        for axes in (left, inner):
            axes.plot(data.r, at.g, color=color, label=f"a = {repulsion(name)}")
        for axes in (right, outer):
            axes.plot(data.bond_length, at.density, color=color, label=f"a = {repulsion(name)}")
        for axes, quantity in ((inner, "r_min"), (outer, "l_max")):
            axes.plot(at[quantity], LEVEL, "o", color=color)
            if name != CONTROL:
                value = PUBLISHED[f"{quantity}_{name}"].value
                axes.plot([value] * 2, [1.6 * LEVEL, 2.4 * LEVEL], color=color, linewidth=1.4)
    for axes in (inner, outer):
        axes.axhline(LEVEL, color=BLACK, linewidth=0.5)
        axes.tick_params(labelsize=7)
    inner.set(xlim=(0.35, 0.85), ylim=(0, 0.2))
    outer.set(xlim=(1.05, 1.45), ylim=(0, 0.3))
    left.set(xlim=(0, 3), ylim=(0, 3.3), xlabel="distance r / $r_c$", ylabel="g(r)")
    right.set(xlim=(0.6, 1.8), ylim=(0, None), xlabel="bond length / $r_c$",
              ylabel="probability density / $r_c^{-1}$")  # fmt: skip
    left.legend(loc="upper left", handlelength=1.2)
    return figure


def trough(r: np.ndarray, g: np.ndarray) -> float:
    """Distance of the first minimum of g(r): the lowest between its peak and twice that.

    By a cubic, as for `peak`.
    """
    first = peak(r, g)
    between = (r > first + AROUND) & (r < 2 * first)
    return peak(r[between], -g[between])


def neighbours(r: np.ndarray, g: np.ndarray, density: float) -> float:
    """Beads in the first shell of another: 4 pi rho times the integral of r^2 g to `trough`."""
    end, width = trough(r, g), r[1] - r[0]
    inside = np.clip((end - r) / width + 0.5, 0, 1)  # share of each bin below the end
    return float(4 * np.pi * density * (inside * r**2 * g).sum() * width)


def unbonded(
    r: np.ndarray,
    g: np.ndarray,
    length: np.ndarray,
    bonds: np.ndarray,
    per_bead: float,
    density: float,
) -> np.ndarray:
    """g(r) of the pairs that no bond connects.

    ``r``, ``g``: (bins,) arrays. ``length``, ``bonds``: (m,) arrays; density of bond lengths,
    normalised to 1. ``per_bead``: bonded neighbours of a bead, 2 (N - 1) / N. ``density``: number
    density in three dimensions. Result: (bins,) array.
    """
    bonded = np.interp(r, length, bonds, right=0.0)
    return g - per_bead * bonded / (4 * np.pi * density * r**2)
