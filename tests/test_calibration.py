"""Intervals cover: 95 % of them, within a little, hold the truth; and what would not, fails."""

import numpy as np
import pytest
import xarray as xr
from scipy.signal import lfilter
from scipy.stats import poisson

from dpd.analysis import diffusion, statistics
from dpd.analysis.statistics import (
    NONE_SEEN,
    block_mean_and_error,
    degrees_of,
    interval,
    jackknife,
    jackknife_error,
    linear_fit,
    mean_and_error,
    over_replicas,
    widening,
)
from dpd.engine.loop import run
from paper_figures.groot_warren_1997.coverage import coverage, coverage_of_pieces, slow_time
from tests.conftest import SCENE
from tests.systems import begun, values_of

LEAST, MOST = 0.93, 0.985
HARD = 0.92  # of few blocks, joined to four parts, and of a slow part under noise
RUNS = 2000  # binomial error of 95 % in so many: 0.5 %


def process(rng, samples, runs, tau=0.5, slow=1.0):
    """Gaussian series of unit variance and zero mean, (samples, runs).

    A share ``slow`` of the variance is an AR(1) process of integrated autocorrelation time
    ``tau``; the rest is white.
    """
    memory = (2 * tau - 1) / (2 * tau + 1)
    noise = rng.normal(size=(samples, runs))
    noise[1:] *= np.sqrt(1 - memory**2)
    correlated = lfilter([1], [1, -memory], noise, axis=0)
    return np.sqrt(slow) * correlated + np.sqrt(1 - slow) * rng.normal(size=(samples, runs))


def rms_z(mean, error):
    """Of pairs of runs: their difference over the error of it; 1 where errors are true."""
    z = (mean[::2] - mean[1::2]) / np.hypot(error[::2], error[1::2])
    return np.sqrt(np.nanmean(z**2))


def jumps(error):
    """Share of pairs of runs whose error bars differ by a factor of 2 or more."""
    return np.mean(np.abs(np.log(error[::2] / error[1::2])) > np.log(2))


PROCESSES = {
    "white": {},
    "tau 0.6": {"tau": 0.6},
    "tau 2": {"tau": 2},
    "n / 200": {"tau": 1 / 200},
    "n / 50": {"tau": 1 / 50},
    "n / 20": {"tau": 1 / 20},
    "a third, n / 25": {"tau": 1 / 25, "slow": 0.3},
    "a tenth, n / 30": {"tau": 1 / 30, "slow": 0.1},
    "a fiftieth, n / 30": {"tau": 1 / 30, "slow": 0.02},
    "a hundredth, n / 30": {"tau": 1 / 30, "slow": 0.01},
}


def made(name, samples, runs=RUNS, seed=3):
    """A process; times below 1/2 are shares of the run."""
    settings = dict(PROCESSES[name])
    if settings.get("tau", 1) < 0.5:
        settings["tau"] *= samples
    return process(np.random.default_rng(seed), samples, runs, **settings)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", PROCESSES)
def test_series_cover(name):
    """Fast and slow down to 20 correlation times, and both together down to 25 or 30 of the slow.

    Few have no error there.
    """
    series = made(name, 1000)
    found = coverage(series, 0.0)
    assert (HARD if "slow" in PROCESSES[name] else LEAST) <= found.share <= MOST
    # Of 50 correlation times few degrees of freedom are left, of 20 two, and Student's t is 4.3.
    least = {"n / 50": 0.72, "n / 20": 0.62, "a third, n / 25": 0.72}.get(name, 0.82)
    assert least < rms_z(*statistics.block_mean_and_error(series)) < 1.05
    assert found.too_short < 0.12
    assert found.width < 1.5


def test_noise_that_is_taken_back():
    """As of the force on a wall: over some twenty samples, beyond where a window closes."""
    white = np.random.default_rng(4).normal(size=(5200, 400))
    back = lfilter([0.2], [1, -0.8], white, axis=0)
    mean, error = statistics.block_mean_and_error((white - 0.8 * back)[200:])
    assert np.mean(np.abs(mean) < 1.96 * error) >= LEAST
    assert 0.6 < rms_z(mean, error) < 1.05  # by the samples alone it is 0.24


