"""Numbers over chain length: end effects, exponents, and where two regimes meet."""

import numpy as np
import pytest

from dpd.analysis.chain_length import end_effect, meeting, power
from dpd.analysis.statistics import COVERAGE
from dpd.report.figure_file import load_module

LENGTHS = np.array([8.0, 16.0, 32.0, 64.0, 96.0, 128.0, 192.0, 256.0])
REGIMES = ((8, 40), (60, np.inf))
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
    """95 %, or a little more: scatter widens errors and never narrows them."""
    share = 1 / (np.array([8, 16, 32]) - 1)

    def draw(rng):
        means = 0.96 + 0.06 * share + 1e-3 * rng.normal(size=3)
        return end_effect(share, means, np.full(3, 1e-3), 1 / 255)

    assert 0.92 < covered(draw, 0.96 + 0.06 / 255) < 1.0


def test_curvature_shows_in_the_p_value():
    """A term in 1 / N^2 of many standard errors."""
    share = 1 / np.array([8, 16, 32])
    found = end_effect(share, 1 + share**2, np.full(3, 1e-4), 0.0)
    assert found.p_value < 1e-6


def test_two_lengths_give_no_extrapolation():
    """They lie on any line."""
    assert np.isnan(end_effect(np.array([0.1, 0.2]), np.ones(2), np.ones(2), 0.0).value)


def test_exponents_and_how_often_their_errors_cover():
    """Relaxation times of 5 % error that go as N^3: 95 % of the intervals hold 3."""

    def draw(rng):
        tau = LENGTHS**3 * (1 + 0.05 * rng.normal(size=len(LENGTHS)))
        return power(LENGTHS, tau, 0.05 * tau, 60, np.inf)

    assert 0.92 < covered(draw, 3) < 1.0
    assert np.isnan(power(LENGTHS, LENGTHS, LENGTHS, 150, np.inf).exponent)  # of two lengths


def two_regimes(crossover):
    """0.3 N^2 up to the crossover, and N^3 from there."""
    return 0.3 * LENGTHS**2 * np.maximum(1, LENGTHS / crossover)


@pytest.mark.parametrize("exponents", [(None, None), (2, 3)])
def test_where_regimes_meet_and_how_often_its_error_covers(exponents):
    """At 50, from relaxation times of 3 % error at the lengths of the long study."""

    def draw(rng):
        tau = two_regimes(50) * (1 + 0.03 * rng.normal(size=len(LENGTHS)))
        return meeting(LENGTHS, tau, 0.03 * tau, REGIMES, exponents)

    exact = two_regimes(50)
    assert meeting(LENGTHS, exact, 0.03 * exact, REGIMES, exponents)[0] == pytest.approx(50)
    assert 0.92 < covered(draw, 50) < 1.0


def test_given_exponents_narrow_the_place_where_regimes_meet():
    """And free ones say so by a larger error."""
    tau = two_regimes(50)
    free = meeting(LENGTHS, tau, 0.03 * tau, REGIMES)
    fixed = meeting(LENGTHS, tau, 0.03 * tau, REGIMES, (2, 3))
    assert 0 < fixed[1] < free[1]


def test_diffusion_constants_meet_alike():
    """D N^-1 to N^-2, the slopes falling in place of rising."""
    constant = 1 / (LENGTHS * np.maximum(1, LENGTHS / 50))
    found, error = meeting(LENGTHS, constant, 0.03 * constant, REGIMES)
    assert found == pytest.approx(50)
    assert error > 0


def test_a_missing_regime_has_no_meeting():
    """Nor do lines of the same slope."""
    short = LENGTHS[:3]
    assert np.isnan(meeting(short, short**2, 0.03 * short**2, REGIMES)[0])
    rouse = LENGTHS**2
    assert np.isnan(meeting(LENGTHS, rouse, 0.03 * rouse, REGIMES, (2, 2))[0])


def test_room_of_a_box_is_counted_in_mean_distances():
    """Ends of Gaussian chains: <R> is below the root of <R^2>, and the rule is on <R>."""
    vectors = np.random.default_rng(4).normal(size=(100_000, 3))
    distance = np.sqrt((vectors**2).sum(axis=1))
    rooms = load_module("nikunen_2007", "fig04_chains").room(5.0, np.sqrt((distance**2).mean()))
    assert rooms == pytest.approx(5.0 / distance.mean(), rel=3e-3)
