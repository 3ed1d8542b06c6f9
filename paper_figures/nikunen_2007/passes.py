"""Bonds that pass through each other, against the criterion that should forbid it."""

from itertools import cycle

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import chain_dynamics, power
from dpd.analysis.statistics import COVERAGE, NONE_SEEN, interval
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, ORANGE, panels, points
from dpd.report.text import with_error
from paper_figures.nikunen_2007.shared import CONTROL, MAIN, criterion, in_words, law, repulsion

PUBLISHED = shown_by(__file__)
ROUSE = law(PUBLISHED["tau_rouse"])  # exponent of tau over N
NEARER = PUBLISHED["tau_rouse"].high - ROUSE  # than this an exponent is nearer to another law
CROSSOVER = PUBLISHED["crossover_diffusion"].high  # chain length beyond which chains should reptate

TITLE = "Rate at which bonds pass through each other, against the margin of the criterion."
PAPER_SHOWS = (
    "Not a figure of the paper, which holds that bonds cannot cross if sqrt(2) r_min > l_max. "
    "Pairs of bonds that go through each other are counted directly, from looks at two intervals "
    "between which beads are taken to move in straight lines. The margin is that of the same runs. "
    "Dashed: margin 0; sets to its right meet the criterion. "
    "Table: in how many passes a chain of the longest of these runs takes part within its own "
    "relaxation time tau, which decides whether other chains hold it back; and the "
    f"exponent of tau over N, {ROUSE:g} for Rouse chains, from runs of ten tau or more, after two "
    f"to settle, with N of {CROSSOVER:g} and more. tau_0 = (m r_c^2 / kT)^(1/2) is the unit of "
    "time."
)
ERRORS = (
    "Bars: 95 % intervals, of rates those of the mean of a Poisson distribution, given the count. "
    "Triangles: none seen, 95 % limit."
)
CHECKED = (MAIN, "a200")  # the set of the dynamics, and the one that meets the criterion
CERTAIN = 2.0  # standard errors
LIFT = 8  # points from a symbol to its label


def compute(sweeps):
    """Counts for each set and interval, the margin of each set, and how tau grows with N."""
    runs = sweeps["passes"]
    shape = (runs.sizes["set"], runs.sizes["interval"])
    count, exposure = np.zeros(shape), np.zeros(shape)
    rows = []
    for k, name in enumerate(runs.set.values):
        for m in range(shape[1]):
            one = runs.isel(set=k, interval=m)
            length = len(first_scene(one).molecules[0].beads)
            count[k, m] = float(one.passes.sum())
            bonds = float(one.beads.sum()) * (length - 1) / length
            exposure[k, m] = bonds * float(one.pass_time.max())
        rate = max(count[k, 0], NONE_SEEN) / exposure[k, 0]
        margin = _margin(runs.sel(set=name).isel(interval=0))
        rows.append((*margin, *_behaviour(sweeps, str(name), rate)))
    data = xr.Dataset(
        {
            "count": (("set", "interval"), count, {"units": "1"}),
            "exposure": (("set", "interval"), exposure, {"units": "tau_0"}),
        },
        {"set": runs.set, "interval": runs.interval},
    )
    names = ("margin", "margin_error", "exponent", "exponent_error", "longest", "in_a_tau")
    for name, column in zip(names, np.array(rows).T):
        data[name] = ("set", column, {"units": "r_c" if "margin" in name else "1"})
    return data


def _margin(at):
    """sqrt(2) r_min - l_max and its standard error."""
    (near, near_error), (far, far_error) = criterion(at)
    return np.sqrt(2) * near - far, float(np.hypot(np.sqrt(2) * near_error, far_error))


def _behaviour(sweeps, name, rate):
    """Exponent of tau for long chains, its error, longest N that counts, passes in its tau.

    Where none was seen, the rate is the limit at 95 %.
    """
    own = {MAIN: "dynamics", CONTROL: "dynamics_control"}
    runs = sweeps[own.get(name, "dynamics_sets")]
    if "set" in runs.dims:
        if name not in runs.set.values:
            return (np.nan,) * 4
        runs = runs.sel(set=name)
    found = chain_dynamics(runs)
    good = found.long_enough.values > 0
    if not good.any():
        return (np.nan,) * 4
    n, tau = found.length.values[good], found.tau.values[good]
    fit = power(n, tau, found.tau_error.values[good], CROSSOVER, np.inf)
    # Each pass has two bonds, so two chains take part in it.
    return fit.exponent, fit.error, n[-1], 2 * rate * (n[-1] - 1) * tau[-1]


def measured(data):
    """The set of the dynamics, and the set for which the criterion holds."""
    return {f"passes_{name}": _rate(data, name) for name in CHECKED}


def _rate(data, name):
    """Passes per bond and unit of time; where none was seen, what that excludes."""
    if name not in data.set.values:
        return Measured(np.nan, np.nan)
    at = data.sel(set=name).isel(interval=0)
    count, exposure = float(at["count"]), float(at.exposure)
    note = f"{count:.0f} passes in {exposure:.3g} bonds times tau_0; margin {float(at.margin):.3f}"
    limit = PUBLISHED[f"passes_{name}"].high
    excluded = NONE_SEEN / exposure
    blind = ""
    if not count and excluded > limit:
        blind = f"none seen excludes only more than {excluded:.1e} (95 %)"
    if not count:
        return Measured(excluded, np.nan, note, blind, bound=True)
    return Measured(count / exposure, _below(count) / exposure, note)


