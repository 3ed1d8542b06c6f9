"""What a dissipative particle dynamics fluid must do, with stated confidence.

Standard errors come from 20 blocks, each longer than the memory of what is averaged. True values
miss by 5 such errors with a chance of 8e-5 (Student, 19 degrees of freedom).
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from dpd import files
from dpd.engine.loop import run
from dpd.errors import UserError
from dpd.runs.run import Options
from dpd.runs.run import simulate as run_scene
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start
from tests.conftest import SCENE
from tests.systems import begun, values_of

MONTE_CARLO_PRESSURE = 23.653  # +- 0.002 at rho 3, a 25: no time step (spec of the paper)


def simulate(box, dt, steps, observe, gamma=4.5, repulsion=25, density=3):
    """Run a fluid of one species: its variables as a file would hold them, its velocities."""
    simulation, watched, steps = begun(SCENE | {
        "dimension": len(box),
        "box": list(box),
        "molecules": [{"architecture": "A", "density": density}],
        "repulsion": {"A A": repulsion},
        "thermostat": {"gamma": gamma},
        "integrator": {"scheme": "gw-vv", "dt": dt},
        "steps": {"equilibrate": steps[0], "sample": steps[1]},
        "observe": observe,
    })  # fmt: skip
    seen = []
    watch = SimpleNamespace(
        every=round(0.8 / dt), arrays={},
        sample=lambda now: seen.append(now.state.velocity.copy()),
    )  # fmt: skip
    run(simulation, steps, [*watched, watch])
    return values_of(watched[0]), np.array(seen)


def mean_and_error(series, blocks=20):
    """Mean over time, and its standard error from blocks."""
    length = len(series) // blocks
    parts = series[: blocks * length].reshape(blocks, length, *series.shape[1:]).mean(axis=1)
    return parts.mean(axis=0), parts.std(axis=0, ddof=1) / np.sqrt(blocks)


@pytest.fixture(scope="module")
def fluid():
    """The standard fluid: rho 3, a 25, 1920 beads, dt 0.02, 60 tau."""
    return simulate((8, 8, 10), 0.02, (500, 3000), [{"thermo": {"every": 5}}])


def test_pressure_of_the_standard_fluid(fluid):
    """The conservative virial gives the Monte Carlo pressure to 0.1 %, six standard errors.

    Ideal part rho kT as in the paper's Eq. 15.
    """
    excess, error = mean_and_error(fluid[0]["excess_conservative"])
    assert error < 0.006
    assert abs(3 + excess - MONTE_CARLO_PRESSURE) < 0.001 * MONTE_CARLO_PRESSURE


@pytest.mark.parametrize("name", ["pressure_tensor", "pressure_tensor_all"])
def test_pressure_tensor_is_isotropic(fluid, name):
    """Diagonal elements agree, the others vanish, within 5 standard errors (below 0.2 %)."""
    tensor = fluid[0][name]
    assert_isotropic(tensor, 0.002 * MONTE_CARLO_PRESSURE)
    np.testing.assert_allclose(tensor, np.swapaxes(tensor, 1, 2), rtol=0, atol=1e-9)


def assert_isotropic(tensor, largest_error):
    """A series of tensors is on average a number times the unit tensor."""
    for i in range(tensor.shape[1]):
        for j in range(i):
            for difference in (tensor[:, i, j], tensor[:, i, i] - tensor[:, j, j]):
                mean, error = mean_and_error(difference)
                assert error < largest_error
                assert abs(mean) < 5 * error


def test_total_energy_is_what_stays():
    """Without a thermostat it keeps to 1e-3 kT a bead, while its parts change a hundred times that.

    Chains, so that all three parts exchange energy; velocity Verlet at dt 0.002.
    """
    simulation, (watch, *_), steps = begun(SCENE | {
        "molecules": [{"architecture": "A 4", "density": 3}],
        "bond": {"stiffness": 50, "length": 0.5},
        "thermostat": {"gamma": 0},
        "integrator": {"scheme": "gw-vv", "dt": 0.002},
        "steps": {"sample": 500},
        "observe": [{"thermo": {"every": 5}}],
    })  # fmt: skip
    run(simulation, steps, [watch])  # the other one looks after bonds
    found, beads = values_of(watch), simulation.state.position.shape[1]
    assert np.ptp(found["total_energy"]) < 1e-3 * beads
    for part in (found["kT"] * 1.5 * beads, found["pair_energy"], found["bond_energy"]):
        assert np.ptp(part) > 0.1 * beads


def test_velocities_are_maxwellian(fluid):
    """Components and speeds by Kolmogorov and Smirnov, at a chance of 1e-6."""
    velocity = fluid[1]
    spread = np.sqrt(np.mean(velocity**2))
    assert velocity.size > 400_000
    assert stats.kstest(velocity.ravel(), stats.norm(scale=spread).cdf).pvalue > 1e-6
    speed = np.sqrt((velocity**2).sum(axis=1)).ravel()
    assert stats.kstest(speed, stats.maxwell(scale=spread).cdf).pvalue > 1e-6


@pytest.mark.parametrize("box", [(22, 22), (8, 8, 8)], ids=["2D", "3D"])
def test_ideal_gas_has_no_structure(box):
    """g(r) = 1 in every bin within 5 standard errors over 40 independent samples.

    The friction is 1: at 4.5 this scheme makes a dip of 0.7 % at dt 0.01 (3 % at 0.04).
    """
    found, _ = simulate(
        box, 0.01, (10, 3200), [{"rdf": {"every": 80, "range": 2, "bin": 0.2}}],
        gamma=1, repulsion=0,
    )  # fmt: skip
    mean, error = mean_and_error(found["rdf"], blocks=40)
    assert found["rdf"].shape == (40, 10)
    assert (error[1:] < 0.015).all()
    assert (np.abs(mean - 1) < 5 * error).all()


def test_an_unstable_run_is_recorded_or_fails(tmp_path):
    """With the step at which it broke, and NaN from there; or without a file or a checkpoint."""
    fluid = SCENE | {"dimension": 2, "box": 6, "integrator": {"scheme": "gw-vv", "dt": 0.12}}
    relaxed = {"start": {"relax": {"steps": 200, "dt": 0.02}}}
    sampled = {"steps": {"sample": 60}, "observe": [{"thermo": {"every": 1}}]}
    data = fluid | relaxed | sampled
    path, options = tmp_path / "run.nc", Options(every_seconds=0.0)
    scene = Scene(data, "my.yaml")
    with pytest.raises(UserError, match=r"my\.yaml: the run blew up"):
        run_scene(scene, path, make_start(scene), options)
    assert not path.exists()
    scene = Scene(data | {"unstable": "record"}, "my.yaml")
    run_scene(scene, path, make_start(scene), options)
    variables, attributes = files.read(path)
    sampled = int(attributes["lost_step"]) - 1
    assert 0 < sampled < 59
    for name in ("kT", "excess_conservative", "pair_energy"):
        assert variables[name].shape == (60,)
        assert np.isfinite(variables[name][:sampled]).all()
        assert np.isnan(variables[name][sampled:]).all()
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
