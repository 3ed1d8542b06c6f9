"""Figure 8: chi N / Delta a against chain length."""

import numpy as np
import xarray as xr
from matplotlib.ticker import MaxNLocator

from dpd.analysis.interfaces import sweep_chi
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, RED, panels, points, published_line
from dpd.report.text import with_error
from paper_figures.groot_warren_1997.shared import NOT_FITTED, monomer_slope

PUBLISHED = shown_by(__file__)
LONGEST, BEYOND = 10, 20  # beads of the longest chains that the paper fits, and that it has
NARROW = 6  # beads of the longest chains whose interfaces leave much bulk in this box
SLOPE, BELOW = PUBLISHED["chain_slope"], PUBLISHED["monomer_below"]

TITLE = "chi N kT / Delta a of chains against their length N (rho = 3, C = 2)."
PAPER_SHOWS = (
    f"(a) The paper shows chi N kT / Delta a against N and fits ({SLOPE}) N for N from 2 to "
    f"{LONGEST} (dashed), N = 1 some {100 * BELOW.value:g} % below. (b) The same over N. N = 1 "
    "here is the slope of the monomer runs with chi > 3. The paper has several Delta a for each N, "
    f"up to N = {BEYOND}; we have one, which keeps chi N near 4. Chains of {BEYOND} are run in the "
    "study paper alone, in a box of twice the length, as in that of the others their interfaces "
    "would leave no bulk; as in the paper they are not fitted. Tails of interfaces are fitted and "
    f"taken off. Open points are not fitted either: {NOT_FITTED}"
)


def compute(sweeps):
    """chi N / Delta a, which points are fitted, and the fits of Eq. 27."""
    there = [sweeps[name] for name in ("chains", "long_chains") if name in sweeps]
    chains = xr.concat([sweep_chi(runs, "length") for runs in there], "length")
    length = chains.length.values.astype(float)
    ratio = chains.chi.values / chains.excess_repulsion.values * length
    error = chains.chi_error.values / chains.excess_repulsion.values * length
    settled = chains.settled.values == 1
    chosen = settled & (length >= 2) & (length <= LONGEST) & np.isfinite(ratio)
    monomers = sweep_chi(sweeps["segregation_3"], "excess")
    _, one = monomer_slope(monomers)
    data = xr.Dataset(
        {
            "ratio": ("length", np.append(one.values if one else np.nan, ratio)),
            "error": ("length", np.append(one.errors if one else np.nan, error)),
            "fitted": ("length", np.append(False, chosen)),
            "settled": ("length", np.append(True, settled)),
            "drift": ("length", np.append(0.0, chains.drift.values)),
        },
        {"length": np.append(1.0, length)},
    )
    data.ratio.attrs = {"units": "r_c", "long_name": "chi N kT / Delta a"}
    data.error.attrs = {"units": "r_c", "long_name": "standard error"}
    data.drift.attrs = {"units": "1", "long_name": "change between halves in standard errors"}
    put_fit(data, "slope", slope_fit(data))
    for name, first in (("offset", False), ("offset_with_1", True)):
        use = data.fitted.values | (
            (data.length.values == 1) & first & np.isfinite(data.ratio.values)
        )
        put_fit(data, name, offset_fit(data.isel(length=use)) if use.sum() >= 3 else None)
    return data


def slope_fit(data, longest=LONGEST):
    """The slope of ratio = s N of the fitted chains up to some length; None without any."""
    at = data.isel(length=data.fitted.values & (data.length.values <= longest))
    if not at.sizes["length"]:
        return None
    return linear_fit([at.length.values], at.ratio.values, at.error.values)


def offset_fit(data):
    """N_0 of ratio = s (N - N_0), with its error by linear propagation."""
    x = data.length.values
    fit = linear_fit([x, np.ones_like(x)], data.ratio.values, data.error.values)
    (slope, constant), (_, constant_error) = fit.values, fit.errors
    relative = constant_error / slope  # the error of the slope matters little for N_0 near 0
    return fit._replace(values=np.array([-constant / slope]), errors=np.array([relative]))


def put_fit(data, name, fit):
    """Put a fit's value, error and quality into a dataset; NaN without a fit."""
    value = error = quality = np.nan
    if fit:
        (value,), (error,), quality, _ = fit
    data[name] = ((), value, {"units": "r_c" if name == "slope" else "1"})
    data[f"{name}_error"] = ((), error, {"units": data[name].attrs["units"]})
    data[f"{name}_reduced_chi_square"] = ((), quality, {"units": "1"})


