"""Displacements by multiple-tau correlation are those of the whole trajectory."""

import numpy as np
import pytest

from dpd.engine.loop import run
from dpd.engine.simulation import Simulation, Snapshot
from dpd.engine.space import wrapped
from dpd.engine.state import State
from dpd.observe.common.measured import Measured, observables
from dpd.observe.common.snapshot import Snapshot as Seen
from dpd.observe.displacement import Displacement, displacements, followed
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.systems import by_identity
from tests.test_constant_pressure import FLUID
from tests.test_shear import PLANE

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


class Trajectory:
    """An observer that follows beads by itself, in steps too short to lose one."""

    def __init__(self, box):
        self.every, self.arrays = 1, {}
        self.edges = np.array(box)[:, None]
        self.steps, self.places, self.last = [], [], None

    def sample(self, simulation):
        now = by_identity(simulation, "position")
        if self.last is None:
            place = now
        else:
            apart = now - self.last
            place = self.places[-1] + apart - self.edges * np.round(apart / self.edges)
        self.last = now
        self.steps.append(simulation.state.step)
        self.places.append(place)


def brute_force(places, lag, apart):
    """Squared displacements of all pairs of samples, (pairs, molecules), and where they end.

    Of innermost beads and of centres, over all pairs of samples ``lag`` apart whose first is
    a multiple of ``apart``.
    """
    places = places - places.mean(axis=2, keepdims=True)
    first = np.arange(0, len(places) - lag, apart)
    squares = ((places[first + lag] - places[first]) ** 2).sum(axis=1)
    inner = np.stack([squares[:, middle].mean(axis=1) for _, middle in MOLECULES], axis=1)
    centres = np.stack([places[:, :, list(beads)].mean(axis=2) for beads, _ in MOLECULES], axis=2)
    centre = ((centres[first + lag] - centres[first]) ** 2).sum(axis=1)
    return inner, centre, first + lag


def test_every_lag_is_that_of_the_whole_trajectory():
    """To 1e-10, for chains with one innermost bead and with two, and for their centres.

    A level that looks at every 4th sample sees every 4th pair: those are compared. The box
    is small enough for beads to leave it, and lags go up to half the run at least. The
    same pairs once more by the tenth of the run in which they end, in sums of up to 170.
    """
    scene = Scene(SCENE)
    system = system_of(scene)
    observer, trajectory = observables(scene, system)[0], Trajectory(scene.box)
    run(Simulation(system, make_start(scene)), scene.steps, [observer, trajectory])
    at = [i for i, step in enumerate(trajectory.steps) if (step - 30) % 2 == 0]
    places = np.array(trajectory.places)[at]
    assert len(places) == 1700
    assert np.abs(places).max() > 1.5 * max(scene.box)
    found = {name: variable[1] for name, variable in observer.variables().items()}
    count = len(found["lag_time"])
    lags = [*range(1, 17), *range(20, 65, 4), *range(80, 257, 16), *range(320, 1025, 64)][:count]
    assert lags[-1] >= 850
    np.testing.assert_allclose(found["lag_time"], np.array(lags) * 2 * 0.02, rtol=1e-12)
    for number, lag in enumerate(lags):
        apart = 1 if lag < 17 else 4 if lag < 65 else 16 if lag < 257 else 64
        *squares, end = brute_force(places, lag, apart)
        parts = end // 8 * 10 // 213  # of 1700 samples, in short parts of 8 each
        np.testing.assert_array_equal(
            found["lag_samples"][:, number], np.bincount(parts, minlength=10)
        )
        for name, pairs in zip(("msd_inner", "msd_centre"), squares):
            mean, sums = found[name][number], found[f"{name}_sums"][:, number]
            np.testing.assert_allclose(mean, pairs.mean(axis=0), rtol=0, atol=1e-10)
            expected = np.bincount(parts, pairs.mean(axis=1), minlength=10)
            np.testing.assert_allclose(sums, expected, rtol=1e-10, atol=1e-8)


FREE = SCENE | {
    "molecules": [{"architecture": "A", "count": 10}],
    "box": [4.0, 5.0],
    "steps": {"sample": 1700},
    "observe": [{"displacement": {"every": 1}}],
}
del FREE["bond"]


def watch(velocity, samples, observer=None, first=0):
    """Beads that move by ``velocity`` from sample to sample, stored in some other order."""
    scene = Scene(FREE)
    if observer is None:
        observer = Measured(Displacement(every=1), scene, system_of(scene))
    rng = np.random.default_rng(3)
    begun = rng.random((2, 10)) * np.array(scene.box)[:, None]
    for t in range(first, first + samples):
        place, image = wrapped(begun + t * velocity, scene.box)
        order = np.random.default_rng(t).permutation(10)
        identity = order.astype(np.uint32)
        state = State(place[:, order], np.zeros((2, 10)), None, identity, None, t, image=image)
        observer.sample(Snapshot(system_of(scene), state))
    return scene, observer


def test_a_bead_that_crosses_the_box_many_times_is_followed():
    """Bead 3 goes 1.3 a sample along both axes, 440 to 550 boxes in all; the others rest.

    Less the centre of mass it moves at 9/10 of that and the others at 1/10 backwards. Places
    are up to 2210 and rounded by 1e-13, displacements 0.1 and more.
    """
    velocity = np.zeros((2, 10))
    velocity[:, 3] = 1.3
    _, observer = watch(velocity, 1700)
    lag = observer.variables()["lag_time"][1] / 0.02
    assert lag.max() >= 170
    share = np.full(10, 0.1)
    share[3] = 0.9
    expected = 2 * (1.3 * share * lag[:, None]) ** 2
    for name in ("msd_inner", "msd_centre"):
        np.testing.assert_allclose(observer.variables()[name][1], expected, rtol=1e-9)


def test_a_drift_of_the_whole_box_does_not_count():
    """Zero to the rounding of places up to 2040, squared."""
    _, observer = watch(np.array([[1.2], [-0.7]]), 1700)
    for name in ("msd_inner", "msd_centre"):
        np.testing.assert_allclose(observer.variables()[name][1], 0, rtol=0, atol=1e-20)


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
    data = {"at rest": SCENE, "shear": PLANE, "constant pressure": FLUID}[kind]
    scene = Scene(data | {"steps": {"equilibrate": 10, "sample": 3000}, "observe": ["thermo"]})
    system = system_of(scene)
    each, far = Far(scene, 1), Far(scene, 500)
    run(Simulation(system, make_start(scene)), scene.steps, [each, far])
    expected = np.array(each.moved)[499::500] - each.moved[499]
    np.testing.assert_allclose(far.moved, expected, rtol=0, atol=1e-10)
    assert np.abs(np.diff(far.moved, axis=0)).max() > 1 / 3
