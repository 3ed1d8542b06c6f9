"""Outcomes of runs, edges of stability, power laws, and the figures made of them."""

import json

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt

from dpd.report.figures import load_module
from paper_figures.benchmark.drift import (
    FAR,
    LOST,
    OFF,
    STABLE,
    crossing,
    edge,
    outcome,
    power_law,
)


def test_blown_up_runs_have_a_time_and_no_temperature():
    """The first replica to break counts, whatever the others' kT; step 0 would break too."""
    kT = np.array([[[1.0, np.nan, 1.0]], [[1.0, 1.0, 1.03]]])
    lost = np.array([[[-1, 400, 90]], [[-1, -1, -1]]])
    found = outcome(kT, np.full(kT.shape, 1e-4), lost, np.array([0.05]))
    assert found.kind.tolist() == [[LOST], [STABLE]]
    assert found.sure.all()
    assert found.lost[0, 0] == pytest.approx(4.5)
    assert np.isnan(found.excess[0, 0])
    assert found.excess[1, 0] == pytest.approx(0.01)
    assert found.error[1, 0] == pytest.approx(1e-4 / np.sqrt(3))


@pytest.mark.parametrize(
    ("kind", "unsure", "expected"),
    [
        ([STABLE, STABLE, OFF, FAR], [], (0.02, 0.04)),
        ([STABLE, OFF, STABLE, LOST], [], (0.01, 0.02)),
        ([STABLE, STABLE, STABLE, STABLE], [], (0.08, np.nan)),
        ([FAR, FAR, LOST, LOST], [], (np.nan, 0.01)),
        ([STABLE, OFF, STABLE, OFF], [1, 3], (0.04, 0.08)),
        ([STABLE, OFF, STABLE, OFF], [3], (0.01, 0.02)),
        ([OFF, OFF, OFF, LOST], [0, 1], (np.nan, 0.01)),
    ],
)
def test_the_edge_lies_where_stability_first_ends(kind, unsure, expected):
    """Where a larger step is stable a sure failure ends it, and an unsure one only at the end."""
    found = edge(np.array([0.01, 0.02, 0.04, 0.08]), kind, ~np.isin(range(4), unsure))
    assert found == pytest.approx(expected, nan_ok=True)


def test_the_step_at_which_heat_reaches_a_tenth():
    """Exact for heat that is a power of dt; anywhere between where the next run blew up."""
    dt = np.array([0.01, 0.02, 0.04, 0.08])
    heat = 80 * dt**2
    value, error = crossing(dt, heat, np.full(4, 1e-9))
    assert value == pytest.approx(np.sqrt(0.1 / 80))
    assert error == pytest.approx(0.05)
    assert crossing(dt, -heat, np.full(4, 1e-9))[0] == pytest.approx(value)
    lost = np.where(dt > 0.03, np.nan, heat)
    assert crossing(dt, lost, np.full(4, 1e-9)) == pytest.approx(
        (np.sqrt(0.02 * 0.04), np.log(2) / np.sqrt(12))
    )
    assert np.isnan(crossing(dt[:2], heat[:2], np.full(2, 1e-9))).all()
    assert np.isnan(crossing(dt, heat + 1, np.full(4, 1e-9))).all()


def test_power_laws_cover_the_true_exponent():
    """Of 400 fits with honest errors 95 % hold it; points that are no number are left out."""
    rng = np.random.default_rng(2)
    x = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])
    error = np.full(6, 0.1)
    exponents = []
    for _ in range(400):
        y = 3 * x**-0.5 * np.exp(rng.normal(scale=error))
        y[2] = np.nan
        exponents.append(power_law(x, y, error)[1:3])
    value, spread = np.array(exponents).T
    assert 0.92 < np.mean(np.abs(value + 0.5) < 1.96 * spread) < 0.99
    exact = power_law(x, 3 * x**-0.5, error)
    assert (exact.factor, exact.exponent, exact.points) == pytest.approx((3, -0.5, 6))
    assert exact.holds


def made_up(axis, x, limit, dt, **more):
    """A sweep whose runs are stable up to ``limit``, 5 % hot up to twice that, lost beyond."""
    ratio = np.array(dt)[None, :] / np.array(limit)[:, None]
    kT = np.select([ratio <= 1, ratio <= 2], [1.001, 1.05], np.nan)[..., None]
    lost = np.where(ratio > 2, 100, -1)[..., None]
    dims = (axis, "dt", "replica")
    data = xr.Dataset(
        {
            "kT": (dims, kT),
            "kT_error": (dims, np.where(np.isnan(kT), np.nan, 1e-3)),
            "lost_step": (dims, lost),
            "beads": (dims, np.full(kT.shape, 10**6)),
        },
        {axis: (axis, x, {"units": "1"}), "dt": dt},
    )
    return data.expand_dims(more) if more else data


