"""Figure 6: mean-square displacements of innermost beads and of centres of mass."""

import numpy as np
import xarray as xr

from dpd.analysis.diffusion import HALF, displacements, subdiffusion
from dpd.analysis.statistics import COVERAGE, UNLIKELY, linear_fit
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, ORANGE, panels
from dpd.report.text import with_error
from paper_figures.liu_2008.shared import (
    LENGTHS,
    PAPER_LENGTH,
    ROUSE,
    SEMENOV_JOHNER,
    excluded,
    too_small,
)

TITLE = "Mean-square displacements over t^(1/2) and t^(8/15), melts of set (1)."
PAPER_SHOWS = (
    "The paper shows g_i of innermost beads and g_cm of centres of mass up to t = 1e4 for several "
    "N (its text names 100 only), over t^(1/2) and over t^(8/15), and reads a plateau of g_i in "
    "the latter. It gives no friction; (a) and (b) have pair friction with gamma 4.5. (c) and (d), "
    "a control of ours: the same melts with friction and noise on each bead (Langevin), which "
    "conserve no momentum. Solid: g_i, dashed: g_cm, relative to the centre of mass of the box; "
    "thick where 4 <l^2> < g_i < R_g^2, beyond two bonds and inside the chain's own size, where "
    "the exponent is fitted, which the legend gives with its 95 % interval. Black: t^(8/15) solid, "
    "t^(1/2) dotted, through the middle of the longest chains' thick line; the law by which a "
    "panel divides is level there. Curves of shorter chains run out of a panel at its top. Times "
    "are in DPD units tau_0."
)
ERRORS = (
    "Bands: 95 % intervals; the larger of two jackknife errors, leaving out molecules, and "
    "leaving out tenths of the run, which know about motion that all chains share. Times up to "
    "half the run, in the archived long study to a tenth; the paper draws the whole run. Beyond a "
    "tenth tenths overlap: the error is that over molecules, larger by as much as that of the "
    "tenths was in the decade before."
)
BATHS = ("pairs", "langevin")
FREE = 20.0  # R_g^2 that g_cm must reach before g_i can be within 5 % of it
MET = 2.0  # g_i over g_cm where a chain goes over to free diffusion
NEAR, FITTED = 1.3, 5  # factor about that within which times are fitted, and how many at least
FROM = 0.3  # DPD time units, from which on displacements are drawn: before, beads fly
ROOM = 1.2  # of the ordinates, above the highest point of the longest chains


def compute(sweeps):
    """Displacements and exponents over chain length, with and without conserved momentum."""
    baths = [subdiffusion(sweeps[name], "length") for name in ("melts", "langevin")]
    data = xr.concat(baths, xr.DataArray(list(BATHS), dims="bath", name="bath"), join="outer")
    melts = sweeps["melts"]
    inner, centre = (
        {n: displacements(melts.sel(length=n), kind, HALF) for n in melts.length.values}
        for kind in ("inner", "centre")
    )
    early = _apart_early(inner, float(data.high.sel(bath="pairs").min()))
    late = _ratio_late(inner, centre, min(inner))
    met = {n: _meeting(inner[n], centre[n]) for n in inner}
    for name, value in (("early", early), ("late", late)):
        data[name], data[f"{name}_error"] = value
        for each in (name, f"{name}_error"):
            data[each].attrs["units"] = "1"
    times = np.array([met[n] for n in melts.length.values])
    for name, column in zip(("meeting", "meeting_error"), times.T):
        data[name] = ("length", xr.DataArray(
            column, {"length": melts.length.values}, "length",
        ).reindex(length=data.length.values).values, {"units": "tau"})  # fmt: skip
    return data


def _apart_early(inner, square):
    """Largest relative difference of g_i between the longest chains and others, and its error.

    Over times until the g_i of the shortest chains has reached a square displacement, their
    R_g^2.
    """
    longest, shortest = inner[max(inner)], inner[min(inner)]
    last = shortest.time[np.argmax(shortest.value > square)]
    found = []
    for other in (inner[n] for n in inner if n != max(inner)):
        count = int((other.time <= last).sum())
        apart = other.value[:count] / longest.value[:count] - 1
        k = int(np.argmax(np.abs(apart)))
        there = [each.derived(lambda g, k=k: g[k]) for each in (other, longest)]
        found.append((abs(apart[k]), float(np.hypot(*(error / value for value, error in there)))))
    return max(found, default=(np.nan, np.nan))


