"""Maps of stability: time step against noise, repulsion, density, core force and bond stiffness."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.lines import Line2D

from dpd.report.style import BLACK, BLUE, ORANGE, RED, Look, panels
from dpd.report.text import with_error
from paper_figures.benchmark.drift import (
    FAR,
    LOST,
    OFF,
    STABLE,
    crossing,
    edge,
    falling,
    outcome,
)

SHOWS_TEMPERATURE = True

TITLE = "How runs fail as the time step grows."
PAPER_SHOWS = (
    "Each mark is a run: by how much kT is off 1, or after how many tau (the number below) a bead "
    "moved more than a cutoff in one step. Open: kT is within two standard errors of the limit "
    "between two kinds. (a) to (c): the standard fluid (rho 3, a 25, gamma 4.5), gw-vv with "
    "lambda 1/2. (d) and (e): monomers in two dimensions (rho 2, a 25, lambda 0.65) with rigid "
    "cores of two radii. (f): chains of 10 of such beads, rest length 0.25, r_s 0.15, F_max 100. "
    "Ticks: the step at which kT is 10 % off, between the steps that were tried. Dashed: a power "
    "law fitted to the ticks of the columns that the line spans. It begins where that step starts "
    "to fall by more than its errors, and is drawn where the fit is good (p > 0.05) and not level."
)
ERRORS = "Errors are standard errors; those of kT know about correlation."
KINDS = {
    STABLE: Look("kT within 2 %", BLUE, "o"),
    OFF: Look("2 to 10 % off", ORANGE, "s"),
    FAR: Look("> 10 % off", RED, "^"),
    LOST: Look(r"blown up (after $\tau$)", BLACK, "x"),
}
FAILS = {OFF: "2 to 10 % off", FAR: "> 10 % off", LOST: "blows up"}


class Map(NamedTuple):
    """A sweep over the time step and one more axis, and how that is called.

    ``name`` is for the table, ``symbol`` for formulas, ``label`` for the axis of the panel.
    """

    sweep: str
    axis: str
    name: str
    symbol: str
    label: str


MAPS = (
    Map("map_noise", "sigma", "noise sigma", r"\sigma",
        r"noise $\sigma$ / ($k_BT$ $\tau^{1/2}$ $r_c^{-1}$)"),
    Map("map_repulsion", "a", "repulsion a", "a", r"repulsion $a$ / ($k_BT$ $r_c^{-1}$)"),
    Map("map_density", "density", "density", r"\rho", r"density $\rho$ / $r_c^{-3}$"),
    Map("map_core", "force", "F_max", "F_{max}", r"core force $F_{max}$ / ($k_BT$ $r_c^{-1}$)"),
    Map("map_bonds", "stiffness", "C", "C", r"spring constant C / ($k_BT$ $r_c^{-2}$)"),
)  # fmt: skip
UNITS = {"excess": "kT", "error": "kT", "lost": "tau", "kind": "1", "sure": "1"}


def compute(sweeps):
    """Kinds of outcome on every map, steps at which runs fail, and their power laws."""
    return xr.merge([_map(key, *rest) for key, *rest in _maps(sweeps)])


def _maps(sweeps):
    """Key, runs, axis and name of each map; one for each core radius."""
    for each in MAPS:
        runs = sweeps[each.sweep]
        if "r_s" not in runs.dims:
            yield each.sweep, runs, each.axis, each.name
            continue
        for number, radius in enumerate(runs.r_s.values):
            name = f"{each.name}, r_s {radius:g}"
            yield f"{each.sweep}_{number}", runs.sel(r_s=radius), each.axis, name


def _map(key, runs, axis, name):
    """One map, all its names beginning with its key."""
    runs = runs.sortby("dt").sortby(axis).transpose(axis, "dt", "replica")
    dt, x = runs.dt.values.astype(float), runs[axis].values.astype(float)
    found = outcome(runs.kT.values, runs.kT_error.values, runs.lost_step.values, dt)
    edges = np.array([edge(dt, kind, sure) for kind, sure in zip(found.kind, found.sure)])
    hot = np.array([crossing(dt, e, error) for e, error in zip(found.excess, found.error)])
    law = falling(x, *hot.T)
    across, up = f"{key}_x", f"{key}_dt"
    along = (across, up)
    data = xr.Dataset(coords={across: (across, x, runs[axis].attrs), up: (up, dt)})
    data[up].attrs = {"units": "tau", "long_name": "time step"}
    for part, values in found._asdict().items():
        data[f"{key}_{part}"] = (along, np.asarray(values), {"units": UNITS[part], "map": name})
    for part, values in zip(("stable", "beyond"), edges.T):
        data[f"{key}_{part}"] = (across, values, {"units": "tau"})
    data[f"{key}_hot"] = (
        across,
        hot[:, 0],
        {"units": "tau", "long_name": "dt where kT is 10 % off"},
    )
    data[f"{key}_hot_error"] = (across, hot[:, 1], {"units": "1", "long_name": "error of ln hot"})
    for part, value in law._asdict().items():
        data[f"{key}_law_{part}"] = ((), float(value), {"units": "1"})
    data[f"{key}_law_holds"] = ((), law.holds, {"units": "1"})
    return data


def _keys(data):
    """The maps of a dataset, in order."""
    return [key.removesuffix("_kind") for key in data.data_vars if key.endswith("_kind")]


def _name(data, key):
    return data[f"{key}_kind"].attrs["map"]


def measured(data):
    """None: no paper gives such numbers."""
    return {}


def table(data):
    """For every column of every map the largest stable step, and how the next one fails."""
    rows = []
    for key in _keys(data):
        hot, hot_error = data[f"{key}_hot"].values, data[f"{key}_hot_error"].values
        x, dt = data[f"{key}_x"].values, data[f"{key}_dt"].values
        for place, value in enumerate(x):
            stable, beyond = (float(data[f"{key}_{p}"][place]) for p in ("stable", "beyond"))
            largest = f"{stable:g}" if np.isfinite(stable) else f"none (< {dt[0]:g})"
            fails = "all that were tried are stable"
            if np.isfinite(beyond):
                fails = f"{beyond:g}: {_failure(data, key, place, dt == beyond)}"
            ten = with_error(hot[place], hot[place] * hot_error[place])
            rows.append((_name(data, key), f"{value:g}", largest, fails, ten))
    return pd.DataFrame(rows, columns=[
        "map", "value", "largest stable dt / tau", "the next dt / tau, and how it fails",
        "dt / tau at which kT is 10 % off",
    ])  # fmt: skip


def _failure(data, key, place, step):
    """How one run fails, in words with numbers."""
    kind, excess, error, lost = (
        data[f"{key}_{part}"].values[place][step][0] for part in ("kind", "excess", "error", "lost")
    )
    if kind == LOST:
        return f"blows up after {lost:.2g} tau"
    return f"kT {100 * excess:+.1f} ± {100 * error:.1f} %"


def warnings(data):
    """What the maps cannot tell, and what is odd in them."""
    keys = _keys(data)

    def count(test):
        return sum(int(test(key).sum()) for key in keys)

    runs = count(lambda key: data[f"{key}_kind"] >= 0)
    unsure = count(lambda key: ~data[f"{key}_sure"].astype(bool))
    cold = count(lambda key: (data[f"{key}_excess"] < 0) & (data[f"{key}_kind"] > STABLE))
    found = []
    if unsure:
        found.append(
            f"Of {runs} runs {unsure} are too short to tell on which side of a limit they lie."
        )
    if cold:
        found.append(
            f"In {cold} of the runs that are off by more than 2 % kT is below 1, not above."
        )
    never = [
        f"{_name(data, key)} {', '.join(f'{v:g}' for v in data[f'{key}_x'].values[none])}"
        for key in keys
        if (none := np.isnan(data[f"{key}_stable"].values)).any()
    ]
    if never:
        found.append(f"No step that was tried is stable at {'; '.join(never)}.")
    again = count(lambda key: _stable_again(data, key))
    if again:
        found.append(f"{again} runs are stable at a step larger than one that is not.")
    bad = [_name(data, key) for key in keys if not data[f"{key}_law_holds"]]
    if bad:
        found.append(
            f"No single power law for the step at which kT is 10 % off over {'; '.join(bad)}."
        )
    return found


def _stable_again(data, key):
    """Stable runs beyond the first that is not."""
    stable = data[f"{key}_kind"].values == STABLE
    return stable & (np.cumprod(stable, axis=1) == 0)


def describe(data):
    """What is seen, in words."""
    return (
        "Maps over the time step and one parameter each: runs that hold their temperature lie at "
        "small steps, above them runs that are too hot, and above those runs that blow up."
    )


def draw(data):
    """A panel for each map, over two log axes."""
    keys = _keys(data)
    figure, axes = panels(3, -(-len(keys) // 3), height=2.6)
    for panel, key in zip(axes.ravel(), keys):
        drawn = next(each for each in MAPS if key.startswith(each.sweep))
        _draw_map(panel, data, key)
        title = f"{_radius(data, key)}{_law(data, key, drawn.symbol)}"
        panel.set(xlabel=drawn.label, ylabel=r"time step dt / $\tau$", title=title)
    for panel in axes.ravel()[len(keys) :]:
        panel.remove()
    handles = [
        Line2D([], [], color=color, marker=marker, linestyle="none", markersize=5, label=label)
        for label, color, marker in KINDS.values()
    ]
    tick = {"color": "0.35", "marker": "_", "markersize": 11, "linestyle": "none"}
    handles.append(Line2D([], [], label="10 % off here", **tick))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    return figure


def _radius(data, key):
    """The core radius of a map as part of its title."""
    _, _, radius = _name(data, key).partition("r_s ")
    return rf" $r_s$ = {radius} $r_c$" if radius else ""


def _law(data, key, symbol):
    """The power law of a map, if there is one, as part of its title."""
    if not data[f"{key}_law_holds"]:
        return ""
    exponent, error = (float(data[f"{key}_law_{part}"]) for part in ("exponent", "error"))
    return rf"  dashed: dt $\propto {symbol}^{{{exponent:.2f} \pm {error:.2f}}}$"


def _draw_map(panel, data, key):
    """Marks, times of blowing up, and the power law if there is one."""
    x, dt = data[f"{key}_x"].values, data[f"{key}_dt"].values
    kinds, sure = data[f"{key}_kind"].values, data[f"{key}_sure"].values.astype(bool)
    across, up = np.meshgrid(x, dt, indexing="ij")
    for kind, (_, color, marker) in KINDS.items():
        for filled in (True, False):
            at = (kinds == kind) & (sure == filled)
            face = color if filled else "white"
            panel.plot(across[at], up[at], marker, color=color, markersize=5, markerfacecolor=face)
    for place in np.argwhere(kinds == LOST):
        time = float(data[f"{key}_lost"].values[tuple(place)])
        panel.annotate(
            f"{time:.2g}", (x[place[0]], dt[place[1]]), (0, -4), textcoords="offset points",
            ha="center", va="top", fontsize=7,
        )  # fmt: skip
    panel.plot(x, data[f"{key}_hot"], "_", color="0.35", markersize=11, markeredgewidth=1)
    if data[f"{key}_law_holds"]:
        factor, exponent = (float(data[f"{key}_law_{part}"]) for part in ("factor", "exponent"))
        ends = np.array([float(data[f"{key}_law_{end}"]) for end in ("low", "high")])
        panel.plot(ends, factor * ends**exponent, "--", color="0.35", zorder=0)
    panel.set(xscale="log", yscale="log", xlim=_around(x), ylim=_around(dt, below=1.2))
    panel.set_xticks(x, [f"{v:g}" for v in x])
    panel.set_yticks(dt, [f"{v:g}" for v in dt])
    panel.minorticks_off()


def _around(values, below=1.0):
    """Limits that leave room for a mark on either side, and for a number below it."""
    room = (values[-1] / values[0]) ** (0.5 / max(1, len(values) - 1)) if len(values) > 1 else 1.5
    return values[0] / (room * below), values[-1] * room
