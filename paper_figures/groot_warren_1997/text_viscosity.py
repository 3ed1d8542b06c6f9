"""Sec. VII: viscosity and self-diffusion at the paper's friction, each in several ways."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE, over_replicas
from dpd.analysis.verdicts import Measured, shown_by
from dpd.analysis.viscosity import viscosity_of_fluctuations
from dpd.report.style import BLACK, BLUE, RED, panels, points
from paper_figures.groot_warren_1997.dynamics import (
    AFTER,
    Found,
    density_of,
    in_an_infinite_box,
    of_two_flows,
    sheared,
)
from paper_figures.groot_warren_1997.spreading import diffusion_of_labels
from paper_figures.groot_warren_1997.text_diffusion import of_sweep
from paper_figures.groot_warren_1997.transport_theory import slowed_by_images

PUBLISHED = shown_by(__file__)
NU, D, SCHMIDT = PUBLISHED["viscosity"], PUBLISHED["diffusion"], PUBLISHED["schmidt"]
MEMORY = 1.0  # units of time, after which the stress of the fluid has forgotten itself
WAYS_OF_NU = {
    "shear": "shear,\nrate 0",
    "flows": "two\nflows",
    "stress": "stress\nat rest",
}
WAYS_OF_D = {"displacements": "displace-\nments", "labels": "spreading\nlabels"}

TITLE = "Viscosity and self-diffusion at gamma 6.75 in several ways (rho = 3, a = 25)."
PAPER_SHOWS = (
    f"Not a figure of the paper: its text gives nu = {NU}, D = {D} and Sc = nu / D = {SCHMIDT} "
    "(gray), and does not say how nu was measured. (a) nu from the stress under shear, with a "
    "straight line in the square of the rate, whose end is nu without shear. (b) nu of this line; "
    "of two opposite flows that a body force drives; and of a fluid at rest, from how the integral "
    "of its stress spreads. (c) D from displacements, on a straight line in 1 / L for an infinite "
    "box; and from how labelled beads spread over a box, with what the drag of a bead's own images "
    "takes off it, 2.837 kT / [6 pi rho (nu + D) L], put back."
)


def compute(sweeps):
    """nu in three ways, D in two."""
    shear = sheared(sweeps["shear"])
    nu = {
        "shear": shear.at_rest,
        "flows": of_two_flows(sweeps["flows"]),
        "stress": of_stress(sweeps["stress"]),
    }
    line = of_sweep(sweeps["diffusion"])
    spread, wave, time = of_labels(sweeps["spreading"])
    edge = first_scene(sweeps["spreading"]).box[0]
    kT = float(sweeps["spreading"].kT.mean())
    density = density_of(sweeps["spreading"])
    enough = float(line.longest) >= 2 * AFTER  # or displacements do not grow as time does
    diffusion = {
        "displacements": Found(
            float(line.infinite), float(line.infinite_error) if enough else np.nan
        ),
        "labels": in_an_infinite_box(spread, edge, nu["shear"], density, kT),
    }
    images = drag_of_images(line, nu["shear"], diffusion["displacements"], density)
    constant = {"units": "r_c^2 / tau"}
    return xr.Dataset(
        {
            "shear_nu": ("rate", shear.nu, constant | {"long_name": "nu under shear"}),
            "shear_nu_error": ("rate", shear.error, constant | {"long_name": "standard error"}),
            "shear_slope": ((), shear.slope, {"units": "r_c^2 tau", "long_name": "over rate^2"}),
            "shear_kT": ("rate", sweeps["shear"].kT.mean("replica").values, {"units": "kT"}),
            "nu": ("way_of_nu", [part.value for part in nu.values()], constant),
            "nu_error": ("way_of_nu", [part.error for part in nu.values()], constant),
            "D": ("way_of_D", [part.value for part in diffusion.values()], constant),
            "D_error": ("way_of_D", [part.error for part in diffusion.values()], constant),
            "in_cube": ((), spread.value, constant | {"long_name": "D of labels in their box"}),
            "edge": ((), edge, {"units": "r_c"}),
            "images": ((), images.value, {"units": "1", "long_name": "fall of D over theory's"}),
            "images_error": ((), images.error, {"units": "1", "long_name": "standard error"}),
            "wave": ("time", wave, {"units": "1 / r_c^3", "long_name": "height of the wave"}),
        },
        {
            "rate": ("rate", shear.rate, {"units": "1 / tau", "long_name": "shear rate"}),
            "way_of_nu": list(nu), "way_of_D": list(diffusion),
            "time": ("time", time, {"units": "tau"}),
        },
    )  # fmt: skip


def of_stress(runs):
    """nu from the fluctuations of the stress, the mean over replicas."""
    scene, density = first_scene(runs), density_of(runs)
    try:
        found = np.array([
            viscosity_of_fluctuations(
                runs.pressure_tensor_all_series.values[k], scene.dt,
                scene.volume, float(runs.kT.values.ravel()[k]), MEMORY,
            )
            for k in range(runs.sizes["replica"])
        ])  # fmt: skip
    except ValueError:  # the run is too short
        return Found(np.nan, np.nan)
    value, error = over_replicas(*found.T, axis=-1)
    return Found(float(value) / density, float(error) / density)


def drag_of_images(line, nu, diffusion, density):
    """How D falls with 1 / L over how theory has it fall, see `slowed_by_images`."""
    theory = float(slowed_by_images(1.0, density, nu.value, diffusion.value, float(line.kT)))
    error = float(line.slope_error) if np.isfinite(diffusion.error) else np.nan
    return Found(-float(line.slope) / theory, error / theory)


def of_labels(runs):
    """D of labelled beads in their box, the mean wave, and its times."""
    scene = first_scene(runs)
    density = runs.density_profile.transpose("replica", "block", "species", "z").values
    steps = scene.steps.sample / density.shape[1]
    time = (np.arange(density.shape[1]) + 0.5) * steps * scene.dt
    found = diffusion_of_labels(density, runs.z.values, time, scene.box[0])
    return Found(*found.diffusion), found.wave.mean(axis=0), time


def part_of(data, name, way):
    """A value and its error by the name of its way."""
    at = data.sel({f"way_of_{name}": way})
    return Found(float(at[name]), float(at[f"{name}_error"]))


def measured(data):
    """nu, Sc, and how well the ways agree."""
    nu = {way: part_of(data, "nu", way) for way in WAYS_OF_NU}
    diffusion = {way: part_of(data, "D", way) for way in WAYS_OF_D}
    schmidt = nu["shear"].over(diffusion["displacements"])
    rates = ", ".join(
        f"{float(value):.4f} at rate {float(rate):g}"
        for value, rate in zip(data.shear_nu, data.rate)
    )
    found = {
        "viscosity": Measured(*nu["shear"], f"under shear, without it; {rates}"),
        "schmidt": Measured(*schmidt, "nu under shear, D of displacements in an infinite box"),
    }
    for way in ("flows", "stress"):
        note = f"nu {nu[way].value:.4f} +- {nu[way].error:.4f}"
        found[f"viscosity_{way}"] = Measured(*nu[way].over(nu["shear"]), note)
    found["diffusion_images"] = Measured(
        float(data.images),
        float(data.images_error),
        f"(nu + D) / nu is {1 + diffusion['displacements'].over(nu['shear']).value:.2f}",
    )
    labels = diffusion["labels"]
    found["diffusion_labels"] = Measured(
        *labels.over(diffusion["displacements"]),
        f"{labels.value:.4f} +- {labels.error:.4f}; in the box of edge {float(data.edge):g} "
        f"{float(data.in_cube):.4f}",
    )
    return found


def describe(data):
    """What is seen."""
    return (
        "(a) The viscosity under shear hardly changes with the rate. (b) Viscosities of all three "
        f"ways agree within their error bars, near {float(data.nu[0]):.3f}. (c) So do both "
        f"diffusion constants, near {float(data.D[0]):.3f}."
    )


def draw(data):
    """nu over the squared rate, and both constants in all ways."""
    figure, (rates, nu, diffusion) = panels(3, height=2.4)
    points(rates, data.rate**2, data.shear_nu, data.shear_nu_error, "under shear", BLUE)
    rest = part_of(data, "nu", "shear")
    label = f"rate 0: {rest.value:.3f} ± {COVERAGE * rest.error:.3f}"
    points(rates, [0], [rest.value], [rest.error], label, BLUE, filled=False)
    if np.isfinite(rest.value):
        ends = np.array([0.0, float(data.rate.max()) ** 2])
        rates.plot(ends, rest.value + float(data.shear_slope) * ends, color=BLUE, lw=0.8)
    rates.set(xlabel=r"squared shear rate / $\tau^{-2}$")
    _ways(nu, data, "nu", WAYS_OF_NU, BLUE)
    _ways(diffusion, data, "D", WAYS_OF_D, RED)
    for axes, number, symbol in ((rates, NU, r"\nu"), (nu, NU, r"\nu"), (diffusion, D, "D")):
        axes.axhspan(number.value - number.error, number.value + number.error, color=BLACK,
                     alpha=0.15, lw=0, label=f"published {number}")  # fmt: skip
        axes.set_ylabel(rf"${symbol}$ / ($r_c^2$ $\tau^{{-1}}$)")
        low, high = axes.get_ylim()
        axes.set_ylim(low - 0.005, high + 0.02)  # room for the legend
        axes.legend(loc="upper left")
    return figure


def _ways(axes, data, name, ways, color):
    """One point for each way."""
    found = [part_of(data, name, way) for way in ways]
    values, errors = np.array(found).T
    points(axes, range(len(ways)), values, errors, "this work", color)
    axes.set_xticks(range(len(ways)), ways.values())
    axes.set_xlim(-0.5, len(ways) - 0.5)
