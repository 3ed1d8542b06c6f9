"""Sec. VI: interfaces in boxes of several areas, which capillary waves widen."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.report.style import BLACK, BLUE, RED, panels, points
from paper_figures.groot_warren_1997.shared import (
    EVEN,
    mean_and_even_error,
    noise_of_stress,
    put_stress_noise,
)
from paper_figures.groot_warren_1997.slab_tension import slab_tension, tension_of_tensor
from paper_figures.groot_warren_1997.tension_sweeps import one_run, sweep_tension

# The variance that the slope of tanh(2 z / xi) stands for is pi^2 xi^2 / 48.
OF_VARIANCE = 48 / np.pi**2
SLABS = ("first", "second")

TITLE = "The interface of Figure 6 in boxes of several areas, and its surface tension (rho = 3)."
PAPER_SHOWS = (
    "Not a figure of the paper, which has one area, 8 x 8. (a) Waves on an interface widen its "
    "profile: its variance rises with the edge L of the box as kT / (2 pi sigma) ln L (Rowlinson "
    "and Widom 1982, the paper's Ref. 24), so xi^2 of Eq. 34 as (48 / pi^2) kT / (2 pi sigma) "
    "ln L. Dashed: this slope with the tension of these runs, through their middle. Square: the "
    "run of Figure 6. (b) The tension does not depend on the area. (c) Normal less tangential "
    "pressure in slices across the box of Figure 6, whose integral, halved, is the tension "
    "(Eq. 31). It vanishes in both bulks. The pressure tensor of the box gives the same tension, "
    "with a smaller error, as it is sampled more often; (b) has that one."
)
ERRORS = f"Bars and bands: 95 % intervals from blocks of the run. In (c): {EVEN}"


def compute(sweeps):
    """Width and tension over the edge, and the slope of theory."""
    parts = [sweep_tension(sweeps["areas"]), sweep_tension(sweeps["interface"])]
    edge = first_scene(sweeps["interface"]).box[0]
    areas = parts[0][["width", "width_error", "tension", "tension_error", "drift"]]
    fig6 = parts[1][list(areas.data_vars)].expand_dims(edge=[edge])
    data = xr.concat(
        [areas.assign_coords(edge=areas.edge.astype(float)), fig6],
        "edge",
        combine_attrs="drop_conflicts",
    )
    data["of_figure_6"] = ("edge", [False] * areas.sizes["edge"] + [True])
    data.edge.attrs = {"units": "r_c", "long_name": "lateral edge of the box"}
    weight = 1 / data.tension_error.where(data.tension_error > 0) ** 2
    tension = float((weight * data.tension).sum() / weight.sum())
    data["sigma"] = ((), tension, {"units": "kT / r_c^2", "long_name": "mean of all areas"})
    data["sigma_error"] = ((), float(weight.sum() ** -0.5), {"units": "kT / r_c^2"})
    theory = OF_VARIANCE / (2 * np.pi * tension)
    data["theory"] = ((), theory, {"units": "r_c^2", "long_name": "d xi^2 / d ln L by theory"})
    return data.merge(of_figure_6(sweeps["interface"]), combine_attrs="drop_conflicts")


def of_figure_6(runs):
    """Profile of the pressure, its bulks, and the tension in two ways."""
    run = one_run(runs.isel(replica=0))
    found = slab_tension(run)
    noise = run.pressure_tensor_all_series - run.pressure_tensor
    added = tension_of_tensor(run.assign(pressure_tensor=noise))
    missing = (run.normal_pressure_profile - run.tangential_pressure_profile).values
    mean, error = mean_and_even_error(missing)
    pressure, tension = {"units": "kT / r_c^3"}, {"units": "kT / r_c^2"}
    data = xr.Dataset(
        {
            "missing": ("slice", mean, pressure | {"long_name": "p_N - p_T"}),
            "missing_error": ("slice", error, pressure | {"long_name": "standard error"}),
        },
        {"slice": run.slice},
    )
    parts = {
        "of_profile": (found.of_profile, tension), "of_tensor": (found.of_tensor, tension),
        "added": (added, tension),
        "bulk_first": (found.bulks[0], pressure), "bulk_second": (found.bulks[1], pressure),
    }  # fmt: skip
    for name, ((value, error), units) in parts.items():
        data[name] = ((), value, units)
        data[f"{name}_error"] = ((), error, units)
    put_stress_noise(data, runs, slice(-1, None))
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
    tensor, profile = float(data.of_tensor), float(data.of_profile)
    peak = float(data.missing.max())
    bulks = [(float(data[f"bulk_{k}"]), float(data[f"bulk_{k}_error"])) for k in SLABS]
    value, of_bulk = max(bulks, key=lambda part: abs(part[0]))
    return {
        "capillary_waves": Measured(ratio, error, f"xi {each}; {sigma}"),
        "tension_of_tensor": Measured(
            tensor / profile, float(data.of_profile_error) / profile,
            f"{tensor:.3f} +- {float(data.of_tensor_error):.3f} and {profile:.3f} +- "
            f"{float(data.of_profile_error):.3f}, mostly from the same samples",
        ),
        "tension_with_noise": Measured(
            float(data.added) / tensor, float(data.added_error) / tensor,
            f"friction and noise add {float(data.added):.3f} +- {float(data.added_error):.3f} to "
            f"{tensor:.3f}",
        ),
        "stress_noise_interface": noise_of_stress(data),
        "isotropic_bulk": Measured(
            value / peak, of_bulk / peak,
            ", ".join(f"{bulk:.3f} +- {error:.3f}" for bulk, error in bulks) + " in both bulks",
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "(a) The squared width of the interface rises with the logarithm of the lateral edge, "
        "along the dashed line of capillary waves. (b) The tension does not depend on the edge. "
        "(c) Normal less tangential pressure is zero in both bulks and has a peak at each of the "
        "two interfaces."
    )


def draw(data):
    """Squared width and tension over the edge, and the profile of the pressure."""
    figure, (left, middle, right) = panels(3, height=2.4)
    for own, color, marker, label in (
        (False, BLUE, "o", "this sweep"), (True, RED, "s", "run of Fig. 6"),
    ):  # fmt: skip
        at = data.isel(edge=data.of_figure_6.values == own)
        points(left, at.edge, at.width**2, 2 * at.width * at.width_error, label, color, marker)
        points(middle, at.edge, at.tension, at.tension_error, label, color, marker)
    edges = data.edge.values
    x = np.array([0.8 * edges.min(), 1.25 * edges.max()])
    centre = np.exp(np.log(edges).mean())
    line = float((data.width**2).mean()) + float(data.theory) * np.log(x / centre)
    left.plot(x, line, color=BLACK, ls="--", lw=0.9, label="capillary waves")
    sigma, error = float(data.sigma), COVERAGE * float(data.sigma_error)
    middle.axhspan(sigma - error, sigma + error, color=BLACK, alpha=0.15, lw=0,
                   label=f"mean: {sigma:.3f} ± {error:.3f}")  # fmt: skip
    for axes in (left, middle):
        axes.set(xscale="log", xlim=x, xlabel="lateral edge $L$ / $r_c$")
        axes.set_xticks(sorted(edges), [f"{edge:g}" for edge in sorted(edges)], minor=False)
        axes.minorticks_off()
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.4 * (high - low))  # room for the legend
        axes.legend(loc="upper left")
    left.set_ylabel(r"$\xi^2$ / $r_c^2$")
    middle.set_ylabel(r"$\sigma$ / ($k_BT$ $r_c^{-2}$)")
    reach = COVERAGE * data.missing_error
    right.fill_between(data.slice, data.missing - reach, data.missing + reach, color=RED,
                       alpha=0.3, lw=0)  # fmt: skip
    right.plot(data.slice, data.missing, color=RED)
    right.axhline(0, color=BLACK, lw=0.5)
    for text, name, height in (("profile", "of_profile", 0.9), ("tensor", "of_tensor", 0.8)):
        value, error = float(data[name]), COVERAGE * float(data[f"{name}_error"])
        right.text(0.5, height, rf"$\sigma$ of {text}: {value:.3f} ± {error:.3f}", ha="center",
                   transform=right.transAxes, fontsize=7)  # fmt: skip
    low, high = right.get_ylim()
    right.set_ylim(low, high + 0.35 * (high - low))  # room for the numbers
    right.set(xlim=(0, float(data.slice[0] + data.slice[-1])), xlabel="$z$ / $r_c$",
              ylabel=r"$p_N - p_T$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    return figure
