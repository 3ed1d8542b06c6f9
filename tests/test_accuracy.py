"""Limits and edges of stability, the cheapest scheme, and the choice that scenes leave to us."""

import numpy as np
import pytest
import xarray as xr
import yaml

from dpd.errors import UserError
from dpd.physics import integrator
from dpd.physics.integrator import Integrator
from dpd.scene.scene import Scene
from paper_figures.benchmark.accuracy import cheapest, choices, limit
from paper_figures.benchmark.drift import FAR, LOST, OFF, STABLE, crossing, edge, outcome, power_law
from paper_figures.benchmark.recommended import recommendations
from tests import conftest

DT = np.array([0.005, 0.01, 0.02, 0.04])
SCHEMES = ["gw-vv-0.5", "shardlow", "aboba"]
SCENE = conftest.SCENE | {"box": 5, "integrator": {"scheme": "auto"}}
MELT = {
    "molecules": [{"architecture": "A 5", "density": 1}],
    "repulsion": {"A A": 100},
    "bond": {"stiffness": 200, "length": 0.95},
}
TABLE = {
    "fluid": {
        "stiffness": {"repulsion": 75},
        "choices": [
            {"gamma": 4.5, "tolerance": 0.03, "scheme": "aboba", "lambda": 0.5, "dt": 0.1},
            {"gamma": 4.5, "tolerance": 0.01, "scheme": "gw-vv", "lambda": 0.65, "dt": 0.05},
            {"gamma": 40.5, "tolerance": 0.01, "scheme": "shardlow", "lambda": 0.5, "dt": 0.04},
        ],
    },
    "melt": {
        "stiffness": {"repulsion": 100, "bond": 200},
        "choices": [
            {"gamma": 4.5, "tolerance": 0.01, "scheme": "dpd-vv", "lambda": 0.5, "dt": 0.02}
        ],
    },
}


def study(errors, sigma=1e-4):
    """Relative errors c dt^2 of each scheme, and run times that go as 1 / dt."""
    shape = (len(SCHEMES), 1, len(DT))
    value = (np.array(errors)[:, None] * DT**2).reshape(shape)
    names = ("scheme", "gamma", "dt")
    cost = xr.DataArray([[1e-4], [2e-4], [3e-4]] / DT, dims=("scheme", "dt"))
    return xr.Dataset(
        {
            "pressure": (names, value),
            "pressure_error": (names, np.full(shape, sigma)),
            "kT": (names, 0 * value),
            "kT_error": (names, np.full(shape, sigma)),
            "seconds": cost,
        },
        {"scheme": SCHEMES, "gamma": [4.5], "dt": DT},
    )


def test_limit_knows_its_error():
    """Of schemes of second order, as gw-vv is none: over many noisy studies pulls are of size 1."""
    rng = np.random.default_rng(1)
    pulls = []
    for _ in range(400):
        data = study([1000.0, 30.0, -50.0], sigma=0.01)
        data["pressure"] = data.pressure + 7.0 + rng.normal(0, 0.01, data.pressure.shape)
        value, error = limit(data, "pressure")
        pulls.append((value - 7.0) / error)
    # Below 1, as errors are widened where points scatter more than they should, never narrowed.
    assert 0.85 < np.std(pulls) < 1.05
    assert abs(np.mean(pulls)) < 0.2


def test_cheapest_is_the_fastest_that_is_surely_good():
    # Errors at dt 0.04: 3.2 %, 0.8 %, 0.16 %; at 0.02: 0.8 %, 0.2 %, 0.04 %.
    data = study([20.0, 5.0, 1.0]).sel(gamma=4.5)
    assert cheapest(data, data.seconds, ["pressure"], 0.04)[:2] == ("gw-vv-0.5", 0.04)
    assert cheapest(data, data.seconds, ["pressure"], 0.01)[:2] == ("gw-vv-0.5", 0.02)
    assert cheapest(data, data.seconds, ["pressure"], 0.003)[:2] == ("aboba", 0.04)
    assert cheapest(data, data.seconds, ["pressure"], 1e-5) is None
    data["kT"] = data.kT + 0.02 * (data.scheme == "gw-vv-0.5")  # all that is asked for
    assert cheapest(data, data.seconds, ["pressure", "kT"], 0.01).scheme == "shardlow"


@pytest.fixture
def measured(monkeypatch, tmp_path):
    (tmp_path / "automatic.yaml").write_text(yaml.safe_dump(TABLE))
    monkeypatch.setattr(integrator, "TABLE", tmp_path / "automatic.yaml")


def guess(scene):
    """The integrator that is tried first."""
    return scene.terms["integrator"].named


def test_auto_takes_the_row_of_the_table(measured):
    scene = Scene(SCENE)
    assert guess(scene) == Integrator(scheme="gw-vv", dt=0.05, **{"lambda": 0.65})
    assert scene.is_auto and not scene.chosen
    assert Scene(scene.data).is_auto and Scene(scene.data).digest == scene.digest
    loose = Scene(SCENE | {"integrator": {"scheme": "auto", "tolerance": 0.05}})
    assert guess(loose).scheme == "aboba"
    rough = Scene(SCENE | {"thermostat": {"gamma": 10}})
    assert guess(rough).scheme == "shardlow"
    assert guess(Scene(SCENE | MELT)).scheme == "dpd-vv"


@pytest.mark.parametrize("change, dt", [
    ({"repulsion": {"A A": 100}}, 0.025), ({"repulsion": {"A A": 5}}, 0.05),
    (MELT | {"bond": {"stiffness": 800, "length": 0.95}}, 0.01),
])  # fmt: skip
def test_auto_goes_slower_where_the_scene_is_stiffer(measured, change, dt):
    assert Scene(SCENE | change).dt == pytest.approx(dt)


@pytest.mark.parametrize("change, message", [
        ({"integrator": {"scheme": "auto", "tolerance": 0.001}}, "tolerance: 0.001 is less"),
        ({"integrator": {"scheme": "gw-vv"}}, "the key 'dt' is missing"),
        ({"thermostat": {"gamma": 100}}, "gamma: 100, over .*: shardlow, lowe-andersen, aboba"),
        ({"thermostat": {"gamma": 0}}, "without friction"),
        ({"core": {"radius": 0.15, "force": 100}}, "rigid core"),
])  # fmt: skip
def test_auto_says_where_it_cannot_choose(measured, change, message):
    with pytest.raises(UserError, match=message):
        Scene(SCENE | change)


def test_recommendations_are_what_auto_reads(tmp_path, monkeypatch):
    data = study([20.0, 5.0, 1.0])
    for system in ("fluid", "melt"):
        data.to_netcdf(tmp_path / f"{system}_accuracy.nc", engine="netcdf4")
    (tmp_path / "schemes.yaml").write_text(recommendations(tmp_path))
    monkeypatch.setattr(integrator, "TABLE", tmp_path / "schemes.yaml")
    scene = Scene(SCENE | {"integrator": {"scheme": "auto", "tolerance": 0.003}})
    best = choices(data)[-1]
    assert (best.tolerance, best.scheme) == (0.003, "aboba")
    assert guess(scene) == Integrator(scheme="aboba", dt=0.04)


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
