"""Correlations by multiple tau are those of the whole series: of any, and of chains."""

from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest

from dpd.engine.loop import run
from dpd.engine.simulation import Simulation, Snapshot
from dpd.observe.common.accumulators import COARSER, FINE, KEPT, PARTS, MultipleTau
from dpd.observe.common.measured import observables
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.systems import by_identity

# Lags of each level, and how many samples apart those are that it begins with.
LEVELS = [
    (range(1, 17), 1), (range(20, 65, 4), 4), (range(80, 257, 16), 16), (range(320, 1025, 64), 64),
    (range(1280, 4097, 256), 256),
]  # fmt: skip
LAGS = [(lag, apart) for lags, apart in LEVELS for lag in lags]


def pairs_of(samples, lag, apart, expected):
    """Numbers of the samples that a lag compares: then, now, and the part of the run of now."""
    then = np.arange(0, samples - lag, apart)
    short = 1
    while expected > FINE * short:
        short *= 2
    return then, then + lag, (then + lag) // short * PARTS // -(-expected // short)


def two_quantities(now, then):
    """A product, and a difference that tells the later sample from the earlier one."""
    return np.stack([(now * then).sum(axis=1), now[0] - then[:, 0]], axis=1)


def correlate(series, expected):
    """`MultipleTau` over a series."""
    found = MultipleTau(expected, series.shape[1:], 2)
    for taken, sample in enumerate(series):
        found.add(taken, sample, two_quantities)
    return found


@pytest.mark.parametrize(
    ("samples", "levels"), [(9, 1), (32, 1), (33, 2), (128, 2), (129, 3), (1700, 4), (2049, 5)]
)
def test_every_lag_of_a_random_series(samples, levels):
    """Means of each molecule, numbers and sums of pairs in each part, to 1e-11: a level that
    takes every 4th sample sees every 4th pair.

    Lags reach half the run; sums are of up to 256 numbers of order 1.
    """
    rng = np.random.default_rng(samples)
    series = rng.normal(size=(samples, 2, 3)) + rng.normal(size=(1, 2, 3))
    found = correlate(series, samples)
    lag, means, counts, sums = found.results(samples)
    expected = [(n, apart) for n, apart in LAGS if n < samples and apart < COARSER**levels]
    np.testing.assert_array_equal(lag, [n for n, _ in expected])
    if samples > KEPT:
        assert lag.max() >= samples // 2
    for number, (n, apart) in enumerate(expected):
        then, now, part = pairs_of(samples, n, apart, samples)
        values = np.stack(
            [(series[now] * series[then]).sum(axis=1), (series[now] - series[then])[:, 0]]
        )
        np.testing.assert_allclose(means[number], values.mean(axis=1), rtol=0, atol=1e-11)
        np.testing.assert_array_equal(counts[:, number], np.bincount(part, minlength=PARTS))
        for quantity, over in enumerate(values.mean(axis=2)):
            expected_sums = np.bincount(part, over, minlength=PARTS)
            np.testing.assert_allclose(sums[:, number, quantity], expected_sums, rtol=0, atol=1e-9)
    # Over all parts they are the means over molecules of what is kept of each.
    total = sums.sum(axis=0) / counts.sum(axis=0)[:, None]
    np.testing.assert_allclose(total, means.mean(axis=2), rtol=0, atol=1e-11)


def test_a_series_that_ends_early():
    """Six samples of 1700 are one to five apart, in 5, 4, 3, 2, 1 pairs; one sample has no lag."""
    series = np.random.default_rng(1).normal(size=(6, 2, 3))
    lag, means, counts, sums = correlate(series, 1700).results(6)
    np.testing.assert_array_equal(lag, [1, 2, 3, 4, 5])
    np.testing.assert_array_equal(counts.sum(axis=0), [5, 4, 3, 2, 1])
    np.testing.assert_allclose(means[4], two_quantities(series[5], series[:1])[0], rtol=1e-14)
    lag, means, counts, sums = correlate(series[:1], 1700).results(1)
    assert (lag.shape, means.shape) == ((0,), (0, 2, 3))
    assert (counts.shape, sums.shape) == ((PARTS, 0), (PARTS, 0, 2))


