"""Interfaces of synthetic slabs: found where they were put, as wide as they were made."""

import numpy as np
import pytest

from dpd.analysis.interfaces import (
    FARTHEST,
    composition,
    in_bulk,
    interface_width,
    interfaces,
    slabs,
)
from paper_figures.groot_warren_1997.fig06_interface import recentred

LENGTH, SLICES = 20.0, 100
THICKNESS = LENGTH / SLICES
Z = (np.arange(SLICES) + 0.5) * THICKNESS


def profile(first, second, width, phi, beads=None, seed=0):
    """Densities of A and B with two interfaces of a width and minority fraction phi.

    Averaged over each slice, as beads are counted; with ``beads`` in a slice, noise as of counts.
    """
    fine = (np.arange(SLICES * 20) + 0.5) * THICKNESS / 20
    inside = np.zeros_like(fine)
    for shift in (-LENGTH, 0, LENGTH):
        inside += np.tanh(2 * (fine - first - shift) / width)
        inside -= np.tanh(2 * (fine - second - shift) / width)
    inside = inside.reshape(SLICES, 20).mean(axis=1) / 2
    fraction = phi + (1 - 2 * phi) * inside
    both = 3 * np.stack([fraction, 1 - fraction])
    if beads is None:
        return both
    return np.random.default_rng(seed).poisson(both * beads / 3) * 3 / beads


def test_moving_interfaces_are_followed():
    """Each block's two positions come back, also across the edge of the box."""
    rng = np.random.default_rng(1)
    moved = rng.normal([0.0, LENGTH / 2], 0.4, (20, 2))
    density = np.array([profile(*at, 1.5, 0.04, 400, n) for n, at in enumerate(moved)])
    found = interfaces(density, Z, LENGTH)
    assert np.abs(found - moved).max() < 0.1
    assert np.std(found - moved) < 0.03


def test_moving_interfaces_are_put_back():
    """As if they had never moved; left where they are, they smear the mean."""
    moved = np.random.default_rng(2).normal([0.0, LENGTH / 2], 0.4, (20, 2))
    density = np.array([profile(*at, 1.5, 0.04) for at in moved])
    still = profile(0.0, LENGTH / 2, 1.5, 0.04)
    back = recentred(density, Z, LENGTH, moved)
    assert np.abs(back - still).max() < 0.05  # lines between slices cut corners
    assert np.abs(density.mean(axis=0) - still).max() > 0.15


@pytest.mark.parametrize("width", [0.9, 1.5, 3.0])
def test_width_of_moving_interfaces(width):
    """The width is that of each block, not that of the mean, which the moves have widened."""
    shifts = np.linspace(-0.6, 0.6, 20)
    density = np.array([profile(s, 10 - s, width, 0.02) for s in shifts])
    found, error = interface_width(slabs(density, Z, LENGTH))
    assert found == pytest.approx(width, rel=0.01)
    assert error < 0.01 * width
    smeared = slabs(density.mean(axis=0)[None].repeat(4, axis=0), Z, LENGTH)
    assert interface_width(smeared)[0] > 1.03 * width


def test_composition_does_not_see_slabs_of_unequal_width():
    """Interfaces 1 r_c off, and tails of wide ones, leave the fraction as it is."""
    density = np.array([profile(1.0, 9.5, 2.5, 0.03, 4000, n) for n in range(40)])
    seen = slabs(density, Z, LENGTH)
    found = composition(seen, 1.0)
    assert abs(found.fraction - 0.03) < 4 * found.error
    assert found.error < 0.001
    assert found.counted == pytest.approx(3 * 0.03 * 4 * in_bulk(seen.distance).sum(), rel=0.1)


def test_slabs_that_have_mixed_are_not_settled():
    """However steady the composition is: interfaces that are not found, or a fraction of a half."""
    density = np.array([profile(0.0, 10.0, 1.5, 0.02, 4000, n) for n in range(40)])
    found = composition(slabs(density, Z, LENGTH), 1.0)
    assert found.settled and not found.mixed
    lost = density.copy()
    lost[7] = profile(4.0, 6.0, 1.5, 0.02)
    even = np.random.default_rng(2).poisson(4000, (40, 2, SLICES)) / 1000.0
    for mixed in (lost, even):
        found = composition(slabs(mixed, Z, LENGTH), 1.0)
        assert found.mixed and not found.steady and not found.settled
    assert slabs(lost, Z, LENGTH).lost
    assert np.abs(interfaces(even, Z, LENGTH) - [0, 10]).max() <= FARTHEST * LENGTH
