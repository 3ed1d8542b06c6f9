"""Sec. V: excess pressure of mixtures that do not segregate."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import linear_fit, over_replicas
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import panels, points, published_line
from paper_figures.groot_warren_1997.shared import SEGREGATION, excess_by

PUBLISHED = shown_by(__file__)
ALPHA = PUBLISHED["alpha"].value

TITLE = "Excess pressure of mixtures (rho = 3, a = 25; rho = 5, a = 15)."
PAPER_SHOWS = (
    "Not a figure of the paper: its text says that the excess pressure of mixing is proportional "
    "to x (1 - x), x the fraction of A, and that the prefactor is not simply linear in Delta a = "
    "a_AB - a from 2 to 5. At rho 5 fluids of Delta a 4 and 5 segregate; there we have 1 to 2.5. "
    "(a) Excess pressure over that of the pure fluid at rho 3, with straight lines through the "
    "origin. (b) The same at rho 5. (c) Prefactor over rho^2 Delta a, a constant if it were "
    f"linear; dashed: 2 alpha with the published alpha = {ALPHA:g}, which Eq. 21 would have."
)
SHAPES = {"mixing_shape_eighth": 0.125, "mixing_shape": 0.25, "mixing_shape_three": 0.375}
MARKERS = "os^D"  # of excess repulsions
# The sweep of each density, and how the names of its numbers end.
SWEEPS = {3: ("mixtures", ""), 5: ("mixtures_5", "_rho_5")}
FOUND = ("mixing", "mixing_error", "prefactor", "prefactor_error", "prefactor_systematic")
SYSTEM = ("repulsion", "density")


def compute(sweeps):
    """What mixing does to the pressure at both densities."""
    parts = []
    for name, end in SWEEPS.values():
        at = mixing(sweeps[name])
        parts.append(at.rename({key: f"{key}{end}" for key in (*at.data_vars, "excess")}))
        parts[-1].attrs = {f"{key}{end}": value for key, value in at.attrs.items()}
    return xr.merge(parts, combine_attrs="no_conflicts")


def mixing(runs):
    """Pressure of mixing over fraction and excess repulsion, and prefactors of x (1 - x)."""
    density = float(np.mean(runs.number_density))
    p, error = excess_by(runs, "conservative")
    pure = runs.excess.values == 0  # there A and B are the same: one fluid, run once a fraction
    reference, reference_error = over_replicas(p[:, pure], error[:, pure], 0)
    mixing, mixing_error = p[:, ~pure] - reference, np.hypot(error[:, ~pure], reference_error)
    x = runs.fraction.values.astype(float)
    excess = runs.excess.values[~pure].astype(float)
    slopes = np.array([slope(x * (1 - x), y, e) for y, e in zip(mixing.T, mixing_error.T)])
    scale = density**2 * excess
    pressure, prefactor = {"units": "kT / r_c^3"}, {"units": "r_c^4"}
    along = ("fraction", "excess")
    return xr.Dataset(
        {
            "mixing": (along, mixing, pressure | {"long_name": "excess pressure of mixing"}),
            "mixing_error": (along, mixing_error, pressure | {"long_name": "standard error"}),
            "prefactor": (
                "excess", slopes[:, 0] / scale,
                prefactor | {"long_name": "of x (1 - x), over rho^2 Delta a"},
            ),
            "prefactor_error": (
                "excess", slopes[:, 1] / scale,
                prefactor | {"long_name": "standard error"},
            ),
            "prefactor_systematic": (
                "excess", slopes[:, 2] / scale, prefactor | {"long_name": "systematic part of it"}
            ),
        },
        {"fraction": x, "excess": excess},
        {"repulsion": first_scene(runs).data["repulsion"]["A A"], "density": density},
    )  # fmt: skip


def each(data):
    """Every density that is there, and what `mixing` has found at it."""
    for rho, (_, end) in SWEEPS.items():
        if f"mixing{end}" in data:
            names = {f"{key}{end}": key for key in ("excess", *FOUND)}
            at = data[list(names)].rename(names)
            yield rho, at.assign_attrs({key: data.attrs[f"{key}{end}"] for key in SYSTEM})


def slope(x, y, error):
    """Slope of y over x through the origin, its error, and the systematic part of that.

    Every point weighs the same, as the points do not lie on the line and their errors scatter: by
    weights from those, the slope would, too. NaN where a point has no error.
    """
    if not np.all(error > 0):
        return (np.nan,) * 3
    fit = linear_fit([x], y, np.full_like(y, np.sqrt(np.mean(error**2))))
    return fit.values[0], fit.errors[0], fit.systematic[0]


def measured(data):
    """The shape in x, and what the prefactor does, at each density."""
    found = dict.fromkeys((name for name in PUBLISHED if name != "alpha"), Measured(np.nan, np.nan))
    for rho, at in each(data):
        found |= {f"{name}{SWEEPS[rho][1]}": number for name, number in of_density(at).items()}
    return found


def of_density(data):
    """The same at one of them."""
    found = {name: over_half(data, x) for name, x in SHAPES.items()}
    low, high = data.isel(excess=0), data.isel(excess=-1)
    change = float(high.prefactor / low.prefactor)
    error, systematic = (
        change * float(np.hypot(high[name] / high.prefactor, low[name] / low.prefactor))
        for name in ("prefactor_error", "prefactor_systematic")
    )
    direction = "falls" if change < 1 else "rises"
    moved = Measured(abs(change - 1), error, f"it {direction} with Delta a", systematic=systematic)
    return found | {"mixing_prefactor": moved}


def over_half(data, x):
    """Excess pressure of mixing at a fraction over that at 1/2, the mean over Delta a."""
    if x not in data.fraction:
        return Measured(np.nan, np.nan)
    part, half = data.sel(fraction=x), data.sel(fraction=0.5)
    ratio = (part.mixing / half.mixing).values
    parts = (part.mixing_error / part.mixing, half.mixing_error / half.mixing)
    shape, error, systematic = slope(np.ones_like(ratio), ratio, np.abs(ratio) * np.hypot(*parts))
    first, last = data.excess.values[[0, -1]]
    return Measured(
        float(shape), float(error), f"mean over Delta a {first:g} to {last:g}",
        systematic=float(systematic),
    )  # fmt: skip


def describe(data):
    """What is seen."""
    goes = " and ".join(
        f"from {float(at.prefactor[0]):.3f} to {float(at.prefactor[-1]):.3f} at density {rho}"
        for rho, at in each(data)
    )
    return (
        "(a) and (b) The excess pressure of mixing lies on straight lines through the origin over "
        "x (1 - x), steeper for larger excess repulsion. (c) Their slope over rho^2 Delta a goes "
        f"{goes} as Delta a rises; the dashed line is at {2 * ALPHA:g}."
    )


def draw(data):
    """Pressure of mixing over x (1 - x), and the prefactor over excess repulsion."""
    there = list(each(data))
    figure, (*left, right) = panels(len(there) + 1)
    product = (data.fraction * (1 - data.fraction)).values
    line = np.array([0, 0.27])
    for axes, (rho, at) in zip(left, there):
        color = SEGREGATION[rho].look.color
        for k, marker in zip(range(at.sizes["excess"]), cycle(MARKERS)):
            one = at.isel(excess=k)
            label = rf"$\Delta a$ = {float(one.excess):g}"
            points(axes, product, one.mixing, one.mixing_error, label, color, marker)
            slope = float(one.prefactor * one.excess) * at.attrs["density"] ** 2
            axes.plot(line, slope * line, color=color, linewidth=0.8)
            points(right, one.excess, one.prefactor, one.prefactor_error, None, color, marker)
        name = rf"$\rho$ = {rho}, $a$ = {at.attrs['repulsion']:g}"
        right.plot(at.excess, at.prefactor, color=color, linewidth=0.8, label=name)
        axes.set(xlim=(0, 0.27), ylim=(0, None), xlabel=r"$x (1 - x)$",
                 ylabel=r"$p(x) - p(0)$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
        axes.legend(loc="upper left", title=name)
    published_line(right, [0, 6], [2 * ALPHA] * 2, rf"$2\alpha$, published $\alpha$ = {ALPHA:g}")
    right.set(xlim=(0, 6), ylim=(0, 0.25), xlabel=r"excess repulsion $\Delta a$ $r_c$ / $k_BT$",
              ylabel=r"$[p(x) - p(0)] / [\rho^2 \Delta a\, x (1 - x)]$ / $r_c^4$")  # fmt: skip
    right.legend(loc="lower right")
    return figure
