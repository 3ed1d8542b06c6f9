"""The lock beside a result: who is at work, and who is no more."""

import errno
import os
import re
import threading
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from dpd.errors import UserError
from dpd.runs import lock as module
from dpd.runs.lock import alone, worker_on

LOCK, PROGRESS = Path("run.nc.lock"), Path("run.nc.progress")


@pytest.fixture
def marker(tmp_path, monkeypatch):
    """What a lock of ours says of its owner, where signs of life are frequent."""
    monkeypatch.chdir(tmp_path)
    for name, seconds in (("POLL", 0.02), ("SIGN", 0.05), ("SILENCE", 0.6)):
        monkeypatch.setattr(module, name, seconds)
    with alone("run.nc", print):
        found = LOCK.read_text()
        with pytest.raises(UserError, match=f"process {os.getpid()}"), alone("run.nc", print):
            pass
    assert os.listdir() == []
    return found


def elsewhere(marker, age=0):
    """A lock of another machine, whose last sign of life is so many seconds old."""
    LOCK.write_text(re.sub("host=.*", "host=elsewhere", marker))
    os.utime(LOCK, (time.time() - age,) * 2)


def test_a_lock_of_a_process_that_was_killed_is_taken_over(marker):
    """At once, whatever process has its number now; what it had reported is known."""
    said = []
    LOCK.write_text(re.sub("start=.*", "start=1", marker))
    PROGRESS.write_text('{"steps": 7}')
    assert worker_on("run.nc").report == {"steps": 7}
    with alone("run.nc", said.append):
        assert worker_on("run.nc").alive
    assert os.listdir() == [] and len(said) == 1 and "taking over" in said[0]


@pytest.mark.parametrize("wait", [False, True])
def test_a_dead_lock_of_another_machine_is_taken_over(marker, wait):
    """After a while without a sign of life, and not before."""
    said, begun = [], time.monotonic()
    elsewhere(marker, age=9)
    with alone("run.nc", said.append, wait):
        assert time.monotonic() - begun >= 0.6
        assert f"pid={os.getpid()}" in LOCK.read_text()
    assert os.listdir() == [] and len(said) == 2
    assert "another machine" in said[0] and "taking over" in said[1]


def test_a_living_lock_of_another_machine_is_respected(marker):
    """It is refused, or waited for as long as it takes."""
    said, ended = [], threading.Event()
    elsewhere(marker)
    refused = pytest.raises(UserError, match=r"another run is at work on it .* on elsewhere")
    with refused, alone("run.nc", print):
        pass

    def live():
        while not ended.wait(0.05):
            os.utime(LOCK)
        LOCK.unlink()

    other, end = threading.Thread(target=live), threading.Timer(1.5, ended.set)
    other.start()
    end.start()
    with alone("run.nc", said.append, wait=True):
        assert ended.is_set()
    other.join()
    assert os.listdir() == [] and any("waiting for it" in sentence for sentence in said)


def test_a_run_that_was_taken_for_dead_stops(marker):
    """As one that is suspended for long; the lock of the other stays."""
    with pytest.raises(UserError, match="took this one for dead"), alone("run.nc", print) as lock:
        lock.report({"step": 1})
        LOCK.unlink()
        elsewhere(marker)
        time.sleep(0.5)
        lock.report({"step": 2})
    assert sorted(os.listdir()) == [LOCK.name, PROGRESS.name] and "elsewhere" in LOCK.read_text()


def test_a_lock_that_cannot_be_written(marker, monkeypatch):
    """Room is asked for."""
    full = Mock(side_effect=OSError(errno.ENOSPC, "No space left on device"))
    monkeypatch.setattr(module.SoftFileLease, "acquire", full)
    refused = pytest.raises(UserError, match=r"No space .* make room there or choose another place")
    with refused, alone("run.nc", print):
        pass
    assert os.listdir() == []


def test_what_is_no_lock_stays(marker):
    """A text, and a link."""
    Path("mine").write_text("")
    for make in (lambda: os.symlink("mine", LOCK), lambda: LOCK.write_text("mine")):
        make()
        with pytest.raises(UserError, match="not a lock"), alone("run.nc", print):
            pass
        os.remove(LOCK)
    assert os.listdir() == ["mine"] and Path("mine").read_text() == ""
