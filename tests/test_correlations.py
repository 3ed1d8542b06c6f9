"""Correlations by multiple tau are those of the whole series: of any, of chains, of places."""

from types import SimpleNamespace

import numpy as np
import pytest

from dpd.engine.loop import run
from dpd.observe.common.accumulators import COARSER, FINE, KEPT, PARTS, MultipleTau
from dpd.observe.common.snapshot import Snapshot as Seen
from dpd.observe.displacement import displacements, followed
from dpd.scene.scene import Scene
from tests.conftest import SCENE
from tests.systems import begun, by_identity, unfolded_places, values_of
from tests.test_constant_pressure import FLUID
from tests.test_shear import FLUID as SHEARED

# Lags of each level, and how many samples apart those are that it begins with.
LEVELS = [
    (range(1, 17), 1), (range(20, 65, 4), 4), (range(80, 257, 16), 16), (range(320, 1025, 64), 64),
    (range(1280, 4097, 256), 256),
]  # fmt: skip
LAGS = [(lag, apart) for lags, apart in LEVELS for lag in lags]
OF_RUN = [(lag, apart) for lag, apart in LAGS if apart < 256]  # of 1700 samples, more than half


def two_quantities(now, then):
    """A product, and a difference that tells the later sample from the earlier one."""
    return np.stack([(now * then).sum(axis=1), now[0] - then[:, 0]], axis=1)


def correlate(series, expected):
    """`MultipleTau` over a series."""
    found = MultipleTau(expected, series.shape[1:], 2)
    for taken, sample in enumerate(series):
        found.add(taken, sample, two_quantities)
    return found


def assert_every_lag(quantity, lag, means, counts, sums, samples, lags):
    """For each molecule, and by the tenth of the run in which pairs end; see `LEVELS`."""
    np.testing.assert_allclose(lag, [n for n, _ in lags], rtol=1e-12)
    short = 1
    while samples > FINE * short:
        short *= 2
    for number, (n, apart) in enumerate(lags):
        then = np.arange(0, samples - n, apart)
        part = (then + n) // short * PARTS // -(-samples // short)
        values = quantity(then, then + n)
        np.testing.assert_allclose(means[number], values.mean(axis=0), rtol=0, atol=1e-10)
        np.testing.assert_array_equal(counts[:, number], np.bincount(part, minlength=PARTS))
        expected = np.bincount(part, values.mean(axis=1), minlength=PARTS)
        np.testing.assert_allclose(sums[:, number], expected, rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize(
    ("samples", "levels"), [(9, 1), (32, 1), (33, 2), (128, 2), (129, 3), (1700, 4), (2049, 5)]
)
def test_every_lag_of_a_random_series(samples, levels):
    """Means of each molecule, numbers and sums of pairs in each part; lags reach half the run."""
    rng = np.random.default_rng(samples)
    series = rng.normal(size=(samples, 2, 3)) + rng.normal(size=(1, 2, 3))
    lag, means, counts, sums = correlate(series, samples).results(samples)
    lags = [(n, apart) for n, apart in LAGS if n < samples and apart < COARSER**levels]
    if samples > KEPT:
        assert lag.max() >= samples // 2
    for quantity in range(2):

        def of(then, now, quantity=quantity):
            product = (series[now] * series[then]).sum(axis=1)
            return [product, (series[now] - series[then])[:, 0]][quantity]

        kept = means[:, quantity], counts, sums[:, :, quantity]
        assert_every_lag(of, lag, *kept, samples, lags)
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


CHAINS = SCENE | {
    "box": [2.5, 3.5, 4.0],
    "molecules": [
        {"architecture": "A", "count": 4}, {"architecture": "A 8", "count": 3},
        {"architecture": "A", "count": 6}, {"architecture": "A 3", "count": 4},
    ],
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 30, "sample": 3400},
    "observe": [{"end_to_end": {"every": 2}}],
}  # fmt: skip
# The beads of each chain; 0 to 3 and 28 to 33 are single.
OF_CHAINS = [*[range(f, f + 8) for f in (4, 12, 20)], *[range(f, f + 3) for f in (34, 37, 40, 43)]]
MOVING = CHAINS | {
    "dimension": 2,
    "box": [4.0, 5.0],
    "molecules": [
        {"architecture": "A 5", "count": 3}, {"architecture": "A 4", "count": 2},
        {"architecture": "A", "count": 7}, {"architecture": "A 2", "count": 2},
    ],
    "observe": [{"displacement": {"every": 2}}],
}  # fmt: skip
# The beads of each molecule, and those of its innermost beads that are averaged.
MOLECULES = [
    *[(range(f, f + 5), [f + 2]) for f in (0, 5, 10)],
    *[(range(f, f + 4), [f + 1, f + 2]) for f in (15, 19)],
    *[([f], [f]) for f in range(23, 30)],
    *[(range(f, f + 2), [f, f + 1]) for f in (30, 32)],
]