@pytest.fixture
def sweeps():
    """Maps with an edge at 1 / x from the second column on; the cores' runs are all lost."""
    x, dt = np.array([1.0, 2, 4, 8, 16, 32]), 0.7 * 2.0 ** np.arange(-7, 2)
    names = {"map_noise": "sigma", "map_repulsion": "a", "map_density": "density"}
    sweeps = {name: made_up(axis, x, 1 / x, dt) for name, axis in names.items()}
    sweeps["map_bonds"] = made_up("stiffness", x, np.full(6, 0.1), dt)
    core = made_up("force", x, np.full(6, 1e-5), dt)
    sweeps["map_core"] = xr.concat([core, core], xr.IndexVariable("r_s", [0.15, 0.25]))
    return sweeps


def test_the_map_says_what_it_was_made_of(sweeps):
    """Edges, laws, words and marks of made-up runs."""
    module = load_module("benchmark", "stability")
    data = module.compute(sweeps)
    assert module.measured(data) == {} and not without_units(data)
    assert float(data.map_noise_law_exponent) == pytest.approx(-1, abs=0.01)
    assert bool(data.map_noise_law_holds) and not bool(data.map_bonds_law_holds)
    table = module.table(data).set_index(["map", "value"])
    assert table.loc[("repulsion a", "4")].tolist() == [
        "0.175", "0.35: kT +5.0 ± 0.1 %", "0.495 ± 0.099",
    ]  # fmt: skip
    text = " ".join(module.warnings(data))
    assert "No step that was tried is stable at F_max, r_s 0.15 1, 2, 4, 8, 16, 32" in text
    assert len(module.draw(data).axes) == 6
    plt.close()


def without_units(data):
    """Names of numbers that do not say their units, which they must in a figure's file."""
    return [n for n, v in data.data_vars.items() if v.dtype.kind == "f" and "units" not in v.attrs]


@pytest.fixture
def long_sweeps():
    """Two long runs, one with a pressure that rises; energy that drifts as dt^3, swings as dt^2."""
    scene = {
        "dimension": 3, "box": 3, "molecules": [{"architecture": "A", "density": 3}],
        "repulsion": {"A A": 25}, "integrator": {"scheme": "aboba", "dt": 0.04},
        "steps": {"sample": 1000}, "observe": ["thermo"],
    }  # fmt: skip
    text, runs = json.dumps(scene), xr.Dataset(coords={"run": ["one", "other"]})
    runs["scene"] = ("run", [text, text])
    given = {"steps": 1000, "beads": 81, "momentum_per_bead": 1e-15, "lost_step": -1}
    for name in ("kT", "total_energy", "pressure"):
        given |= {name: 1.0, f"{name}_error": 0.01, f"{name}_trend": 0.0}
        given |= {f"{name}_trend_error": 1e-5, f"{name}_spread": 0.5}
    for name, value in given.items():
        runs[name] = ("run", [value, value], {"units": "as collected"})
    runs.pressure_trend[1] = 7e-5
    dt = np.array([0.001, 0.01, 0.02, 0.05])
    free = xr.Dataset(
        {
            "total_energy_trend": ("dt", -81 * 2 * dt**3),
            "total_energy_trend_error": ("dt", np.full(4, 81 * 1e-7)),
            "total_energy_spread": ("dt", 81 * 5 * dt**2),
            "total_energy_correlation_time": ("dt", np.full(4, 0.4)),
            "momentum_per_bead": ("dt", np.full(4, 1e-15), {"units": "m r_c / tau"}),
            "beads": ("dt", np.full(4, 81)), "lost_step": ("dt", np.full(4, -1)),
            "scene": ("dt", [text] * 4),
        },
        {"dt": dt},
    )  # fmt: skip
    return {
        "long_runs": runs.expand_dims("replica", -1),
        "no_thermostat": free.expand_dims("replica", -1),
    }


def test_orders_of_drift_and_fluctuation(long_sweeps):
    """Both come back; the drift at dt 0.001, a hundredth of its error, is not fitted."""
    module = load_module("benchmark", "long_runs")
    data = module.compute(long_sweeps)
    assert module.measured(data) == {} and not without_units(data)
    assert float(data.drift_law_exponent) == pytest.approx(3)
    assert (float(data.drift_law_low), float(data.drift_law_points)) == (0.01, 3)
    assert float(data.spread_law_exponent) == pytest.approx(2)
    assert float(data.spread_law_factor) == pytest.approx(5)
    assert float(data.spread_error[1] / data.spread[1]) == pytest.approx(0.1)
    text = " ".join(module.warnings(data))
    assert "Of 6 trends 1 exceed two standard errors" in text
    assert "The largest is 7.0 standard errors" in text
    assert module.table(data).iloc[1, 6] == "0.00280 ± 0.00040"
    assert len(module.draw(data).axes) == 3
    plt.close()
