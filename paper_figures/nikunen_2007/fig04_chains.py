"""Figure 4: size of chains, and how long they remember where they point."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene, padded
from dpd.analysis.diffusion import (
    DIFFUSES,
    SETTLED,
    TAIL_HIGH,
    TAIL_LOW,
    chain_dynamics,
    decay_time,
    diffusion_constant,
    displacements,
    end_to_end,
    in_tail,
    power,
    relaxation_time,
)
from dpd.analysis.statistics import COVERAGE, block_mean_and_error, linear_fit
from dpd.analysis.structure import blocks_of
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import (
    BLACK,
    BLUE,
    GREEN,
    MANY,
    MARKERS,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    panels,
    points,
    published_line,
)
from dpd.report.text import with_error
from paper_figures.nikunen_2007.shared import (
    MAIN,
    PAPER_CHAINS,
    PAPER_LENGTH,
    SETS,
    in_words,
    repulsion,
)

ROOM = shown_by(__file__)["box_rule"].low  # box over mean end-to-end distance
EARLY, LATE = (0.3, TAIL_HIGH), (TAIL_LOW, 0.4)  # parts of the tail of a correlation

TITLE = (
    "Radius of gyration over N^(1/2) (a), and autocorrelation of the end-to-end vector for a 100, "
    "k 200 (b)."
)
PAPER_SHOWS = (
    "The paper shows (a) R_g over N for every set, which follows N^(1/2), level here (dashed, "
    "through the longest chains of a 100), and (b) the "
    "correlation <R(t) . R(0)>, whose exponential tail gives the relaxation time tau. Runs that "
    "were equilibrated for less than two tau of a 100 are left out of (a) (where N is longer than "
    "any with a known tau, tau / N^2 is taken from the longest). Sets of "
    "one N are drawn side by side. Time in (b) is in units tau_0 = (m r_c^2 / kT)^(1/2), over N^2, "
    "so that Rouse chains fall on one curve; dashed: exp(-t / tau), fitted between 0.6 and 0.15, "
    "or to the last time, a tenth of the run."
)
ERRORS = (
    "Bars and bands: 95 % intervals; sizes from blocks of the run, correlations from the larger "
    "of two jackknife errors, leaving out molecules, and leaving out tenths of the run."
)
SERIES = (BLUE, GREEN, ORANGE, RED, PURPLE, SKY, BLACK, MANY[4])
OTHERS = ("a50", "a150", "a200")
LONG = 32  # beads from which on a chain is long beside its stiffness, one or two bonds
SHORT = 8  # from which on exponents of sets are compared
SIZES = ["scene", "gyration_square", "end_to_end_square"]
BOX = 16  # length of the chains in the small box
FEWEST = 4  # lengths or lags that can tell a line from another curve
MEAN = np.sqrt(8 / (3 * np.pi))  # mean distance over its root mean square, of a Gaussian vector


def compute(sweeps):
    """Sizes over N for each set; correlations over time for each N."""
    statics, runs = sweeps["statics"][SIZES], sweeps["dynamics"]
    dynamics = chain_dynamics(runs)
    sizes = runs[SIZES]  # choosing a point costs for each variable there is
    rows = [_size(sizes.sel(length=n), MAIN, n, dynamics) for n in runs.length.values]
    for name in statics.set.values:
        if name != MAIN:  # whose runs in (b) are longer
            rows += [
                _size(statics.sel(set=name, length=n), name, n, dynamics)
                for n in statics.length.values
            ]
    box = [_size(sweeps["box_size"], MAIN, BOX, dynamics)]
    if BOX in runs.length.values:
        box.append(_size(sizes.sel(length=BOX), MAIN, BOX, dynamics))
    curves, straight = [], []
    for n in runs.length.values:
        found, square = end_to_end(runs.sel(length=n))
        straight.append(straightness(found, square))
        curves.append(np.array([found.time, *found.derived(lambda c, square=square: c / square)]))
    curves = np.stack(padded(curves), axis=1)
    data = xr.Dataset(
        {
            "time": (("chain", "end_lag"), curves[0], {"units": "tau_0"}),
            "correlation": (("chain", "end_lag"), curves[1], {"units": "1"}),
            "correlation_error": (("chain", "end_lag"), curves[2], {"units": "1"}),
            "tau": ("chain", dynamics.tau.values, {"units": "tau_0"}),
            "long_enough": ("chain", dynamics.long_enough.values, {"units": "1"}),
            "straightness": (("chain", "estimate"), straight, {"units": "1"}),
        }
        | _diffusion_in_box(sweeps),
        {"chain": runs.length.values.astype(float), "estimate": ["value", "error"]},
    )
    for dimension, table in (("point", rows), ("box", box)):
        names = [f"{dimension}_{name}" if dimension == "box" else name for name in table[0]]
        for name, column in zip(names, zip(*(row.values() for row in table))):
            unit = "r_c" if "gyration" in name or "end_to_end" in name else "1"
            data[name] = (dimension, list(column), {"units": unit})
    return data


def straightness(found, square):
    """tau from the early part of the tail over tau from its late part, with its error.

    1 of an exponential; NaN where a part has fewer than four lags.
    """
    early, late = (in_tail(found.value / square, *limits) for limits in (EARLY, LATE))
    if min(early.sum(), late.sum()) < FEWEST:
        return np.nan, np.nan
    time = found.time
    return found.derived(lambda c: decay_time(time, c, early) / decay_time(time, c, late))


def _diffusion_in_box(sweeps):
    """Relative change of D in the small box, at the same lags, and that by the drag of images."""
    runs = sweeps["dynamics"]
    if BOX not in runs.length.values:
        return _in_box(np.nan, np.nan, np.nan)
    large, little = runs.sel(length=BOX), sweeps["box_size"]
    tau, _ = relaxation_time(*end_to_end(large))
    (small, small_error), (wide, wide_error) = (
        diffusion_constant(displacements(at, "centre"), 3, *(share * tau for share in DIFFUSES))
        for at in (little, large)
    )
    error = small / wide * np.hypot(small_error / small, wide_error / wide)
    narrow, broad = (min(first_scene(at).box) for at in (little, large))
    # Rouse's viscosity (Doi and Edwards, Eq. 7.36) at density 1 and kT 1, where D is lower by
    # 2.837 kT / (6 pi eta L) than in a wide box (Yeh and Hummer, J. Phys. Chem. B 108, 15873).
    viscosity = np.pi**2 / 12 * tau / BOX
    drag = 2.837 / (6 * np.pi * viscosity) * (1 / narrow - 1 / broad)
    return _in_box(small / wide - 1, error, -drag / wide)


def _in_box(change, error, by_drag):
    """What the figure keeps of the small box."""
    return {
        "box_diffusion": ("estimate", [change, error], {"units": "1"}),
        "box_drag": ((), by_drag, {"units": "1"}),
    }


def _size(at, name, n, dynamics):
    """R_g and R of one point, with errors, and what its box and its equilibration are worth."""
    row = {"set": str(name), "length": float(n)}
    for quantity in ("gyration", "end_to_end"):
        blocks = blocks_of(at[f"{quantity}_square"].isel(kind=0))
        square, error = block_mean_and_error(blocks)
        row[quantity], row[f"{quantity}_error"] = np.sqrt(square), error / (2 * np.sqrt(square))
    scene = first_scene(at)
    equilibrated = scene.steps.equilibrate * scene.dt
    row["settled"] = float(equilibrated >= SETTLED * _relaxation_time(n, dynamics))
    row["room"] = room(min(scene.box), row["end_to_end"])
    return row


def room(edge, distance):
    """Edge of a box over the mean end-to-end distance <R>, by which the paper's rule goes.

    <R> is smaller than the root of <R^2>, which the runs give: by the factor `MEAN`, as the ends of
    chains are nearly Gaussian.

    ``distance``: root of <R^2>.
    """
    return edge / (MEAN * distance)


def _relaxation_time(n, dynamics):
    """tau at a length, with tau / N^2 between those that are known; inf if none is.

    Where a run is too short for a certain tau, the larger of its own and of that.
    """
    good = dynamics.long_enough.values > 0
    if not good.any():
        return np.inf
    known, tau = dynamics.length.values[good], dynamics.tau.values[good]
    between = n**2 * np.exp(np.interp(np.log(n), np.log(known), np.log(tau / known**2)))
    own = dynamics.tau.values[dynamics.length.values == n]
    return float(np.nanmax([between, *own]))


def _sizes(data, name, quantity):
    """N, value and error of one set, by N, of runs that were equilibrated."""
    use = np.flatnonzero((data.set.values == name) & (data.settled.values > 0))
    use = use[np.argsort(data.length.values[use], kind="stable")]
    return tuple(data[each].values[use] for each in ("length", quantity, f"{quantity}_error"))


def measured(data):
    """Exponents of R_g and R, and what set and box change."""
    found = {}
    for quantity in ("gyration", "end_to_end"):
        found[f"{quantity}_exponent"] = _exponent(data, quantity)
        found[f"box_{quantity}"] = _box_effect(data, quantity)
    for name in OTHERS:
        found[f"gyration_exponent_{name}"] = _exponent_beside(data, name)
    found["box_diffusion"] = _box_drag(data)
    found["box_rule"] = _box_rule(data)
    return found


def _exponent(data, quantity):
    """Exponent of a size for long chains of a 100."""
    n, size, error = _sizes(data, MAIN, quantity)
    found = power(n, size, error, LONG, np.inf)
    fitted = ", ".join(f"{length:g}" for length in n[n >= LONG])
    if np.isfinite(found.exponent):
        return Measured(found.exponent, found.error, f"N {fitted}")
    note = ""
    if len(n) > 1:
        slope = np.log(size[-1] / size[-2]) / np.log(n[-1] / n[-2])
        spread = np.hypot(*(error[-2:] / size[-2:])) / np.log(n[-1] / n[-2])
        note = f"slope {slope:.3f} ± {spread:.3f} from N {n[-2]:g} to {n[-1]:g}"
    return Measured(np.nan, np.nan, note, f"fewer than three lengths from N {LONG} on")


def _exponent_beside(data, name):
    """Exponent of R_g of a set less that of a 100, over the lengths that both have."""
    n, size, error = _sizes(data, name, "gyration")
    main, main_size, main_error = _sizes(data, MAIN, "gyration")
    common, at, at_main = np.intersect1d(n, main, return_indices=True)
    found = power(common, size[at], error[at], SHORT, np.inf)
    beside = power(common, main_size[at_main], main_error[at_main], SHORT, np.inf)
    if not np.isfinite(found.exponent):
        few = "fewer than three lengths that both sets have and that are equilibrated"
        return Measured(np.nan, np.nan, "", few)
    used = ", ".join(f"{length:g}" for length in common[common >= SHORT])
    note = f"N {used}: {found.exponent:.3f}, a 100: {beside.exponent:.3f}"
    return Measured(
        found.exponent - beside.exponent, float(np.hypot(found.error, beside.error)), note
    )


def _box_effect(data, quantity):
    """Relative change of a size in the small box."""
    value, error = data[f"box_{quantity}"].values, data[f"box_{quantity}_error"].values
    if len(value) < 2:
        return Measured(np.nan, np.nan)
    rooms = " and ".join(f"{ratio:.2f}" for ratio in data.box_room.values)
    change = value[0] / value[1] - 1
    return Measured(
        float(change), float(value[0] / value[1] * np.hypot(*(error / value))),
        f"N {BOX} in boxes of {rooms} <R>",
    )  # fmt: skip


def _box_drag(data):
    """Change of D in the small box over that by the drag of images."""
    change, error = map(float, data.box_diffusion.values)
    drag = float(data.box_drag)
    note = (
        f"relative change {change:.3f} ± {error:.3f}, by drag {drag:.3f}; N {BOX}, at the same "
        "lags of half a tau to one"
    )
    return Measured(change / drag, abs(error / drag), note)


def _box_rule(data):
    """Edge over mean end-to-end distance of the paper's own system, from the longest chains."""
    n, size, error = _sizes(data, MAIN, "end_to_end")
    if not len(n):
        return Measured(np.nan, np.nan, "", "no run is equilibrated")
    edge = np.cbrt(PAPER_CHAINS * PAPER_LENGTH)
    here = room(edge, size[-1] * np.sqrt((PAPER_LENGTH - 1) / (n[-1] - 1)))
    spread = here * error[-1] / size[-1]
    note = f"from <R^2> of N {n[-1]:g} by R^2 ~ N - 1 and <R> = {MEAN:.3f} <R^2>^(1/2)"
    if n[-1] >= PAPER_LENGTH:
        return Measured(float(here), float(spread), note)
    # R^2 / (N - 1) still grows, so this is an upper bound, which can miss the rule but not meet it.
    note += "; an upper bound, as R^2 / (N - 1) still grows"
    blind = f"chains of {n[-1]:g} leave it open" if here > ROOM else ""
    return Measured(float(here), float(spread), note, blind)


