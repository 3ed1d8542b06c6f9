"""Trajectories: what is in them, who reads them, and the same bits however often one is killed."""

import os
import random
import re
import resource

import gsd.fl
import gsd.hoomd
import numpy as np
import pytest

from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.files import read
from dpd.observe.chains import sizes
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE

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


def unfolded(path):
    """(frames, n, 3) positions, each bead along its way through the images."""
    with gsd.hoomd.open(path) as file:
        return np.array([
            frame.particles.position
            + frame.particles.image * frame.configuration.box[:3].astype(float)
            for frame in file
        ])  # fmt: skip


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


def test_images_are_those_of_a_bead_that_is_followed_step_by_step(tmp_path):
    scene = watched(5, steps={"equilibrate": 0, "sample": 400})
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    simulation, box = Simulation(system_of(scene), make_start(scene)), np.array(scene.box)[:, None]
    moved, last = 0, None
    for step in range(1, 401):
        simulation.advance(1)
        now = simulation.state.by_identity(simulation.state.position)
        if step > 5:
            moved = moved + (now - last + box / 2) % box - box / 2
        last = now
    found = unfolded(tmp_path / "run.gsd")
    np.testing.assert_allclose((found[-1] - found[0]).T, moved, atol=1e-5)
    assert np.abs(moved).max() > 4


class Killed(BaseException):
    """What ends a run at once, without any of its clean-up."""


def kill_after(steps):
    """Progress that ends a run."""

    def progress(done):
        if done >= steps:
            raise Killed

    return progress


def test_a_run_that_was_killed_leaves_the_same_file(tmp_path):
    """Frames up to 600, for which the index of the file grows three times; killed at 8 places."""
    scene = watched(1, CHAINS)
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    simulate(scene, whole / "run.nc", make_start(scene))
    rng, stops = random.Random(1), 0
    for _ in range(8):
        settings, kill = Options(every_seconds=rng.choice([0, 1e9])), rng.randrange(1, 610)
        try:
            simulate(scene, killed / "run.nc", make_start(scene), settings, kill_after(kill))
        except Killed:
            stops += 1
            assert not (killed / "run.gsd").exists()
    assert stops
    simulate(scene, killed / "run.nc", make_start(scene), Options(every_seconds=60))
    assert (killed / "run.gsd").read_bytes() == (whole / "run.gsd").read_bytes()
    assert sorted(os.listdir(killed)) == ["run.gsd", "run.nc"]
    with gsd.hoomd.open(killed / "run.gsd") as file:
        assert len(file) == 600


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


def damage(path, number):
    """Change a byte of the third frame's positions."""
    with gsd.fl.open(str(path), "r") as file:
        place = file.read_chunk(frame=2, name="particles/position").tobytes()
    data = bytearray(path.read_bytes())
    data[data.index(place) + number] ^= 1
    path.write_bytes(data)


WRONG = {
    "gone": lambda path: path.unlink(),
    "other bits": lambda path: damage(path, 100),
    "no index": lambda path: path.write_bytes(path.read_bytes()[:300] + bytes(20_000)),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("case", WRONG)
def test_frames_that_are_not_those_of_the_checkpoint(tmp_path, case):
    """The run says so and starts anew, to the same bits."""
    scene, said = watched(4, CHAINS), []
    simulate(scene, tmp_path / "whole.nc", make_start(scene))
    settings = Options(every_seconds=0.0)
    with pytest.raises(Killed):
        simulate(scene, tmp_path / "run.nc", make_start(scene), settings, kill_after(500))
    WRONG[case](tmp_path / "run.unfinished.gsd")
    settings = Options(every_seconds=60, say=said.append)
    simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    assert re.search(r"checkpoint that cannot be right \(.*gsd.*\); starting anew", said[0])
    assert (tmp_path / "run.gsd").read_bytes() == (tmp_path / "whole.gsd").read_bytes()


def test_molecules_are_whole_from_the_start_on(tmp_path):
    """In the state, by its counts alone, and in frames far apart."""
    scene = Scene(CHAINS | {
        "steps": {"equilibrate": 1000, "sample": 9000},
        "observe": [{"chains": {"every": 3000}}, {"trajectory": {"every": 3000}}],
    })  # fmt: skip
    start, system = make_start(scene), system_of(scene)
    simulation = Simulation(system, start)
    for steps in (1, 2500):
        simulation.advance(steps)
        one, other = scene.bonded.T
        bonds = simulation.unfolded[:, one] - simulation.unfolded[:, other]
        assert np.sqrt((bonds**2).sum(axis=0)).max() < 1.5
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    result, _ = read(tmp_path / "run.nc")
    places = unfolded(tmp_path / "run.gsd")[:, :100, :2].reshape(-1, 20, 5, 2)
    found = [sizes(frame)[0] for frame in places.transpose(0, 3, 1, 2)]
    assert len(found) == 3
    np.testing.assert_allclose(np.mean(found), result["gyration_square"][:, 0].mean(), rtol=1e-5)


def test_frames_hold_what_a_scene_asks_for(tmp_path):
    """One species with the bonds among its beads, without velocities, from the beginning on."""
    asked = {"every": 5, "species": ["A"], "velocities": False, "equilibration": True}
    scene = Scene(CHAINS | {"steps": {"equilibrate": 13, "sample": 12}, "observe": [
        {"trajectory": asked}, {"thermo": {"every": 4}}]})  # fmt: skip
    settings = Options(every_seconds=0.0)
    with pytest.raises(Killed):
        simulate(scene, tmp_path / "run.nc", make_start(scene), settings, kill_after(16))
    simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    simulation, written = Simulation(system_of(scene), make_start(scene)), scene.kinds == 0
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        assert [frame.configuration.step for frame in file] == [5, 10, 15, 20, 25]
        for frame in file:
            simulation.advance(5)
            place = simulation.state.by_identity(simulation.state.position)[:, written]
            centred = place - np.array(scene.box)[:, None] / 2
            found = frame.particles
            np.testing.assert_array_equal(found.position[:, :2].T, centred.astype(np.float32))
            assert not found.velocity.any() and found.N == 60
            np.testing.assert_array_equal(found.body, np.repeat(np.arange(20), 3))
            bonds = [(3 * k + i, 3 * k + i + 1) for k in range(20) for i in range(2)]
            np.testing.assert_array_equal(frame.bonds.group, bonds)
            assert frame.log["time"] == pytest.approx(0.02 * frame.configuration.step)


def test_a_disk_that_is_full_later(tmp_path):
    """A sentence, and the checkpoint stays; then the run goes on, to the same bits."""
    scene, said = watched(4, CHAINS), []
    simulate(scene, tmp_path / "whole.nc", make_start(scene))
    size = (tmp_path / "whole.gsd").stat().st_size
    settings = Options(every_seconds=0.0, say=said.append)
    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(0.3 * size), former[1]))
    try:
        with pytest.raises(UserError, match=r"unfinished\.gsd: cannot be written \(File too large"):
            simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, former)
    assert (tmp_path / "run.checkpoint").exists() and not (tmp_path / "run.gsd").exists()
    simulate(scene, tmp_path / "run.nc", make_start(scene), settings)
    assert (tmp_path / "run.gsd").read_bytes() == (tmp_path / "whole.gsd").read_bytes()
    assert not any(said)
