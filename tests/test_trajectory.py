"""Trajectories: what is in them, who reads them, and the same frames through any kill."""

import os
import re

import freud
import gsd.fl
import gsd.hoomd
import MDAnalysis
import numpy as np
import pytest

import dpd
from dpd.engine.simulation import Simulation
from dpd.engine.stress import at_beads
from dpd.errors import UserError
from dpd.files import read
from dpd.folders import PACKAGE
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.systems import Killed, frames_of, kill_at

CHAINS = {
    "dimension": 2,
    "box": [7.0, 8.0],
    "molecules": [{"architecture": "A 3 B 2", "count": 20}, {"architecture": "B", "count": 12}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 50, "length": 0.3},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 10, "sample": 600},
    "observe": ["thermo", {"trajectory": {"every": 4}}],
}


def watched(every, base=SCENE, **changes):
    """A scene with a trajectory, and something beside it."""
    return Scene(base | {"observe": ["thermo", {"trajectory": {"every": every}}]} | changes)


@pytest.mark.parametrize("base", [SCENE, CHAINS], ids=["3D", "2D"])
def test_frames_are_the_states_of_the_run(tmp_path, base):
    """Positions, velocities, types, bonds, steps and box; and images that go on at faces."""
    scene = watched(5, base, steps={"equilibrate": 30, "sample": 24})
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    assert sorted(os.listdir(tmp_path)) == ["run.gsd", "run.nc"]
    simulation, d = Simulation(system_of(scene), make_start(scene)), scene.dimension
    simulation.advance(30)
    half = np.array(scene.box)[:, None] / 2
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        assert file.file.application == "dpd-papers" and len(file) == 4
        for number, frame in enumerate(file):
            simulation.advance(5)
            state = simulation.state
            position = state.by_identity(state.position) - half
            beads, configuration = frame.particles, frame.configuration
            np.testing.assert_array_equal(beads.position[:, :d].T, position.astype(np.float32))
            velocity = state.by_identity(state.velocity).astype(np.float32)
            np.testing.assert_array_equal(beads.velocity[:, :d].T, velocity)
            assert configuration.step == 30 + 5 * (number + 1)
            assert configuration.dimensions == d
            thick = [2] * (3 - d)
            assert configuration.box.tolist() == [*scene.box, *thick, 0, 0, 0]
            assert beads.types == list(scene.species)
            np.testing.assert_array_equal(beads.typeid, scene.kinds)
            np.testing.assert_array_equal(frame.bonds.group, scene.bonded)
            assert (beads.mass == 1).all()
            for array in (beads.position, beads.velocity, beads.image):
                assert not array[:, d:].any()


def test_a_run_that_is_stopped_can_be_looked_at(tmp_path):
    """The unfinished file has all frames so far, and the former trajectory is still there."""
    scene = watched(4, CHAINS)
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    former = (tmp_path / "run.gsd").read_bytes()
    settings = Options(every_seconds=60)
    for _ in range(5):
        with pytest.raises(UserError, match="stopped at step") as stopped:
            simulate(scene, tmp_path / "run.nc", make_start(scene), settings, stopping=lambda: 15)
        with gsd.hoomd.open(tmp_path / "run.unfinished.gsd") as file:
            step = int(re.search(r"step (\d+)", str(stopped.value))[1])
            assert len(file) == (step - 10) // 4 > 0
    assert (tmp_path / "run.gsd").read_bytes() == former


def test_frames_that_are_not_those_of_the_checkpoint(tmp_path):
    """The run says so and starts anew, to the same bits."""
    scene, said = watched(4, CHAINS), []
    simulate(scene, tmp_path / "whole.nc", make_start(scene))
    settings = Options(every_seconds=0.0)
    with pytest.raises(Killed):
        simulate(scene, tmp_path / "run.nc", make_start(scene), settings, kill_at(500))
    path = tmp_path / "run.unfinished.gsd"
    with gsd.fl.open(str(path), "r") as file:
        place = file.read_chunk(frame=2, name="particles/position").tobytes()
    data = bytearray(path.read_bytes())
    data[data.index(place) + 100] ^= 1  # in the third frame
    path.write_bytes(data)
    settings = Options(every_seconds=60, say=said.append)
    simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    assert re.search(r"checkpoint that cannot be right \(.*gsd.*\); starting anew", said[0])
    assert frames_of(tmp_path / "run.gsd") == frames_of(tmp_path / "whole.gsd")


