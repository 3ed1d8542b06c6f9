"""kT and pressure count degrees of freedom, and are those about the flow."""

import numpy as np
import pytest

import dpd
from dpd.engine.simulation import Snapshot
from dpd.engine.state import State
from dpd.observe.common.bins import ThermalMotion
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE

FLUID = SCENE | {
    "box": 5,
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 500, "sample": 4000},
    "observe": [{"thermo": {"every": 2}}],
}
BATH = {"thermostat": {"kind": "langevin", "gamma": 4.5}}
SMOOTH = {"axis": "z", "repulsion": 25}
FLOW = {"axis": "x", "strength": 0.05, "opposite": "z"}
# What a scene changes, and the axes along which its momentum is conserved.
AXES = {
    "closed": ({}, (0, 1, 2)),
    "exchange": ({"integrator": {"scheme": "lowe-andersen", "dt": 0.02}}, (0, 1, 2)),
    "Langevin": (BATH, ()),
    "Langevin, no friction": ({"thermostat": {"kind": "langevin", "gamma": {"A": 0}}}, (0, 1, 2)),
    "smooth walls": ({"walls": SMOOTH}, (0, 1)),
    "a cage": ({"walls": SMOOTH | {"axis": ["x", "y", "z"]}}, ()),
    "rough walls": ({"walls": SMOOTH | {"gamma": 4.5}}, ()),
    "gravity": ({"walls": SMOOTH, "body_force": {"axis": "z", "strength": 1}}, (0, 1)),
    "two flows": ({"body_force": FLOW}, (0, 1, 2)),
    "shear": ({"shear": {"flow": "x", "gradient": "y", "rate": 0.1}}, (0, 1, 2)),
    "constant pressure": ({"pressure": {"target": 24, "time": 1, "axes": "all"}}, (0, 1, 2)),
}


@pytest.mark.parametrize("name", AXES)
def test_where_momentum_is_conserved(name):
    """Along an axis where no friction with a bath or a wall, and no plane, takes it up."""
    changes, axes = AXES[name]
    assert Scene(FLUID | changes).momentum_axes == axes


def thermal_kT(scene, flow, samples=400, seed=1):
    """(samples, 3) array: <m c^2> along each axis, of beads with kT 1 about a flow.

    As dynamics would, what takes no momentum starts at rest as a whole, and then drifts with 5.
    """
    scene, rng = Scene(FLUID | scene), np.random.default_rng(seed)
    system, kinds = system_of(scene), scene.kinds
    thermal, found = ThermalMotion(scene, system), np.empty((samples, 3))
    mass = np.broadcast_to(system.mass_of(kinds), kinds.shape)
    low, extent = np.array(system.origin)[:, None], np.array(system.extent)[:, None]
    axes = list(scene.momentum_axes)
    for sample in found:
        place = rng.random((3, len(kinds))) * extent
        velocity = rng.normal(size=place.shape) / np.sqrt(mass)
        velocity[axes] -= (velocity[axes] @ mass / mass.sum())[:, None] - 5
        velocity[0] += flow(*place)
        state = State(place + low, velocity, None, None, kinds, 0)
        sample[:] = np.mean(mass * thermal.velocities(Snapshot(system, state)) ** 2, axis=1)
    return found


FEW = {"molecules": [{"architecture": "A", "count": 6}, {"architecture": "B", "count": 3}],
       "repulsion": {"A A": 25, "A B": 25, "B B": 25}, "mass": {"B": 5}}  # fmt: skip


@pytest.mark.parametrize("name", ["closed", "Langevin", "smooth walls"])
def test_few_beads_have_their_temperature_along_each_axis(name):
    """Nine of them, three of them heavy: 1, whatever axes keep their momentum, within 4 errors."""
    changes = dict(AXES[name][0])
    found = thermal_kT(FEW | changes, lambda *place: 0)
    assert (abs(found.mean(axis=0) - 1) < 4 * found.std(axis=0) / np.sqrt(len(found))).all()


def test_a_lone_bead_in_a_closed_box_has_none():
    """No number instead of a wrong one."""
    one = {"molecules": [{"architecture": "A", "count": 1}]}
    assert np.isnan(thermal_kT(one, lambda *place: 0, samples=1)).all()


ROUGH = SMOOTH | {"gamma": 4.5}
FLOWS = {
    "two flows": ({"box": [4, 5, 12], "body_force": FLOW},
                  lambda x, y, z: np.sign(6 - z) * (z % 6) * (6 - z % 6) / 6),
    "channel": ({"walls": ROUGH, "body_force": {"axis": "x", "strength": 0.05}},
                lambda x, y, z: 0.3 * z * (5 - z)),
    "moving walls": ({"walls": ROUGH | {"velocity": [[-2, 0, 0], [2, 0, 0]]}},
                     lambda x, y, z: 0.8 * z - 2),
    "all go": (BATH | {"body_force": {"axis": "x", "strength": 9}}, lambda x, y, z: 2),
    "few": ({"walls": ROUGH, "body_force": {"axis": "x", "strength": 0.05},
             "molecules": [{"architecture": "A", "count": 50}]}, lambda x, y, z: z),
}  # fmt: skip


@pytest.mark.parametrize("name", FLOWS)
def test_a_flow_is_no_heat(name):
    """1 along each axis, also that of the flow, whose own <u^2> is up to 4; 4 errors and 0.4 %.

    The curves of these profiles are not quite straight in a cell.
    """
    found = thermal_kT(*FLOWS[name], samples=150)
    error = found.std(axis=0) / np.sqrt(len(found))
    assert (abs(found.mean(axis=0) - 1) < 4 * error + 0.004).all(), found.mean(axis=0)


def test_a_start_that_drifts(tmp_path):
    """The drift is no heat and no pressure: 23.68 as at rest. One sentence says so, none of dt."""
    scene = Scene(FLUID)
    state = make_start(scene)
    state.velocity[0] += 1.0
    simulate(scene, tmp_path / "drift.nc", state)
    run = dpd.load(tmp_path / "drift.nc")
    assert "drifts with (1, 0, 0)" in run.warning
    assert "dt" not in run.warning and run.warning.count(";") == 1
    for name, expected, off in (("kT", 1.0, 0.005), ("pressure", 23.68, 0.05)):
        about = run[name].attrs
        assert abs(about["mean"] - expected) < 4 * about["error"] + off
    tensor = run.pressure_tensor.mean("time").values
    assert abs(tensor[0, 0] - tensor[1:, 1:].trace() / 2) < 0.3
