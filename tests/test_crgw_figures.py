"""Figures of the chain-revised equation of state, on made-up numbers."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.errors import UserError
from dpd.theory.equation_of_state import BETA, ETA, crgw
from paper_figures.crgw_2019 import (
    fig02_mismatch,
    fig07_solutes,
    mixtures,
    shared,
)
from paper_figures.crgw_2019.mixing import chain_potential, monomer_potential

SCENE = {
    "dimension": 3, "box": 8, "molecules": [{"architecture": "A 2", "count": 500}],
    "repulsion": {"A A": 25}, "bond": {"stiffness": 500, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.01}, "steps": {"sample": 10},
}  # fmt: skip


def runs(values, coordinates, scene=SCENE):
    """A collected sweep: each value over all axes but replica, with an error of a hundredth."""
    dims = tuple(coordinates)
    shape = tuple(len(labels) for labels in coordinates.values())
    data = xr.Dataset(coords=coordinates)
    for name, value in values.items():
        full = np.broadcast_to(value, shape)[..., None]
        data[name] = ((*dims, "replica"), full.astype(float))
        data[f"{name}_error"] = ((*dims, "replica"), 0.01 * np.abs(full))
        data[f"{name}_spread"] = ((*dims, "replica"), 0.1 * np.abs(full))
    data["scene"] = ((*dims, "replica"), np.full((*shape, 1), json.dumps(scene)))
    return data


def test_mismatches_are_relative_to_the_simulated_pressure():
    """Predictions of 10 and 20 percent more; the worst is found; mean bonds over those asked."""
    axes = {"chain": [2, 8], "density": [3, 5], "bond": [0.4], "repulsion": [20]}
    pressure = np.array([[20.0, 50.0], [10.0, 40.0]])[..., None, None]
    simulated = runs({"pressure": pressure}, axes)
    simulated["bond_mean"] = (
        (*axes, "replica", "block"),
        np.full((2, 2, 1, 1, 1, 3), 0.402),
    )
    more = np.array([[1.1, 1.0], [1.2, 1.1]])[..., None, None]
    theory = xr.Dataset(
        {name: (tuple(axes), pressure * more) for name in ("crGW", "rGW", "GW")}, axes
    )
    data = shared.mismatches({"oligomers": simulated, "oligomer_pressures": theory})
    at = data.sel(equation="rGW")
    mean, error = shared.mean_unsigned(at)
    assert mean == pytest.approx(10)
    assert error == pytest.approx(np.hypot(np.hypot(1.1, 1.0), np.hypot(1.2, 1.1)) / 4)
    worst, _, where = shared.largest(at)
    assert worst == pytest.approx(20)
    assert where == "m = 8, rho = 3, l = 0.4, a = 20"
    assert float(data.bond_ratio.max()) == pytest.approx(1.005)


def test_the_constants_of_the_bonds_come_back():
    """Of pressures that are those of the equation, whatever constants the prediction had."""
    axes = {"chain": [2, 8], "density": [3, 6], "bond": [0.3, 0.5], "repulsion": [10, 40]}
    m, rho, length, a = np.meshgrid(*axes.values(), indexing="ij")
    pressure = crgw(rho / m, a, m, length)
    simulated = runs({"pressure": pressure}, axes)
    simulated["bond_mean"] = ((*axes, "replica", "block"), np.ones((2, 2, 2, 2, 1, 3)))
    theory = xr.Dataset({name: (tuple(axes), pressure) for name in shared.LOOKS}, axes)
    data = fig02_mismatch.compute({"oligomers": simulated, "oligomer_pressures": theory})
    np.testing.assert_allclose(data.constants, [ETA, BETA], rtol=1e-6)
    assert float(np.abs(data.refitted_off).max()) < 1e-6
    assert (data.constants_error > 0.01).all()


def held(values, coordinates):
    """Runs at a constant pressure, at which the enthalpy is constant as well."""
    data, noise = runs(values, coordinates), np.random.default_rng(3).normal(size=200)
    change = (data.volume / 100).expand_dims(time=np.arange(200.0), axis=-1) * (
        noise - noise.mean()
    )
    data["volume_series"] = data.volume + change
    data["pair_energy_series"] = data.pair_energy - shared.TARGET * change
    return data


def test_excess_properties_vanish_for_ideal_mixing():
    """A volume linear in the mole fraction, and a pressure that is off by 5 percent at one end.

    Where energy and volume change against each other, the error of the enthalpy knows it.
    """
    both, shares = {"equation": ["crGW", "rGW"]}, [0.25, 0.5]
    sweeps = {}
    for ensemble in ("", "_npt"):
        for name, volume in (("vh1", 300.0), ("vh2", 500.0)):
            values = {"pressure": 41.89, "volume": volume, "pair_energy": 2 * volume}
            sweeps[name + ensemble] = (held if ensemble else runs)(values, both)
        volume = 500.0 - 200.0 * np.array(shares)[:, None] * np.ones((1, 2))
        values = {"pressure": 41.89 * 1.05, "volume": volume, "pair_energy": 2 * volume}
        sweeps["vh1_vh2" + ensemble] = (held if ensemble else runs)(
            values, {"share": shares} | both
        )
    data = mixtures.mixture(sweeps, "vh1", "vh2")
    assert list(data.share.values) == [0, 0.25, 0.5, 1]
    for name in mixtures.EXCESSES:
        np.testing.assert_allclose(data[name], 0, atol=1e-9)
    errors = data.sel(share=0.5)
    assert (errors.energy_error > 0).all() and (errors.volume_error > 0).all()
    assert (errors.enthalpy_error < 1e-6 * errors.energy_error).all()
    assert mixtures.most(data, "pressure_off", "rGW")[0] == pytest.approx(5)


def solute(potential, coupling):
    """Runs of a solute whose energy with the solvent follows from a potential of a."""
    step = 1e-4
    slope = np.array([(potential(a + step) - potential(a - step)) / (2 * step) for a in coupling])
    scene = SCENE | {
        "molecules": [{"architecture": "W", "count": 1000}, {"architecture": "S 2", "count": 5},
                      {"architecture": "M", "count": 10}],
        "repulsion": {f"{i} {j}": 20 for i, j in ("WW", "SW", "MW", "SS", "MM", "MS")},
    }  # fmt: skip
    energy = np.array(coupling) * slope
    block = np.repeat(energy[:, None, None], 4, axis=2)
    pairs = np.stack([5 * block, 10 * block], axis=-1)
    return xr.Dataset(
        {
            "energy_of_pair": (("coupling", "replica", "block", "energy_pair"), pairs),
            "scene": (("coupling", "replica"), np.full((len(coupling), 1), json.dumps(scene))),
        },
        {"coupling": coupling, "energy_pair": ["S W", "M W"]},
    )


def test_a_potential_is_integrated_from_its_derivative():
    """Those of Eqs. 30 and 34 come back; other points than those of Gauss are refused."""
    nodes = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2
    for potential in (
        lambda a: monomer_potential(a, 4.0),
        lambda a: chain_potential(a, 4.0, 2, 0.4),
    ):
        sweep = solute(potential, 20 * nodes)
        found, _ = fig07_solutes._potential(sweep, "S W", 5, 20.0)
        assert found == pytest.approx(float(potential(20.0)), rel=1e-3)
        found, _ = fig07_solutes._potential(sweep, "W M", 10, 20.0)
        assert found == pytest.approx(float(potential(20.0)), rel=1e-3)
    with pytest.raises(UserError, match="not the points after Gauss"):
        fig07_solutes._potential(sweep, "S W", 5, 21.0)
