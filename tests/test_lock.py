"""The lock beside a result: who is at work, and who is no more."""

import errno
import json
import os
import threading
import time
from pathlib import Path

import pytest
from filelock import FileLock

from dpd.errors import UserError
from dpd.runs import lock as module
from dpd.runs.lock import alone, lock_of, worker_on

LOCK = Path("run.nc.lock")


@pytest.fixture
def owner(tmp_path, monkeypatch):
    """What a lock of ours says of its owner, where signs of life are frequent."""
    monkeypatch.chdir(tmp_path)
    for name, seconds in (("POLL", 0.02), ("SIGN", 0.05), ("SILENCE", 0.6)):
        monkeypatch.setattr(module, name, seconds)
    with alone("run.nc", print):
        found = json.loads(LOCK.read_text())
        with pytest.raises(UserError, match=f"process {os.getpid()}"), alone("run.nc", print):
            pass
    assert made() == []
    return found


def made():
    """Names of what is here."""
    return sorted(os.listdir())


def test_a_lock_of_a_process_that_was_killed_is_taken_over(owner):
    """At once, whatever process has its number now; what it had reported is known."""
    said = []
    LOCK.write_text(json.dumps(owner | {"steps": 7}))
    assert not worker_on("run.nc").alive
    with alone("run.nc", said.append) as lock:
        assert lock.left["steps"] == 7 and worker_on("run.nc").alive
    assert made() == [] and len(said) == 1 and "taking over" in said[0]


@pytest.mark.parametrize("wait", [False, True])
def test_a_dead_lock_of_another_machine_is_taken_over(owner, wait):
    """After a while without a sign of life, and not before."""
    said, begun = [], time.monotonic()
    LOCK.write_text(json.dumps(owner | {"host": "elsewhere"}))
    with alone("run.nc", said.append, wait):
        assert time.monotonic() - begun >= 0.6
        assert json.loads(LOCK.read_text())["host"] == owner["host"]
    assert made() == [] and len(said) == 2
    assert "another machine" in said[0] and "taking over" in said[1]


def test_a_living_lock_of_another_machine_is_respected(owner):
    """It is refused, or waited for as long as it takes."""
    said, ended = [], threading.Event()
    LOCK.write_text(json.dumps(owner | {"host": "elsewhere"}))

    def live():
        while not ended.wait(0.05):
            os.utime(LOCK)
        LOCK.unlink()

    other = threading.Thread(target=live)
    other.start()
    try:
        refused = pytest.raises(UserError, match=r"another run is at work on it .* on elsewhere")
        with refused, alone("run.nc", print):
            pass
        threading.Timer(1.5, ended.set).start()
        with alone("run.nc", said.append, wait=True):
            assert ended.is_set()
    finally:
        ended.set()
        other.join()
    assert made() == [] and any("waiting for it" in sentence for sentence in said)


def test_a_run_gives_signs_of_life_until_it_ends(owner):
    """Another machine would see them."""
    seen = set()
    with alone("run.nc", print):
        for _ in range(30):
            seen.add(LOCK.stat().st_mtime_ns)
            time.sleep(0.02)
    assert len(seen) > 3 and made() == []


def test_a_run_that_was_taken_for_dead_stops(owner):
    """As one that is suspended for long; the lock of the other stays."""
    with pytest.raises(UserError, match="took this one for dead"), alone("run.nc", print) as lock:
        lock.report({"step": 1})
        LOCK.write_text(json.dumps(owner | {"host": "elsewhere"}))
        lock.report({"step": 2})
    assert made() == ["run.nc.lock"] and "step" not in json.loads(LOCK.read_text())


def test_a_lock_that_cannot_be_written_is_not_in_the_way(owner, monkeypatch):
    """The disk is full: room is asked for."""

    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(module, "_write", full)
        refused = pytest.raises(UserError, match=r"No space left on device\); make room there or")
        with refused, alone("run.nc", print):
            pass
    with alone("run.nc", print):
        pass
    assert made() == []


def test_a_link_in_the_place_of_a_lock_is_not_followed(owner):
    """Whatever it leads to stays, and nothing is made there."""
    Path("mine").write_text("")
    for target in ("mine", "nothing"):
        os.symlink(target, LOCK)
        with pytest.raises(UserError, match="remove the link"), alone("run.nc", print):
            pass
        os.remove(LOCK)
    assert made() == ["mine"] and Path("mine").read_text() == ""


def test_where_files_cannot_be_locked_the_process_is_looked_for(owner, monkeypatch):
    """As on some cluster's disks: alive, or dead."""

    def unknown(*arguments, **more):
        LOCK.touch()
        raise OSError(errno.ENOSYS, "Function not implemented")

    monkeypatch.setattr(FileLock, "acquire", unknown)
    monkeypatch.setattr("fcntl.flock", unknown)
    said = []
    with alone("run.nc", said.append):
        assert worker_on("run.nc").alive
        with pytest.raises(UserError, match="at work"), alone("run.nc", said.append):
            pass
    lock_of("run.nc").write_text(json.dumps(owner | {"pid": 2**22 + 1}))
    with alone("run.nc", said.append):
        pass
    assert len(said) == 1 and "taking over" in said[0] and made() == []
