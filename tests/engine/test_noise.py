"""The noise of the pairs: its distribution, and that nothing hangs together.

Each statistic is held to 5 of its own standard errors, or to a probability of 1e-6.
"""

import numpy as np
import pytest
from scipy import stats

from dpd.jit import kernel
from dpd.physics.common.noise import cos_pi, minus_log
from tests.engine.reference import fill_noise, pair_noise, step_keys

SIGMAS, CHANCE = 5.0, 1e-6
# Name, whether Gaussian, fourth and eighth moment at unit variance.
NOISES = [("uniform", False, 9 / 5, 9.0), ("gaussian", True, 3.0, 105.0)]
noises = pytest.mark.parametrize("noise", NOISES, ids=lambda noise: noise[0])
LOW, HIGH = np.triu_indices(1000, 1)  # half a million pairs


def draw(noise, low=LOW, high=HIGH, seed=1, step=1):
    """Noise of pairs at a step."""
    return pair_noise(np.minimum(low, high), np.maximum(low, high), seed, step, noise[1])


def assert_mean(values, expected, variance):
    """The mean of independent values lies within its error of the expected one."""
    error = np.sqrt(variance / len(values))
    assert abs(np.mean(values) - expected) < SIGMAS * error


def assert_independent(x, y, fourth):
    """Neither the noises nor their squares are correlated."""
    assert_mean(x * y, 0.0, 1.0)
    assert_mean((x**2 - 1) * (y**2 - 1), 0.0, (fourth - 1) ** 2)


@noises
@pytest.mark.parametrize("seed, step", [(1, 1), (1, 2), (0, 0), (2**63, 10**7)])
def test_moments(noise, seed, step):
    """Mean 0, variance 1, no skew, and the fourth moment of the distribution."""
    _, _, fourth, eighth = noise
    theta = draw(noise, seed=seed, step=step)
    sixth = 27 / 7 if fourth < 2 else 15.0
    assert_mean(theta, 0.0, 1.0)
    assert_mean(theta**2, 1.0, fourth - 1)
    assert_mean(theta**3, 0.0, sixth)
    assert_mean(theta**4, fourth, eighth - fourth**2)


@noises
def test_distribution(noise):
    """Kolmogorov and Smirnov; a distance above 0.0038 is a probability below 1e-6 here."""
    theta = draw(noise)
    root = np.sqrt(3.0)
    law = stats.norm() if noise[1] else stats.uniform(-root, 2 * root)
    assert stats.kstest(theta, law.cdf).pvalue > CHANCE


def test_polynomials_of_gaussian_noise():
    words, x = np.array([0, 1, 2**31, 2**32 - 2, 2**32 - 1, *LOW[::99]], np.uint32), LOW / 500 - 1
    logarithms = -np.log((words + 0.5) / 2**32)
    assert [*map(minus_log, words)] == pytest.approx(logarithms, rel=5e-12)
    assert cos_pi(x) == pytest.approx(np.cos(np.pi * x), abs=2e-10)


OTHER = np.random.default_rng(2).permutation(1000)  # a third bead for each first one
PARTNERS = {
    "same first, next second": (LOW, HIGH, LOW, HIGH + 1),
    "same first, second 64 on": (LOW, HIGH, LOW, HIGH + 64),
    "same first, any second": (LOW, HIGH, LOW, 1000 + OTHER[HIGH]),
    "same second, next first": (LOW, HIGH + 1, LOW + 1, HIGH + 1),
    "same second, any first": (LOW, HIGH + 1000, OTHER[LOW], HIGH + 1000),
    "second is the other's first": (LOW, HIGH, HIGH, HIGH + 1 + LOW),
    "chain i, i+1, i+2": (np.arange(10**6), np.arange(10**6) + 1,
                          np.arange(10**6) + 1, np.arange(10**6) + 2),
    "both moved by one": (LOW, HIGH, LOW + 1, HIGH + 1),
    "sum of identities kept": (LOW, HIGH + 1, LOW + 1, HIGH),
}  # fmt: skip


@noises
@pytest.mark.parametrize("name", PARTNERS)
def test_pairs_of_a_step_are_independent(noise, name):
    """Above all those that share a bead, where known codes went wrong."""
    i, j, k, m = PARTNERS[name]
    apart = ((i != k) | (j != m)) & (i != j) & (k != m)
    i, j, k, m = i[apart], j[apart], k[apart], m[apart]
    assert len(i) > 400_000
    assert_independent(draw(noise, i, j), draw(noise, k, m), noise[2])


@noises
@pytest.mark.parametrize(
    "seed, step", [(1, 6), (1, 261), (1, 2**32 + 5), (2, 5), (2, 4), (2**32 + 1, 5), (2**40, 6)]
)
def test_seeds_and_steps_are_independent(noise, seed, step):
    assert_independent(draw(noise, seed=1, step=5), draw(noise, seed=seed, step=step), noise[2])


@kernel(allocates=True)
def sums_of_steps(low, high, seed, steps, gaussian):
    """Noise summed over all pairs, and over the pairs of bead 0, for each step."""
    total, of_bead = np.zeros(steps), np.zeros(steps)
    theta = np.empty(len(low))
    for step in range(steps):
        keys = step_keys(seed, step)
        fill_noise(theta, low, high, len(low), keys, gaussian)
        for p in range(len(low)):
            total[step] += theta[p]
            if low[p] == 0:
                of_bead[step] += theta[p]
    return total, of_bead


@noises
def test_no_covariance_hides_in_sums(noise):
    """The variance of a sum of n noises is n (1 + (n-1) c), c their mean covariance.

    With 2000 steps the variance is known to 3.2 %, so c is below 0.16 / n: 8e-6 over all
    pairs of 200 beads. The sums of neighbouring steps are as independent.
    """
    low, high = (a.astype(np.uint32) for a in np.triu_indices(200, 1))
    steps = 2000
    for sums, n in zip(sums_of_steps(low, high, np.uint64(3), steps, noise[1]), (19_900, 199)):
        sums = sums / np.sqrt(n)
        assert_mean(sums, 0.0, 1.0)
        assert_mean(sums**2, 1.0, 2.0)
        assert_mean(sums[1:] * sums[:-1], 0.0, 1.0)
