"""Structure and thermodynamics from the Ornstein-Zernike equation with HNC."""

import numpy as np
import pytest

from dpd.theory.equation_of_state import second_virial
from dpd.theory.integral_equations import (
    RANGE,
    NoSolution,
    R,
    potentials,
    solve,
    transform,
)
from paper_figures.crgw_2019.thermodynamics import (
    energy,
    excess_chemical_potentials,
    inverse_compressibility,
    pressure,
)

UNLIKE = np.array([[25.0, 22.0], [22.0, 15.0]])


def test_the_fluid_of_groot_and_warren():
    """HNC at density 3 and repulsion 25, as two other solvers have it."""
    fluid = solve(3, 25)
    assert pressure(fluid) == pytest.approx(23.564, abs=5e-4)
    assert excess_chemical_potentials(fluid) == pytest.approx([12.17], abs=5e-3)


@pytest.mark.parametrize("density", [0.01, 0.5, 3, 8])
@pytest.mark.parametrize("a", [0.1, 25, 130])
def test_it_converges_in_the_whole_range(density, a):
    """The solution obeys both equations, and is nothing far away."""
    fluid = solve(density, a)
    ck = transform(fluid.c)
    np.testing.assert_allclose(transform(fluid.h), ck / (1 - density * ck), atol=1e-6)
    expected = np.exp(fluid.gamma - potentials(fluid.repulsions))
    np.testing.assert_allclose(fluid.g, expected, atol=1e-12)
    assert np.abs(fluid.h[R > 0.8 * RANGE]).max() < 1e-4
    assert fluid.structure_factors().min() > 0 and fluid.g.min() > -1e-12


@pytest.mark.parametrize("a", [1.0, 25.0, 130.0])
def test_low_density_is_the_second_virial_coefficient(a):
    """p = rho + B2 rho^2, mu = 2 B2 rho, dp/drho = 1 + 2 B2 rho; the structure is exp(-u)."""
    rho, b2 = 1e-4, second_virial(a)
    fluid = solve(rho, a)
    assert (pressure(fluid) - rho) / rho**2 == pytest.approx(b2, rel=1e-3)
    assert excess_chemical_potentials(fluid)[0] / rho == pytest.approx(2 * b2, rel=1e-3)
    assert (inverse_compressibility(fluid) - 1) / rho == pytest.approx(2 * b2, rel=1e-3)
    np.testing.assert_allclose(fluid.g, np.exp(-potentials(fluid.repulsions)), atol=2e-3)


@pytest.mark.parametrize("state", [(3.0, 25.0), (5.0, 15.0), (2.0, 100.0)])
def test_chemical_potential_is_that_of_the_energy(state):
    """F from the coupling, dF/da = E / a, is rho mu - p."""
    rho, a = state
    nodes, weights = np.polynomial.legendre.leggauss(24)
    couplings = a * (nodes + 1) / 2
    free = weights @ [energy(solve(rho, part)) / part for part in couplings] * a / 2
    fluid = solve(rho, a)
    expected = rho * excess_chemical_potentials(fluid)[0] - (pressure(fluid) - rho)
    assert free == pytest.approx(expected, rel=1e-4)


def test_the_pressure_of_a_mixture_is_consistent_with_chemical_potentials():
    """Gibbs and Duhem: dp / d rho_i = 1 + sum_j rho_j d mu_j / d rho_i, for unlike species."""
    rho, step = np.array([1.2, 2.1]), 1e-3
    for species in range(2):
        shift = step * np.eye(2)[species]
        low, high = solve(rho - shift, UNLIKE), solve(rho + shift, UNLIKE)
        slope = (pressure(high) - pressure(low)) / (2 * step)
        change = excess_chemical_potentials(high) - excess_chemical_potentials(low)
        assert slope == pytest.approx(1 + rho @ change / (2 * step), rel=1e-4)


def test_species_that_are_the_same_are_one():
    """Three names for one bead, and a solute that is a bead of the fluid."""
    one, three = solve(3, 25), solve([0.5, 1, 1.5], np.full((3, 3), 25.0))
    dilute = solve([0, 3], [[0, 25], [25, 25]])
    for mixture in (three, dilute):
        assert pressure(mixture) == pytest.approx(pressure(one), rel=1e-8)
        np.testing.assert_allclose(
            excess_chemical_potentials(mixture), excess_chemical_potentials(one)[0], rtol=1e-8
        )
    np.testing.assert_allclose(three.g, np.broadcast_to(one.g, three.g.shape), atol=1e-7)
    assert inverse_compressibility(three) == pytest.approx(inverse_compressibility(one))


def test_the_cavity_function_is_smooth_where_the_potential_ends():
    """ln y = u + ln g on the grid; even in the distance, so flat at 0."""
    fluid = solve(3, 25)
    inside = slice(20, 150)
    expected = potentials(fluid.repulsions)[inside] + np.log(fluid.g[inside])
    np.testing.assert_allclose(fluid.ln_y(R[inside]), expected, atol=1e-8)
    near, nearer = (fluid.ln_y(distance)[0, 0] for distance in (2e-3, 1e-3))
    at_zero = fluid.ln_y(0)[0, 0]
    assert (at_zero - near) / (at_zero - nearer) == pytest.approx(4, rel=0.05)


@pytest.mark.thorough
def test_a_mixture_that_separates_has_no_solution():
    """Fluctuations of composition grow without bound."""
    with pytest.raises(NoSolution, match=r"no solution at density 1\.5, 1\.5 and repulsion 25, 60"):
        solve([1.5, 1.5], [[25, 60], [60, 25]])


@pytest.mark.parametrize(
    ("densities", "repulsions", "message"),
    [
        (0, 25, "density: 0 is out of range; allowed: at least one above 0"),
        (3, -25, "repulsion: -25 is out of range"),
        ([1, 2], 25, "n rows and columns"),
        ([1, 2], [[25, 30], [31, 25]], "a_ij = a_ji"),
    ],
)
def test_bad_states_are_one_message(densities, repulsions, message):
    with pytest.raises(ValueError, match=message) as caught:
        solve(densities, repulsions)
    assert "\n" not in str(caught.value)
