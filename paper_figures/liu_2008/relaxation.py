"""How long chains remember their direction, over chain length: 15/8 or 2?"""

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.diffusion import TEN, chain_dynamics, power
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, ORANGE, Look, panels, points
from dpd.report.text import with_error
from paper_figures.liu_2008.shared import too_small

TITLE = "Relaxation time of the end-to-end vector over chain length, melts of set (1)."
PAPER_SHOWS = (
    "Not a figure of the paper, which infers tau_N ~ N^(15/8) from the plateau of Fig. 6b. Here "
    "tau_N is that of the exponential tail of <R(t) . R(0)>, R the end-to-end vector, fitted "
    "between 0.6 and 0.15 of <R^2>. (a) tau_N; (b) tau_N over N^(15/8). Only runs of ten "
    "relaxation times or more, after two to settle, count; others are drawn hollow and left out "
    "of the fits. "
    "Solid: N^(15/8) (Semenov and Johner), dotted: N^2 (Rouse), through the shortest chains that "
    "count with each thermostat. "
    "Langevin: a control of ours that conserves no momentum. Times in DPD units tau_0."
)
ERRORS = (
    "Bars, and exponents in the legend: 95 % intervals, the larger of two jackknife errors, "
    "leaving out molecules, and leaving out tenths of the run."
)
LAWS = {"15/8": (15 / 8, "-"), "2": (2.0, ":")}
BATHS = {"melts": Look("pair friction", BLUE, "o"), "langevin": Look("Langevin", ORANGE, "s")}
LABELS = {0.0: r"$\tau_N$ / $\tau_0$", LAWS["15/8"][0]: r"$\tau_N / N^{15/8}$ / $\tau_0$"}


def compute(sweeps):
    """tau_N over N with both thermostats, and its exponent."""
    data = xr.concat([_of_bath(sweeps[name]) for name in BATHS], "sweep", join="outer")
    data = data.assign_coords(sweep=list(BATHS))
    fits = [power(*_counted(data.sel(sweep=name)), 0, np.inf) for name in BATHS]
    data["exponent"] = ("sweep", [fit.exponent for fit in fits], {"units": "1"})
    data["exponent_error"] = ("sweep", [fit.error for fit in fits], {"units": "1"})
    return data


def _of_bath(sweep):
    """Relaxation of the chains of a sweep, and the edges of their boxes."""
    edges = [min(first_scene(sweep.sel(length=n)).box) for n in sweep.length.values]
    found = chain_dynamics(sweep)
    return found.assign(box_edge=("length", np.array(edges, dtype=float), {"units": "r_c"}))


def _counted(at):
    """N, tau_N and its error where a run is long enough."""
    use = at.long_enough.values > 0
    return at.length.values[use], at.tau.values[use], at.tau_error.values[use]


def measured(data):
    """The exponent of tau_N with both thermostats."""
    pairs = data.sel(sweep="melts").dropna("length", subset=["duration"])
    small = too_small(pairs.isel(length=-1))
    claim = _exponent(data, "melts")
    return {
        "end_to_end": Measured(claim.value, claim.error, claim.note, claim.undecided or small),
        "end_to_end_langevin": _exponent(data, "langevin"),
    }


def _exponent(data, sweep):
    at = data.sel(sweep=sweep)
    length, time, error = _counted(at)
    listed = ", ".join(f"N {n:g}: {with_error(*of)}" for n, *of in zip(length, time, error))
    value, note = float(at.exponent), f"tau_N {listed}" if listed else ""
    reason = "" if np.isfinite(value) else f"fewer than three lengths ran {TEN:g} tau_N"
    return Measured(value, float(at.exponent_error), note, reason)


def table(data):
    """tau_N of each chain length, with how long its run was."""
    rows = []
    for name, look in BATHS.items():
        at = data.sel(sweep=name).dropna("length", subset=["duration"])
        for n in at.length.values:
            one = at.sel(length=n)
            rows.append((
                look.label, f"{n:g}", with_error(float(one.tau), float(one.tau_error)),
                f"{float(one.duration):.4g}",
                "yes" if one.long_enough else "no: run too short",
            ))  # fmt: skip
    return pd.DataFrame(rows, columns=["thermostat", "N", "tau_N / tau_0", "run / tau_0", "counts"])


def describe(data):
    """What is seen."""
    parts = [
        f"{look.label}: {with_error(float(at.exponent), float(at.exponent_error))}"
        for look, at in ((look, data.sel(sweep=name)) for name, look in BATHS.items())
    ]
    return f"Exponents of tau_N over N: {'; '.join(parts)}. The paper's is 15/8."


def draw(data):
    """tau_N, and the same over the paper's law."""
    figure, axes = panels(2, height=2.6)
    for panel, (taken, label) in zip(axes, LABELS.items()):
        panel.set(xscale="log", yscale="log", xlabel="chain length N")
        for name, look in BATHS.items():
            _draw_bath(panel, data.sel(sweep=name), taken, look)
        panel.set_ylabel(label)
        panel.set_xticks(data.length.values, [f"{n:g}" for n in data.length.values])
        panel.set_xticks([], minor=True)
    handles = axes[0].get_legend_handles_labels()
    if handles[0]:
        figure.legend(*handles, loc="outside upper center", ncols=3)
    return figure


def _draw_bath(panel, at, taken, look):
    """Points of one thermostat over N^taken, hollow where the run was too short, and both laws."""
    n, counts = at.length.values, at.long_enough.values > 0
    value, error = at.tau.values / n**taken, at.tau_error.values / n**taken
    label = look.label
    if np.isfinite(float(at.exponent)):
        label += f": {with_error(float(at.exponent), COVERAGE * float(at.exponent_error))}"
    if counts.any():
        points(panel, n[counts], value[counts], error[counts], label, look.color, look.marker)
    rest = ~counts & np.isfinite(value)
    if rest.any():
        points(panel, n[rest], value[rest], error[rest], f"{look.label}, run too short",
               look.color, look.marker, filled=False)  # fmt: skip
    if not (counts & np.isfinite(value)).any():
        return
    x = np.geomspace(n[counts][0], n[np.isfinite(value)][-1], 50)
    for name, (law, style) in LAWS.items():
        y = value[counts][0] * n[counts][0] ** taken * (x / x[0]) ** law / x**taken
        shown = rf"$N^{{{name}}}$" if look.label == "pair friction" else None
        panel.plot(x, y, color=BLACK, linestyle=style, linewidth=0.9, label=shown)
