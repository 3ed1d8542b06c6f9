"""Figure 5: relaxation time and diffusion over chain length, from Rouse to reptation."""

import numpy as np
import pandas as pd

from dpd.analysis.relaxation import chain_dynamics, power
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, panels, points
from dpd.report.text import with_error

TITLE = "Relaxation time (a) and diffusion constant of chains (b) over chain length, a 100, k 200."
PAPER_SHOWS = (
    "The paper shows tau ~ N^2 crossing to N^3 and D ~ 1/N crossing to N^-2, with the crossover "
    "between N = 40 and 60 (shaded). Below, tau / N^2 and D N, which are level for Rouse chains "
    "whatever the crossover. Only runs of ten tau or more count; others are drawn open and left "
    "out of the fits, N from 8 to 40 and from 60 on. Dashed: the published laws, through the "
    "longest of the chains fitted."
)
ERRORS = (
    "Bars: 95 % intervals, the larger of two jackknife errors, leaving out molecules, and leaving"
    " out tenths of the run."
)
ROUSE, REPTATION = (8, 40), (60, np.inf)
ROUSE_LAW = {"tau": 2, "diffusion": -1}


def compute(sweeps):
    """tau and D over N."""
    data = chain_dynamics(sweeps["dynamics"])
    n = data.length.values
    good = data.long_enough.values > 0
    for name in ("tau", "diffusion"):
        value = np.where(good, data[name].values, np.nan)
        for regime, limits in (("rouse", ROUSE), ("reptation", REPTATION)):
            found = power(n, value, data[f"{name}_error"].values, *limits)
            data[f"{name}_{regime}"] = ((), found[0], {"units": "1"})
            data[f"{name}_{regime}_error"] = ((), found[1], {"units": "1"})
    return data


def measured(data):
    """Exponents in both regimes, and the crossover."""
    good = data.length.values[data.long_enough.values > 0]
    note = f"N {', '.join(f'{n:g}' for n in good)} ran ten tau or more"
    found = {}
    for name in ("tau", "diffusion"):
        for regime in ("rouse", "reptation"):
            value = float(data[f"{name}_{regime}"])
            limits = ROUSE if regime == "rouse" else REPTATION
            missing = f"fewer than two lengths between {limits[0]} and {limits[1]} ran ten tau"
            found[f"{name}_{regime}"] = Measured(
                value, float(data[f"{name}_{regime}_error"]), note,
                "" if np.isfinite(value) else missing,
            )  # fmt: skip
    found["crossover"] = _crossover(data)
    return found


def _crossover(data):
    """Where the lines of both regimes meet in tau."""
    use = (data.long_enough.values > 0) & np.isfinite(data.tau.values)
    use &= data.tau_error.values > 0
    n, tau = np.log(data.length.values[use]), np.log(data.tau.values[use])
    error = data.tau_error.values[use] / data.tau.values[use]
    low, high = n < np.log(ROUSE[1]), n > np.log(REPTATION[0])
    if low.sum() < 2 or high.sum() < 2:
        return Measured(np.nan, np.nan, "", "needs two lengths with an error in each regime")
    a, b = (np.polyfit(n[part], tau[part], 1, w=1 / error[part]) for part in (low, high))
    crossing = np.exp((a[1] - b[1]) / (b[0] - a[0]))
    spread = []
    rng = np.random.default_rng(0)
    for _ in range(200):
        noisy = tau + error * rng.normal(size=len(tau))
        c, d = (np.polyfit(n[part], noisy[part], 1, w=1 / error[part]) for part in (low, high))
        spread.append(np.exp((c[1] - d[1]) / (d[0] - c[0])))
    return Measured(float(crossing), float(np.std(spread)), "lines of both regimes in tau")


def table(data):
    """tau and D of each chain length, with how long its run was."""
    rows = []
    for n in data.length.values:
        at = data.sel(length=n)
        fitted = "yes" if at.long_enough else "no: shorter than ten tau"
        rows.append((
            f"{n:g}", with_error(float(at.tau), float(at.tau_error)),
            with_error(float(at.diffusion), float(at.diffusion_error)),
            with_error(float(at.diffusion) * n, float(at.diffusion_error) * n),
            f"{float(at.duration):.4g}", fitted,
        ))  # fmt: skip
    return pd.DataFrame(rows, columns=["N", "tau", "D", "D N", "run / tau", "counts"])


def draw(data):
    """tau and D, and below both with Rouse's law taken out."""
    figure, axes = panels(2, rows=2)
    n, good = data.length, data.long_enough > 0
    shown = (
        ("tau", 2, r"$\tau$ / $\tau_0$", r"$\tau / N^2$ / $\tau_0$", (2, 3)),
        ("diffusion", -1, r"$D \tau_0$ / $r_c^2$", r"$D N \tau_0$ / $r_c^2$", (-1, -2)),
    )
    for column, (name, power_taken, label, reduced, laws) in zip(axes.T, shown):
        for panel, taken in zip(column, (0, power_taken)):
            value, error = data[name] / n**taken, data[f"{name}_error"] / n**taken
            points(panel, n[good], value[good], error[good], "ten relaxation times or more", BLUE)
            if (~good).any() and np.isfinite(value[~good]).any():
                points(panel, n[~good], value[~good], error[~good], "shorter, not fitted", BLUE,
                       filled=False)  # fmt: skip
            for law, style in zip(laws, ("--", ":")):
                _draw_law(panel, data, name, law, taken, style)
            panel.axvspan(40, 60, color=BLACK, alpha=0.1, linewidth=0, label="published crossover")
            panel.set(xscale="log", yscale="linear" if taken else "log", xlabel="chain length N",
                      ylabel=reduced if taken else label)  # fmt: skip
            panel.set_xticks(n.values, [f"{length:g}" for length in n.values])
            panel.set_xticks([], minor=True)
    for panel, title in zip(axes.flat, "abcd"):
        panel.set_title(f"({title})")
    axes[0, 0].legend(loc="upper left")
    axes[0, 1].legend(loc="lower left")
    return figure


def _draw_law(panel, data, name, law, taken, style):
    """N^law, through the longest chain below the crossover that was fitted, or above it."""
    n = data.length.values
    use = (data.long_enough.values > 0) & np.isfinite(data[name].values)
    rouse = abs(law) == abs(ROUSE_LAW[name])
    use &= (n <= ROUSE[1]) if rouse else (n >= REPTATION[0])
    if not use.any():
        return
    last = np.flatnonzero(use)[-1]
    x = np.array([n[0], ROUSE[1]]) if rouse else np.array([REPTATION[0], n[-1]])
    y = float(data[name].values[last]) * (x / n[last]) ** law
    panel.plot(x, y / x**taken, color=BLACK, linestyle=style, linewidth=0.8, label=f"$N^{{{law}}}$")
