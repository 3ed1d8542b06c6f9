"""The lock beside a result: who is at work, and who is no more."""

import errno
import json
import os
import threading
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from dpd.errors import UserError
from dpd.pipeline.lock import alone, told_before


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder."""
    monkeypatch.chdir(tmp_path)


def made():
    """Names of what is here."""
    return sorted(os.listdir())


def write_elsewhere(owner):
    """Put the lock of a run on another machine there."""
    Path("run.nc.lock").write_text(json.dumps(owner | {"host": "elsewhere", "boot": "another"}))


@pytest.fixture
def owner(here, monkeypatch):
    """What a lock of ours says of its owner, where signs of life are frequent."""
    for name, seconds in (("POLL", 0.02), ("SIGN", 0.05), ("SILENCE", 0.6)):
        monkeypatch.setattr(f"dpd.pipeline.lock.{name}", seconds)
    with alone("run.nc", print):
        found = json.loads(Path("run.nc.lock").read_text())
        with pytest.raises(UserError, match=f"process {os.getpid()}"), alone("run.nc", print):
            pass
    assert made() == []
    return found


def test_a_lock_of_this_machine_before_its_start_is_taken_over(owner):
    """At once."""
    said = []
    Path("run.nc.lock").write_text(json.dumps(owner | {"boot": "before"}))
    with alone("run.nc", said.append):
        assert json.loads(Path("run.nc.lock").read_text())["pid"] == os.getpid()
    assert made() == [] and len(said) == 1 and "taking over" in said[0]


@pytest.mark.parametrize("wait", [False, True])
def test_a_dead_lock_of_another_machine_is_taken_over(owner, wait):
    """After a while without a sign of life, and not before."""
    said, begun = [], time.monotonic()
    write_elsewhere(owner)
    with alone("run.nc", said.append, wait):
        assert time.monotonic() - begun >= 0.6
        assert json.loads(Path("run.nc.lock").read_text())["host"] == owner["host"]
    assert made() == [] and len(said) == 2
    assert "another machine" in said[0] and "taking over" in said[1]


def test_a_living_lock_of_another_machine_is_respected(owner):
    """It is refused, or waited for as long as it takes."""
    lock, said, ended = Path("run.nc.lock"), [], threading.Event()
    write_elsewhere(owner)

    def live():
        while not ended.wait(0.05):
            os.utime(lock)
        lock.unlink()

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
    assert made() == [] and "waiting for it" in said[-1]


def test_a_run_gives_signs_of_life_until_it_ends(owner):
    """Another machine would see them."""
    lock, seen = Path("run.nc.lock"), set()
    with alone("run.nc", print):
        for _ in range(30):
            seen.add(lock.stat().st_mtime_ns)
            time.sleep(0.02)
    assert len(seen) > 3 and made() == []


def test_a_run_that_was_taken_for_dead_stops(owner, monkeypatch):
    """As one that is suspended for long; the lock of the other stays."""
    asked, said = threading.Event(), []
    monkeypatch.setattr("dpd.pipeline.lock.ask", asked.set)
    with alone("run.nc", said.append):
        write_elsewhere(owner)
        assert asked.wait(5)
    assert made() == ["run.nc.lock"] and "no sign of life" in said[0]


def test_a_lock_that_cannot_be_written_is_not_left(here, monkeypatch):
    """The disk is full: room is asked for, and nothing is in the way later."""

    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("dpd.pipeline.lock.os.pwrite", full)
        refused = pytest.raises(UserError, match=r"No space left on device\); make room there or")
        with refused, alone("run.nc", print):
            pass
    assert made() == []


def test_what_a_killed_run_had_told_outlasts_whoever_begins_nothing(owner, monkeypatch):
    """One that is refused, or is killed or has no room while it takes the lock over."""
    lock, told = Path("run.nc.lock"), {"steps": 7}
    text = "\n".join([json.dumps(owner | {"boot": "before"}), json.dumps(told).ljust(256), ""])
    lock.write_text(text)
    for call, problem in (
        ("pwrite", KeyboardInterrupt()), ("ftruncate", KeyboardInterrupt()),
        ("pwrite", OSError(errno.ENOSPC, "No space left on device")),
    ):  # fmt: skip
        with monkeypatch.context() as patch:
            patch.setattr(f"dpd.pipeline.lock.os.{call}", Mock(side_effect=problem))
            with pytest.raises((KeyboardInterrupt, UserError)), alone("run.nc", print):
                pass
        kept = lock.read_text()
        for _ in range(2):
            with pytest.raises(UserError, match="refused"), alone("run.nc", print):
                assert told_before("run.nc") == told
                raise UserError("refused")
            assert lock.read_text() == kept
    with pytest.raises(UserError), alone("run.nc", print) as report:
        report({"steps": 8})
        raise UserError("begun")
    assert made() == []


def test_a_link_in_the_place_of_a_lock_is_not_followed(here):
    """Whatever it leads to stays, and nothing is made there."""
    Path("mine").write_text("")
    for target in ("mine", "nothing"):
        os.symlink(target, "run.nc.lock")
        with pytest.raises(UserError, match="remove the link"), alone("run.nc", print):
            pass
        os.remove("run.nc.lock")
    assert made() == ["mine"] and Path("mine").read_text() == ""


def test_where_files_cannot_be_locked_the_process_is_looked_for(here, monkeypatch):
    """As on some cluster's disks: alive, or dead, or another of the same number."""

    def unknown(*arguments):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr("fcntl.flock", unknown)
    lock, said = Path("run.nc.lock"), []
    with alone("run.nc", said.append):
        owner = json.loads(lock.read_text())
        with pytest.raises(UserError, match="at work"), alone("run.nc", said.append):
            pass
    for change in ({"pid": 2**22 + 1}, {"ticks": owner["ticks"] - 1}):
        lock.write_text(json.dumps(owner | change))
        with alone("run.nc", said.append):
            pass
    assert len(said) == 2 and made() == []