def warnings(data):
    """Boxes that the paper's rule calls too small, and chains that remember their start."""
    found = []
    for name in dict.fromkeys(data.set.values):
        at = data.isel(point=np.flatnonzero(data.set.values == name)).sortby("length")
        small = at.isel(point=np.flatnonzero(at.room.values < ROOM))
        tight = [f"N = {n:g} ({r:.2f})" for n, r in zip(small.length.values, small.room.values)]
        if tight:
            found.append(
                f"Box below {ROOM:g} mean end-to-end distances, the paper's rule, for "
                f"{in_words(name)}: {', '.join(tight)}."
            )
        young = [f"{n:g}" for n in at.length.values[at.settled.values == 0]]
        if young:
            found.append(
                f"Equilibrated for less than {SETTLED:g} relaxation times, {in_words(name)}: N = "
                f"{', '.join(young)}."
            )
    return found


def describe(data):
    """What is seen."""
    n, size, _ = _sizes(data, MAIN, "gyration")
    if len(n) < 2:
        return TITLE
    level = size / np.sqrt(n)
    text = (
        f"R_g over the square root of N rises slowly, for a 100 from {level[0]:.3f} at N = {n[0]:g}"
        f" to {level[-1]:.3f} at N = {n[-1]:g}, and alike for all sets.{_approach(data)}"
    )
    known = data.where(data.long_enough > 0).dropna("chain", subset=["straightness"])
    if not known.sizes["chain"]:
        return text
    ratios = ", ".join(
        f"{with_error(*map(float, known.straightness.sel(chain=n).values))} (N = {n:g})"
        for n in known.chain.values
    )
    return (
        f"{text} Taken from the first part of the correlation's tail, tau over that from the "
        f"second part, which is 1 of an exponential, is {ratios}."
    )


