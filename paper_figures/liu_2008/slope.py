"""Local slopes of the innermost beads' displacement: the melt, the box, or the thermostat?"""

from itertools import cycle

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.diffusion import HALF, USED, displacements, subdiffusion
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels
from dpd.report.text import with_error
from paper_figures.liu_2008.plateau import plateau
from paper_figures.liu_2008.shared import (
    LENGTHS,
    PAPER_LENGTH,
    ROUSE,
    SEMENOV_JOHNER,
    excluded,
    too_small,
)

LIMIT = shown_by(__file__)["level"].low  # decades for which a plateau is to last
LEVEL = 0.03  # share of its middle within which g_i / t^(8/15) is called level
# Level stretches: the power of time, and whether beyond the chain's own size or inside it.
STRETCHES = {
    "level": (SEMENOV_JOHNER, False), "beyond": (SEMENOV_JOHNER, True), "rouse": (ROUSE, True),
}  # fmt: skip
# Fields of `Plateau`.
LEVEL_UNITS = {
    "first": "tau", "last": "tau", "decades": "1", "error": "1", "low": "r_c^2", "high": "r_c^2",
}  # fmt: skip

TITLE = "Local slope d ln g_i / d ln t of the innermost beads' displacement, melts of set (1)."
PAPER_SHOWS = (
    "Not a figure of the paper. Dashed: 8/15 (Semenov and Johner), dotted: 1/2 (Rouse). (a) The "
    "paper's dynamics, pair friction gamma 4.5, for several N. (b) The same melts with friction "
    "and noise on each bead (Langevin), which conserve no momentum: chains alone, without flow. "
    "(c) Boxes of edge L, with and (dashed) without momentum. (d) Other pair frictions. "
    "Where (a) and (b) differ, flow carries the beads, and a power law there does not describe the "
    "chain's own motion. The legends give exponents inside the chain's own size, 4 <l^2> < g_i < "
    "R_g^2, in (a) and (b) with 95 % intervals. Table: where the slope is smallest; and the "
    "longest stretch of time inside the chain's own size in which g_i / t^(8/15) stays within "
    f"{100 * LEVEL:g} % of its middle, as long a plateau as an eye could see; and the same beyond "
    "it, g_i > R_g^2, for t^(8/15) and for t^(1/2). Inside, ideal (Rouse) chains "
    "of N = 100 have 0.8 decades, as their slope falls through 8/15 to 1/2; a law t^1 has 0.06. "
    "Times in DPD units tau_0."
)
ERRORS = (
    "Each slope is that of a straight line over a factor of 4 in time. Bands: 95 % intervals; the"
    " larger of two jackknife errors, leaving out molecules, and leaving out tenths of the run. "
    "Times up to half the run, in the archived long study to a tenth. Beyond a tenth parts of the "
    "run overlap: the error is that over molecules, larger by as much as that of the parts was in "
    "the decade before."
)
AXES = {
    "melts": "length", "langevin": "length", "box_size": "box", "langevin_box_size": "box",
    "friction": "gamma",
}  # fmt: skip
FROM = 0.3  # DPD time units, from which on slopes are drawn: before, beads fly
PAIR = 50  # chain length of the pair of boxes


def compute(sweeps):
    """Slopes and exponents of every run, one after the other."""
    parts = []
    for name, axis in AXES.items():
        found = subdiffusion(sweeps[name], axis)
        found = found.merge(_levels(sweeps[name], axis, found))
        labels = [f"{name} {value}" for value in found[axis].values]
        found = found.rename({axis: "run"}).drop_vars("run").assign_coords(run=labels)
        parts.append(found)
    return xr.concat(parts, "run", join="outer")


def _levels(sweep, axis, found):
    """Where g_i over a power of t is level inside the chains' own size and beyond, over an axis."""
    levels = {stretch: [] for stretch in STRETCHES}
    sweep = sweep[[name for name in sweep.data_vars if str(name).startswith(USED)]]
    for place, (low, high) in enumerate(zip(found.low.values, found.high.values)):
        inner = displacements(sweep.isel({axis: place}), "inner", HALF)
        for stretch, (power, outside) in STRETCHES.items():
            ends = (high, np.inf) if outside else (low, high)
            levels[stretch].append(plateau(inner, power, LEVEL, *ends)._asdict())
    return xr.Dataset(
        {
            f"{stretch}_{field}": (axis, [level[field] for level in rows], {"units": unit})
            for stretch, rows in levels.items()
            for field, unit in LEVEL_UNITS.items()
        },
        {axis: sweep[axis]},
    )


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
        end = float(at.time.where(at.slope.notnull()).max())
        reason = f"the slope falls until {end:.3g} DPD time units, the end"
        return Measured(np.nan, np.nan, "", small or reason)
    value, error = float(at.lowest), float(at.lowest_error)
    ratio = float(at.lowest_square / at.high)
    note = (
        f"at {float(at.lowest_time):.3g} DPD time units, g_i = {ratio:.1f} R_g^2; "
        f"{excluded(value, error)}"
    )
    return Measured(value, error, note, small)


