"""What the figures of Groot and Warren 1997 make of data whose answers are known."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.published import published, shown_by
from dpd.analysis.verdicts import judge
from dpd.report.figures import load_module
from dpd.scene.scene import Scene
from paper_figures.groot_warren_1997 import dynamics

RNG = np.random.default_rng(8)


def module(figure):
    """The file of a figure."""
    return load_module("groot_warren_1997", figure)


@pytest.mark.parametrize("apart, verdict", [(0.0, "replicated"), (0.01, "deviates")])
def test_two_kinds_of_noise(apart, verdict):
    """Temperatures that differ by 1 % are told apart, however far from 1 they are."""
    true = np.array([1, 3])[:, None, None] * np.array([1, 1 + apart])[:, None] * np.ones(8)
    along, error = ("scheme", "noise", "dt"), 0.001 * true
    data = xr.Dataset(
        {
            "excess": (along, true - 1 + RNG.normal(0, error)),
            "error": (along, error),
            "degrees": (along, np.full(true.shape, np.inf)),
        },
        {"noise": ["uniform", "gaussian"]},
    )
    found = module("fig01_time_step").between_noises(data)
    limits = published("groot_warren_1997")["noise_difference"]
    assert judge(limits, found).verdict == verdict


def test_best_lambda_is_where_the_temperature_is_right():
    """Zero of a parabola through kT - 1."""
    factor = np.array([0.5, 0.55, 0.6, 0.65, 0.7])
    data = xr.Dataset(
        {
            "at_lambda": ("lambda", -0.4 * (factor - 0.67) + 0.3 * (factor - 0.67) ** 2),
            "at_lambda_error": ("lambda", np.full(5, 0.002)),
        },
        {"lambda": factor},
    )
    temperature = module("text_temperature")
    value, error, _ = temperature.best_lambda(data)
    assert value == pytest.approx(0.67)
    noisy = [
        temperature.best_lambda(
            data.assign(at_lambda=data.at_lambda + RNG.normal(scale=0.002, size=5))
        ).value
        for _ in range(400)
    ]
    assert np.std(noisy) == pytest.approx(error, rel=0.15)


def widths_over(chi, power):
    """Interface widths of Eq. 35, where their inverse squares are a line in chi to a power."""
    true = 3.24 / np.sqrt(3 * (chi - 2.39) ** power)
    return xr.Dataset(
        {
            "chi": ("excess", chi),
            "width": ("excess", true * (1 + RNG.normal(scale=0.01, size=6))),
            "width_error": ("excess", 0.01 * true),
            "fitted": ("excess", np.ones(6, dtype=bool)),
        }
    )


def test_width_against_chi():
    """Eq. 35 put in comes out, with errors that hold; points off a line decide nothing."""
    widths, chi = module("text_interface_width"), np.linspace(2.6, 3.9, 6)
    found = [widths.line(widths_over(chi, 1.0), 3, 0.5) for _ in range(100)]
    for name, true in (("amplitude", 3.24), ("critical", 2.39)):
        pulls = [(each[name] - true) / each[f"{name}_error"] for each in found]
        # Errors are widened where points scatter more by chance: a little narrower than 1.
        assert abs(np.mean(pulls)) < 0.4 and 0.6 < np.std(pulls) < 1.2
    refused = [
        sum(
            "straight line" in widths.of_line(widths_over(chi, power), 3, 0.5, "critical").undecided
            for _ in range(100)
        )
        for power in (1.0, 1.3)
    ]
    assert refused[0] <= 6 and refused[1] >= 94
    few = widths.of_line(widths_over(chi, 1.0).isel(excess=slice(4, 6)), 3, 0.5, "critical")
    assert "fewer than three" in few.undecided


FLUID = {
    "dimension": 3,
    "box": 10,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 100},
    "observe": ["thermo"],
}


def test_the_wall_that_gives_three_pressures():
    """Pressures that are parabolas of ln a_w and meet the published ones at a_w 45."""
    walls = module("text_walls")
    strength = np.array([30.0, 40.0, 50.0, 60.0])
    away = np.log(strength / 45)
    data = xr.Dataset(coords={"strength": strength})
    for name, row in walls.PRINTED.items():
        data[name] = ("strength", walls.PUBLISHED[row].value + 7 * away + away**2)
        data[f"{name}_error"] = ("strength", np.full(4, 0.02))
    best, at = walls.best_wall(data)
    assert best == pytest.approx(45, rel=1e-3)
    for name, row in walls.PRINTED.items():
        value, error = at[name]
        assert value == pytest.approx(walls.PUBLISHED[row].value, abs=1e-3)
        assert 0.005 < error < 0.02
    assert np.isnan(walls.best_wall(data.isel(strength=[0, 1]))[0])


def test_viscosity_without_shear():
    """The constant of a straight line in the square of the rate."""
    rates, stress = np.array([0.2, 0.4, 0.8]), {"units": "kT / r_c^3"}
    eta = 0.9 - 0.05 * rates**2
    scenes = [[json.dumps(Scene(FLUID | {"shear": {"rate": rate}}).data)] for rate in rates]
    runs = xr.Dataset(
        {
            "shear_stress": (("rate", "replica"), (eta * rates)[:, None], stress),
            "shear_stress_error": (("rate", "replica"), np.full((3, 1), 0.003), stress),
            "scene": (("rate", "replica"), scenes),
        },
        {"rate": rates},
    )
    found = dynamics.sheared(runs)
    assert found.nu == pytest.approx(eta / 3)
    assert found.at_rest.value == pytest.approx(0.3)
    assert found.slope == pytest.approx(-0.05 / 3)
    assert 0 < found.at_rest.error < 0.01


def test_power_and_misses_of_the_schmidt_number():
    """Sc ~ gamma^2, and a theory that is 20 % above D and right for nu."""
    schmidt = module("text_schmidt")
    gamma = np.array([schmidt.GAMMA, 20.0, 50.0])
    d, nu = schmidt.diffusion_constant(gamma, 3.0) / 1.2, schmidt.kinematic_viscosity(gamma, 3.0)
    data = xr.Dataset({"density": 3.0}, {"gamma": gamma})
    for name, values in {"D": d, "nu": nu, "Sc": gamma**2}.items():
        data[name] = ("gamma", values)
        data[f"{name}_error"] = ("gamma", 0.01 * values)
    assert schmidt._power(data).value == pytest.approx(2)
    assert schmidt._power(data).error == pytest.approx(0.01 * np.sqrt(2) / np.log(2.5))
    data["Sc"] = ("gamma", nu / d)
    miss = schmidt._largest_miss(data)
    assert miss.value == pytest.approx(0.2)
    assert "nu +0 %" in miss.note
    at = shown_by(schmidt.__file__)
    found = schmidt.measured(data)
    for name in ("theory_diffusion", "theory_viscosity", "theory_schmidt"):
        assert abs(found[name].value - at[name].value) < at[name].rounding