SCENE = {
    "dimension": 3,
    "box": [2.5, 3.5, 4.0],
    "molecules": [
        {"architecture": "A", "count": 4},
        {"architecture": "A 8", "count": 3},
        {"architecture": "A", "count": 6},
        {"architecture": "A 3", "count": 4},
    ],
    "repulsion": {"A A": 25},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 30, "sample": 3400},
    "observe": [{"end_to_end": {"every": 2}}],
}
# The beads of each chain; 0 to 3 and 28 to 33 are single.
CHAINS = [*[range(f, f + 8) for f in (4, 12, 20)], *[range(f, f + 3) for f in (34, 37, 40, 43)]]


@pytest.fixture(scope="module")
def chain_run():
    """A run of chains among single beads: its observer, its samples, and (samples, 3, chains)
    end-to-end vectors, from bead to bead by the shortest way."""
    scene, seen = Scene(SCENE), []
    system, edges = system_of(scene), np.array(scene.box)[:, None]
    observer = observables(scene, system)[0]
    watch = SimpleNamespace(
        every=2, arrays={}, sample=lambda now: seen.append(Snapshot(now.system, now.state))
    )
    run(Simulation(system, make_start(scene)), scene.steps, [observer, watch])
    places = np.array([by_identity(simulation, "position") for simulation in seen])
    flights = [np.diff(places[:, :, list(beads)], axis=2) for beads in CHAINS]
    assert all((np.abs(each) > edges / 2).any() for each in flights)  # across the boundary
    vectors = [(each - edges * np.round(each / edges)).sum(axis=2) for each in flights]
    return scene, observer, seen, np.stack(vectors, axis=2)


def test_every_lag_is_that_of_the_whole_run(chain_run):
    """To 1e-10, for each chain of both kinds; the same pairs once more by parts of the run."""
    scene, observer, _, vectors = chain_run
    # Some reach further than half an edge: the nearest image of one end is not the vector to it.
    assert (np.abs(vectors) > np.array(scene.box)[:, None] / 2).sum() > 10
    found = {name: variable[1] for name, variable in observer.variables().items()}
    assert vectors.shape == (1700, 3, len(CHAINS))
    expected = [(n, apart) for n, apart in LAGS if apart < 256]
    lags = np.array([n for n, _ in expected])
    np.testing.assert_allclose(found["end_lag_time"], lags * 2 * 0.02, rtol=1e-12)
    assert lags.max() >= 170
    square = (vectors**2).sum(axis=1).mean(axis=0)
    np.testing.assert_allclose(found["end_square"], square, rtol=1e-11)
    for number, (n, apart) in enumerate(expected):
        then, now, part = pairs_of(1700, n, apart, 1700)
        products = (vectors[now] * vectors[then]).sum(axis=1)
        mean = found["end_correlation"][number]
        np.testing.assert_allclose(mean, products.mean(axis=0), rtol=0, atol=1e-10)
        counts = found["end_samples"][:, number]
        np.testing.assert_array_equal(counts, np.bincount(part, minlength=PARTS))
        sums = np.bincount(part, products.mean(axis=1), minlength=PARTS)
        np.testing.assert_allclose(found["end_sums"][:, number], sums, rtol=1e-10, atol=1e-8)


def test_a_file_holds_them_beside_displacements(tmp_path):
    """Molecules are not as many there: single beads move, and have no ends."""
    observe = [{"end_to_end": {"every": 2}}, {"displacement": {"every": 2}}]
    scene = Scene(SCENE | {"steps": {"sample": 40}, "observe": observe})
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        assert file["end_correlation"].shape == (16, len(CHAINS))
        assert file["msd_centre"].shape == (16, len(CHAINS) + 10)