@pytest.mark.few(12)
@pytest.mark.parametrize("name", ["white", "n / 200", "n / 50", "n / 20"])
@pytest.mark.parametrize("count", [50, 30, 25, 15, 10, 5, 3, 2])
def test_blocks_cover(name, count):
    """Fifty blocks of a run, and as few as two."""
    blocks = made(name, count * 40).reshape(count, 40, RUNS).mean(axis=1)
    found = coverage(blocks, 0.0)
    assert (LEAST if count >= statistics.FEW else HARD) <= found.share <= MOST
    assert found.too_short < 0.16
    if count == 50:  # as runs have
        mean, error = statistics.block_mean_and_error(blocks)
        assert 0.87 < rms_z(mean, error) < 1.05
        assert jumps(error) < {"n / 20": 0.2, "n / 50": 0.12}.get(name, 0.05)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["white", "n / 50", "n / 20"])
def test_jackknives_cover(name):
    """The exponential of the mean, from blocks, from tenths of a run, and from molecules."""
    blocks = made(name, 2000).reshape(50, 40, RUNS).mean(axis=1)
    found = np.array([jackknife(b, lambda mean: np.exp(0.3 * mean)) for b in blocks.T])
    assert LEAST <= coverage(blocks, 1.0, lambda _: found.T).share <= MOST
    tenths = blocks.reshape(10, 5, RUNS).mean(axis=1)
    left_out = np.exp(0.3 * (tenths.sum(axis=0) - tenths) / 9)
    estimate = np.exp(0.3 * tenths.mean(axis=0)), jackknife_error(left_out, serial=True)
    assert HARD <= coverage(tenths, 1.0, lambda _: estimate).share <= MOST


@pytest.mark.parametrize(("points", "degrees"), [(3, 16), (4, 9), (8, 16), (8, 1000)])
def test_fits_cover(points, degrees):
    """The slope of points whose errors have some degrees of freedom each."""
    rng, x = np.random.default_rng(1), np.arange(points) + 1.0
    found = []
    for _ in range(RUNS):
        error = widening(degrees) * np.sqrt(rng.chisquare(degrees, points) / degrees)
        fit = linear_fit([np.ones(points), x], rng.normal(size=points), error)
        found.append((fit.values[1], fit.errors[1]))
    value, error = np.array(found).T
    assert LEAST <= np.mean(np.abs(value) < 1.96 * error) <= 0.97
    assert 0.9 < rms_z(value, error) < 1.06
    assert jumps(error) < 0.03


@pytest.mark.thorough
@pytest.mark.parametrize(("tau", "slow"), [(0.5, 1.0), (5.0, 1.0), (8.0, 0.3)])
def test_replicas_share_what_is_known_of_their_correlation(tau, slow):
    """Of three that are 400 samples long: intervals cover, and errors jump less than of each."""
    series = process(np.random.default_rng(11), 400, 3 * RUNS, tau, slow).reshape(400, RUNS, 3)
    alone, together = (
        [
            over_replicas(*block_mean_and_error(point, alike), axis=0)
            for point in np.moveaxis(series, 1, 0)
        ]
        for alike in (False, True)
    )
    mean, error = np.transpose(together)
    assert LEAST <= np.mean(abs(mean) < 1.96 * error) <= MOST
    assert 0.93 < rms_z(mean, error) < 1.07
    assert jumps(error) < 0.01 and jumps(error) <= jumps(np.transpose(alone)[1])


def test_degrees_of_freedom_are_carried():
    """Of a mean, of few replicas, of what is made of both, of a fit, and of what is known."""
    rng = np.random.default_rng(3)
    blocks, few, x = rng.normal(size=(50, 8)), rng.normal(size=(2, 5)), np.arange(8) + 1.0

    def make(scattered):
        mean, error = statistics.block_mean_and_error(blocks)
        _, two = statistics.independent_mean_and_error(few)
        return "made", {
            "blocks": error[0],
            "few": two[0],
            "both": np.hypot(*two) if two[0] != two[1] else np.nan,
            "fit": linear_fit([np.ones(8), x], mean, error).errors[1],
            "scatter": linear_fit([np.ones(8), x], mean).errors[1],
            "series": 2.0 * scattered(np.array(30.0)),
            "known": 0.1,
        }

    made, degrees = degrees_of(make)
    assert made == "made"
    of_blocks = float(statistics.spread_of_mean(blocks[:, 0]).degrees)
    for name, true in (("blocks", of_blocks), ("few", 4), ("scatter", 6), ("series", 30)):
        assert true / 2 < degrees[name] < 2 * true, name
    assert degrees["few"] < degrees["both"] < 16
    assert degrees["fit"] > 2 * of_blocks and degrees["known"] > 1e6
    assert degrees_of(make)[1] == degrees  # the same each time


