"""Numbers over chain length: end effects, exponents, and where two regimes meet."""

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.diffusion import power
from dpd.analysis.statistics import COVERAGE
from dpd.report.figures import load_module
from paper_figures.nikunen_2007.chain_lengths import crossover, end_effect

LENGTHS = np.array([8.0, 16.0, 32.0, 64.0, 96.0, 128.0, 192.0, 256.0])
DRAWS = 400


def covered(draw, truth):
    """Share of draws whose 95 % interval holds the truth."""
    rng = np.random.default_rng(3)
    found = np.array([draw(rng)[:2] for _ in range(DRAWS)])
    return np.mean(np.abs(found[:, 0] - truth) < COVERAGE * found[:, 1])


def test_means_over_bonds_are_linear_in_the_share_of_ends():
    """Chains whose end bonds are 0.99 and whose others are 0.96 long, without noise."""
    n = np.array([8, 16, 32])
    means = np.array([np.mean([0.99, *[0.96] * (k - 3), 0.99]) for k in n])
    found = end_effect(1 / (n - 1), means, np.full(3, 1e-4), 1 / 255)
    assert found.value == pytest.approx(np.mean([0.99, *[0.96] * 253, 0.99]), abs=1e-12)
    assert found.slope == pytest.approx(2 * 0.03)
    assert found.p_value > 0.99


def test_how_often_extrapolated_errors_cover():
    """95 %, or a little more: scatter widens errors and never narrows them; curvature shows."""
    share = 1 / (np.array([8, 16, 32]) - 1)

    def draw(rng):
        means = 0.96 + 0.06 * share + 1e-3 * rng.normal(size=3)
        return end_effect(share, means, np.full(3, 1e-3), 1 / 255)

    assert 0.92 < covered(draw, 0.96 + 0.06 / 255) < 1.0
    assert end_effect(share, 1 + share**2, np.full(3, 1e-4), 0.0).p_value < 1e-6


def test_exponents_and_how_often_their_errors_cover():
    """Relaxation times of 5 % error that go as N^3: 95 % of the intervals hold 3."""

    def draw(rng):
        tau = LENGTHS**3 * (1 + 0.05 * rng.normal(size=len(LENGTHS)))
        return power(LENGTHS, tau, 0.05 * tau, 60, np.inf)

    assert 0.92 < covered(draw, 3) < 1.0
    assert np.isnan(power(LENGTHS, LENGTHS, LENGTHS, 150, np.inf).exponent)  # of two lengths


@pytest.mark.parametrize(
    ("place", "exponents"), [(25.0, (2, 3)), (50.0, (None, None)), (110.0, (2, 3))]
)
def test_where_regimes_meet_and_how_often_its_error_covers(place, exponents):
    """Wherever that is among the lengths: nothing but the points says where to look."""
    exact = 0.3 * LENGTHS**2 * np.maximum(1, LENGTHS / place)  # N^2, and N^3 from there
    found = crossover(LENGTHS, exact, 0.03 * exact, exponents)
    assert found.length == pytest.approx(place, rel=0.02) and found.p_value > 0.99

    def draw(rng):
        tau = exact * (1 + 0.03 * rng.normal(size=len(LENGTHS)))
        return crossover(LENGTHS, tau, 0.03 * tau, exponents)

    rng = np.random.default_rng(3)
    draws = np.array([draw(rng)[:2] for _ in range(150)])
    bounded = draws[np.isfinite(draws[:, 1])]
    assert len(bounded) > 0.9 * len(draws)
    inside = np.abs(bounded[:, 0] - place) < COVERAGE * bounded[:, 1]
    assert 0.9 < np.mean(inside) <= 1.0


def test_what_has_no_crossover():
    """One power law fits, and nothing bounds the place; too few lengths give none at all."""
    noise = 1 + 0.03 * np.random.default_rng(4).normal(size=len(LENGTHS))
    for exponent in (2.0, 2.3):
        law = LENGTHS**exponent * noise
        found = crossover(LENGTHS, law, 0.03 * law)
        assert found.straight > 0.05
    rouse = LENGTHS**2 * noise
    fixed = crossover(LENGTHS, rouse, 0.03 * rouse, (2, 3))
    assert fixed.length > 150 or np.isnan(fixed.error)
    few = LENGTHS[:4]
    assert np.isnan(crossover(few, few**2, 0.03 * few**2).length)


@pytest.mark.parametrize(("quantity", "exponents"), [("tau", (2, 3)), ("diffusion", (-1, -2))])
def test_where_the_drawn_laws_meet(quantity, exponents):
    """The published laws through either end, whatever the points between; none without an end."""
    figure = load_module("nikunen_2007", "fig05_exponents")
    n = np.array([8.0, 16.0, 50.0, 64.0, 128.0])
    value = np.where(n < 45, n ** exponents[0], n ** exponents[1] * 45.0 ** -np.diff(exponents))
    value[2] *= 3
    data = xr.Dataset(
        {
            quantity: (("set", "length"), [value]),
            f"{quantity}_error": (("set", "length"), [0.03 * value]),
            "long_enough": (("set", "length"), [np.ones(5)]),
        },
        {"set": ["a100"], "length": n},
    )
    found, error = figure.meeting(data, quantity)
    assert found == pytest.approx(45.0)
    assert error == pytest.approx(45 * 0.03)  # two points at each end
    assert np.isnan(figure.meeting(data.isel(length=slice(3)), quantity)[0])