def measured(data):
    """Numbers around Eq. 27."""
    count = int(data.fitted.sum())
    few = "" if count >= 3 else "fewer than three chain lengths in equilibrium"
    lengths = ", ".join(f"{n:g}" for n in data.length.values[data.fitted.values])
    slope, error = float(data.slope), float(data.slope_error)
    narrow = slope_fit(data, NARROW)
    alone = with_error(narrow.values[0], narrow.errors[0]) if narrow else "none"
    one = data.sel(length=1)
    below = 1 - float(one.ratio) / slope
    below_error = float(np.hypot(one.error / slope, float(one.ratio) * error / slope**2))
    return {
        "chain_slope": Measured(
            slope, error,
            f"N = {lengths}, reduced chi-square {float(data.slope_reduced_chi_square):.2f}; from N "
            f"up to {NARROW} alone: {alone}", few,
        ),
        "monomer_below": Measured(below, below_error, "1 - (chi / Delta a at N = 1) / slope", few),
        "chain_20": of_longest(data),
        "offset": Measured(float(data.offset), float(data.offset_error), "", few),
        "offset_with_1": Measured(
            float(data.offset_with_1), float(data.offset_with_1_error),
            f"{abs(float(data.offset_with_1 / data.offset_with_1_error)):.1f} standard "
            "errors from 0", few,
        ),
    }  # fmt: skip


def of_longest(data):
    """chi kT / Delta a of the longest chains, which are not fitted."""
    if BEYOND not in data.length:
        return Measured(np.nan, np.nan)
    at = data.sel(length=BEYOND)
    unsettled = "" if at.settled else "the run has not settled"
    return Measured(float(at.ratio) / BEYOND, float(at.error) / BEYOND, "", unsettled)


def describe(data):
    """What is seen."""
    slope, one, longest = float(data.slope), float(data.ratio.sel(length=1)), of_longest(data).value
    beyond = f", and N = {BEYOND}, not fitted, is at {longest:.3f}" if np.isfinite(longest) else ""
    return (
        f"(a) chi N kT / Delta a lies on a straight line through the origin, of slope {slope:.3f}, "
        "on the dashed published one. (b) Divided by N the points scatter about that slope within "
        f"their error bars; N = 1 lies lower, at {one:.3f}{beyond}. With N = 1 a line has the "
        f"offset N_0 = {with_error(float(data.offset_with_1), float(data.offset_with_1_error))}."
    )


def draw(data):
    """chi N / Delta a against N, the paper's axes, and the ratio per bead."""
    figure, (left, right) = panels(2)
    fitted, one = data.fitted.values, data.length.values == 1
    beyond = data.get("settled", data.fitted).values & (data.length.values > LONGEST)
    groups = (
        (fitted, BLUE, "o", True, "fitted"),
        (one, RED, "s", True, "$N$ = 1, from Fig. 7"),
        (beyond, GREEN, "^", True, f"$N$ = {BEYOND}, beyond the fit"),
        (~fitted & ~one & ~beyond, BLUE, "o", False, "not fitted"),
    )
    for use, color, marker, filled, label in groups:
        if not use.any():
            continue
        at = data.isel(length=use)
        points(left, at.length, at.ratio, at.error, label, color, marker, filled)
        n = at.length.values
        points(right, n, at.ratio / n, at.error / n, None, color, marker, filled)
    x = np.array([0, float(data.length.max()) * 1.05])
    slope = float(data.slope)
    if np.isfinite(slope):
        label = f"fit {slope:.3f} ± {COVERAGE * float(data.slope_error):.3f} (95 %)"
        left.plot(x, slope * x, color=BLUE, linewidth=0.8, label=label)
        right.axhline(slope, color=BLUE, linewidth=0.8, label="fit")
    published_line(left, x, SLOPE.value * x, f"published {SLOPE.value:g} $N$")
    right.axhspan(SLOPE.value - SLOPE.error, SLOPE.value + SLOPE.error, color=BLACK, alpha=0.2,
                  linewidth=0, label=f"published {SLOPE}")  # fmt: skip
    left.set(xlim=(0, x[1]), ylim=(0, None), xlabel="chain length $N$",
             ylabel=r"$\chi N k_BT / \Delta a$ / $r_c$")  # fmt: skip
    right.set(xlim=(0, x[1]), xlabel="chain length $N$", ylabel=r"$\chi k_BT / \Delta a$ / $r_c$")
    for axes in (left, right):
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    low, high = right.get_ylim()
    right.set_ylim(low, high + 0.25 * (high - low))  # room for the legend
    left.legend(loc="upper left")
    right.legend(loc="upper left", ncols=2)
    return figure
