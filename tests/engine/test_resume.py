"""An interrupted run goes on to the same bits as one that was left alone."""

import json
import os
import signal
import subprocess
import sys

import netCDF4
import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import advance_looking, run
from dpd.engine.simulation import Simulation
from dpd.files import remove_drafts
from dpd.observe.common.measured import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.systems import assert_same_state, make_simulation

SCENE = {
    "dimension": 2,
    "box": [4.0, 5.5],
    "molecules": [{"architecture": "A 3 B", "count": 10}, {"architecture": "B", "count": 15}],
    "repulsion": {"A A": 25, "A B": 40, "B B": 30},
    "bond": {"stiffness": 20, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.03},
    "steps": {"equilibrate": 1020, "sample": 200},
    "observe": [
        {"thermo": {"every": 5}},
        {"rdf": {"every": 10, "range": 2}},
        {"profile": {"every": 20}},
        {"bonds": {"every": 20}},
    ],
}
LAST = 1220
KEY = {"scene": "this", "sources": "these"}


class Interrupted(Exception):
    """What stops a run from outside."""


def new_run(seed=1):
    """A simulation at its start, its observers, and its steps."""
    scene = Scene(SCENE | {"seed": seed})
    system, start = system_of(scene), make_start(scene)
    simulation = make_simulation(system, start.position, start.velocity, start.species)
    return simulation, observables(scene, system), scene.steps


def stop_at(last):
    """Progress that interrupts the run once it has come to a step."""

    def progress(step):
        if step >= last:
            raise Interrupted

    return progress


def interrupted_run(checkpoint, last):
    """Run from the start until interrupted, saving after every stretch of steps."""
    simulation, observers, steps = new_run()
    with pytest.raises(Interrupted):
        run(simulation, steps, observers, checkpoint, stop_at(last), every_seconds=0.0)


def assert_same_run(one, other):
    """State and all that was observed agree bit for bit."""
    assert_same_state(one[0].state, other[0].state)
    for a, b in zip(one[1], other[1]):
        assert a.arrays.keys() == b.arrays.keys()
        for name, array in a.arrays.items():
            np.testing.assert_array_equal(array, b.arrays[name], err_msg=name)


@pytest.fixture(scope="module")
def whole():
    """A run that nothing interrupts."""
    simulation, observers, steps = new_run()
    assert run(simulation, steps, observers) == LAST
    return simulation, observers


