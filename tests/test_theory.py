"""Closed forms against quadrature and against what the paper prints."""

import numpy as np
import pytest
from scipy.integrate import quad

from dpd.analysis.interfaces import chi_of_composition
from dpd.theory.equation_of_state import MEAN_FIELD, second_virial
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
    assert chi_of_composition(phi, length) == pytest.approx(chi)
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
