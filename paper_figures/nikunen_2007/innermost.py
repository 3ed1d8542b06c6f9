"""How far beads in the middle of long chains move: as in a tube, or as Rouse's?"""

import numpy as np

from dpd.analysis.diffusion import subdiffusion
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels
from paper_figures.nikunen_2007.shared import CONTROL, MAIN, SETS, in_words, law, repulsion

PUBLISHED = shown_by(__file__)
NAMES = {MAIN: f"slope_{MAIN}", CONTROL: "slope_control"}
TUBE, ROUSE = law(PUBLISHED[NAMES[MAIN]]), law(PUBLISHED[NAMES[CONTROL]])  # powers of time
FROM = 0.5  # tau, from which on displacements are drawn: before, beads fly

TITLE = "Displacement of the innermost beads of long chains (a), and its local slope (b)."
PAPER_SHOWS = (
    "Not a figure of the paper, which says that chains of a 100 reptate. Innermost beads of Rouse "
    "chains move as t^(1/2), those in a tube as t^(1/4) from the time on at which they feel it, "
    "until the chain has lost its own shape (Doi and Edwards). (a) Solid: g_1 of the two "
    "innermost beads, dashed: g_cm of centres of mass, relative to the centre of mass of the box; "
    "thick where 4 <l^2> < g_1 < R_g^2. Black: both laws, through the first thick point. (b) d ln "
    "g_1 / d ln t, of a straight line over a factor of 4 in time. Time in units tau_0 = (m r_c^2 / "
    "kT)^(1/2)."
)
ERRORS = (
    "Bands: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving "
    "out tenths of the run; beyond a tenth of the run that over molecules alone, larger by as much "
    "as that of the tenths was in the decade before. Times up to half the run."
)


def compute(sweeps):
    """Displacements and local slopes of both sets."""
    return subdiffusion(sweeps["innermost"], "set")


def _lowest(data, name):
    """The smallest local slope beyond two bonds and inside of the chain's own size."""
    if name not in data.set.values:
        return Measured(np.nan, np.nan)
    at = data.sel(set=name)
    known = at.slope.dropna("lag")
    slope = known.where((at.inner >= at.low) & (at.inner <= at.high)).dropna("lag")
    if not len(slope):
        return Measured(np.nan, np.nan, "", "the run is too short for a slope beyond two bonds")
    place = int(slope.values.argmin())
    there = at.sel(lag=slope.lag[place])
    note = (
        f"N {int(at.beads)}, at {float(there.time):.3g} tau_0, g_1 = "
        f"{float(there.inner / at.high):.2g} R_g^2"
    )
    falls = bool(slope.lag[place] == known.lag[-1])
    reason = f"the slope falls until {float(there.time):.3g} tau_0, the end" if falls else ""
    return Measured(float(there.slope), float(there.slope_error), note, reason)


def measured(data):
    """The smallest slopes of the set of the dynamics and of the control."""
    return {published: _lowest(data, name) for name, published in NAMES.items()}


def describe(data):
    """What is seen."""
    found = {in_words(name): _lowest(data, name) for name in NAMES}
    parts = [f"{name}: {one.value:.2f}" for name, one in found.items() if np.isfinite(one.value)]
    return f"Local slopes fall from 2, free flight. Smallest: {'; '.join(parts) or 'not known'}."


def draw(data):
    """Displacements and slopes."""
    figure, (left, right) = panels(2)
    for name in data.set.values:
        at = data.sel(set=name).isel(lag=np.flatnonzero(data.time.sel(set=name) >= FROM))
        color = SETS[str(name)]
        curves = ((left, "inner", "-"), (left, "centre", "--"), (right, "slope", "-"))
        for panel, kind, style in curves:
            value, reach = at[kind], COVERAGE * at[f"{kind}_error"]
            panel.fill_between(at.time, value - reach, value + reach, color=color, alpha=0.25,
                               linewidth=0)  # fmt: skip
            label = f"a = {repulsion(name)}, N = {int(at.beads)}" if kind == "inner" else None
            panel.plot(at.time, value, style, color=color, label=label)
        inside = ((at.inner >= at.low) & (at.inner <= at.high)).values
        left.plot(at.time[inside], at.inner[inside], color=color, linewidth=2)
        if name == MAIN and inside.any():
            first = at.isel(lag=np.flatnonzero(inside)[0])
            time = np.geomspace(float(first.time), float(at.time.max()), 50)
            for power, style, text in ((ROUSE, "-.", "1/2"), (TUBE, ":", "1/4")):
                left.plot(time, float(first.inner) * (time / time[0]) ** power, style, color=BLACK,
                          linewidth=0.9, label=f"$t^{{{text}}}$")  # fmt: skip
    for power, style in ((ROUSE, "-."), (TUBE, ":")):
        right.axhline(power, color=BLACK, linestyle=style, linewidth=0.9)
    scale = "log" if data.inner.notnull().any() else "linear"  # a logarithm of nothing fails
    for panel in (left, right):
        panel.set(xscale=scale, xlabel=r"time $t$ / $\tau_0$")
    left.set(yscale=scale, ylabel=r"$g_1$, $g_{cm}$ / $r_c^2$")
    right.set(ylim=(0, 1), ylabel=r"local slope d ln $g_1$ / d ln $t$")
    left.legend(loc="upper left")
    return figure