LAGS = np.array([4, 8, 16, 20, 25, 30, 40, 60, 100, 200])


def recorded(rng, shared, samples=400, walkers=24):
    """Mean squares of random walks in a plane at lags up to half the run, as its file has them.

    Four groups of walkers share a part of their steps.
    """
    own, common = rng.normal(size=(2, walkers, samples)), rng.normal(size=(2, 4, samples))
    steps = np.sqrt(1 - shared) * own + np.sqrt(shared) * np.tile(common, (1, walkers // 4, 1))
    place = steps.cumsum(axis=2)
    squares = [((place[..., n:] - place[..., :-n]) ** 2).sum(axis=0) for n in LAGS]
    ends = [np.arange(n, samples) * 10 // samples for n in LAGS]
    counts = [np.bincount(e, minlength=10) for e in ends]
    sums = [np.bincount(e, s.mean(axis=0), minlength=10) for e, s in zip(ends, squares)]
    return xr.Dataset({
        "time": (("replica", "lag"), LAGS[None] * 1.0),
        "each": (("replica", "lag", "walker"), [[s.mean(axis=1) for s in squares]]),
        "sums": (("replica", "part", "lag"), np.transpose(sums)[None]),
        "count": (("replica", "part", "lag"), np.transpose(counts)[None]),
    })  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("shared", [0.0, 0.4, 0.7])
def test_errors_at_lags_of_which_a_run_has_few(monkeypatch, shared):
    """Half a run: right to a third, whether walkers share steps or not; of slopes, and of D."""
    monkeypatch.setattr(diffusion, "part_length", lambda runs: 40.0)
    rng, found = np.random.default_rng(7), []
    for _ in range(250):
        names = ("lag", "walker", "time", "each", "sums", "count")
        one = diffusion.resampled(recorded(rng, shared), *names, reach=5.0)
        assert one.time[-1] == 200
        for of in (
            lambda g: g[-1] / 400,
            lambda g: np.log(g[-1] / g[-3]) / np.log(200 / 60),
            lambda g: np.polyfit(LAGS[:8], g[:8], 1)[0],
        ):
            value, error = one.derived(of)
            found.append((value - of(2 * one.time)) / error)
    found = np.reshape(found, (-1, 3))
    rms = np.sqrt(np.mean(found**2, axis=0))
    assert (np.mean(np.abs(found) < 1.96, axis=0) > 0.9).all()
    assert (rms > 0.75).all() and (rms < 1.33).all()


def melt(seed, duration):
    """kT, pressure and bond energy of a small melt, every 0.08 tau."""
    simulation, watched, steps = begun(SCENE | {
        "box": 5, "molecules": [{"architecture": "A 4", "density": 3}], "bond": {"stiffness": 4},
        "steps": {"equilibrate": 250, "sample": round(duration / 0.04)}, "seed": seed,
        "observe": [{"thermo": {"every": 2}}],
    })  # fmt: skip
    run(simulation, steps, watched)
    found = values_of(watched[0])
    return {name: found[name] for name in ("kT", "pressure", "bond_energy")}


@pytest.mark.thorough
def test_intervals_of_simulations_cover():
    """Runs of a melt: 400 of 40 tau against one of 6000 with its own error, and pieces of that.

    93 % of the intervals hold the truth, or more; of 400 that is known to 1.3 %, which each kind of
    processor draws anew. Three times that may be missing, of all three quantities twice.
    """
    long = melt(1, 6000)
    short = [melt(100 + seed, 40) for seed in range(400)]
    held = []
    for name, series in long.items():
        truth, own, _ = mean_and_error(series)
        found = np.array([mean_and_error(one[name])[:2] for one in short])
        known = np.isfinite(found[:, 1])
        assert known.sum() >= 390
        away = np.abs(found[known, 0] - truth)
        held.append(np.mean(away < 1.96 * np.hypot(found[known, 1], own)))
        assert held[-1] >= 0.89
        pieces = coverage_of_pieces(series, round(20 * slow_time(series)))
        assert pieces.share + 2 * pieces.error >= LEAST
    assert np.mean(held) >= 0.905


# Of counts.


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
