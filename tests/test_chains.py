"""Sizes of chains are those of rods, whose radius of gyration is known."""

import numpy as np
import pytest

from dpd.engine.simulation import Snapshot
from dpd.engine.state import State
from dpd.observe.chains import sizes
from dpd.observe.common.measured import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of


def rods(count, length, spacing, box, seed=0):
    """(dimension, count, length) beads in a row, in any direction, anywhere in the box."""
    rng = np.random.default_rng(seed)
    along = rng.normal(size=(len(box), count))
    along /= np.sqrt((along**2).sum(axis=0))
    first = rng.random((len(box), count)) * np.array(box)[:, None]
    return first[:, :, None] + spacing * along[:, :, None] * np.arange(length)


def wrapped(beads, box):
    """Beads in the box."""
    edges = np.array(box).reshape(-1, *[1] * (beads.ndim - 1))
    return beads - edges * np.floor(beads / edges)


@pytest.mark.parametrize("length", [1, 2, 3, 12])
def test_sizes_of_rods(length):
    """R_g^2 = d^2 (n^2 - 1) / 12 and R^2 = d^2 (n - 1)^2 to rounding."""
    gyration, across = sizes(rods(7, length, 0.9, (3.0, 3.5, 4.0)))
    assert gyration == pytest.approx(0.81 * (length**2 - 1) / 12, rel=1e-12, abs=1e-14)
    assert across == pytest.approx(0.81 * (length - 1) ** 2, rel=1e-12, abs=1e-14)


SCENE = {
    "dimension": 3,
    "box": [3.0, 3.5, 4.0],
    "molecules": [
        {"architecture": "A 6", "count": 4},
        {"architecture": "A", "count": 5},
        {"architecture": "A 9", "count": 3},
    ],
    "repulsion": {"A A": 25},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"sample": 400},
    "observe": [{"chains": {"every": 4}}],
}


def sample(observer, count):
    """Rods that grow from sample to sample, and move across the boundary; beads in any order."""
    box = tuple(SCENE["box"])
    for t in range(count):
        kinds = [rods(4, 6, growth(t), box, t), rods(5, 1, 1.0, box, t), rods(3, 9, 0.7, box, t)]
        place = np.concatenate([wrapped(kind, box).reshape(3, -1) for kind in kinds], axis=1)
        order = np.random.default_rng(t).permutation(56)
        identity = order.astype(np.uint32)
        state = State(place[:, order], np.zeros((3, 56)), None, identity, None, t)
        observer.sample(Snapshot(system_of(Scene(SCENE)), state))


def growth(t):
    """Spacing of the rods of the first kind at a sample."""
    return 0.5 + t / 400


def test_kinds_of_molecules_in_blocks_of_the_run():
    """Each of 50 blocks has the mean of its two samples for each kind; single beads have none."""
    scene = Scene(SCENE)
    whole = observables(scene, system_of(scene))[0]
    sample(whole, 100)
    found = {name: variable[1] for name, variable in whole.variables().items()}
    squares = np.array([growth(t) ** 2 for t in range(100)]).reshape(50, 2).mean(axis=1)
    for name, first, last in [
        ("gyration_square", 35 / 12, 0.49 * 80 / 12),
        ("end_to_end_square", 25, 0.49 * 64),
    ]:
        expected = np.stack([first * squares, 0 * squares, last + 0 * squares], axis=1)
        np.testing.assert_allclose(found[name], expected, rtol=1e-11, atol=1e-14)
