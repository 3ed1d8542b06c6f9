"""Local slopes of the innermost beads' displacement: the melt, the box, or the thermostat?"""

import numpy as np
import xarray as xr

from dpd.analysis.diffusion import subdiffusion
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels
from paper_figures.liu_2008.shared import (
    LENGTHS,
    PAPER_LENGTH,
    ROUSE,
    SEMENOV_JOHNER,
    excluded,
    too_small,
)

TITLE = "Local slope d ln g_i / d ln t of the innermost beads' displacement, melts of set (1)."
PAPER_SHOWS = (
    "Not a figure of the paper. Dashed: 8/15 (Semenov and Johner), dotted: 1/2 (Rouse). (a) The "
    "paper's dynamics, pair friction gamma 4.5, for several N. (b) The same melts with friction "
    "and noise on each bead (Langevin), which conserve no momentum: chains alone, without flow. "
    "(c) N = 50 in boxes of other sizes and with other frictions, with and without momentum. "
    "Where (a) and (b) differ, flow carries the beads, and a power law of g_i is not one of the "
    "chain. The legends give exponents inside the chain's own size, 4 <l^2> < g_i < R_g^2, in (a) "
    "and (b) with 95 % intervals. Times in DPD units tau_0."
)
ERRORS = (
    "Each slope is that of a straight line over a factor of 4 in time. Bands: 95 % intervals; the"
    " larger of two jackknife errors, leaving out molecules, and leaving out tenths of the run. "
    "Times up to a tenth of the run, so that tenths are independent."
)
COLORS = (BLUE, GREEN, RED, PURPLE, ORANGE, BLACK)
AXES = {
    "melts": "length", "langevin": "length", "box_size": "box", "langevin_box_size": "box",
    "friction": "gamma",
}  # fmt: skip
ALONE = ("box_size", "langevin_box_size", "friction")
FROM = 0.3  # DPD time units, from which on slopes are drawn: before, beads fly
PAIR = 50  # chain length of the pair of boxes


def compute(sweeps):
    """Slopes and exponents of every run, one after the other."""
    parts = []
    for name, axis in AXES.items():
        found = subdiffusion(sweeps[name], axis)
        labels = [f"{name} {value}" for value in found[axis].values]
        found = found.rename({axis: "run"}).drop_vars("run").assign_coords(run=labels)
        parts.append(found)
    return xr.concat(parts, "run", join="outer")


def _at(data, run):
    return data.sel(run=run) if run in data.run.values else None


def _exponent(data, run):
    """Exponent of a run, or a missing one."""
    at = _at(data, run)
    if at is None:
        return Measured(np.nan, np.nan)
    window = f"{float(at.first):.3g} to {float(at['last']):.3g} DPD time units"
    exponent, error = float(at.exponent), float(at.exponent_error)
    said = excluded(exponent, error)
    if np.isnan(exponent):
        return Measured(exponent, error, "", said)
    return Measured(exponent, error, f"window {window}; {said}")


def _lowest(data):
    """The smallest local slope of the paper's chains, which a plateau by eye may have been."""
    at = _at(data, f"melts {PAPER_LENGTH}")
    if at is None:
        return Measured(np.nan, np.nan)
    small = too_small(at)
    if not np.isfinite(at.lowest):
        end = float(at.time[at.slope.notnull()][-1])
        reason = f"the slope falls until {end:.3g} DPD time units, the end"
        return Measured(np.nan, np.nan, "", small or reason)
    value, error = float(at.lowest), float(at.lowest_error)
    ratio = float(at.lowest_square / at.high)
    note = (
        f"at {float(at.lowest_time):.3g} DPD time units, g_i = {ratio:.1f} R_g^2; "
        f"{excluded(value, error)}"
    )
    return Measured(value, error, note, small)


