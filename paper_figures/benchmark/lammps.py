"""This engine beside LAMMPS: speed on four workloads, and the physics of both."""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.statistics import block_mean_and_error
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, panels
from dpd.report.text import with_error
from paper_figures.benchmark.shared import middle_and_range, with_range

TITLE = "Speed of this engine and of LAMMPS (a), and g(r) of both (b)."
PAPER_SHOWS = (
    "Medians of the turns on one core; above the bars the ratio of the two. Dashed: five times "
    "the rate of LAMMPS. In (b) lines are this engine, points LAMMPS, each workload higher by "
    "one; peaks above 2.2, of neighbours along a chain, are left open. Table: means over snapshots "
    "of both codes going on from one state, the difference in its standard errors, and of g(r) "
    "the largest difference of all bins in the same measure with the mean square over bins, which "
    "is 1 or less where only noise differs."
)
ERRORS = (
    "Bars in (a): from the slowest turn to the fastest. Errors in the table: standard errors, by "
    "blocking."
)
TARGET = 5.0  # times LAMMPS
OWN, LAMMPS = "own", "lammps"
COLORS = (BLUE, ORANGE, GREEN, RED, BLACK)
WIDTH = 0.38  # of a bar
SEEN = ("kT", "pressure", "bond")
FARTHEST = 2.0  # r_c, of g(r) in the picture
HIGHEST = 2.2  # of g(r) in the picture; neighbours along a chain stand higher
EACH = 3  # bins from one point to the next
LEAST = 20  # snapshots with pairs in a bin, for its difference to be judged


def compute(data):
    """Medians and ranges of rates and ratio; means, errors and differences of the physics."""
    source = data["lammps"]
    rates = np.stack([source.own_rate, source.lammps_rate], axis=1)
    along = ("workload", "code")
    numbers = xr.Dataset(coords={name: source[name] for name in ("workload", "code", "r")})
    numbers["system"] = source.system
    for name, part in zip(("rate", "rate_low", "rate_high"), middle_and_range(rates)):
        numbers[name] = (along, part, {"units": "1 / s", "long_name": "bead-steps per second"})
    ratios = middle_and_range(rates[:, 0] / rates[:, 1])
    for name, part in zip(("ratio", "ratio_low", "ratio_high"), ratios):
        numbers[name] = ("workload", part, {"units": "1", "long_name": "rate over LAMMPS's"})
    for name in (*SEEN, "rdf"):
        blocks = source[name].transpose("snapshot", ...)
        mean, error = block_mean_and_error(blocks.values)
        numbers[name] = (blocks.dims[1:], mean, source[name].attrs)
        numbers[f"{name}_error"] = (blocks.dims[1:], error, {"units": source[name].units})
    met = (source.rdf > 0).sum("snapshot").min("code") >= LEAST
    numbers["rdf_deviation"] = deviation(numbers, "rdf").where(met).assign_attrs(units="1")
    return numbers


def deviation(numbers, name):
    """Difference of the codes over its standard error."""
    value, error = numbers[name], numbers[f"{name}_error"]
    return (value.sel(code=OWN) - value.sel(code=LAMMPS)) / np.sqrt((error**2).sum("code"))


def measured(data):
    """None: nobody has published these numbers."""
    return {}


def table(data):
    """Rates, and the physics side by side."""
    rows = []
    for name in data.workload.values:
        at = data.sel(workload=name)
        ratio = with_range(*(float(at[part]) for part in ("ratio", "ratio_low", "ratio_high")))
        rows.append((
            f"{name}: {at.system.item()}",
            *(f"{float(at.rate.sel(code=code)) / 1e6:.3g}" for code in (OWN, LAMMPS)), ratio,
            *(_side_by_side(at, quantity) for quantity in SEEN), _largest(at.rdf_deviation),
        ))  # fmt: skip
    columns = [
        "workload", "10^6 bead-steps / s", "LAMMPS", "ratio (range)", "kT", "pressure / kT r_c^-d",
        "mean bond / r_c", "g(r): largest; mean square",
    ]  # fmt: skip
    return pd.DataFrame([[_none(cell) for cell in row] for row in rows], columns=columns)


