"""Compressibility, exponents and g(r) pressures of fluids whose answers are known."""

import json

import numpy as np
import pytest
import xarray as xr

from paper_figures.groot_warren_1997.excess_pressure import compressibility, exponent, from_rdf


def equation_of_state(pressure, densities, repulsions=(15.0, 25.0, 30.0), noise=0.0):
    """A dataset as of `excess_pressure`, from a function of repulsion and density."""
    a, rho = np.array(repulsions)[:, None], np.array(densities)
    excess = pressure(a, rho) + np.random.default_rng(5).normal(
        scale=noise, size=(len(a), len(rho))
    )
    along = ("repulsion", "density")
    return xr.Dataset(
        {
            "excess": (along, excess),
            "excess_error": (along, np.full(excess.shape, max(noise, 1e-6))),
            "scaled": (along, excess / (a * rho**2)),
            "scaled_error": (along, max(noise, 1e-6) / (a * rho**2)),
        },
        {"repulsion": a.ravel(), "density": rho},
    )


def test_compressibility_is_the_slope_of_the_pressure():
    """Of p = rho + 0.1 a rho^2 it is 1 + 0.2 a rho; noise is within the error."""
    data = equation_of_state(lambda a, rho: 0.1 * a * rho**2, [1, 2, 2.5, 3, 3.5, 4, 5], noise=0.01)
    value, error = compressibility(data.sel(repulsion=25.0), 3.0)
    assert abs(value - 16) < 4 * error
    assert 0.005 < error < 0.05
    bent = equation_of_state(lambda a, rho: 0.02 * a * rho**3, [2, 2.5, 3, 3.5, 4])
    assert compressibility(bent.sel(repulsion=25.0), 3.0)[0] == pytest.approx(1 + 0.06 * 25 * 9)


@pytest.mark.parametrize("power", [0.9, 1.0])
def test_exponent_in_the_repulsion(power):
    """Whatever the density dependence is; densities of 2 and below do not enter."""
    data = equation_of_state(
        lambda a, rho: np.where(rho > 2, a**power * rho**1.7, a**0.4), [1, 2, 3, 4, 5]
    )
    value, error = exponent(data)
    assert value == pytest.approx(power)
    assert error < 1e-6


def test_pressure_from_a_flat_rdf():
    """g = 1 gives mean field, pi a rho^2 / 30, whatever the bins."""
    scene = json.dumps({
        "dimension": 3, "box": 8, "molecules": [{"architecture": "A", "density": 3}],
        "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
        "steps": {"equilibrate": 0, "sample": 10}, "observe": ["thermo"],
    })  # fmt: skip
    for width in (0.02, 0.3):
        r = np.arange(0.5 * width, 1.5, width)
        runs = xr.Dataset(
            {
                "rdf": (("replica", "block", "r"), np.ones((1, 12, len(r)))),
                "scene": ("replica", [scene]),
                "number_density": ("replica", [3.0]),
            },
            {"r": r},
        )
        value, error = from_rdf(runs)
        assert value == pytest.approx(np.pi / 30 * 25 * 9)
        assert error == pytest.approx(0, abs=1e-9)