def measured(data):
    """The control's exponent, and how the exponent depends on the box."""
    control = _exponent(data, f"langevin {PAPER_LENGTH}")
    large = _exponent(data, f"melts {PAIR}")
    found = {"langevin_exponent": control, "lowest_slope": _lowest(data)}
    for name, prefix, reference in (
        ("box_dependence", "box_size", large),
        ("langevin_box_dependence", "langevin_box_size", _exponent(data, f"langevin {PAIR}")),
    ):
        runs = sorted(r for r in data.run.values if r.startswith(f"{prefix} "))
        other = _exponent(data, runs[0]) if runs else Measured(np.nan, np.nan)
        edge = float(data.sel(run=runs[0]).box_edge) if runs else np.nan
        found[name] = Measured(
            reference.value - other.value, float(np.hypot(reference.error, other.error)),
            f"N {PAIR}: {reference.value:.3f} in the largest box, {other.value:.3f} with edge "
            f"{edge:.0f}",
        )  # fmt: skip
    dpd = _exponent(data, f"melts {PAPER_LENGTH}")
    found["momentum_difference"] = Measured(
        dpd.value - control.value, float(np.hypot(dpd.error, control.error)),
        f"N {PAPER_LENGTH}: {dpd.value:.3f} with momentum conserved, {control.value:.3f} without",
    )  # fmt: skip
    return found


def describe(data):
    """What is seen, in words."""
    parts = [f"{_label(run, data.sel(run=run), True)}" for run in data.run.values]
    return (
        "Local slopes over time fall from 2, free flight, through about 1 to lower values; 8/15 "
        f"and 1/2 are drawn in. Exponents inside the chain: {'; '.join(parts)}."
    )


def draw(data):
    """Three panels of slopes."""
    figure, panel = panels(3, height=3.0, sharey=True)
    groups = (
        ("pair friction", [r for r in data.run.values if r.startswith("melts ")]),
        ("Langevin", [r for r in data.run.values if r.startswith("langevin ")]),
        (
            f"N = {PAIR}",
            [r for r in data.run.values if r.split()[0] in ALONE]
            + [r for r in (f"melts {PAIR}", f"langevin {PAIR}") if r in data.run.values],
        ),
    )  # fmt: skip
    for axes, (title, runs) in zip(panel, groups):
        together = title.startswith("N = ")
        for run, color in zip(runs, COLORS):
            at = data.sel(run=run)
            at = at.isel(lag=np.flatnonzero(at.time >= FROM))
            if not together:
                color = LENGTHS.get(int(run.split()[1]), color)
            reach = COVERAGE * at.slope_error
            style = "--" if run.startswith("langevin") and together else "-"
            axes.fill_between(at.time, at.slope - reach, at.slope + reach, color=color, alpha=0.2,
                              linewidth=0)  # fmt: skip
            axes.plot(at.time, at.slope, style, color=color, label=_label(run, at, together))
        axes.axhline(SEMENOV_JOHNER, color=BLACK, linestyle="--", linewidth=0.8)
        axes.axhline(ROUSE, color=BLACK, linestyle=":", linewidth=0.8)
        # Room above the curves for a line of the legend each.
        axes.set(xscale="log", xlim=(FROM, None), ylim=(0.4, 1.8), title=title,
                 xlabel=r"time $t$ / $\tau_0$")  # fmt: skip
        axes.legend(loc="upper right")
    panel[0].set_ylabel(r"local slope d ln $g_i$ / d ln $t$")
    return figure


def _label(run, at, together):
    """What a curve is of."""
    name, value = run.split()
    exponent, error = float(at.exponent), COVERAGE * float(at.exponent_error)
    if not together:
        return f"N = {value}: {exponent:.2f} ± {error:.2f}"
    kind = "Langevin" if name.startswith("langevin") else "pairs"
    text = f"{kind}, L = {float(at.box_edge):.0f}"
    text += rf", $\gamma$ = {value}" if name == "friction" else ""
    return f"{text}: {exponent:.2f}"
