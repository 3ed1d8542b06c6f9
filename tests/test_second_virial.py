"""Second virial coefficients of chains: samples, quadrature and fits."""

import numpy as np
import pytest

from dpd.theory.equation_of_state import second_virial
from paper_figures.crgw_2019.sampled_virial import sampled_second_virial


def agree(estimate, expected):
    """Within four standard errors, which are themselves small."""
    assert estimate.error < 0.01 * estimate.value
    return abs(estimate.value - expected) < 4 * estimate.error


@pytest.mark.parametrize("a", [1.0, 100.0])
def test_single_beads_have_the_closed_form(a):
    """And a sample of another seed is another one."""
    one, other = (sampled_second_virial(a, 1, 0, seed=seed) for seed in (1, 2))
    assert agree(one, second_virial(a)) and agree(other, second_virial(a)) and one != other
    assert one == sampled_second_virial(a, 1, 0)


def test_the_closed_form_in_two_dimensions():
    """Minus half the integral of the Mayer function over the plane."""
    r = (np.arange(2000) + 0.5) / 2000
    integral = np.mean(2 * np.pi * r * np.expm1(-12.5 * (1 - r) ** 2))
    assert second_virial(25.0, dimension=2) == pytest.approx(-integral / 2, rel=1e-6)


def dumbbells(a, length, angles, distances):
    """B2 of two rigid pairs of beads by quadrature over their places and directions."""
    place, of_place = np.polynomial.legendre.leggauss(2 * angles)
    tilt, of_tilt = np.polynomial.legendre.leggauss(angles)
    tilt, of_tilt = (tilt + 1) / 2, of_tilt / 2  # a dumbbell looks the same from behind
    turn = np.pi * (np.arange(angles) + 0.5) / angles
    node, of_node = np.polynomial.legendre.leggauss(distances)
    far, total = 1 + length, 0.0
    sine = np.sqrt(1 - tilt**2)[None, :, None]
    second = (sine * np.cos(turn), sine * np.sin(turn), tilt[None, :, None])
    for part, weight in zip((node + 1) / 2, of_node / 2):
        r = far * part
        across = r * np.sqrt(1 - place[:, None, None] ** 2)
        along = r * place[:, None, None]
        energy = 0.0
        for i in (-length / 2, length / 2):
            for j in (-length / 2, length / 2):
                vector = across + j * second[0], j * second[1], along + j * second[2] - i
                apart = np.sqrt(sum(component**2 for component in vector))
                energy = energy + 0.5 * a * np.maximum(1 - apart, 0) ** 2
        mayer = np.expm1(-energy).mean(axis=2)
        total += weight * far * r**2 * (of_place / 2 @ mayer @ of_tilt)
    return -2 * np.pi * total


def test_two_beads_with_a_rigid_bond():
    """Against quadrature over the three angles and the distance."""
    expected = dumbbells(40.0, 0.6, 16, 60)
    estimate = sampled_second_virial(40.0, 2, 0.6, samples=50_000)
    assert abs(estimate.value - expected) < 4 * estimate.error + 1e-3 * expected


def test_weak_beads_add_up():
    """m^2 B2 of a bead as a goes to 0, for any chain; bonds of length 0 make one strong bead."""
    weak = sampled_second_virial(1e-3, 4, 0.5, samples=20_000)
    assert agree(weak, 16 * second_virial(1e-3))
    together = sampled_second_virial(10.0, 2, 0.0, samples=20_000)
    assert agree(together, second_virial(40.0))


def test_the_error_is_that_of_repeated_samples():
    """The spread of 24 estimates against the errors that they state."""
    estimates = [sampled_second_virial(25, 4, 0.4, samples=1280, seed=seed) for seed in range(24)]
    spread = np.std([estimate.value for estimate in estimates], ddof=1)
    stated = np.mean([estimate.error for estimate in estimates])
    assert 0.6 < spread / stated < 1.6
