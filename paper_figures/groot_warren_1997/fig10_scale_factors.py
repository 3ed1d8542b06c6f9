"""Figure 10: the factors that bring tensions of chains to one curve, against chi."""

import numpy as np
import xarray as xr
from matplotlib.ticker import FixedLocator, NullFormatter

from dpd.analysis.published import shown_by
from dpd.analysis.statistics import COVERAGE, linear_fit
from dpd.analysis.tension_laws import collapse
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, panels, points, published_line
from paper_figures.groot_warren_1997.tensions import VAN_DER_WAALS, tensions_of_chains

PUBLISHED = shown_by(__file__)
SLOPE, PUBLISHED_SLOPE = PUBLISHED["chain_slope"], PUBLISHED["scale_slope"]
MEAN_FIELD = PUBLISHED_SLOPE.rival

TITLE = "Height of the tension's curve against chi (rho = 3, C = 2)."
PAPER_SHOWS = (
    "The paper shows the factors of its Figure 9 against chi on logarithmic axes, and finds the "
    f"slope {PUBLISHED_SLOPE}; mean field would have {MEAN_FIELD:g}. Here each point is the height "
    "k of sigma / (rho kT r_c) = k (1 - 2 / (chi N))^(3/2) through the settled runs of one Delta a "
    "(Figure 9), which is that factor but for a constant. The straight line is fitted to the "
    "logarithms."
)


def compute(sweeps):
    """Heights over chi, and the slope of their logarithms."""
    tensions = tensions_of_chains(sweeps["tension"], SLOPE.value)
    group, _ = np.indices(tensions.scaled.shape)
    use = tensions.fitted.values
    columns = (tensions[n].values[use] for n in ("segregation", "scaled", "scaled_error"))
    found = collapse(group[use], *columns, groups=tensions.sizes["excess"], **VAN_DER_WAALS)
    height, error = np.array(found.prefactors).T
    chi = SLOPE.value * tensions.excess.values.astype(float)
    data = xr.Dataset(
        {
            "height": ("chi", height, {"units": "1", "long_name": "k of each Delta a"}),
            "height_error": ("chi", error, {"units": "1", "long_name": "standard error"}),
            "reduced_chi_square": ((), found.reduced_chi_square, {"units": "1"}),
        },
        {"chi": ("chi", chi, {"units": "1", "long_name": "chi of Delta a"})},
    )
    known = np.isfinite(height) & (error > 0)
    slope = slope_error = constant = np.nan
    if known.sum() >= 3:
        x, y = np.log(chi[known]), np.log(height[known])
        fit = linear_fit([x, np.ones_like(x)], y, error[known] / height[known])
        (slope, constant), (slope_error, _) = fit.values, fit.errors
    data["slope"] = ((), slope, {"units": "1", "long_name": "d ln k / d ln chi"})
    data["slope_error"] = ((), slope_error, {"units": "1", "long_name": "standard error"})
    data["at_one"] = ((), np.exp(constant), {"units": "1", "long_name": "k at chi 1"})
    return data


def measured(data):
    """The exponent of chi."""
    count = int(np.isfinite(data.height).sum())
    return {
        "scale_slope": Measured(
            float(data.slope), float(data.slope_error),
            f"{count} values of Delta a; the heights' reduced chi-square "
            f"{float(data.reduced_chi_square):.2f}",
            "" if count >= 3 else "fewer than three values of Delta a with settled runs",
        )
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        f"Heights rise with chi in a straight line of slope {float(data.slope):.2f} on logarithmic "
        "axes, less steeply than the dotted line of mean field."
    )


def draw(data):
    """Heights over chi, logarithmic axes."""
    figure, axes = panels(1)
    points(axes, data.chi, data.height, data.height_error, "this work", BLUE)
    x = np.array([0.9 * float(data.chi.min()), 1.1 * float(data.chi.max())])
    middle = np.sqrt(x.prod())
    slope, error = float(data.slope), float(data.slope_error)
    if np.isfinite(slope):
        top = float(data.at_one) * middle**slope
        axes.plot(x, top * (x / middle) ** slope, color=BLUE, lw=0.8,
                  label=f"fit: slope {slope:.3f} ± {COVERAGE * error:.3f}")  # fmt: skip
        axes.plot(x, top * (x / middle) ** MEAN_FIELD, color=BLACK, lw=0.9, ls=":",
                  label=f"mean field: slope {MEAN_FIELD:g}")  # fmt: skip
    eq_33 = PUBLISHED["master_prefactor"].value * x**PUBLISHED_SLOPE.value
    published_line(axes, x, eq_33, f"published, Eq. 33: slope {PUBLISHED_SLOPE}")
    axes.set(xscale="log", yscale="log", xlabel=r"$\chi$", xlim=x,
             ylabel=r"height $k$ of $\sigma / (\rho k_BT r_c)$")  # fmt: skip
    ticks = {"x": [1, 1.5, 2, 2.5], "y": [0.5, 0.6, 0.7, 0.8, 0.9, 1]}
    for name, values in ticks.items():
        axis = getattr(axes, f"{name}axis")
        axis.set_major_locator(FixedLocator(values))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    axes.legend(loc="upper left")
    return figure
