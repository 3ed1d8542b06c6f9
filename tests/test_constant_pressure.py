"""Scenes at constant pressure, from what they may say to what their runs leave."""

from types import SimpleNamespace

import numpy as np
import pytest

import dpd
from dpd import files
from dpd.engine.loop import stored_in
from dpd.engine.simulation import Simulation, Snapshot
from dpd.engine.space import wrapped
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.folders import PACKAGE
from dpd.observe.common.snapshot import Snapshot as Seen
from dpd.observe.displacement import displacements, followed
from dpd.particles import read
from dpd.pipeline.status import look_at
from dpd.runs.result import pressure_warning
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge
from dpd.start.common.files import read_start, starting_from, write_start
from dpd.start.common.make import make_start, system_of
from tests import test_extend
from tests.conftest import SCENE
from tests.systems import Killed, kill_at

FLUID = SCENE | {
    "pressure": {"target": 23.7, "time": 0.5},
    "steps": {"equilibrate": 100, "sample": 400},
    "observe": [
        {"thermo": {"every": 3}}, {"rdf": {"range": 1.5, "every": 10}}, {"profile": {"every": 3}},
        "configuration",
    ],
}  # fmt: skip


def run(*given, **settings):
    """What a run that keeps its state leaves."""
    return files.read(test_extend.run(*given, **settings))


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A finished run: its file, variables, attributes."""
    path = tmp_path_factory.mktemp("done") / "run.nc"
    return SimpleNamespace(path=path, found=run(FLUID, path))


def test_what_a_scene_leaves_to_us():
    """The compressibility is that of p = rho kT + alpha a rho^2, alpha = pi / 30 in mean field."""
    scene = Scene(FLUID)
    law = scene.data["pressure"]
    expected = 1 / (3 + 2 * np.pi / 30 * 25 * 9)
    assert law["compressibility"] == pytest.approx(expected, rel=1e-3)
    assert law["every"] == round(0.5 / 5 / 0.04)
    given = 23.7, 0.5, law["compressibility"], (0, 1, 2), law["every"]
    assert system_of(scene).pressure[:5] == given
    again = Scene(scene.data)
    assert again.data == scene.data and again.digest == scene.digest


@pytest.mark.parametrize(
    ("box", "target", "words"), [(2.2, 500, "is too high for it"), (3, 0.001, "is too low for it")]
)
def test_box_that_becomes_too_small_or_too_large(tmp_path, box, target, words):
    """One sentence with the target and the remedy, and no file."""
    change = {"box": box, "pressure": {"target": target}, "steps": {"equilibrate": 9000}}
    with pytest.raises(UserError, match=rf"pressure\.target {target} {words}"):
        run(merge(FLUID, change) | {"observe": ["thermo"]}, tmp_path / "run.nc")
    assert not (tmp_path / "run.nc").exists()


def test_what_a_run_leaves(done):
    """Volumes over time, pressures with the volume of each sample, densities in that volume."""
    variables, attributes = done.found
    volume = variables["volume"]
    assert len(volume) == 400 // 3 and np.ptp(volume) > 1
    assert attributes["number_density"] == pytest.approx(np.mean(192 / volume), rel=1e-12)
    assert attributes["last_box"] == pytest.approx(variables["box_edges"], rel=0)
    ideal = 192 * variables["kT"] / volume
    np.testing.assert_allclose(
        variables["pressure"], ideal + variables["excess_conservative"], rtol=1e-12
    )
    # Both look at the same steps: the mean over all slices is N / V of each block.
    assert variables["density_profile"].shape[0] == 50
    blocks = np.minimum(np.arange(133) * 50 // 133, 49)
    means = [np.mean(192 / volume[blocks == block]) for block in range(50)]
    np.testing.assert_allclose(variables["density_profile"].mean(axis=(1, 2)), means, rtol=1e-12)


def test_a_run_far_from_its_pressure_says_so():
    """By 5 % and 4 standard errors, in the second half; along the axis that is held."""
    rng = np.random.default_rng(1)
    noise = rng.normal(size=400)
    held = Scene(FLUID | {"pressure": {"target": 23.7, "axes": "z"}})
    tensor = np.zeros((400, 3, 3))
    tensor[:, 2, 2] = 23.7 + noise
    assert pressure_warning(Scene(FLUID), {"pressure": 23.7 + noise}) == ""
    assert "the pressure is 25.9" in pressure_warning(Scene(FLUID), {"pressure": 26 + noise})
    assert pressure_warning(held, {"pressure": 26 + noise, "pressure_tensor": tensor}) == ""


def test_a_checkpoint_holds_the_box(tmp_path):
    """Of its step, for those who read or look at it; also between two trials."""
    path, checkpoint = tmp_path / "run.nc", tmp_path / "run.checkpoint"
    with pytest.raises(Killed):
        run(FLUID, path, kill_at(313), every_seconds=0.0)
    assert stored_in(checkpoint).key["scene"] == Scene(FLUID).digest
    with np.load(checkpoint) as stored:
        box = stored["box"]
    assert (box != 4.0).all()
    assert read(checkpoint).box == tuple(box)
    assert 5 < look_at((), path).measured["pressure"][0] < 50


def test_start_from_a_run_whose_box_has_changed(done, tmp_path):
    """Its box is that of the start, which is said; without pressure that of the scene has to be."""
    last, said = read(done.path), []
    fixed = Scene({key: value for key, value in FLUID.items() if key != "pressure"})
    with pytest.raises(UserError, match="they have to agree"):
        make_start(starting_from(fixed, done.path))
    scene = starting_from(Scene(FLUID), done.path)
    state = make_start(scene, say=said.append)
    np.testing.assert_allclose(state.box, last.box, rtol=1e-7)
    assert any("is that of the start, instead of the scene's" in sentence for sentence in said)
    simulation = Simulation(system_of(scene), state)
    assert simulation.box == state.box
    simulation.advance(5)
    write_start(scene, tmp_path / "start.nc")
    again = read_start(scene, tmp_path / "start.nc")
    assert again.box == state.box == read(tmp_path / "start.nc").box
    np.testing.assert_array_equal(again.position, make_start(scene).position)


def test_to_be_moved_with_the_box_is_no_displacement():
    """Beads at rest in a box that breathes by 30 %, while one goes its way across all faces.

    It moves by 0.6 of an edge from sample to sample; edges are 4 + sin t, and 4 at the first.
    """
    data = FLUID | {"molecules": [{"architecture": "A", "count": 20}]}
    data |= {"pressure": {"target": 1}, "steps": {"sample": 200}}
    scene = Scene(data)
    system = system_of(scene)
    kept = followed(scene)
    scaled = np.random.default_rng(3).random((3, 20))
    identity = np.arange(20, dtype=np.uint32)
    expected = np.zeros((3, 20))
    for t in range(200):
        box = (4 + np.sin(t),) * 3
        place, image = wrapped(scaled * box[0], box)
        state = State(place, np.zeros((3, 20)), None, identity, None, t, box=box, image=image)
        now = Seen(scene, Snapshot(system, state))
        now.sample, now.kept = t, kept
        found = displacements(now)
        expected[0, 7] = 0.6 * 4 * t
        about = expected - expected.mean(axis=1, keepdims=True)
        np.testing.assert_allclose(found, about, atol=1e-11)
        scaled[0, 7] += 0.6


def test_a_trajectory_has_the_box_of_each_frame(tmp_path):
    """And its beads in it; unwrapped they move by less than an edge from frame to frame."""
    data = FLUID | {"observe": [{"trajectory": {"every": 5}}, {"thermo": {"every": 5}}]}
    variables, _ = run(data, tmp_path / "run.nc")
    frames = [read(tmp_path / "run.gsd", frame) for frame in range(80)]
    volumes = [np.prod(frame.box) for frame in frames]
    np.testing.assert_allclose(volumes, variables["volume"], rtol=1e-6)
    for frame in frames:
        edges = np.array(frame.box)[:, None]
        assert (frame.position >= -1e-5).all() and (frame.position <= edges + 1e-5).all()
    scaled = [frame.position / np.array(frame.box)[:, None] + frame.image for frame in frames]
    assert np.abs(np.diff(scaled, axis=0)).max() < 1 / 3
    assert np.abs(scaled[-1] - scaled[0]).max() > 0.5


def test_a_gas_is_compressed(tmp_path):
    """All work is heat: kT V^(2/3) stays, p_zz V goes with 1 / L_z^2; through any kill."""
    gas = dpd.run(PACKAGE / "scenes" / "compression.yaml", progress=False)
    assert gas.kT.values == pytest.approx([2] * 10, rel=0.1)  # standard error 3 %
    for more in ({"pressure": {"target": 20}}, {"shear": {"rate": 1}}):
        with pytest.raises(UserError, match=r"not allowed with 'box'"):
            Scene(FLUID | more | {"box": {"from": 4, "to": 6}})
    free = {"repulsion": {"A A": 0}, "thermostat": {"gamma": 0}, "observe": ["thermo"]}
    same = {"box": {"from": 4, "to": 6, "over": "equilibrate"}}
    steps = {"steps": {"equilibrate": 100, "sample": 60}}
    gas = dpd.run(SCENE | free | same | steps, progress=False)
    before = dpd.run(SCENE | free | steps, progress=False)
    expected = before.kT.mean() * (64 / 216) ** (2 / 3)
    assert gas.volume.values == pytest.approx([216] * 6) and gas.kT.values == pytest.approx(
        [float(expected)] * 6
    )
    whole, _ = run(SCENE | same | steps, tmp_path / "whole.nc")
    with pytest.raises(Killed):
        run(SCENE | same | steps, tmp_path / "run.nc", kill_at(66), every_seconds=0.0)
    again, _ = run(SCENE | same | steps, tmp_path / "run.nc")
    np.testing.assert_array_equal(again["pressure"], whole["pressure"])
    ramp = SCENE | {"box": {"from": 4, "to": 5}, "steps": {"equilibrate": 20, "sample": 30}}
    ramp["observe"] = [{"thermo": {"every": 1}}, "profile", "stress_profile"]
    run(ramp, tmp_path / "short.nc")
    longer = dpd.extend(tmp_path / "short.nc", sample=30, progress=False)
    scene = dict(Scene(ramp).data) | {"steps": {"equilibrate": 20, "sample": 60}}
    np.testing.assert_array_equal(longer.kT, dpd.run(scene, progress=False).kT)
    sim = dpd.Simulation(ramp, progress=False)
    sim.run(50)
    assert sim.snapshot().volume == pytest.approx(float(longer.volume[29]))
