"""Numbers read off curves: flanks, exponents, relaxation times."""

import numpy as np
import pytest

from dpd.analysis.statistics import block_mean_and_error, jackknife
from dpd.analysis.structure import rise
from paper_figures.nikunen_2007.shared import fall

LEVEL = 0.05


def bins(width, last):
    """Middles of bins from 0."""
    return np.arange(width / 2, last, width)


@pytest.mark.parametrize("width", [0.005, 0.01, 0.02])
def test_an_exponential_flank_is_found_between_bins(width):
    """g = exp(30 (r - 0.8)) has 0.05 at 0.8 + ln(0.05) / 30, whatever the bins; a chord is off."""
    r = bins(width, 1.0)
    assert rise(r, np.exp(30 * (r - 0.8))) == pytest.approx(0.8 + np.log(LEVEL) / 30, abs=1e-12)


def test_a_flank_uses_all_bins_near_the_level():
    """A level of 1000 counts a bin is found three times as well as between two bins."""
    length = bins(0.005, 2.0)
    density = np.exp(-0.5 * ((length - 0.97) / 0.06) ** 2) / (0.06 * np.sqrt(2 * np.pi))
    exact = 0.97 + 0.06 * np.sqrt(-2 * np.log(LEVEL * 0.06 * np.sqrt(2 * np.pi)))
    rng = np.random.default_rng(5)
    found = [fall(length, rng.poisson(2e4 * density) / 2e4) for _ in range(200)]
    two_bins = 1 / (np.sqrt(1000) * (exact - 0.97) / 0.06**2)  # error of ln density over slope
    assert np.std(found) < 0.5 * two_bins
    assert np.mean(found) == pytest.approx(exact, abs=1e-4)


def test_flanks_that_end_at_an_empty_bin():
    """A straight line there, and no number where the bins end before the flank does."""
    r = np.array([0.1, 0.2, 0.3])
    assert rise(r, np.array([0.0, 0.1, 0.5])) == pytest.approx(0.15)
    assert fall(r, np.array([0.5, 0.1, 0.0])) == pytest.approx(0.25)
    assert np.isnan(fall(r, np.array([0.1, 0.5, 0.2])))


def test_jackknife_of_a_mean_is_its_standard_error():
    """And that of its square, twice the mean times that."""
    blocks = np.random.default_rng(1).normal(3.0, 1.0, size=(50, 1))
    error = float(block_mean_and_error(blocks[:, 0])[1])
    assert error == pytest.approx(blocks.std(ddof=1) / np.sqrt(50), rel=0.5)
    assert jackknife(blocks, lambda mean: mean[0]) == pytest.approx((blocks.mean(), error))
    squared = jackknife(blocks, lambda mean: mean[0] ** 2)[1]
    assert squared == pytest.approx(2 * blocks.mean() * error, rel=0.05)