def _none(cell):
    return "–" if cell == "nan" else cell


def _side_by_side(at, name):
    """Both codes' means and their difference in standard errors."""
    parts = [
        with_error(float(at[name].sel(code=code)), float(at[f"{name}_error"].sel(code=code)))
        for code in (OWN, LAMMPS)
    ]
    apart = float(deviation(at, name))
    if not np.isfinite(apart):
        return parts[0]
    return f"{parts[0]}; {parts[1]}; {apart:+.1f}"


def _largest(found):
    """Largest deviation of g(r), and the mean square."""
    seen = found.values[np.isfinite(found.values)]
    if not len(seen):
        return "–"
    return f"{np.abs(seen).max():.1f} of {len(seen)} bins; {np.mean(seen**2):.2f}"


def describe(data):
    """What is seen, in words."""
    return (
        "(a) Bars of speed, this engine beside LAMMPS, for four workloads. (b) Radial distribution "
        "functions of both codes for each workload, which lie on each other."
    )


def draw(data):
    """Bars of both rates, and curves of both."""
    figure, axes = panels(2)
    bars, curves = axes
    place = np.arange(data.sizes["workload"])
    for side, (code, color, label) in zip(
        (-0.5, 0.5), ((OWN, BLUE, "this engine"), (LAMMPS, ORANGE, "LAMMPS"))
    ):
        at = data.sel(code=code)
        middle, low, high = (at[name].values / 1e6 for name in ("rate", "rate_low", "rate_high"))
        bars.bar(
            place + side * WIDTH, middle, WIDTH, color=color, label=label,
            yerr=(middle - low, high - middle), error_kw={"elinewidth": 0.8, "capsize": 1.5},
        )  # fmt: skip
    _targets(bars, data, place)
    bars.set(
        xticks=place, xticklabels=[str(name).replace(", ", ",\n") for name in data.workload.values],
        ylabel=r"$10^6$ bead-steps / s",
    )  # fmt: skip
    bars.set_ylim(0, 1.4 * float(data.rate_high.max()) / 1e6)
    bars.legend(loc="upper left")
    _curves(curves, data)
    return figure


def _targets(bars, data, place):
    """Ratios over the bars, and where five times LAMMPS would be."""
    label = f"{TARGET:g} x LAMMPS"
    for x, name in zip(place, data.workload.values):
        at = data.sel(workload=name)
        other = float(at.rate.sel(code=LAMMPS)) / 1e6
        if np.isfinite(other):
            height = TARGET * other
            bars.plot([x - WIDTH, x], [height, height], "--", color=BLACK, lw=0.9, label=label)
            label = None
            top = max(height, float(at.rate_high.sel(code=OWN)) / 1e6)
            bars.annotate(f"x {float(at.ratio):.1f}", (x - WIDTH / 2, top), (0, 2),
                          textcoords="offset points", ha="center", fontsize=7)  # fmt: skip


def _curves(axes, data):
    """g(r) of both codes, one workload above the other."""
    near = data.sel(r=slice(0, FARTHEST))
    both = [
        name for name in data.workload.values
        if np.isfinite(data.rdf.sel(workload=name)).all() or not np.isfinite(data.ratio).any()
    ]  # fmt: skip
    for k, (name, color) in enumerate(zip(both, COLORS)):
        own, other = (near.rdf.sel(workload=name, code=code) for code in (OWN, LAMMPS))
        axes.plot(near.r, own.where(own < HIGHEST) + k, color=color, label=str(name))
        sparse = other.where(other < HIGHEST)[::EACH]
        axes.plot(sparse.r, sparse + k, "o", color=color, markersize=2)
    axes.set_ylim(-0.1, len(both) + 0.9)
    axes.set(xlabel=r"$r$ / $r_c$", ylabel="g(r), shifted by 1 each")
    axes.legend(loc="upper right", ncols=2)
