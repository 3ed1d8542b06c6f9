"""Sec. V: excess pressure of mixtures that do not segregate."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import linear_fit, over_replicas
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLUE, GREEN, ORANGE, RED, panels, points, published_line
from paper_figures.groot_warren_1997.shared import excess_by

PUBLISHED = shown_by(__file__)
ALPHA = PUBLISHED["alpha"].value

TITLE = "Excess pressure of mixtures (rho = 3, a = 25)."
PAPER_SHOWS = (
    "Not a figure of the paper: its text says that the excess pressure of mixing is proportional "
    "to x (1 - x), x the fraction of A, and that the prefactor is not simply linear in Delta a = "
    "a_AB - a from 2 to 5. (a) Excess pressure over that of the pure fluid, with straight lines "
    "through the origin. (b) Prefactor over rho^2 Delta a, a constant if it were linear; dashed: "
    f"2 alpha with the published alpha = {ALPHA:g}, which Eq. 21 would have."
)
SHAPES = {"mixing_shape_eighth": 0.125, "mixing_shape": 0.25, "mixing_shape_three": 0.375}
COLORS = (BLUE, GREEN, ORANGE, RED)


def compute(sweeps):
    """Pressure of mixing over fraction and excess repulsion, and prefactors of x (1 - x)."""
    runs = sweeps["mixtures"]
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
    """The shape in x, and what the prefactor does."""
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
    first, last = (float(data.prefactor.isel(excess=n)) for n in (0, -1))
    return (
        "(a) The excess pressure of mixing lies on straight lines through the origin over "
        "x (1 - x), steeper for larger excess repulsion. (b) Their slope over rho^2 Delta a "
        f"goes from {first:.3f} to {last:.3f} as Delta a rises, below the dashed line at "
        f"{2 * ALPHA:g}."
    )


def draw(data):
    """Pressure of mixing over x (1 - x), and the prefactor over excess repulsion."""
    figure, (left, right) = panels(2)
    product = (data.fraction * (1 - data.fraction)).values
    line = np.array([0, 0.27])
    for n, color in zip(range(data.sizes["excess"]), COLORS):
        at = data.isel(excess=n)
        label = rf"$\Delta a$ = {float(at.excess):g}"
        points(left, product, at.mixing, at.mixing_error, label, color)
        slope = float(at.prefactor * at.excess) * data.attrs["density"] ** 2
        left.plot(line, slope * line, color=color, linewidth=0.8)
        points(right, at.excess, at.prefactor, at.prefactor_error, None, color)
    label = rf"$2\alpha$, published $\alpha$ = {ALPHA:g}"
    published_line(right, [0, 6], [2 * ALPHA] * 2, label)
    left.set(xlim=(0, 0.27), ylim=(0, None), xlabel=r"$x (1 - x)$",
             ylabel=r"$p(x) - p(0)$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    right.set(xlim=(0, 6), ylim=(0, 0.25), xlabel=r"excess repulsion $\Delta a$ $r_c$ / $k_BT$",
              ylabel=r"$[p(x) - p(0)] / [\rho^2 \Delta a\, x (1 - x)]$ / $r_c^4$")  # fmt: skip
    left.legend(loc="upper left")
    right.legend(loc="lower right")
    return figure