def _level(data):
    """How long g_i / t^(8/15) of the paper's chains is level, in decades."""
    at = _at(data, f"melts {PAPER_LENGTH}")
    if at is None or not np.isfinite(at.level_decades):
        return Measured(np.nan, np.nan, "", "fewer than four lags inside the chain's own size")
    value, error = float(at.level_decades), float(at.level_error)
    small = too_small(at)
    if _goes_on(at) and value - 2 * error < LIMIT:
        small = small or "level until the last time, so it may go on"
    note = f"{_times(at)} DPD time units, g_i = {_sizes(at)} R_g^2"
    return Measured(value, error, note, small)


def _beyond(data):
    """How long g_i / t^(8/15) of the paper's chains is level there, and how much longer than 1/2.

    Of the difference the larger of both errors counts: one curve has both stretches.
    """
    at = _at(data, f"melts {PAPER_LENGTH}")
    if at is None or not np.isfinite(at.beyond_decades):
        none = Measured(np.nan, np.nan, "", "fewer than four lags beyond the chain's own size")
        return none, none
    value, error = float(at.beyond_decades), float(at.beyond_error)
    small, more = too_small(at), value - float(at.rouse_decades)
    note = f"{_times(at, 'beyond')} DPD time units, of t^(1/2) {_times(at, 'rouse')}"
    cut = "level until the last time, so it may go on" if _goes_on(at, "beyond") else ""
    long = cut if value - 2 * error < LIMIT else ""
    return (
        Measured(value, error, note, small or long),
        Measured(more, float(max(error, at.rouse_error)), note, small or cut),
    )


def _goes_on(at, stretch="level"):
    """Whether a level stretch ends because the times do: it lasts for as long at least."""
    return float(at[f"{stretch}_last"]) >= float(at.time.max()) * (1 - 1e-9)


def _times(at, stretch="level"):
    return f"{float(at[f'{stretch}_first']):.3g} to {float(at[f'{stretch}_last']):.3g}"


def _sizes(at):
    return f"{float(at.level_low / at.high):.2g} to {float(at.level_high / at.high):.2g}"


def measured(data):
    """The control's exponent, and how the exponent depends on the box."""
    control = _exponent(data, f"langevin {PAPER_LENGTH}")
    large = _exponent(data, f"melts {PAIR}")
    long, longer = _beyond(data)
    found = {
        "langevin_exponent": control, "lowest_slope": _lowest(data), "level": _level(data),
        "level_beyond": long, "level_laws": longer,
    }  # fmt: skip
    for name, prefix, reference in (
        ("box_dependence", "box_size", large),
        ("langevin_box_dependence", "langevin_box_size", _exponent(data, f"langevin {PAIR}")),
    ):
        runs = [r for r in data.run.values if r.startswith(f"{prefix} ")]
        runs.sort(key=lambda run: float(data.box_edge.sel(run=run)))
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


def table(data):
    """Of every run: exponent, smallest slope, and where g_i / t^(8/15) is level."""
    rows = []
    for run in data.run.values:
        at = data.sel(run=run)
        lowest = "not reached"
        if np.isfinite(at.lowest):
            lowest = (
                f"{with_error(float(at.lowest), float(at.lowest_error))} at "
                f"{float(at.lowest_time):.3g}, {float(at.lowest_square / at.high):.2g} R_g^2"
            )
        level = ("–",) * 3
        if np.isfinite(at.level_decades):
            length = with_error(float(at.level_decades), float(at.level_error))
            level = (f"at least {length}" if _goes_on(at) else length, _times(at), _sizes(at))
        rows.append((
            _name(run, at), with_error(float(at.exponent), float(at.exponent_error)), lowest,
            *level, *(
                _times(at, stretch) if np.isfinite(at[f"{stretch}_decades"]) else "–"
                for stretch in ("beyond", "rouse")
            ),
        ))  # fmt: skip
    return pd.DataFrame(rows, columns=[
        "run", "exponent inside", "smallest slope", "level for / decades",
        "from t / tau_0", "at g_i / R_g^2", "level beyond R_g^2, t / tau_0", "t^(1/2) beyond",
    ])  # fmt: skip