@pytest.mark.parametrize(
    "last, saved",
    [(1000, 500), (1025, 1000), (1115, 1110), (LAST, 1210)],
    ids=["equilibrating", "at the first sample", "sampling", "after the last sample"],
)
def test_interrupted_run_goes_on_to_the_same_bits(whole, tmp_path, last, saved):
    """Whatever came after the last checkpoint is done again, and no more than that."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    interrupted_run(checkpoint, last)
    simulation, observers, steps = new_run()
    assert run(simulation, steps, observers, checkpoint) == LAST - saved
    assert_same_run((simulation, observers), whole)


def test_run_interrupted_many_times(whole, tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    for last in (1000, 1025, 1100, 1100, 1140):
        interrupted_run(checkpoint, last)
    simulation, observers, steps = new_run()
    run(simulation, steps, observers, checkpoint)
    assert_same_run((simulation, observers), whole)


@pytest.mark.few(1)
@pytest.mark.parametrize("change", [{}, {"pairs": {"search": "list", "skin": 0.15}}])
def test_steps_with_looks_between_lead_to_the_same_bits(change):
    """As many looks as there are whole stretches before the end."""
    scene = Scene(SCENE | change)
    one, other = (Simulation(system_of(scene), make_start(scene)) for _ in range(2))
    looks = []
    advance_looking(one, 1700, lambda: looks.append(one.state.step))
    other.advance(1700)
    assert looks == [500, 1000, 1500]
    assert_same_state(one.state, other.state)


def test_no_checkpoint_before_its_time(tmp_path):
    """Saved by the clock: a run shorter than the interval leaves no file."""
    simulation, observers, steps = new_run()
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    run(simulation, steps, observers, checkpoint, every_seconds=3600.0)
    assert list(tmp_path.iterdir()) == []


def test_checkpoint_of_another_run_is_ignored(whole, tmp_path):
    """Another scene or other sources: the run begins at the beginning."""
    path = tmp_path / "run.checkpoint"
    interrupted_run(Checkpoint(path, KEY | {"sources": "others"}), 1115)
    simulation, observers, steps = new_run()
    assert run(simulation, steps, observers, Checkpoint(path, KEY)) == LAST
    assert_same_run((simulation, observers), whole)


def test_kill_while_writing_leaves_the_former_file(whole, tmp_path, monkeypatch):
    """Half a file is written under another name, and later neither read nor in the way."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    interrupted_run(checkpoint, 1115)
    former = checkpoint.path.read_bytes()

    def write_half(file, **arrays):
        file.write(former[: len(former) // 2])
        file.flush()
        raise Interrupted

    with monkeypatch.context() as broken, pytest.raises(Interrupted):
        broken.setattr("numpy.savez", write_half)
        checkpoint.save(*new_run()[:2])
    assert checkpoint.path.read_bytes() == former
    simulation, observers, steps = new_run()
    assert run(simulation, steps, observers, checkpoint, every_seconds=0.0) == LAST - 1110
    assert_same_run((simulation, observers), whole)
    assert list(tmp_path.iterdir()) == [checkpoint.path]


def test_discarded_checkpoint_is_gone(tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    checkpoint.save(*new_run()[:2])
    checkpoint.discard()
    assert list(tmp_path.iterdir()) == []
    checkpoint.discard()


def test_ten_steps_are_three_and_seven():
    """The same bits of state, virial and energy, measured on the way or not."""
    one, other = new_run()[0], new_run()[0]
    sums = one.advance_measured(10)
    other.advance_measured(3)
    again = other.advance_measured(7)
    assert_same_state(one.state, other.state)
    np.testing.assert_array_equal(sums.virial, again.virial)
    np.testing.assert_array_equal(sums.energy, again.energy)
    third = new_run()[0]
    third.advance(10)
    assert_same_state(third.state, one.state)


def test_seed_decides_the_noise():
    """Another seed is another trajectory from the same start; the same seed is the same."""
    one, same, other = (new_run(seed)[0] for seed in (1, 1, 2))
    other.state = make_simulation(
        other.system, one.state.position, one.state.velocity, one.state.species,
        one.state.identity,
    ).state  # fmt: skip
    for simulation in (one, same, other):
        simulation.advance(10)
    assert_same_state(one.state, same.state)
    assert np.abs(one.state.velocity - other.state.velocity).max() > 0.1


PROGRAM = """
import json, sys
from dpd.scene.scene import Scene
from dpd.runs.run import Options, simulate
from dpd.start.common.make import make_start
text, result = sys.argv[1:]
scene = Scene(json.loads(text))
show = lambda step: print(step, flush=True)
simulate(scene, result, make_start(scene), Options(every_seconds=0.0), show)
"""
LONG = SCENE | {"steps": {"equilibrate": 20, "sample": 6_000}}


def process(result):
    """A Python of its own that runs `LONG`; each line that it prints is a step."""
    arguments = [json.dumps(LONG), str(result)]
    paths = {"PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        stdout=subprocess.PIPE, text=True, env=os.environ | paths,
    )  # fmt: skip


def read_all(path):
    """Every variable of a result."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return {name: variable[...] for name, variable in file.variables.items()}


def test_killed_process_resumes_to_the_same_bits(tmp_path):
    """SIGKILL in the middle, a new process, and the file of a run that was never killed."""
    killed, whole = tmp_path / "killed.nc", tmp_path / "whole.nc"
    with process(killed) as first:
        for line in first.stdout:
            if int(line) >= 300:
                break
        first.send_signal(signal.SIGKILL)
    assert first.returncode == -signal.SIGKILL
    assert killed.with_suffix(".checkpoint").exists()
    assert not killed.exists()
    remove_drafts(killed.with_suffix(".checkpoint"))  # as `dpd.runs.run` does
    with process(killed) as second, process(whole) as other:
        resumed_at = int(second.stdout.readline())
        for run_of in (second, other):
            run_of.communicate()
    assert (second.returncode, other.returncode) == (0, 0)
    assert resumed_at > 290
    found, expected = read_all(killed), read_all(whole)
    assert found.keys() == expected.keys() >= {"kT", "pressure_tensor", "rdf", "bond_mean"}
    for name, array in expected.items():
        np.testing.assert_array_equal(found[name], array, err_msg=name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["killed.nc", "whole.nc"]
