"""Displacements by multiple-tau correlation are those of the whole trajectory."""

from types import SimpleNamespace

import numpy as np
import pytest

from dpd.engine.loop import run
from dpd.observe.common.snapshot import Snapshot as Seen
from dpd.observe.displacement import displacements, followed
from dpd.scene.scene import Scene
from tests.systems import begun, values_of
from tests.test_constant_pressure import FLUID
from tests.test_end_to_end import LAGS, pairs_of
from tests.test_shear import FLUID as SHEARED

SCENE = {
    "dimension": 2,
    "box": [4.0, 5.0],
    "molecules": [
        {"architecture": "A 5", "count": 3},
        {"architecture": "A 4", "count": 2},
        {"architecture": "A", "count": 7},
        {"architecture": "A 2", "count": 2},
    ],
    "repulsion": {"A A": 25},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 30, "sample": 3400},
    "observe": [{"displacement": {"every": 2}}],
}
# The beads of each molecule, and those of its innermost beads that are averaged.
MOLECULES = [
    *[(range(f, f + 5), [f + 2]) for f in (0, 5, 10)],
    *[(range(f, f + 4), [f + 1, f + 2]) for f in (15, 19)],
    *[([f], [f]) for f in range(23, 30)],
    *[(range(f, f + 2), [f, f + 1]) for f in (30, 32)],
]


def test_every_lag_is_that_of_the_whole_trajectory():
    """To 1e-10, for chains with one innermost bead and with two, and for their centres.

    A level that looks at every 4th sample sees every 4th pair: those are compared. The box
    is small enough for beads to leave it, and lags go up to half the run at least. The
    same pairs once more by the tenth of the run in which they end, in sums of up to 170.
    """
    places, (simulation, (observer, *_), steps) = [], begun(SCENE)
    watch = SimpleNamespace(every=2, arrays={}, sample=lambda now: places.append(now.unfolded))
    run(simulation, steps, [observer, watch])
    assert np.abs(places).max() > 1.5 * max(SCENE["box"])
    places = np.array(places) - np.mean(places, axis=2, keepdims=True)
    centres = np.stack([places[:, :, list(beads)].mean(axis=2) for beads, _ in MOLECULES], axis=2)
    found = values_of(observer)
    lags = [(lag, apart) for lag, apart in LAGS if apart < 256]
    assert lags[-1][0] >= 850
    np.testing.assert_allclose(found["lag_time"], [lag * 2 * 0.02 for lag, _ in lags], rtol=1e-12)
    for number, (lag, apart) in enumerate(lags):
        then, now, part = pairs_of(1700, lag, apart, 1700)
        counts = found["lag_samples"][:, number]
        np.testing.assert_array_equal(counts, np.bincount(part, minlength=10))
        of_beads = ((places[now] - places[then]) ** 2).sum(axis=1)
        inner = np.stack([of_beads[:, middle].mean(axis=1) for _, middle in MOLECULES], axis=1)
        centre = ((centres[now] - centres[then]) ** 2).sum(axis=1)
        for name, squares in (("msd_inner", inner), ("msd_centre", centre)):
            mean, sums = found[name][number], found[f"{name}_sums"][:, number]
            np.testing.assert_allclose(mean, squares.mean(axis=0), rtol=0, atol=1e-10)
            expected = np.bincount(part, squares.mean(axis=1), minlength=10)
            np.testing.assert_allclose(sums, expected, rtol=1e-10, atol=1e-8)


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
        "at rest": SCENE,
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
