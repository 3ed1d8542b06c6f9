"""Second virial coefficients, Flory and Huggins, bonds: by quadrature, samples, and as printed."""

import numpy as np
import pytest
from scipy.integrate import quad

from dpd.analysis.interfaces import chi_and_error
from dpd.theory.equation_of_state import MEAN_FIELD, second_virial
from paper_figures.crgw_2019.bonds import mean_length, rest_length
from paper_figures.crgw_2019.sampled_virial import sampled_second_virial
from paper_figures.groot_warren_1997 import flory_huggins as fh


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("a", [0.1, 25.0])
def test_second_virial_is_the_mayer_integral(a, dimension):
    """B2 = -1/2 integral of (exp(-u) - 1) over space."""
    surface = {2: lambda r: 2 * np.pi * r, 3: lambda r: 4 * np.pi * r**2}[dimension]
    integral, _ = quad(lambda r: surface(r) * np.expm1(-a * (1 - r) ** 2 / 2), 0, 1)
    assert second_virial(a, dimension) == pytest.approx(-integral / 2, rel=1e-10)


def test_weak_repulsion_is_mean_field():
    """B2 / a goes to the mean-field alpha as a goes to 0, in both dimensions."""
    for dimension, alpha in MEAN_FIELD.items():
        assert second_virial(1e-4, dimension) / 1e-4 == pytest.approx(alpha, rel=1e-3)


@pytest.mark.parametrize(("chi", "length"), [(2.2, 1), (3.0, 1), (8.0, 1), (0.5, 10)])
def test_binodal_and_spinodal(chi, length):
    """Coexisting phases have mu = 0 and give chi back; mu is extremal at the spinodal."""
    phi = fh.binodal(chi, length)
    assert fh.chemical_potential(phi, chi, length) == pytest.approx(0, abs=1e-9)
    assert chi_and_error(phi, 0.0, length)[0] == pytest.approx(chi)
    s, h = fh.spinodal(chi, length), 1e-5
    slope = fh.chemical_potential(s + h, chi, length) - fh.chemical_potential(s - h, chi, length)
    assert slope / (2 * h) == pytest.approx(0, abs=1e-3)
    assert phi < s < 0.5


def test_one_phase_has_no_binodal():
    """At and below the critical point there is nothing to find, and it says so."""
    assert fh.critical_chi() == 2
    assert fh.critical_chi(10, 10) == pytest.approx(0.2)
    with pytest.raises(ValueError, match="one phase"):
        fh.binodal(2.0)


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
    """The spread of 24 estimates against the errors that they state; other fluids have others."""
    (value, error), (one, _), (other, _) = (
        np.transpose([sampled_second_virial(a, m, 0.4, 1280, seed) for seed in range(24)])
        for a, m in ((25, 4), (10, 2), (20, 2))
    )
    assert 0.6 < np.std(value, ddof=1) / np.mean(error) < 1.6
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.4


# Mean lengths of harmonic bonds, alone and in a fluid.


def test_a_bond_without_repulsion():
    """Rest length 0: the mean of a Maxwell distribution, sqrt(8 / (pi C))."""
    assert mean_length(4, 0) == pytest.approx(np.sqrt(8 / (np.pi * 4)), rel=1e-6)


def test_the_soft_repulsion_is_a_second_spring():
    """Below r_c both are harmonic: one spring with the sum of the stiffnesses, and its mean."""
    stiffness, rest, a = 400.0, 0.3, 40.0
    both = (stiffness * rest + a) / (stiffness + a)
    assert mean_length(stiffness, rest, a) == pytest.approx(
        mean_length(stiffness + a, both), rel=1e-6
    )


def test_a_fluid_pushes_beads_together():
    """The denser, the shorter; of beads at density 0 it is the limit."""
    lengths = [mean_length(200, 0.3, 25, density) for density in (0, 1e-4, 3, 7)]
    assert lengths[1] == pytest.approx(lengths[0], abs=1e-5)
    assert lengths[0] > lengths[2] > lengths[3]


@pytest.mark.parametrize("density", [0, 5])
def test_there_and_back(density):
    """The rest length gives the mean that was asked for."""
    rest = rest_length(500, 25, 0.4, density)
    assert mean_length(500, rest, 25, density) == pytest.approx(0.4, rel=1e-9)


def test_the_rest_of_a_chain_pushes_a_bond_apart():
    """Means of runs of 240 beads with these rest lengths: 0.308 for m = 4, 0.318 for m = 8."""
    for beads, mean in ((2, 0.283), (4, 0.308), (8, 0.318)):
        assert rest_length(1000, 40, mean, 3, beads) == pytest.approx(0.26, abs=0.004)
    alone, far = rest_length(1000, 40, 0.6, 3), rest_length(1000, 40, 0.6, 3, 8)
    assert far == pytest.approx(alone, abs=4e-3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((0.001, 25, 0.4, 3), "bond length: with a stiffness of 0.001 .* beyond the grid"),
        ((10, 40, 0.3), "needs a rest length below 0; allowed: 0.8"),
    ],
)
def test_what_cannot_be(arguments, said):
    """With name, value, and what is allowed."""
    with pytest.raises(ValueError, match=said):
        rest_length(*arguments)