def _approach(data):
    """How R_g^2 / N of a 100 comes to its limit.

    The ends of a chain change it in proportion to 1 / N, and what a melt leaves of the repulsion
    between distant parts of a chain, in proportion to 1 / N^(1/2) (Wittmer et al.,
    arXiv:0704.1620).
    """
    n, size, error = _sizes(data, MAIN, "gyration")
    known = np.isfinite(error)  # a run may be too short for an error
    n, size, error = n[known], size[known], error[known]
    if len(n) < FEWEST:
        return ""
    square, spread = size**2 / n, 2 * size * error / n

    def likely(power, shortest):
        basis = np.stack([np.ones(len(n)), n**power])
        fit = linear_fit(basis[:, shortest:], square[shortest:], spread[shortest:])
        return f"{fit.p_value:.1g}"

    return (
        " The points of R_g^2 / N lie on a line over 1 / N^(1/2) with probability "
        f"{likely(-0.5, 0)}, over 1 / N with {likely(-1, 0)}; without the shortest chains "
        f"{likely(-0.5, 1)} and {likely(-1, 1)}."
    )


def draw(data):
    """Sizes and correlations."""
    figure, (left, right) = panels(2, height=3.0)
    _draw_sizes(left, data)
    top = 0.0
    for chain, color in zip(data.chain.values, cycle(SERIES)):
        at = data.sel(chain=chain).dropna("end_lag", subset=["time"])
        top = max(top, _draw_correlation(right, at, chain, color))
    right.set(yscale="log", xlim=(0, 1.1 * top or None), ylim=(0.08, 1.1),
              xlabel=r"time $t$ / ($N^2$ $\tau_0$)",
              ylabel=r"$\langle R(t) \cdot R(0) \rangle / \langle R^2 \rangle$")  # fmt: skip
    right.set_yticks([0.1, 0.2, 0.5, 1], ["0.1", "0.2", "0.5", "1"])
    right.set_yticks([], minor=True)
    right.legend(loc="lower left")
    return figure