def _jointly(inner, centre, function):
    """A function of g_i and g_cm of the same runs, and its standard error."""
    count = len(inner.time)
    joined = inner._replace(
        value=np.concatenate([inner.value, centre.value]),
        without_molecules=np.hstack([inner.without_molecules, centre.without_molecules]),
        without_part=np.hstack([inner.without_part, centre.without_part]),
    )
    value, error = joined.derived(lambda both: function(both[:count], both[count:]))
    return float(value), float(error)


def _ratio_late(inner, centre, length):
    """g_i over g_cm at the last time, and its error."""
    return _jointly(inner[length], centre[length], lambda g, cm: g[-1] / cm[-1])


def _meeting(inner, centre):
    """Time at which g_i falls to twice g_cm, and its error; NaN where it does not.

    By a parabola of ln t in ln (g_i / g_cm), through the times where that is near: at a single
    crossing of noisy curves, the error of the longest chains was as large as the time.
    """

    def when(g, cm):
        ratio = np.log(g / cm / MET)
        near = np.abs(ratio) < np.log(NEAR)
        if not (np.any(ratio[near] > 0) and np.any(ratio[near] < 0)) or near.sum() < FITTED:
            return np.nan
        parabola = np.polynomial.Polynomial.fit(ratio[near], np.log(inner.time[near]), 2)
        return parabola(0.0)

    logarithm, error = _jointly(inner, centre, when)
    return np.exp(logarithm), np.exp(logarithm) * error


def measured(data):
    """The exponent of the paper's chains, what it excludes, and what the text says of all N."""
    pairs = data.sel(bath="pairs").dropna("length", subset=["duration"])
    found = {
        "exponent_here": Measured(np.nan, np.nan),
        "early": Measured(
            float(data.early), float(data.early_error),
            f"up to the R_g^2 of N {int(pairs.length.min())}, all N against "
            f"{int(pairs.length.max())}",
        ),
    }  # fmt: skip
    if PAPER_LENGTH in pairs.length:
        at = pairs.sel(length=PAPER_LENGTH)
        found["exponent_here"] = _exponent(pairs, at)
    shortest = pairs.sel(length=pairs.length.min())
    sizes = float(shortest.centre.dropna("lag")[-1] / shortest.high)
    found["late"] = Measured(
        float(data.late), float(data.late_error), f"N {int(shortest.length)}, at the last time",
        "" if sizes >= FREE else f"g_cm comes to {sizes:.1f} R_g^2, needed are {FREE:g}",
    )  # fmt: skip
    return found | _meetings(pairs)


def _exponent(pairs, at):
    """Exponent inside the chain's own size, in words what it excludes, and that of other N."""
    exponent, error = float(at.exponent), float(at.exponent_error)
    if np.isnan(exponent):
        return Measured(exponent, error, "", excluded(exponent, error))
    others = ", ".join(
        f"N {n}: {float(pairs.exponent.sel(length=n)):.3f} +- "
        f"{float(pairs.exponent_error.sel(length=n)):.3f}"
        for n in pairs.length.values
    )
    window = f"{float(at.first):.3g} to {float(at['last']):.3g} DPD time units"
    return Measured(exponent, error, f"window {window}; {excluded(exponent, error)}; {others}")