def _below(count):
    """Standard error of a count on the side of smaller rates, where the limit is."""
    return float(count - interval(count)[0]) / COVERAGE


def halving(data):
    """Relative change of each set's rate when the interval is halved, and its error."""
    rate = data["count"] / data.exposure
    fine, coarse = rate.isel(interval=0), rate.isel(interval=1)
    error = np.sqrt((1 / data["count"]).sum("interval"))
    return (fine / coarse - 1), error


def warnings(data):
    """Sets whose count is not yet independent of the interval."""
    if data.sizes["interval"] < 2:
        return [
            "Passes were looked for at one interval only: nothing says that it is short enough."
        ]
    change, error = halving(data)
    return [
        f"For {_text(name)}, halving the interval of looks changes the count by "
        f"{with_error(100 * float(change.sel(set=name)), 100 * float(error.sel(set=name)))} %."
        for name in data.set.values
        if abs(change.sel(set=name)) > CERTAIN * error.sel(set=name)
    ]


def table(data):
    """The criterion, and what becomes of it."""
    rows = []
    for name in data.set.values:
        at = data.sel(set=name)
        one = at.isel(interval=0)
        count, exposure = float(one["count"]), float(one.exposure)
        rate = with_error(count / exposure, _below(count) / exposure)
        change, error = (float(part.sel(set=name)) for part in halving(data))
        rows.append((
            _text(name),
            with_error(float(at.margin), float(at.margin_error)),
            "holds" if at.margin > 0 else "fails",
            rate if count else f"< {NONE_SEEN / exposure:.1e}",
            with_error(100 * change, 100 * error) if np.isfinite(change) else "–",
            _in_a_tau(at, seen=count > 0),
            _verdict(at),
        ))  # fmt: skip
    return pd.DataFrame(rows, columns=[
        "set", "margin / r_c", "criterion", "rate per bond x tau_0",
        "change on halving the interval / %", "passes of a chain in its tau", "Rouse-like",
    ])  # fmt: skip


def _text(name):
    return f"{in_words(name)}, k {2 * repulsion(name)}"


def _in_a_tau(at, seen):
    """Passes of the longest chain that counts in its relaxation time."""
    if not at.longest > 0:
        return "–"
    return f"{'' if seen else '< '}{float(at.in_a_tau):.2g} (N {float(at.longest):g})"


def _verdict(at):
    """Whether tau of long chains grows as N^2."""
    exponent, error = float(at.exponent), float(at.exponent_error)
    if not np.isfinite(exponent):
        longest = f", N up to {float(at.longest):g}" if at.longest > 0 else ""
        return f"not reached at this scale{longest}"
    text = f"exponent {with_error(exponent, error)}"
    if CERTAIN * error > NEARER:
        return f"undecided: {text}"
    return f"{'no' if exponent - ROUSE > CERTAIN * error else 'yes'}: {text}"


def describe(data):
    """What is seen."""
    one = data.isel(interval=0)
    passing = [in_words(name) for name in data.set.values if one["count"].sel(set=name) > 0]
    none = [in_words(name) for name in data.set.values if one["count"].sel(set=name) == 0]
    return (
        f"The rate falls steeply as the margin grows: passes were seen for "
        f"{', '.join(passing) or 'no set'}, none for {', '.join(none) or 'no set'}."
    )


def draw(data):
    """Rates over the margin."""
    figure, axes = panels(1)
    axes.set(yscale="log", xlabel=r"margin $(\sqrt{2} r_{min} - l_{max})$ / $r_c$",
             ylabel=r"rate of passes per bond / $\tau_0^{-1}$")  # fmt: skip
    for k, color in zip(range(data.sizes["interval"]), cycle((BLUE, ORANGE))):
        at = data.isel(interval=k)
        seen = at["count"] > 0
        rate = (at["count"] / at.exposure)[seen]
        low, high = (end[seen.values] / at.exposure[seen] for end in interval(at["count"]))
        steps = at.interval.item()
        label = f"looks every {steps} steps" if steps > 1 else "looks every step"
        points(axes, at.margin[seen], rate, np.array([rate - low, high - rate]) / COVERAGE, label,
               color)  # fmt: skip
        # Both intervals have the same bound where none was seen: the second is drawn smaller.
        axes.plot(at.margin[~seen], NONE_SEEN / at.exposure[~seen], "v", color=color,
                  markerfacecolor="white", markersize=6 - 3 * k)  # fmt: skip
    for name in data.set.values:
        at = data.sel(set=name)
        height = float((interval(at["count"])[1] / at.exposure).max())
        # Neighbours stand close together, the last at the dashed line: labels are upright.
        axes.annotate(f"a = {repulsion(name)}", (at.margin.item(), height), (0, LIFT),
                      textcoords="offset points", fontsize=7, ha="center", rotation=90,
                      bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})  # fmt: skip
    axes.axvline(0, color="0.5", linestyle="--", linewidth=0.8)
    axes.margins(x=0.12, y=0.4)  # room for the highest label
    axes.legend()
    return figure
