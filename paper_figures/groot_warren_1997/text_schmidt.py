"""Sec. VII: diffusion, viscosity and the Schmidt number over the friction."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, RED, panels, points
from paper_figures.groot_warren_1997.dynamics import (
    Found,
    density_of,
    in_a_cube,
    in_an_infinite_box,
    of_two_flows,
)
from paper_figures.groot_warren_1997.transport_theory import (
    diffusion_constant,
    kinematic_viscosity,
    schmidt_number,
)

PUBLISHED = shown_by(__file__)
GAMMA = 6.75  # of the paper
LOOKS = {
    "D": (BLUE, "o", "diffusion", diffusion_constant),
    "nu": (RED, "s", "viscosity", kinematic_viscosity),
    "Sc": (GREEN, "^", "schmidt", schmidt_number),
}

TITLE = "Diffusion, viscosity and Schmidt number over the friction (rho = 3, a = 25)."
PAPER_SHOWS = (
    "Not a figure of the paper, which has one friction, gamma = 6.75 (stars), and the theory of a "
    "fluid without conservative forces (lines): D = 45 kT / (2 pi gamma rho), nu = D / 2 + "
    "2 pi gamma rho / 1575, Sc = nu / D. nu is that of two opposite flows which a body force "
    "drives, D that of displacements in a periodic cube, with 2.837 kT / [6 pi rho (nu + D) L] "
    "added for an infinite box. Friction and noise are split off the forces (Shardlow), so that kT "
    "is right at all these frictions."
)


def compute(sweeps):
    """D for an infinite box, nu and Sc over gamma."""
    flows, moving = sweeps["flows_by_friction"], sweeps["diffusion_by_friction"]
    edge, density = first_scene(moving).box[0], density_of(moving)
    rows = [_of_friction(flows.sel(gamma=g), moving.sel(gamma=g)) for g in flows.gamma.values]
    units = {"D": "r_c^2 / tau", "nu": "r_c^2 / tau", "Sc": "1", "in_cube": "r_c^2 / tau"}
    data = xr.Dataset(coords={"gamma": flows.gamma.astype(float)})
    for name, unit in units.items():
        values, errors = np.array([row[name] for row in rows]).T
        data[name] = ("gamma", values, {"units": unit})
        data[f"{name}_error"] = ("gamma", errors, {"units": unit, "long_name": "standard error"})
    data["kT"] = ("gamma", moving.kT.mean("replica").values, {"units": "kT"})
    data["edge"] = ((), edge, {"units": "r_c"})
    data["density"] = ((), density, {"units": "1 / r_c^3"})
    return data


def _of_friction(flowing, moving):
    """D, nu and Sc at one friction."""
    nu, in_cube = of_two_flows(flowing), in_a_cube(moving)
    found = in_an_infinite_box(
        in_cube, first_scene(moving).box[0], nu, density_of(moving), float(moving.kT.mean())
    )
    return {"D": found, "nu": nu, "Sc": nu.over(found), "in_cube": in_cube}


def measured(data):
    """Numbers of the theory, how far off it is, and the power of Sc."""
    density = float(data.density)
    found = {
        f"theory_{name}": Measured(float(law(GAMMA, density)), 0.0, "closed form")
        for _, _, name, law in LOOKS.values()
    }
    return found | {"theory_misses": _largest_miss(data), "schmidt_power": _power(data)}


def _largest_miss(data):
    """Of the theory at the paper's friction, over what is measured there."""
    if GAMMA not in data.gamma.values:
        return Measured(np.nan, np.nan)
    at, misses = data.sel(gamma=GAMMA), {}
    for name, (_, _, _, law) in LOOKS.items():
        theory = float(law(GAMMA, float(data.density)))
        value, error = float(at[name]), float(at[f"{name}_error"])
        misses[name] = Found(theory / value - 1, theory * error / value**2)
    each = ", ".join(f"{name} {100 * part.value:+.0f} %" for name, part in misses.items())
    largest = max(misses.values(), key=lambda part: abs(part.value))
    return Measured(abs(largest.value), largest.error, each)


def _power(data):
    """d ln (Sc - 1/2) / d ln gamma between the two largest frictions: 2 by Eq. 37."""
    if data.sizes["gamma"] < 2:
        return Measured(np.nan, np.nan)
    low, high = (data.isel(gamma=k) for k in (-2, -1))
    span = float(np.log(high.gamma / low.gamma))
    above = [float(at.Sc) - 0.5 for at in (low, high)]
    power = np.log(above[1] / above[0]) / span
    error = np.hypot(float(low.Sc_error) / above[0], float(high.Sc_error) / above[1]) / span
    return Measured(
        power, error,
        f"from gamma {float(low.gamma):g} to {float(high.gamma):g}, Sc {float(low.Sc):.2f} and "
        f"{float(high.Sc):.2f}",
    )  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "On logarithmic axes D falls with the friction, less steeply than the line of theory, and "
        "nu rises with it, while theory falls first. The Schmidt number rises from "
        f"{float(data.Sc[0]):.2f} to {float(data.Sc[-1]):.1f}; it is above theory at small "
        "frictions and below it at large ones. The published points at gamma 6.75 lie beside ours."
    )


def draw(data):
    """D and nu, and Sc, over gamma."""
    figure, (left, right) = panels(2)
    gamma = np.geomspace(0.8 * float(data.gamma.min()), 1.25 * float(data.gamma.max()), 100)
    density = float(data.density)
    labels = {"D": "$D$", "nu": r"$\nu$", "Sc": "Sc"}
    for name, (color, marker, row, law) in LOOKS.items():
        axes = right if name == "Sc" else left
        points(axes, data.gamma, data[name], data[f"{name}_error"], f"{labels[name]}, this work",
               color, marker)  # fmt: skip
        axes.plot(gamma, law(gamma, density), color=color, lw=0.8, label=f"{labels[name]}, theory")
        label = "published" if name != "nu" else None
        axes.plot(GAMMA, PUBLISHED[row].value, "*", color=BLACK, markersize=9, fillstyle="none",
                  zorder=5, label=label)  # fmt: skip
    for axes in (left, right):
        axes.set(xscale="log", yscale="log", xlim=gamma[[0, -1]],
                 xlabel=r"friction $\gamma$ / ($m$ $\tau^{-1}$)")  # fmt: skip
    left.set_ylabel(r"$D$, $\nu$ / ($r_c^2$ $\tau^{-1}$)")
    right.set_ylabel(r"Schmidt number $\nu / D$")
    low, high = left.get_ylim()
    left.set_ylim(low, 5 * high)  # room for the legend
    left.legend(loc="upper right", ncols=2)
    right.legend(loc="upper left")
    return figure
