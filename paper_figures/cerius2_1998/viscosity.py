"""The viscosity of the standard fluid: by shear, two opposite flows, walls, and at rest."""

from itertools import cycle

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import COVERAGE
from dpd.analysis.verdicts import Measured
from dpd.analysis.viscosity import Measured as Viscosity
from dpd.analysis.viscosity import (
    viscosities,
    viscosity_of_fluctuations,
    viscosity_of_two_flows,
)
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED, panels, points
from paper_figures.cerius2_1998.channel import channel_flow
from paper_figures.cerius2_1998.shared import profile_and_errors

COLORS = (ORANGE, GREEN, PURPLE)
MEMORY = 1.0  # tau, after which the stress of the fluid has forgotten itself

TITLE = "Flows of the standard fluid (rho = 3, a = 25, gamma = 4.5) and its viscosity eta."
PAPER_SHOWS = (
    "The manual offers shear and walls, without numbers. (a) Two opposite flows in a periodic box: "
    "a force along x acts in the lower half, and its opposite in the upper half; both halves are "
    "averaged. (b) Flow between walls that have a friction of their own, "
    "for three of these frictions gamma_w; dotted: the parabola of the middle, continued to the "
    "walls. Its tangent at the wall gives the slip length b. (c) eta from the stress under shear, "
    "from the parabolas, and from the fluctuations of the stress of a fluid at rest, whose 95 % "
    "interval is gray: without a flow, it is what the others are held against. The table says what "
    "kT was under shear, which heats the fluid."
)


def compute(sweeps):
    """Profiles, viscosities and slip lengths."""
    shear, two, channel = (sweeps[name] for name in ("shear", "two_flows", "channel"))
    stress, rest = viscosities(shear), _at_rest(sweeps["at_rest"])
    flows, walls = _two_flows(two), [_channel(channel.sel(gamma=g)) for g in channel.gamma.values]
    speed, length = {"units": "r_c / tau"}, {"units": "r_c"}
    eta = {"units": "kT tau / r_c^3"}
    return xr.Dataset(
        {
            "shear_eta": ("rate", stress.viscosity.values, eta),
            "shear_eta_error": ("rate", stress.viscosity_error.values, eta),
            "shear_kT": ("rate", shear.kT.mean("replica").values, {"units": "kT"}),
            "rest_eta": ((), rest.value, eta),
            "rest_eta_error": ((), rest.error, eta),
            "two_u": ("two_z", flows.u, speed),
            "two_u_error": ("two_z", flows.error, speed),
            "two_eta": ((), flows.eta.value, eta),
            "two_eta_error": ((), flows.eta.error, eta),
            "two_curve": ("two_z", flows.curve, speed),
            "wall_u": (("gamma", "wall_z"), [w.u for w in walls], speed),
            "wall_u_error": (("gamma", "wall_z"), [w.error for w in walls], speed),
            "wall_eta": ("gamma", [w.eta.value for w in walls], eta),
            "wall_eta_error": ("gamma", [w.eta.error for w in walls], eta),
            "wall_curve": (("gamma", "wall_z"), [w.curve for w in walls], speed),
            "slip": ("gamma", [w.slip.value for w in walls], length),
            "slip_error": ("gamma", [w.slip.error for w in walls], length),
            "apart": ((), first_scene(channel).box[2], length),
        },
        {
            "rate": shear.rate, "gamma": channel.gamma,
            "two_z": ("two_z", flows.z, length), "wall_z": ("wall_z", walls[0].z, length),
        },
    )  # fmt: skip


class _Flow:
    """A profile with its parabola, viscosity, and slip length."""

    def __init__(self, z, velocity, eta, curve, slip=None):
        self.u, self.error = profile_and_errors(velocity)
        self.z, self.eta, self.curve, self.slip = z, eta, curve, slip


def _at_rest(runs):
    """Viscosity by the fluctuations of the stress; none if the run is too short."""
    scene, run = first_scene(runs), runs.isel(replica=0)
    try:
        return viscosity_of_fluctuations(
            run.pressure_tensor_all_series.values, scene.dt, scene.volume,
            float(run.kT.mean()), MEMORY,
        )  # fmt: skip
    except ValueError:
        return Viscosity(np.nan, np.nan)


def _two_flows(runs):
    """The profile of the lower half, both halves averaged."""
    scene = first_scene(runs)
    run, strength, edge = runs.isel(replica=0), scene.data["body_force"]["strength"], scene.box[2]
    eta = viscosity_of_two_flows(run, strength, edge)
    z = run.layer.values
    half = len(z) // 2
    velocity = run.velocity_profile.values[:, 0]
    density = float(run.bead_profile.mean())
    curve = density * strength * z[:half] * (0.5 * edge - z[:half]) / (2 * eta.value)
    return _Flow(z[:half], 0.5 * (velocity[:, :half] - velocity[:, half:]), eta, curve)


