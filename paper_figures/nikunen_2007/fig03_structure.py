"""Figure 3: g(r) and bond lengths of the parameter sets, and the criterion that they decide."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import block_mean_and_error
from dpd.analysis.structure import blocks_of, criterion, radial_distribution, rise
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels

TITLE = "Radial distribution function (a) and bond lengths (b) for the parameter sets, k = 2 a."
PAPER_SHOWS = (
    "The paper shows both for N = 256 and four sets, takes r_min where g(r) = 0.05 and l_max "
    "where the bond length density, normalised to unit area, falls to 0.05, and holds that bonds "
    "cannot cross if sqrt(2) r_min > l_max. Insets: the ends of the curves; dots: r_min and "
    "l_max. Its control a 25, k 50 has no published numbers. Here: the longest chains of this "
    "study."
)
ERRORS = (
    "Errors of g(r) and of densities are smaller than the lines; those of r_min and l_max by "
    "leaving out blocks."
)
COLORS = {"a25": BLACK, "a50": BLUE, "a100": GREEN, "a150": ORANGE, "a200": RED}
LEVEL = 0.05


def compute(sweeps):
    """Curves and numbers of the longest chains, for each set."""
    every = sweeps["statics"]
    runs = every.sel(length=every.length.max())
    r = runs.r.values
    rows, curves = [], []
    for name in runs.set.values:
        at = runs.sel(set=name)
        g, _, _ = radial_distribution(at)
        bonds = blocks_of(at.bond_density)
        closest, longest = criterion(at)
        mean, mean_error = block_mean_and_error(blocks_of(at.bond_mean))
        deviation = at.bond_mean_square - at.bond_mean**2
        rms, rms_error = block_mean_and_error(np.sqrt(blocks_of(deviation)))
        rows.append((*closest, *longest, mean, mean_error, rms, rms_error, float(at.kT.mean())))
        curves.append((g, bonds.mean(axis=0)))
    data = xr.Dataset(
        {
            "g": (("set", "r"), [g for g, _ in curves], {"units": "1"}),
            "density": (("set", "bond_length"), [d for _, d in curves], {"units": "1 / r_c"}),
        },
        {"set": runs.set, "r": runs.r, "bond_length": runs.bond_length},
        {"length": int(runs.length)},
    )
    names = (
        "r_min", "r_min_error", "l_max", "l_max_error", "mean_bond", "mean_bond_error", "rms",
        "rms_error", "kT",
    )  # fmt: skip
    for name, column in zip(names, np.array(rows).T):
        data[name] = ("set", column, {"units": "kT" if name == "kT" else "r_c"})
    shorter = [
        [
            rise(r, radial_distribution(every.sel(set=name, length=n))[0], LEVEL)
            for n in every.length.values
        ]
        for name in runs.set.values
    ]
    data["r_min_of"] = (("set", "chain"), shorter, {"units": "r_c", "long_name": "r_min over N"})
    data = data.assign_coords(chain=every.length.values)
    data["margin"] = (np.sqrt(2) * data.r_min - data.l_max).assign_attrs(units="r_c")
    return data


def measured(data):
    """Table II, and the bond lengths of the text."""
    found = {}
    for name in ("a50", "a100", "a150", "a200"):
        for quantity in ("r_min", "l_max", "mean_bond", "rms"):
            if name not in data.set.values:
                found[f"{quantity}_{name}"] = Measured(np.nan, np.nan)
                continue
            at = data.sel(set=name)
            note = f"N {data.attrs['length']}, kT {float(at.kT):.3f} at the paper's dt"
            if quantity == "r_min" and data.sizes["chain"] > 1:
                trend = ", ".join(f"{value:.4f}" for value in at.r_min_of.values[:-1])
                lengths = ", ".join(str(n) for n in data.chain.values[:-1])
                note += f"; {trend} at N {lengths}"
            found[f"{quantity}_{name}"] = Measured(
                float(at[quantity]), float(at[f"{quantity}_error"]), note
            )
    return found


def draw(data):
    """Two panels with insets."""
    figure, (left, right) = panels(2)
    inner = left.inset_axes([0.55, 0.5, 0.42, 0.45])
    outer = right.inset_axes([0.58, 0.42, 0.39, 0.45])
    for name in data.set.values:
        at, color = data.sel(set=name), COLORS.get(str(name), BLACK)
        for axes in (left, inner):
            axes.plot(data.r, at.g, color=color, label=f"a = {str(name)[1:]}")
        for axes in (right, outer):
            axes.plot(data.bond_length, at.density, color=color, label=f"a = {str(name)[1:]}")
        inner.plot(at.r_min, LEVEL, "o", color=color)
        outer.plot(at.l_max, LEVEL, "o", color=color)
    for axes in (inner, outer):
        axes.axhline(LEVEL, color=BLACK, linewidth=0.5)
        axes.tick_params(labelsize=5)
    inner.set(xlim=(0.3, 0.9), ylim=(0, 0.2))
    outer.set(xlim=(1.0, 1.5), ylim=(0, 0.5))
    left.set(xlim=(0, 3), ylim=(0, 3.3), xlabel="distance r / $r_c$", ylabel="g(r)", title="(a)")
    right.set(xlim=(0.6, 1.6), ylim=(0, None), xlabel="bond length / $r_c$",
              ylabel="probability density / $r_c^{-1}$", title="(b)")  # fmt: skip
    right.legend(loc="upper left")
    return figure
