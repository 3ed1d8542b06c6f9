"""Figure 4: size of chains, and how long they remember where they point."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import padded
from dpd.analysis.relaxation import TAIL, chain_dynamics, end_to_end, power
from dpd.analysis.statistics import COVERAGE, block_mean_and_error
from dpd.analysis.structure import blocks_of
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, SKY, panels, points

TITLE = "Radius of gyration (a), and autocorrelation of the end-to-end vector for a 100 (b)."
PAPER_SHOWS = (
    "The paper shows (a) R_g over N for every set, which follows N^(1/2), and (b) the correlation"
    " <R(t) . R(0)>, whose exponential tail gives tau. Line in (a): N^(1/2). Thick in (b): the "
    "part between 0.6 and 0.15 that tau is fitted to; lags reach up to a tenth of the run."
)
ERRORS = (
    "Bars and bands: 95 % intervals; sizes from blocks of the run, correlations from the larger "
    "of two jackknife errors, leaving out molecules, and leaving out tenths of the run."
)
COLORS = {"a25": BLACK, "a50": BLUE, "a100": GREEN, "a150": ORANGE, "a200": RED}
SERIES = (BLUE, GREEN, ORANGE, RED, PURPLE, SKY, BLACK)
SHORTEST = 16  # beads from which on a chain counts as long for the exponent
ROOM = 1.75  # box over end-to-end distance that the paper asks for


def compute(sweeps):
    """Sizes over N for each set; correlations over time for each N."""
    statics, runs = sweeps["statics"], sweeps["dynamics"]
    size = np.full((statics.sizes["set"], statics.sizes["length"], 2), np.nan)
    room = np.full(size.shape[:2], np.nan)
    for place in np.ndindex(size.shape[:2]):
        at = statics.isel(set=place[0], length=place[1])
        blocks = np.sqrt(blocks_of(at.gyration_square.isel(kind=0)))
        size[place] = block_mean_and_error(blocks)
        edge = float(np.cbrt(at.beads / at.number_density).mean())
        room[place] = edge / np.sqrt(float(at.end_to_end_square.mean()))
    length = statics.length.values.astype(float)
    curves = []
    for n in runs.length.values:
        found, square = end_to_end(runs.sel(length=n))
        value, error = found.derived(lambda c, square=square: c / square)
        curves.append(np.array([found.time, value, error]))
    table = np.stack(padded(curves), axis=1)
    exponents = [power(length, *size[k].T, SHORTEST, np.inf) for k in range(len(size))]
    dynamics = chain_dynamics(runs)
    return xr.Dataset(
        {
            "gyration": (("set", "length"), size[..., 0], {"units": "r_c"}),
            "gyration_error": (("set", "length"), size[..., 1], {"units": "r_c"}),
            "room": (("set", "length"), room, {"units": "1", "long_name": "box over R"}),
            "exponent": ("set", [x for x, _ in exponents], {"units": "1"}),
            "exponent_error": ("set", [e for _, e in exponents], {"units": "1"}),
            "time": (("chain", "end_lag"), table[0], {"units": "tau"}),
            "correlation": (("chain", "end_lag"), table[1], {"units": "1"}),
            "correlation_error": (("chain", "end_lag"), table[2], {"units": "1"}),
            "tau": ("chain", dynamics.tau.values, {"units": "tau"}),
            "long_enough": ("chain", dynamics.long_enough.values, {"units": "1"}),
        },
        {"set": statics.set, "length": length, "chain": runs.length.values.astype(float)},
    )


def measured(data):
    """The exponent of R_g."""
    chosen = data.sel(set="a100") if "a100" in data.set.values else data.isel(set=0)
    others = ", ".join(
        f"{name}: {float(data.exponent.sel(set=name)):.3f}" for name in data.set.values
    )
    tight = int((data.room < ROOM).sum())
    note = (
        f"N from {SHORTEST} on, a 100; {others}; box below {ROOM} R in {tight} of {data.room.size}"
    )
    return {
        "gyration_exponent": Measured(
            float(chosen.exponent), float(chosen.exponent_error), note,
            "" if np.isfinite(chosen.exponent) else f"fewer than two lengths from {SHORTEST} on",
        )
    }  # fmt: skip


def warnings(data):
    """Boxes that the paper's rule calls too small."""
    found = []
    for name in data.set.values:
        room = data.room.sel(set=name)
        tight = [
            f"N = {n:g} ({float(room.sel(length=n)):.2f})"
            for n in data.length.values
            if room.sel(length=n) < ROOM
        ]
        if tight:
            found.append(
                f"Box below {ROOM} end-to-end distances, the paper's rule, for a {str(name)[1:]}: "
                f"{', '.join(tight)}."
            )
    return found


def draw(data):
    """Sizes and correlations."""
    figure, (left, right) = panels(2)
    for name in data.set.values:
        at = data.sel(set=name)
        points(left, data.length, at.gyration, at.gyration_error, f"a = {str(name)[1:]}",
               COLORS.get(str(name), BLACK))  # fmt: skip
    n = np.array([float(data.length.min()), float(data.length.max())])
    anchor = float(data.gyration.mean("set")[-1])
    left.plot(n, anchor * np.sqrt(n / n[-1]), color=BLACK, linewidth=0.8, label="$N^{1/2}$")
    left.set(
        xscale="log", yscale="log", xlabel="chain length N", ylabel="$R_g$ / $r_c$", title="(a)"
    )
    left.set_xticks(data.length.values, [f"{n:g}" for n in data.length.values])
    low, high = left.get_ylim()
    sizes = [size for size in (0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 8) if low <= size <= high]
    left.set_yticks(sizes, [f"{size:g}" for size in sizes])
    left.minorticks_off()
    left.legend(loc="upper left")
    for chain, color in zip(data.chain.values, SERIES):
        at = data.sel(chain=chain).dropna("end_lag", subset=["time"])
        low = np.maximum(at.correlation - COVERAGE * at.correlation_error, 1e-3)
        right.fill_between(at.time, low, at.correlation + COVERAGE * at.correlation_error,
                           color=color, alpha=0.25, linewidth=0)  # fmt: skip
        seen = at.correlation > 0
        flag = "" if at.long_enough else " (run < 10 $\\tau$)"
        right.plot(at.time[seen], at.correlation[seen], color=color, linewidth=0.8,
                   label=f"N = {chain:g}{flag}")  # fmt: skip
        tail = (at.correlation < TAIL[1]) & (at.correlation > TAIL[0])
        right.plot(at.time[tail], at.correlation[tail], color=color, linewidth=2)
    right.set(yscale="log", xscale="log", ylim=(0.05, 1.1), xlabel=r"time t / $\tau$",
              ylabel=r"$\langle R(t) \cdot R(0) \rangle / \langle R^2 \rangle$",
              title="(b)")  # fmt: skip
    right.legend(loc="lower left")
    return figure
