"""What the figures of Groot and Warren 1997 make of data whose answers are known."""

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.published import published
from dpd.analysis.verdicts import judge
from dpd.report.figures import load_module

RNG = np.random.default_rng(8)


def module(figure):
    """The file of a figure."""
    return load_module("groot_warren_1997", figure)


def test_step_at_a_temperature():
    """The dt at which 2 dt + 30 dt^2 is 0.02."""
    dt = np.array([0.001, 0.002, 0.005, 0.01])
    excess = 2 * dt + 30 * dt**2
    data = xr.Dataset(
        {
            "excess": (("scheme", "noise", "dt"), np.tile(excess, (1, 2, 1))),
            "error": (("scheme", "noise", "dt"), np.full((1, 2, 4), 1e-4)),
        },
        {"scheme": ["euler"], "noise": ["uniform", "gaussian"], "dt": dt},
    )
    step, error = module("fig01_time_step").step_at(data, "euler", 0.02, 0.01)
    assert 2 * step + 30 * step**2 == pytest.approx(0.02)
    assert 1e-5 < error < 1e-4


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


def test_steepening_of_a_broken_line():
    """A slope that grows five times at 8 is found there, and none before."""
    sigma = np.arange(1.0, 10.0)
    excess = 0.01 * sigma + 0.04 * np.maximum(0, sigma - 8)
    data = xr.Dataset(
        {
            "excess": ("amplitude", excess),
            "excess_error": ("amplitude", np.full(9, 1e-3)),
        },
        {"amplitude": sigma},
    )
    temperature = module("text_temperature")
    assert temperature.steepening(data, 8.0)[0] == pytest.approx(5)
    assert temperature.steepening(data, 7.0)[0] == pytest.approx(1)
    assert np.isnan(temperature.steepening(data.isel(amplitude=slice(0, 7)), 8.0)[0])


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


@pytest.mark.parametrize("rho", [3, 5])
def test_width_against_chi(rho):
    """Eq. 35 put in comes out, with errors that hold."""
    chi = np.linspace(2.8, 5.0, 6)
    widths = module("text_interface_width")
    pulls = []
    for _ in range(100):
        true = 3.24 / np.sqrt(rho * (chi - 2.39))
        data = xr.Dataset(
            {
                "chi": ("excess", chi),
                "width": ("excess", true * (1 + RNG.normal(scale=0.01, size=6))),
                "width_error": ("excess", 0.01 * true),
            }
        )
        found = widths.line(data, rho, 0.5)
        pulls.append([
            (found["amplitude"] - 3.24) / found["amplitude_error"],
            (found["critical"] - 2.39) / found["critical_error"],
        ])  # fmt: skip
    # Errors are widened where points scatter more by chance: pulls are a little narrower than 1.
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 0.4)
    assert np.all((np.std(pulls, axis=0) > 0.6) & (np.std(pulls, axis=0) < 1.2))


def test_points_off_a_straight_line_decide_nothing():
    """Their zero depends on which are fitted; points on one are taken, but for 1 in 100.

    A point far from the critical one is not fitted, so it may lie anywhere.
    """
    widths, refused = module("text_interface_width"), []
    chi = np.append(np.linspace(2.6, 3.9, 5), 5)
    for power in (1.0, 1.3):
        reasons = []
        for _ in range(100):
            true = (0.3 * (chi - 2.39) ** power) ** -0.5
            true[-1] *= 2
            data = xr.Dataset(
                {
                    "chi": ("excess", chi),
                    "width": ("excess", true * (1 + RNG.normal(scale=0.01, size=6))),
                    "width_error": ("excess", 0.01 * true),
                    "fitted": ("excess", np.ones(6, dtype=bool)),
                }
            )
            reasons.append(widths.of_line(data, 3, 0.5, "critical").undecided)
        refused.append(sum("straight line" in reason for reason in reasons))
    assert refused[0] <= 6 and refused[1] >= 94
    few = widths.of_line(data.isel(excess=slice(3, 6)), 3, 0.5, "critical")
    assert "fewer than three" in few.undecided
