"""Long runs: killed, stopped, short of room, with a checkpoint that is no good."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
import yaml

from dpd.digest import ROOT
from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.errors import Stopped, UserError
from dpd.files import check_room
from dpd.observe.common.measured import observables
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

SCENE = {
    "dimension": 3,
    "box": 4,
    "molecules": [{"architecture": "A 4", "density": 3}],
    "repulsion": {"A A": 25},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "dpd-vv", "dt": 0.02},
    "steps": {"equilibrate": 20, "sample": 3000},
    "observe": ["thermo", {"displacement": {"every": 5}}, {"end_to_end": {"every": 5}}],
}
KEY = {"scene": "this one"}


def new_run():
    """A simulation and its observers at their beginning."""
    scene = Scene(SCENE)
    system = system_of(scene)
    return Simulation(system, make_start(scene)), observables(scene, system)


@pytest.fixture
def kept(tmp_path):
    """A checkpoint after 100 steps, and its bytes."""
    simulation, observers = new_run()
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    run(simulation, (20, 80), observers)
    assert checkpoint.save(simulation, observers) == ""
    return checkpoint


def stored(checkpoint):
    with np.load(checkpoint.path) as file:
        return dict(file)


def rewritten(checkpoint, change):
    """The same file with other arrays."""
    arrays = stored(checkpoint)
    change(arrays)
    with open(checkpoint.path, "wb") as file:
        np.savez(file, **arrays)


BAD = {
    "cut": lambda kept: kept.path.write_bytes(kept.path.read_bytes()[:-2000]),
    "empty": lambda kept: kept.path.write_bytes(b""),
    "a part is lost": lambda kept: rewritten(kept, lambda arrays: arrays.pop("force")),
    "another shape": lambda kept: rewritten(
        kept, lambda arrays: arrays.update({"0/kT": arrays["0/kT"][:-1]})
    ),
    "another scene": lambda kept: setattr(kept, "key", json.dumps({"scene": "another"})),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_checkpoint_is_refused_and_changes_nothing(kept, name):
    """The sentence names file and reason; state and observers stay at their beginning."""
    simulation, observers = new_run()
    assert kept.resume(simulation, observers) == ""
    assert simulation.state.step == 100
    BAD[name](kept)
    simulation, observers = new_run()
    state = simulation.state
    before = [{n: a.copy() for n, a in o.arrays.items()} for o in observers]
    said = kept.resume(simulation, observers)
    reason = "another scene" if name == "another scene" else "damaged"
    assert str(kept.path) in said and reason in said and "starting anew" in said
    assert simulation.state is state
    for observer, arrays in zip(observers, before):
        for each, array in arrays.items():
            np.testing.assert_array_equal(observer.arrays[each], array, err_msg=each)


def test_a_run_that_fails_names_its_own_last_state_alone(tmp_path):
    """Not a checkpoint of another scene that lies there."""
    path = tmp_path / "run.checkpoint"
    Checkpoint(path, KEY).save(*new_run())
    scene = Scene(SCENE | {"integrator": {"scheme": "gw-vv", "dt": 5}})
    with pytest.raises(UserError, match="blew up") as caught:
        simulate(scene, tmp_path / "run.nc", make_start(scene), Options(every_seconds=60))
    assert "last good state" not in str(caught.value)
    scene = Scene(SCENE)
    with pytest.raises(Stopped, match=r"last good state is in .*run\.checkpoint"):
        simulate(
            scene, tmp_path / "run.nc", make_start(scene), Options(every_seconds=60),
            stopping=lambda: 15,
        )  # fmt: skip


def test_a_checkpoint_that_cannot_be_written_does_not_end_a_run(kept, monkeypatch):
    """A full disk for a while: a sentence, no half file, the former one stays, the run goes on."""
    former = kept.path.read_bytes()

    def full(file, **arrays):
        file.write(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    simulation, observers = new_run()
    said = []
    done = run(simulation, (20, 500), observers, kept, every_seconds=0.0, say=said.append)
    assert done == 420 and simulation.state.step == 520
    problems = [sentence for sentence in said if sentence]
    assert len(problems) == 1 and "No space left" in problems[0] and "going on" in problems[0]
    assert kept.path.read_bytes() == former
    assert [path.name for path in kept.path.parent.iterdir()] == [kept.path.name]


def test_a_run_that_is_asked_to_stop_saves_its_state(tmp_path):
    """It ends at the next look at the clock, and goes on from there to the same bits."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    first, observers = new_run()
    with pytest.raises(Stopped, match="as asked"):
        run(first, (20, 1000), observers, checkpoint, stopping=lambda: first.state.step >= 300)
    second, observers = new_run()
    run(second, (20, 1000), observers, checkpoint)
    whole, whole_observers = new_run()
    run(whole, (20, 1000), whole_observers)
    np.testing.assert_array_equal(second.state.position, whole.state.position)
    for found, expected in zip(observers, whole_observers):
        for name, array in expected.arrays.items():
            np.testing.assert_array_equal(found.arrays[name], array, err_msg=name)


def test_room_is_asked_for_before_a_run(tmp_path, monkeypatch):
    """A full disk and a place that is no folder are errors with file and remedy."""
    check_room(tmp_path / "new" / "run.nc", 10)
    assert list((tmp_path / "new").iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot be written"):
        check_room(tmp_path / "file" / "run.nc", 10)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=5 * 2**20))
    with pytest.raises(UserError, match=r"5\.0 MiB are free there, 9\.0 MiB are needed"):
        check_room(tmp_path / "run.nc", 9 * 2**20)


def command(folder, name):
    """``python -m dpd run`` on `SCENE`, with a checkpoint after every stretch."""
    (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE))
    arguments = ["run", "scene.yaml", "-o", name, "--checkpoint-every", "0"]
    return subprocess.Popen(
        [sys.executable, "-m", "dpd", *arguments], cwd=folder, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
    )  # fmt: skip


def wait_for_step(path, step):
    """Until a checkpoint beyond a step is there, and beyond the one that the run began with.

    False if the run has ended before.
    """

    def now():
        return stored(SimpleNamespace(path=path))["step"] if path.exists() else 0

    began = now()  # a process that has only begun would not hear a signal
    while now() < max(step, began + 1):
        if path.with_suffix(".nc").exists():
            return False
    return True


@pytest.mark.thorough
def test_a_run_killed_at_random_moments_ends_like_one_that_was_not(tmp_path):
    """SIGKILL twice, SIGTERM and Ctrl-C once, at steps that differ from day to day."""
    rng = np.random.default_rng()
    moments = np.sort(rng.integers(30, 2500, size=4))
    print("moments", moments)  # to repeat a failure
    numbers = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGKILL)
    for moment, number in zip(moments, numbers):
        with command(tmp_path, "run.nc") as process:
            if not wait_for_step(tmp_path / "run.checkpoint", moment):
                break
            process.send_signal(number)
            errors = process.communicate()[1]
        if number != signal.SIGKILL and not (tmp_path / "run.nc").exists():
            assert process.returncode == 128 + number and "stopped at step" in errors
            assert "run.checkpoint" in errors and "Traceback" not in errors
    for name in ("run.nc", "whole.nc"):
        with command(tmp_path, name) as process:
            assert process.communicate()[0] and process.returncode == 0
    found, expected = (netCDF4.Dataset(tmp_path / name) for name in ("run.nc", "whole.nc"))
    with found, expected:
        assert found.variables.keys() == expected.variables.keys()
        for name, variable in expected.variables.items():
            np.testing.assert_array_equal(found[name][...], variable[...], err_msg=name)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.nc", "scene.yaml", "whole.nc"]