def watched(data, look):
    """What the first observable of a run leaves, and what ``look`` saw at the same steps."""
    seen, (simulation, (observer, *_), steps) = [], begun(data)
    watch = SimpleNamespace(every=2, arrays={}, sample=lambda now: seen.append(look(now)))
    run(simulation, steps, [observer, watch])
    return values_of(observer), np.array(seen)


def test_every_lag_is_that_of_the_whole_run():
    """Of end-to-end vectors, from bead to bead by the shortest way, of chains of both kinds."""
    found, places = watched(CHAINS, lambda now: by_identity(now, "position"))
    edges = np.array(CHAINS["box"])[:, None]
    flights = [np.diff(places[:, :, list(beads)], axis=2) for beads in OF_CHAINS]
    assert all((np.abs(each) > edges / 2).any() for each in flights)  # across the boundary
    vectors = [(each - edges * np.round(each / edges)).sum(axis=2) for each in flights]
    vectors = np.stack(vectors, axis=2)
    # Some reach further than half an edge: the nearest image of one end is not the vector to it.
    assert (np.abs(vectors) > edges / 2).sum() > 10
    square = (vectors**2).sum(axis=1).mean(axis=0)
    np.testing.assert_allclose(found["end_square"], square, rtol=1e-11)
    lag, *kept = (found[f"end_{n}"] for n in ("lag_time", "correlation", "samples", "sums"))
    assert_every_lag(
        lambda then, now: (vectors[now] * vectors[then]).sum(axis=1),
        lag / 0.04,
        *kept,
        1700,
        OF_RUN,
    )


def test_every_lag_is_that_of_the_whole_trajectory():
    """For chains with one innermost bead and with two, and centres, in a box that beads leave."""
    found, places = watched(MOVING, unfolded_places)
    assert np.abs(places).max() > 1.5 * max(MOVING["box"])
    places -= np.mean(places, axis=2, keepdims=True)
    centres = np.stack([places[:, :, list(beads)].mean(axis=2) for beads, _ in MOLECULES], axis=2)

    def of_inner(then, now):
        square = ((places[now] - places[then]) ** 2).sum(axis=1)
        return np.stack([square[:, middle].mean(axis=1) for _, middle in MOLECULES], axis=1)

    def of_centres(then, now):
        return ((centres[now] - centres[then]) ** 2).sum(axis=1)

    for name, quantity in (("msd_inner", of_inner), ("msd_centre", of_centres)):
        kept = (found[each] for each in (name, "lag_samples", f"{name}_sums"))
        assert_every_lag(quantity, found["lag_time"] / 0.04, *kept, 1700, OF_RUN)


class Far:
    """An observer that keeps displacements since its first sample, as shares of the edges."""

    def __init__(self, scene, every):
        self.scene, self.every, self.moved = scene, every, []
        self.arrays = followed(scene)

    def sample(self, simulation):
        now = Seen(self.scene, simulation)
        now.sample, now.kept = len(self.moved), self.arrays
        self.moved.append(displacements(now) / self.arrays["edges"][:, None])


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["at rest", "shear", "constant pressure"])
def test_samples_any_distance_apart_follow_as_those_of_every_step(kind):
    """Some beads cross the box and a third of it, or images turn round, between two of them."""
    data = {
        "at rest": MOVING,
        "shear": SHEARED | {"dimension": 2, "box": [4.5, 4]},
        "constant pressure": FLUID,
    }[kind]
    data |= {"steps": {"equilibrate": 10, "sample": 3000}, "observe": ["thermo"]}
    each, far = Far(Scene(data), 1), Far(Scene(data), 500)
    simulation, _, steps = begun(data)
    run(simulation, steps, [each, far])
    expected = np.array(each.moved)[499::500] - each.moved[499]
    np.testing.assert_allclose(far.moved, expected, rtol=0, atol=1e-10)
    assert np.abs(np.diff(far.moved, axis=0)).max() > 1 / 3
