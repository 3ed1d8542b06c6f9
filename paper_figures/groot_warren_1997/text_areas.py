"""Sec. VI: interfaces in boxes of several areas, which capillary waves widen."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.tension_sweeps import sweep_tension
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels, points

# The variance that the slope of tanh(2 z / xi) stands for is pi^2 xi^2 / 48.
OF_VARIANCE = 48 / np.pi**2

TITLE = "Width of the same interface in boxes of several areas (rho = 3, a_AB = 37)."
PAPER_SHOWS = (
    "Not a figure of the paper, which has one area, 8 x 8. Waves on an interface widen its "
    "profile: its variance rises with the edge L of the box as kT / (2 pi sigma) ln L (Rowlinson "
    "and Widom 1982, the paper's Ref. 24), so xi^2 of Eq. 34 as (48 / pi^2) kT / (2 pi sigma) "
    "ln L. Dashed: this slope with the tension of these runs, through their middle. Square: the "
    "run of Figure 6."
)


def compute(sweeps):
    """Width and tension over the edge, and the slope of theory."""
    parts = [sweep_tension(sweeps["areas"]), sweep_tension(sweeps["interface"])]
    edge = first_scene(sweeps["interface"]).box[0]
    areas = parts[0][["width", "width_error", "tension", "tension_error", "drift"]]
    fig6 = parts[1][list(areas.data_vars)].expand_dims(edge=[edge])
    data = xr.concat(
        [areas.assign_coords(edge=areas.edge.astype(float)), fig6], "edge", combine_attrs="drop"
    )
    data["of_figure_6"] = ("edge", [False] * areas.sizes["edge"] + [True])
    data.edge.attrs = {"units": "r_c", "long_name": "lateral edge of the box"}
    weight = 1 / data.tension_error.where(data.tension_error > 0) ** 2
    tension = float((weight * data.tension).sum() / weight.sum())
    data["sigma"] = ((), tension, {"units": "kT / r_c^2", "long_name": "mean of all areas"})
    data["sigma_error"] = ((), float(weight.sum() ** -0.5), {"units": "kT / r_c^2"})
    theory = OF_VARIANCE / (2 * np.pi * tension)
    data["theory"] = ((), theory, {"units": "r_c^2", "long_name": "d xi^2 / d ln L by theory"})
    return data


def rise(data):
    """Rise of xi^2 from the smallest edge to the largest over that by theory, and its error."""
    edges = data.edge.values
    first, last = (data.isel(edge=int(k)) for k in (edges.argmin(), edges.argmax()))
    span = float(data.theory) * np.log(edges.max() / edges.min())
    ratio = float(last.width**2 - first.width**2) / span
    of_widths = 2 * np.hypot(last.width * last.width_error, first.width * first.width_error)
    relative = float(data.sigma_error / data.sigma)
    return ratio, float(np.hypot(float(of_widths) / span, ratio * relative))


def measured(data):
    """The rise by waves."""
    ratio, error = rise(data)
    each = ", ".join(
        f"{float(w):.3f} +- {float(e):.3f} at L {float(edge):g}"
        for w, e, edge in zip(data.width, data.width_error, data.edge)
    )
    sigma = f"sigma {float(data.sigma):.3f} +- {float(data.sigma_error):.3f}"
    return {"capillary_waves": Measured(ratio, error, f"xi {each}; {sigma}")}


def describe(data):
    """What is seen."""
    return (
        "The squared width of the interface rises with the logarithm of the lateral edge, along "
        "the dashed line of capillary waves. The tension does not depend on the edge."
    )


def draw(data):
    """Squared width, and tension, over the logarithm of the edge."""
    figure, (left, right) = panels(2)
    for own, color, marker, label in (
        (False, BLUE, "o", "this sweep"), (True, RED, "s", "run of Fig. 6"),
    ):  # fmt: skip
        at = data.isel(edge=data.of_figure_6.values == own)
        points(left, at.edge, at.width**2, 2 * at.width * at.width_error, label, color, marker)
        points(right, at.edge, at.tension, at.tension_error, label, color, marker)
    edges = data.edge.values
    x = np.array([0.85 * edges.min(), 1.18 * edges.max()])
    middle = np.exp(np.log(edges).mean())
    line = float((data.width**2).mean()) + float(data.theory) * np.log(x / middle)
    left.plot(x, line, color=BLACK, ls="--", lw=0.9, label="capillary waves")
    sigma, error = float(data.sigma), COVERAGE * float(data.sigma_error)
    right.axhspan(sigma - error, sigma + error, color=BLACK, alpha=0.15, lw=0,
                  label=f"mean: {sigma:.3f} ± {error:.3f}")  # fmt: skip
    for axes in (left, right):
        axes.set(xscale="log", xlim=x, xlabel="lateral edge $L$ / $r_c$")
        axes.set_xticks(sorted(edges), [f"{edge:g}" for edge in sorted(edges)], minor=False)
        axes.minorticks_off()
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.35 * (high - low))  # room for the legend
        axes.legend(loc="upper left")
    left.set_ylabel(r"$\xi^2$ / $r_c^2$")
    right.set_ylabel(r"$\sigma$ / ($k_BT$ $r_c^{-2}$)")
    return figure
