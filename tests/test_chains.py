"""Sizes of chains are those of rods, whose radius of gyration is known."""

import numpy as np
import pytest

from dpd.observe.chains import sizes
from tests.conftest import SCENE as FLUID
from tests.systems import look


def rods(count, length, spacing, box, seed=0):
    """(dimension, count, length) beads in a row, in any direction, anywhere in the box."""
    rng = np.random.default_rng(seed)
    along = rng.normal(size=(len(box), count))
    along /= np.sqrt((along**2).sum(axis=0))
    first = rng.random((len(box), count)) * np.array(box)[:, None]
    return first[:, :, None] + spacing * along[:, :, None] * np.arange(length)


@pytest.mark.parametrize("length", [1, 2, 3, 12])
def test_sizes_of_rods(length):
    """R_g^2 = d^2 (n^2 - 1) / 12 and R^2 = d^2 (n - 1)^2 to rounding."""
    gyration, across = sizes(rods(7, length, 0.9, (3.0, 3.5, 4.0)))
    assert gyration == pytest.approx(0.81 * (length**2 - 1) / 12, rel=1e-12, abs=1e-14)
    assert across == pytest.approx(0.81 * (length - 1) ** 2, rel=1e-12, abs=1e-14)


SCENE = FLUID | {
    "box": [3.0, 3.5, 4.0],
    "molecules": [
        {"architecture": "A 6", "count": 4},
        {"architecture": "A", "count": 5},
        {"architecture": "A 9", "count": 3},
    ],
    "bond": {"stiffness": 50, "length": 0.5},
    "steps": {"sample": 400},
}


def growth(t):
    """Spacing of the rods of the first kind at a sample."""
    return 0.5 + t / 400


def places(t):
    """Rods that grow from sample to sample, and move across the boundary."""
    box = SCENE["box"]
    kinds = [rods(4, 6, growth(t), box, t), rods(5, 1, 1.0, box, t), rods(3, 9, 0.7, box, t)]
    return np.concatenate([kind.reshape(3, -1) for kind in kinds], axis=1)


def test_kinds_of_molecules_in_blocks_of_the_run():
    """Each of 50 blocks has the mean of its two samples for each kind; single beads have none."""
    found = look(SCENE, {"chains": {"every": 4}}, *map(places, range(100)))
    squares = np.array([growth(t) ** 2 for t in range(100)]).reshape(50, 2).mean(axis=1)
    for name, first, last in [
        ("gyration_square", 35 / 12, 0.49 * 80 / 12),
        ("end_to_end_square", 25, 0.49 * 64),
    ]:
        expected = np.stack([first * squares, 0 * squares, last + 0 * squares], axis=1)
        np.testing.assert_allclose(found[name], expected, rtol=1e-11, atol=1e-14)