def _meetings(pairs):
    """What the times say at which chains go over to free diffusion."""
    seen = np.isfinite(pairs.meeting.values) & (pairs.meeting_error.values > 0)
    length, time = pairs.length.values[seen], pairs.meeting.values[seen]
    error = pairs.meeting_error.values[seen] / time
    listed = ", ".join(f"N {n}: {t:.3g}" for n, t in zip(length, time))
    if len(length) < 2:
        reason = f"g_i falls to {MET:g} g_cm within the times for fewer than two N"
        return dict.fromkeys(("crossover", "relaxation"), Measured(np.nan, np.nan, "", reason))
    steps, errors = np.diff(np.log(time)), np.hypot(error[1:], error[:-1])
    k = int(np.argmin(steps))
    ratio = float(np.exp(steps[k]))
    fit = linear_fit([np.ones(len(length)), np.log(length)], np.log(time), error)
    (_, power), (_, power_error) = fit.values, fit.errors
    undecided = too_small(pairs.isel(length=int(np.argmax(pairs.length.values))))
    if fit.p_value < UNLIKELY:
        undecided = f"the times do not lie on a power law (p = {fit.p_value:.1g})"
    note = f"g_i = {MET:g} g_cm at {listed} DPD time units"
    return {
        "crossover": Measured(ratio, ratio * float(errors[k]), note),
        "relaxation": Measured(float(power), float(power_error), note, undecided),
    }


def describe(data):
    """What is seen, in words."""
    parts = []
    for bath, words in zip(BATHS, ("pair friction", "Langevin friction")):
        at = data.sel(bath=bath).dropna("length", subset=["exponent"])
        slopes = ", ".join(f"{float(x):.2f} for N {int(n)}" for n, x in zip(at.length, at.exponent))
        parts.append(f"with {words} the exponents inside the chain are {slopes or 'not found'}")
    return f"Displacements over two powers of time: {'; '.join(parts)}."


def draw(data):
    """Displacements over two powers of time, for both thermostats."""
    figure, axes = panels(2, 2, height=2.5, sharex="row")
    for row, bath, words in zip(axes, BATHS, ("pair friction", "Langevin")):
        here = data.sel(bath=bath).dropna("length", subset=["duration"])
        for panel, power, label in zip(row, (ROUSE, SEMENOV_JOHNER), ("1/2", "8/15")):
            for length in here.length.values:
                _curves(panel, here.sel(length=length), power, named=power == ROUSE)
            longest = here.isel(length=-1)
            _guide(panel, longest, power)
            highest = float((longest.inner / longest.time**power).max())
            panel.set(xscale="log", xlim=(FROM, float(here.time.max())), title=words)
            panel.set_ylim(0, ROOM * highest if np.isfinite(highest) else None)
            panel.set_ylabel(rf"$g(t) / t^{{{label}}}$ / ($r_c^2$ $\tau_0^{{-{label}}}$)")
        for panel in row:
            handles, _ = panel.get_legend_handles_labels()
            if handles:
                panel.legend(loc="upper left")
    for panel in axes[-1]:
        panel.set_xlabel(r"time $t$ / $\tau_0$")
    return figure


def _curves(panel, at, power, named):
    """g_i and g_cm of one N over a power of time."""
    length = int(at.length)
    color, scale = LENGTHS.get(length, ORANGE), at.time**power
    text = with_error(float(at.exponent), COVERAGE * float(at.exponent_error))
    for kind, style in (("inner", "-"), ("centre", "--")):
        value, reach = at[kind] / scale, COVERAGE * at[f"{kind}_error"] / scale
        panel.fill_between(at.time, value - reach, value + reach, color=color, alpha=0.25,
                           linewidth=0)  # fmt: skip
        label = f"N = {length}: {text}" if kind == "inner" and named else None
        panel.plot(at.time, value, style, color=color, linewidth=0.8, label=label)
    inside = (at.inner >= at.low) & (at.inner <= at.high)
    panel.plot(at.time[inside], (at.inner / scale)[inside], color=color, linewidth=2)


def _guide(panel, at, power):
    """Both power laws through the middle of the window of some chains, from its beginning on."""
    inside = np.flatnonzero(((at.inner >= at.low) & (at.inner <= at.high)).values)
    if not len(inside):
        return
    middle = at.isel(lag=inside[len(inside) // 2])
    time = np.geomspace(float(at.time[inside[0]]), float(at.time.max()), 50)
    for theory, label in ((ROUSE, "1/2"), (SEMENOV_JOHNER, "8/15")):
        guide = float(middle.inner) * (time / float(middle.time)) ** theory / time**power
        style = "-" if theory == SEMENOV_JOHNER else ":"
        shown = rf"$t^{{{label}}}$" if power == SEMENOV_JOHNER else None
        panel.plot(time, guide, style, color=BLACK, linewidth=0.9, label=shown)