def _draw_sizes(panel, data):
    """R_g over N^(1/2), the sets a little aside of each other."""
    present = [name for name in SETS if name in data.set.values]
    for k, name in enumerate(present):
        aside = 1.03 ** (k - 0.5 * (len(present) - 1))
        n, size, error = _sizes(data, name, "gyration")
        points(panel, n * aside, size / np.sqrt(n), error / np.sqrt(n), f"a = {repulsion(name)}",
               SETS[name], MARKERS[k])  # fmt: skip
    n, size, _ = _sizes(data, MAIN, "gyration")
    if len(n):
        published_line(panel, n[[0, -1]], [size[-1] / np.sqrt(n[-1])] * 2, "$N^{1/2}$")
    lengths = np.unique(data.length.values[data.settled.values > 0])
    panel.set(xscale="log", xlabel="chain length N", ylabel="$R_g$ / ($N^{1/2}$ $r_c$)")
    panel.set_xticks(lengths, [f"{n:g}" for n in lengths])
    panel.set_xticks([], minor=True)
    panel.legend(loc="lower right")


def _draw_correlation(panel, at, chain, color):
    """One length over t / N^2, with its fit; where it ends."""
    time = at.time.values / chain**2
    value, error = at.correlation.values, at.correlation_error.values
    low = np.maximum(value - COVERAGE * error, 1e-3)
    panel.fill_between(time, low, value + COVERAGE * error, color=color, alpha=0.25, linewidth=0)
    flag = "" if at.long_enough else " (run too short)"
    panel.plot(time, np.where(value > 0, value, np.nan), color=color, label=f"N = {chain:g}{flag}")
    tail = in_tail(value)
    tau = float(at.tau) / chain**2
    if tail.sum() < 4 or not np.isfinite(tau):
        return 0.0
    height = np.mean(np.log(value[tail]) + time[tail] / tau)
    line = np.array([0, 2.5 * tau])
    panel.plot(line, np.exp(height - line / tau), "--", color=color, linewidth=0.7)
    return time[tail][-1]