def test_frames_hold_what_a_scene_asks_for(tmp_path):
    """One species with the bonds among its beads, without velocities, from the beginning on."""
    asked = {"species": ["A"], "velocities": False, "equilibration": True}
    asked |= {"every": 5, "per_decade": 2, "forces": True}
    scene = Scene(CHAINS | {"steps": {"equilibrate": 13, "sample": 12}, "observe": [
        {"trajectory": asked}, {"thermo": {"every": 4}}]})  # fmt: skip
    settings = Options(every_seconds=0.0)
    with pytest.raises(Killed):
        simulate(scene, tmp_path / "run.nc", make_start(scene), settings, kill_at(16))
    simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    simulation, written = Simulation(system_of(scene), make_start(scene)), scene.kinds == 0
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        assert [frame.configuration.step for frame in file] == [5, 15]
        for frame in file:
            simulation.advance(int(frame.configuration.step) - simulation.state.step)
            place = simulation.state.by_identity(simulation.state.position)[:, written]
            centred = place - np.array(scene.box)[:, None] / 2
            found = frame.particles
            np.testing.assert_array_equal(found.position[:, :2].T, centred.astype(np.float32))
            assert not found.velocity.any() and found.N == 60
            np.testing.assert_array_equal(found.body, np.repeat(np.arange(20), 3))
            bonds = [(3 * k + i, 3 * k + i + 1) for k in range(20) for i in range(2)]
            np.testing.assert_array_equal(frame.bonds.group, bonds)
            held = at_beads(simulation.system, simulation.state)
            np.testing.assert_allclose(
                frame.log["particles/forces"][:, :2], held.force[written], 1e-6
            )
            np.testing.assert_allclose(frame.log["particles/energies"], held.energy[written], 1e-6)
            xx, xy, _, yy, *_ = frame.log["particles/virials"].T
            flat = np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)
            np.testing.assert_allclose(flat, held.virial[written], 1e-6)
            assert frame.log["time"] == pytest.approx(0.02 * frame.configuration.step)


def test_forces_of_beads_are_those_of_the_run(tmp_path):
    """Their energies add up to that of the run, their virials and velocities to its pressure."""
    run = dpd.run(PACKAGE / "scenes" / "frames.yaml", output=tmp_path / "run.nc", progress=False)
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        assert len(file) == 17
        for frame in file:
            there = run.isel(time=(frame.configuration.step - 200) // 10 - 1)
            held = frame.log["particles/energies"].sum()
            moved = (frame.particles.velocity**2).sum() * 375 / 374  # of N - 1 free beads
            virial = frame.log["particles/virials"][:, [0, 3, 5]].sum()
            assert held == pytest.approx(float(there.pair_energy), rel=1e-5)
            assert (virial + moved) / 375 == pytest.approx(float(there.pressure), rel=1e-5)
            assert abs(frame.log["particles/forces"].sum(axis=0)).max() < 1e-2


def test_freud_finds_the_same_structure(tmp_path):
    """The radial distribution function of each frame, against that of the run at the same steps."""
    scene = Scene(SCENE | {
        "box": 6, "steps": {"equilibrate": 100, "sample": 500},
        "observe": [
            {"rdf": {"every": 10, "range": 2.5, "bin": 0.05}}, {"trajectory": {"every": 10}}
        ],
    })  # fmt: skip
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    found = freud.density.RDF(bins=50, r_max=2.5)
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        for frame in file:
            found.compute(frame, reset=False)
    ours = read(tmp_path / "run.nc")[0]["rdf"].mean(axis=0)
    # freud counts neighbours per bead and density, N / V; we have (N - 1) / V, of 647 others.
    np.testing.assert_allclose(found.rdf * 648 / 647, ours, rtol=2e-3, atol=2e-3)
    assert ours.max() > 1.1


def test_mdanalysis_finds_the_same_beads_bonds_and_times(tmp_path):
    scene = Scene(CHAINS | {
        "steps": {"equilibrate": 50, "sample": 400},
        "observe": [{"trajectory": {"every": 4}}],
    })  # fmt: skip
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    found = MDAnalysis.Universe(tmp_path / "run.gsd")
    assert len(found.trajectory) == 100 and len(found.atoms) == scene.beads
    np.testing.assert_array_equal(found.bonds.indices, scene.bonded)
    assert found.atoms.types.tolist() == [scene.species[kind] for kind in scene.kinds]
    np.testing.assert_allclose(found.dimensions, [7, 8, 2, 90, 90, 90])
    assert len(found.residues) == len(scene.lengths)
    np.testing.assert_array_equal(found.residues[3].atoms.indices, range(15, 20))
    # Its reader asks no file for times: it takes dt and the first time from its user.
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        times = [float(frame.log["time"][0]) for frame in file]
    timed = MDAnalysis.Universe(tmp_path / "run.gsd", dt=times[1] - times[0], time_offset=times[0])
    np.testing.assert_allclose([step.time for step in timed.trajectory], times, rtol=1e-12)
    np.testing.assert_allclose(times, 0.02 * (50 + 4 * np.arange(1, 101)), rtol=1e-12)
