"""Figure 6: mean-square displacements of innermost beads and of centres of mass."""

import numpy as np

from dpd.analysis.diffusion import ROUSE, SEMENOV_JOHNER, excluded, subdiffusion
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels

TITLE = "Mean-square displacements over t^(1/2) (a) and t^(8/15) (b), melts of set (1)."
PAPER_SHOWS = (
    "The paper shows g_i of innermost beads and g_cm of centres of mass up to 1e4 tau for several"
    " N (its text names 100 only), and reads a plateau of g_i / t^(8/15) in (b). Solid: g_i, "
    "dashed: g_cm, relative to the centre of mass of the box. The paper gives no friction; gamma "
    "is 4.5 here. The exponent of g_i is fitted where 4 <l^2> < g_i < R_g^2 (thick part of the "
    "lines): beyond two bonds, and inside the chain's own size. A plateau is a horizontal line."
)
ERRORS = (
    "Bands: 95 % intervals; the larger of two jackknife errors, leaving out molecules, and "
    "leaving out tenths of the run, which know about motion that all chains share. Times up to a "
    "tenth of the run, so that tenths are independent."
)
COLORS = (BLUE, GREEN, RED, PURPLE, ORANGE)
PAPER_LENGTH = 100


def compute(sweeps):
    """Displacements and exponents over chain length."""
    return subdiffusion(sweeps["melts"], "length")


def measured(data):
    """The exponent of the paper's chains, and what it excludes."""
    if PAPER_LENGTH not in data.length:
        return {"exponent": Measured(np.nan, np.nan)}
    at = data.sel(length=PAPER_LENGTH)
    exponent, error = float(at.exponent), float(at.exponent_error)
    if np.isnan(exponent):
        return {"exponent": Measured(exponent, error, "", excluded(exponent, error))}
    window = f"{float(at.first):.3g} to {float(at['last']):.3g} tau"
    others = ", ".join(
        f"N {n}: {float(data.exponent.sel(length=n)):.3f} +- "
        f"{float(data.exponent_error.sel(length=n)):.3f}"
        for n in data.length.values
    )
    note = f"window {window}; {excluded(exponent, error)}; {others}"
    return {"exponent": Measured(exponent, error, note)}


def draw(data):
    """Displacements over two powers of time."""
    figure, panel = panels(2)
    for axes, power, label, name in zip(
        panel, (ROUSE, SEMENOV_JOHNER), ("1/2", "8/15"), ("(a)", "(b)")
    ):
        for length, color in zip(data.length.values, COLORS):
            at = data.sel(length=length).dropna("lag", subset=["time"])
            time, scale = at.time, at.time**power
            exponent, error = float(at.exponent), COVERAGE * float(at.exponent_error)
            text = rf"N = {length}, exponent {exponent:.2f} ± {error:.2f}"
            for kind, style in (("inner", "-"), ("centre", "--")):
                value, reach = at[kind] / scale, COVERAGE * at[f"{kind}_error"] / scale
                axes.fill_between(time, value - reach, value + reach, color=color, alpha=0.25,
                                  linewidth=0)  # fmt: skip
                axes.plot(time, value, style, color=color, linewidth=0.8,
                          label=text if kind == "inner" else None)  # fmt: skip
            inside = (at.inner >= at.low) & (at.inner <= at.high)
            axes.plot(time[inside], (at.inner / scale)[inside], color=color, linewidth=2)
        axes.plot([], [], "--", color=BLACK, linewidth=0.8, label="centre of mass")
        axes.set(xscale="log", yscale="log", xlabel=r"time $t$ / $\tau$", title=name,
                 ylabel=rf"$g(t) / t^{{{label}}}$ / ($r_c^2$ $\tau^{{-{label}}}$)")  # fmt: skip
    panel[0].legend(loc="lower right")
    return figure
