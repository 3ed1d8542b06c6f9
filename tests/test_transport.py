"""Viscosity and diffusion from fluctuations and from spreading labels, and their closed forms."""

import numpy as np
import pytest

from dpd.analysis.viscosity import shear_components, viscosity_of_fluctuations
from paper_figures.groot_warren_1997.shared import noise_ratio
from paper_figures.groot_warren_1997.spreading import diffusion_of_labels
from paper_figures.groot_warren_1997.transport_theory import (
    diffusion_constant,
    kinematic_viscosity,
    schmidt_number,
    slowed_by_images,
)

RNG = np.random.default_rng(42)
DT, VOLUME, KT = 0.04, 125.0, 1.02


def tensors(steps, spread, memory=0.0):
    """Pressure tensors of an isotropic fluid whose shear stresses scatter by ``spread``.

    Each step remembers the share ``memory`` of the one before.
    """
    fresh = RNG.normal(size=(steps, 3, 3)) * spread
    fresh[:, [0, 1, 2], [0, 1, 2]] *= np.sqrt(2)
    for a, b in ((0, 1), (0, 2), (1, 2)):
        fresh[:, b, a] = fresh[:, a, b]
    found = np.empty_like(fresh)
    found[0] = fresh[0]
    for n in range(1, steps):
        found[n] = memory * found[n - 1] + np.sqrt(1 - memory**2) * fresh[n]
    return found + 20 * np.eye(3)


def test_components_have_one_variance():
    """Five that do not depend on each other, and none of the mean pressure."""
    parts = shear_components(tensors(20000, 0.3))
    assert np.cov(parts.T) == pytest.approx(0.09 * np.eye(5), abs=0.004)
    assert np.abs(parts.mean(axis=0)).max() < 0.02


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_viscosity_of_known_noise(memory):
    """s^2 dt V / (2 kT) of white noise, and more by (1 + m) / (1 - m) with a memory m."""
    exact = 0.3**2 * DT * VOLUME / (2 * KT) * (1 + memory) / (1 - memory)
    found = [
        viscosity_of_fluctuations(tensors(20000, 0.3, memory), DT, VOLUME, KT, 1.2)
        for _ in range(6)
    ]
    for each in found:
        assert 0 < each.error < 0.15 * exact
        assert abs(each.value - exact) < 4.5 * each.error
    mean = np.mean([each.value for each in found])
    assert mean == pytest.approx(exact, rel=0.06)


def test_ratio_of_noises():
    """Of means: what is correlated counts with its sum, what is not with its root."""
    white = RNG.normal(size=(40000, 5))
    slow = np.repeat(RNG.normal(size=(4000, 5)), 10, axis=0)
    found = noise_ratio(slow, white, 100)
    assert found.value == pytest.approx(np.sqrt(10), abs=4 * found.error)
    assert 0 < found.error < 0.2
    assert noise_ratio(2 * white, white, 1).value == pytest.approx(2)


def test_labels_spread():
    """The wave's decay gives D, whatever else is in the profile; errors come from the runs."""
    z = np.arange(14) + 0.5
    time, q = np.linspace(0.4, 40, 50), 2 * np.pi / 14
    wave = 1.9 * np.exp(-0.3 * q**2 * time)[:, None] * np.sin(q * z)
    wave = wave + 0.3 * np.exp(-2.7 * q**2 * time)[:, None] * np.sin(3 * q * z)
    both = np.stack([1.5 + wave / 2, 1.5 - wave / 2], axis=1)
    exact = diffusion_of_labels(both[None], z, time, 14.0)
    assert exact.diffusion.value == pytest.approx(0.3, rel=1e-6)
    assert np.isnan(exact.diffusion.error)
    assert exact.height == pytest.approx(1.9)
    runs = both + 0.05 * RNG.normal(size=(8, *both.shape))
    found = diffusion_of_labels(runs, z, time, 14.0)
    assert 0 < found.diffusion.error < 0.02
    assert abs(found.diffusion.value - 0.3) < 4 * found.diffusion.error
    assert found.wave.shape == (8, 50)


def test_theory_of_the_paper():
    """Groot and Warren 1997, Sec. VII, at gamma 6.75 and density 3."""
    assert float(diffusion_constant(6.75, 3)) == pytest.approx(0.354, abs=5e-4)
    assert float(kinematic_viscosity(6.75, 3)) == pytest.approx(0.258, abs=5e-4)
    assert float(schmidt_number(6.75, 3)) == pytest.approx(0.728, abs=5e-4)
    gamma = np.array([1.0, 20.0])
    eq_37 = 0.5 + (2 * np.pi * gamma * 3) ** 2 / 70875
    assert schmidt_number(gamma, 3) == pytest.approx(eq_37)


def test_images_slow_a_bead_less_in_a_larger_box():
    """As one over the edge, and over the density times the sum of nu and D."""
    one = float(slowed_by_images(10, 3, 0.2, 0.1))
    assert one == pytest.approx(2.837297 / (6 * np.pi * 9))
    assert slowed_by_images(20, 1.5, 0.05, 0.25, 2.0) == pytest.approx(2 * one)
