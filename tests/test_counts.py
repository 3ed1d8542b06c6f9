"""Intervals of counts cover as often as they say."""

import numpy as np
import pytest
from scipy.stats import poisson

from dpd.analysis.statistics import NONE_SEEN, interval


@pytest.mark.parametrize("mean", [0.3, 1.0, 2.7, 3.2, 8.0, 60.0])
def test_intervals_cover_the_mean(mean):
    """95 % or more of all counts have an interval that holds the mean they were drawn from.

    By the sum over all counts, so without noise. Counts are whole numbers, so few of them cover
    more often than they must.
    """
    counts = np.arange(400)
    low, high = interval(counts)
    covered = poisson.pmf(counts, mean)[(low <= mean) & (mean <= high)].sum()
    assert covered >= (0.94 if NONE_SEEN < mean < 3.7 else 0.95)
    assert covered < (0.97 if mean > 50 else 1)


def test_ends_have_their_probability():
    """So many or more at the lower end, and so few or fewer at the upper one: 2.5 % each."""
    counts = np.array([1, 2, 5, 30])
    low, high = interval(counts)
    np.testing.assert_allclose(poisson.sf(counts - 1, low), 0.025)
    np.testing.assert_allclose(poisson.cdf(counts, high), 0.025)


def test_none_seen():
    """No lower end, and all 5 % above the upper one."""
    low, high = interval(0)
    assert (low, high) == (0, NONE_SEEN)
    assert poisson.cdf(0, NONE_SEEN) == pytest.approx(0.05, abs=0.001)
