"""What a run resumes from has a checksum, and what it cannot write is no reason to lose it."""

import errno
import json
import os
import resource
import signal
from contextlib import suppress
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import yaml

from dpd import jit
from dpd.engine.loop import Checkpoint, run
from dpd.jit import kernel
from tests.conftest import begin
from tests.systems import Killed, assert_same_state, begun, kill_at
from tests.test_extend import CHAINS, PAGES, assert_same

SCENE = CHAINS | {
    "steps": {"equilibrate": 20, "sample": 700},
    "observe": [
        "thermo", {"rdf": {"range": 2, "every": 10}}, {"displacement": {"every": 5}},
        {"crossings": {"every": 5}}, {"configuration": {"every": 100}},
        {"trace": {"every": 10}},
    ],
}  # fmt: skip
KEY = {"scene": "this"}


def new_run():
    """A simulation with a pair list, and its observers, at their beginning."""
    simulation, observers, _ = begun(SCENE)
    assert simulation.system.skin > 0
    return simulation, observers


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Arrays of a checkpoint after 220 steps."""
    checkpoint = Checkpoint(tmp_path_factory.mktemp("good") / "run.checkpoint", KEY)
    simulation, observers = new_run()
    run(simulation, (20, 200), observers)
    assert checkpoint.save(simulation, observers) == ""
    with np.load(checkpoint.path) as file:
        return dict(file)


@pytest.fixture
def kept(good, tmp_path):
    """The same in a file."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    with open(checkpoint.path, "wb") as file:
        np.savez(file, **good)
    return checkpoint


@pytest.fixture(scope="module")
def whole():
    """A run that nothing interrupts."""
    simulation, observers = new_run()
    assert run(simulation, (1020, 200), observers) == 1220
    return simulation, observers


@pytest.mark.parametrize(
    "last, saved",
    [(1000, 500), (1025, 1000), (1115, 1110), (1220, 1215)],
    ids=["equilibrating", "at the first sample", "sampling", "after the last sample"],
)
def test_a_killed_run_goes_on_to_the_same_bits(whole, tmp_path, last, saved):
    """Whatever came after the last checkpoint is done again, and no more than that."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    simulation, observers = new_run()
    with pytest.raises(Killed):
        run(simulation, (1020, 200), observers, checkpoint, kill_at(last), every_seconds=0.0)
    simulation, observers = new_run()
    assert run(simulation, (1020, 200), observers, checkpoint) == 1220 - saved
    assert_same_state(simulation.state, whole[0].state)
    for found, expected in zip(observers, whole[1]):
        np.testing.assert_equal(found.arrays, expected.arrays)


def flipped(name):
    """Changes one bit of one array: its checksum does not fit."""

    def flip(checkpoint, good):
        whole, values = bytearray(checkpoint.path.read_bytes()), good[name].tobytes("A")
        whole[whole.index(values) + len(values) // 2] ^= 1
        checkpoint.path.write_bytes(whole)

    return flip


BAD = {
    "cut": lambda kept, good: kept.path.write_bytes(kept.path.read_bytes()[:-2000]),
    "another scene": lambda kept, good: setattr(kept, "key", json.dumps({"scene": "another"})),
} | {name: flipped(name) for name in ("position", "dpd_checkpoint", "2.earlier")}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_checkpoint_is_refused_and_changes_nothing(kept, good, name):
    """The sentence names file and reason; state and observers stay at their beginning."""
    simulation, observers = new_run()
    assert kept.resume(simulation, observers) == ""
    assert simulation.state.step == 220
    BAD[name](kept, good)
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
    assert done == 300 and simulation.state.step == 520
    problems = [sentence for sentence in said if sentence]
    assert len(problems) == 1 and "No space left" in problems[0] and "going on" in problems[0]
    assert kept.path.read_bytes() == former
    assert [path.name for path in kept.path.parent.iterdir()] == [kept.path.name]


def test_a_result_that_cannot_be_written_is_not_lost(folder, dpd):
    """The disk is full at the end: a sentence, and the last state is kept; then it goes on."""
    scene = yaml.safe_load((folder / "scene.yaml").read_text())
    scene |= {"pages": [PAGES["trace"]], "observe": [*scene["observe"], {"trace": {"every": 1}}]}
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    code, errors = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 0
    size = os.path.getsize("run.nc")
    os.remove("run.nc")
    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, former[1]))  # as a full disk does
    try:
        code, errors = dpd("run", "scene.yaml", "-o", "run.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, former)
    assert code == 1 and "run.nc: cannot be written (" in errors
    assert len(errors.splitlines()) == 1
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    assert sorted(os.listdir()) == ["run.nc", "scene.yaml"]


def test_a_full_cache_is_no_reason_not_to_run(monkeypatch):
    """A kernel that cannot be kept is compiled and runs; one sentence says so."""

    @kernel()
    def twice(x):
        return 2 * x

    full = Mock(side_effect=OSError(errno.ENOSPC, "No space left on device"))
    monkeypatch.setattr(twice._cache, "_save_overload", full, raising=False)
    monkeypatch.setattr(twice._cache, "_load_overload", full, raising=False)
    with pytest.warns(UserWarning, match="No space left"):
        assert twice(21) == 42


def test_kernels_that_others_could_have_written_are_not_run(tmp_path):
    """Nor kept, in a folder that all may write to."""
    trusts = jit._is_trusted.__wrapped__
    assert trusts(tmp_path / "kernels") and (tmp_path / "kernels").is_dir()
    (tmp_path / "kernels").chmod(0o777)
    jit._warn.cache_clear()
    with pytest.warns(UserWarning, match="another user can write there"):
        assert not trusts(tmp_path / "kernels")
    jit._warn.cache_clear()


LONG = SCENE | {
    "steps": {"equilibrate": 20, "sample": 5000},
    "observe": [*SCENE["observe"], {"trajectory": {"every": 50}}],
}


def command(name):
    """``python -m dpd run`` on `LONG`, with a checkpoint after every stretch."""
    return begin("run", "scene.yaml", "-o", name, "--checkpoint-every", "0")


def wait_for_step(path, step):
    """Until a checkpoint beyond a step is there, and beyond the one that the run began with.

    False if the run has ended before.
    """

    def now():
        with suppress(FileNotFoundError), np.load(path) as file:
            return file["step"]
        return 0

    began = now()  # a process that has only begun would not hear a signal
    while now() < max(step, began + 1):
        if path.with_suffix(".nc").exists():
            return False
    return True


@pytest.mark.thorough
def test_a_run_killed_at_random_moments_ends_like_one_that_was_not(tmp_path, monkeypatch):
    """SIGKILL twice, SIGTERM and Ctrl-C once, at steps that differ from day to day."""
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(yaml.safe_dump(LONG))
    moments = np.sort(np.random.default_rng().integers(30, 4000, size=4))
    print("moments", moments)  # to repeat a failure
    numbers = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGKILL)
    for moment, number in zip(moments, numbers):
        with command("run.nc") as process:
            if not wait_for_step(Path("run.checkpoint"), moment):
                break
            process.send_signal(number)
            errors = process.communicate()[1]
        if number != signal.SIGKILL and not Path("run.nc").exists():
            assert process.returncode == 128 + number and "stopped at step" in errors
    for name in ("run.nc", "whole.nc"):
        with command(name) as process:
            assert process.communicate()[0] and process.returncode == 0
    assert_same("run.nc", "whole.nc")
    assert sorted(os.listdir()) == ["run.gsd", "run.nc", "scene.yaml", "whole.gsd", "whole.nc"]