def _channel(runs):
    """The profile between two walls, and the parabola of its middle."""
    scene = first_scene(runs)
    run, strength, apart = runs.isel(replica=0), scene.data["body_force"]["strength"], scene.box[2]
    found = channel_flow(run, strength, apart)
    inside = (run.layer.values > 0) & (run.layer.values < apart)
    z = run.layer.values[inside]
    middle = (z > apart / 3) & (z < 2 * apart / 3)
    velocity = run.velocity_profile.values[:, 0, inside]
    density = float(run.bead_profile.values[:, inside][:, middle].mean())
    bend = density * strength / (2 * found.viscosity.value)
    shape = -bend * (z - 0.5 * apart) ** 2
    curve = shape + (velocity.mean(axis=0) - shape)[middle].mean()
    return _Flow(z, velocity, found.viscosity, curve, found.slip)


def measured(data):
    """eta in three ways over that at rest, that it does not depend on the rate, and the slip."""
    eta, error = data.shear_eta.values, data.shear_eta_error.values
    rest, rest_error = float(data.rest_eta), float(data.rest_eta_error)
    ratio = eta[-1] / eta[0]
    rates = [f"{float(rate):g}" for rate in data.rate]
    gammas = [f"{float(gamma):g}" for gamma in data.gamma]
    weight = 1 / data.wall_eta_error.values**2
    walls = float((weight * data.wall_eta.values).sum() / weight.sum())
    slips = ", ".join(f"{float(s):.2f} at {g}" for s, g in zip(data.slip, gammas))

    def over_rest(value, error, note):
        """A viscosity over that at rest."""
        relative = np.hypot(error / value, rest_error / rest)
        said = f"{value:.3f} ± {error:.3f} over {rest:.3f} ± {rest_error:.3f}; {note}"
        return Measured(float(value / rest), float(value / rest * relative), said)

    return {
        "viscosity_shear": over_rest(
            eta[-1], error[-1],
            f"rate {rates[-1]}, kT {float(data.shear_kT[-1]):.3f}; at rate {rates[0]}, "
            f"kT {float(data.shear_kT[0]):.3f}: {eta[0]:.3f}",
        ),
        "viscosity_two_flows": over_rest(
            float(data.two_eta), float(data.two_eta_error), "both halves averaged"
        ),
        "viscosity_walls": over_rest(
            walls, float(weight.sum() ** -0.5),
            f"weighted mean over wall frictions {', '.join(gammas)}",
        ),
        "newtonian": Measured(
            float(ratio), float(ratio * np.hypot(*(error / eta)[[0, -1]])),
            f"rate {rates[-1]} over rate {rates[0]}",
        ),
        "slip": Measured(
            float(data.slip[-1]), float(data.slip_error[-1]), f"slip lengths: {slips}"
        ),
    }  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Parabolic profiles of two opposite flows and of flows between walls, which fit their "
        "parabolas; the larger the friction of a wall, the slower the flow beside it. Viscosities "
        "by all ways lie in a row, in the gray band or near it."
    )


def draw(data):
    """Profiles, and viscosities beside each other."""
    figure, (two, walls, eta) = panels(3, height=2.4)
    points(two, data.two_z, data.two_u, data.two_u_error, "this work", BLUE)
    two.plot(data.two_z, data.two_curve, color=BLACK, linewidth=0.8, label="parabola")
    two.set(xlabel="$z$ / $r_c$", ylabel=r"velocity / ($r_c$ $\tau^{-1}$)", ylim=(0, None))
    two.legend(loc="lower center")
    for k, color in zip(range(data.sizes["gamma"]), cycle(COLORS)):
        at = data.isel(gamma=k)
        label = rf"$\gamma_w$ = {float(at.gamma):g}, $b = {float(at.slip):.2f}\,r_c$"
        points(walls, at.wall_z, at.wall_u, at.wall_u_error, label, color, markersize=2)
        walls.plot(at.wall_z, at.wall_curve, color=color, linewidth=0.8, linestyle=":")
    walls.set(xlabel="$z$ / $r_c$", ylabel=r"velocity / ($r_c$ $\tau^{-1}$)", ylim=(0, None))
    walls.legend(loc="lower center")
    _viscosities(eta, data)
    return figure


def _viscosities(axes, data):
    """One point for each way."""
    labels, value, error = [], [], []
    for k, rate in enumerate(data.rate.values):
        labels.append(f"shear {rate:g}")
        value.append(float(data.shear_eta[k]))
        error.append(float(data.shear_eta_error[k]))
    labels.append("at rest")
    value.append(float(data.rest_eta))
    error.append(float(data.rest_eta_error))
    labels.append("two flows")
    value.append(float(data.two_eta))
    error.append(float(data.two_eta_error))
    for k, gamma in enumerate(data.gamma.values):
        labels.append(rf"walls, $\gamma_w$ = {gamma:g}")
        value.append(float(data.wall_eta[k]))
        error.append(float(data.wall_eta_error[k]))
    half = COVERAGE * float(data.rest_eta_error)
    if np.isfinite(half):
        axes.axhspan(
            float(data.rest_eta) - half, float(data.rest_eta) + half, color=BLACK, alpha=0.15,
            linewidth=0,
        )  # fmt: skip
    points(axes, range(len(labels)), value, error, None, RED)
    axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right")
    axes.set(ylabel=r"$\eta$ / ($k_BT$ $\tau$ $r_c^{-3}$)", xlim=(-0.5, len(labels) - 0.5))