def _name(run, at):
    """Which melt a run is of."""
    bath = "Langevin" if run.startswith("langevin") else "pairs"
    return (
        f"{bath}, N = {int(at.beads)}, L = {float(at.box_edge):.0f}, gamma {float(at.friction):g}"
    )


def describe(data):
    """What is seen, in words."""
    points = [(run, data.sel(run=run)) for run in data.run.values]
    parts = [f"{_name(run, at)}: {float(at.exponent):.2f}" for run, at in points]
    return (
        "Local slopes over time fall from 2, free flight, through about 1 to lower values; 8/15 "
        f"and 1/2 are drawn in. Exponents inside the chain: {'; '.join(parts)}."
    )


def draw(data):
    """Slopes over chain length with both thermostats, box and friction."""
    figure, axes = panels(2, rows=2, height=2.6, sharex=True, sharey=True)
    sweep = {run: run.split()[0] for run in data.run.values}
    boxes = [run for run in sweep if sweep[run] in ("box_size", "langevin_box_size")]
    frictions = [run for run in sweep if sweep[run] == "friction"]
    groups = {
        "pair friction": [run for run in sweep if sweep[run] == "melts"],
        "Langevin": [run for run in sweep if sweep[run] == "langevin"],
        "boxes": boxes + _there(data, f"melts {PAIR}", f"langevin {PAIR}"),
        "frictions": frictions + _like(data, frictions),
    }
    end = float(data.time.where(data.slope.notnull()).max().fillna(data.time.max()))
    for panel, (title, runs) in zip(axes.flat, groups.items()):
        colors = cycle((BLUE, GREEN, RED, PURPLE, ORANGE, BLACK))
        for run, color in zip(runs, colors):
            at = data.sel(run=run)
            if title in ("pair friction", "Langevin"):
                color, label = LENGTHS.get(int(at.beads), color), _by_length(at)
            else:
                label = rf"$\gamma$ = {float(at.friction):g}: {float(at.exponent):.2f}"
                if title == "boxes":
                    label = f"L = {float(at.box_edge):.0f}: {float(at.exponent):.2f}"
            _curve(panel, at, color, "--" if run.startswith("langevin") else "-", label)
        panel.axhline(SEMENOV_JOHNER, color=BLACK, linestyle="--", linewidth=0.8)
        panel.axhline(ROUSE, color=BLACK, linestyle=":", linewidth=0.8)
        chains = {int(data.beads.sel(run=run)) for run in runs}
        if title in ("boxes", "frictions") and len(chains) == 1:
            title += f", N = {chains.pop()}"
        # Room above the curves for the legend.
        panel.set(xscale="log", xlim=(FROM, end), ylim=(0.4, 1.6), title=title)
        panel.legend(loc="upper right", ncols=2 if len(runs) > 4 else 1)
    for panel in axes[-1]:
        panel.set_xlabel(r"time $t$ / $\tau_0$")
    for panel in axes[:, 0]:
        panel.set_ylabel(r"local slope d ln $g_i$ / d ln $t$")
    return figure


def _there(data, *runs):
    return [run for run in runs if run in data.run.values]


def _like(data, runs):
    """Runs of pairs with the melts' friction, in the box and with the chains of some."""
    alike = {(int(at.beads), float(at.box_edge)) for at in (data.sel(run=run) for run in runs)}
    return [
        run for run in data.run.values
        if run.split()[0] in ("melts", "box_size")
        and (int(data.beads.sel(run=run)), float(data.box_edge.sel(run=run))) in alike
    ]  # fmt: skip


def _curve(panel, at, color, style, label):
    """The slope of a run, with its band."""
    at = at.isel(lag=np.flatnonzero(at.time >= FROM))
    reach = COVERAGE * at.slope_error
    panel.fill_between(at.time, at.slope - reach, at.slope + reach, color=color, alpha=0.2,
                       linewidth=0)  # fmt: skip
    panel.plot(at.time, at.slope, style, color=color, label=label)


def _by_length(at):
    """Chain length and exponent with its 95 % interval."""
    exponent = with_error(float(at.exponent), COVERAGE * float(at.exponent_error))
    return f"N = {int(at.beads)}: {exponent}"
