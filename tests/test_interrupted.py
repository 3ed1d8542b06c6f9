"""Commands that are interrupted, started twice, or heard by nobody: processes of their own."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import netCDF4
import pytest

from dpd import runs as module
from dpd.errors import UserError
from dpd.files import read
from dpd.folders import ROOT
from dpd.runs import alone, worker_on
from tests.conftest import SCENE, begin, folder_with, wait_for
from tests.test_faults import POINT

LONG = SCENE | {"steps": {"equilibrate": 20, "sample": 10_000_000}}


here = folder_with({"scene.yaml": SCENE, "long.yaml": LONG})


def made():
    """Names of what commands have made here."""
    return sorted(name for name in os.listdir() if not name.endswith(".yaml"))


def dpd(*arguments):
    """Exit code, output and errors of a command."""
    with begin(*arguments) as process:
        output, errors = process.communicate(timeout=200)
    return process.returncode, output, errors


def at_work(name="run.nc"):
    """Whether a run has begun to write who it is."""
    lock = Path(f"{name}.lock")
    return lock.exists() and lock.stat().st_size > 0


LATER = "stopping after the steps under way; a second Ctrl-C ends at once"
SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


@pytest.mark.few(1)
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("wait", [0.0, 1.5])
def test_a_signal_lets_a_run_keep_its_state(here, number, wait):
    """At any moment: its code, one sentence, the state or nothing, no lock."""
    with begin("run", "long.yaml", "-o", "run.nc") as process:
        wait_for(at_work)
        time.sleep(wait)
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == SIGNALS[number], errors
    heard = [line for line in errors.splitlines() if not re.search("compiling|: step [0-9]", line)]
    *before, last = heard
    assert last.startswith("error: ") and set(before) <= {LATER}, errors  # on a busy machine
    assert made() in ([], ["run.checkpoint"])
    assert ("stopped at step" in errors) == (made() == ["run.checkpoint"])
    assert wait < 1 or "stopped at step" in errors


def test_points_that_begin_together(here):
    """The second waits for the first, as after a kill of Snakemake, and takes its result."""
    started = [begin("simulate", *POINT, "-o", "run.nc") for _ in range(2)]
    said = [process.communicate(timeout=200) for process in started]
    assert [process.returncode for process in started] == [0, 0], said
    assert made() == ["run.nc"]
    waited = [errors for _, errors in said if "waiting for it" in errors]
    if waited:  # unless the first had ended when the second came
        assert "is there already" in said[0][0] + said[1][0]
    assert "Traceback" not in "".join(errors for _, errors in said)


def test_what_a_killed_run_left_is_taken_over(here):
    """Lock and drafts, with a sentence; another's files of like names stay."""
    with begin("run", "long.yaml", "-o", "run.nc") as process:
        wait_for(at_work)
        process.kill()
        process.communicate(timeout=60)
    for name in ("run.nc.12.writing", "run.checkpoint.3.writing", "other.nc.4.writing"):
        Path(name).write_text("draft")
    code, output, errors = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 0 and "kT" in output
    assert f"process {process.pid}" in errors and "taking over" in errors
    assert made() == ["other.nc.4.writing", "run.nc"]


@pytest.mark.parametrize("heard", ["<&- >&- 2>&-", ">/dev/full", "2>&1 | true"])
def test_a_summary_that_nobody_reads_costs_no_result(here, heard):
    """It is there and whole; the exit code is 0, but for a full disk that lost the summary."""
    command = f"{sys.executable} -m dpd run scene.yaml -o run.nc {heard}; exit ${{PIPESTATUS[0]}}"
    source = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(["bash", "-c", command], env=source, check=False)
    assert done.returncode == (heard == ">/dev/full")
    assert made() == ["run.nc"] and read("run.nc")[0]["kT"].size == 20


def test_a_result_that_is_there_stays(here):
    """A point that is asked for again is not simulated again, unless it is another or damaged."""
    assert dpd("simulate", *POINT, "-o", "run.nc")[0] == 0
    first = read("run.nc")[1]["seconds"]
    code, output, errors = dpd("simulate", *POINT, "-o", "run.nc")
    assert code == 0 and errors == "" and "is there already" in output and "kT" in output
    assert made() == ["run.nc"] and read("run.nc")[1]["seconds"] == first
    with netCDF4.Dataset("run.nc", "a") as file:
        file.setncattr("scene_digest", "another")
    assert "is there already" not in dpd("simulate", *POINT, "-o", "run.nc")[1]
    assert read("run.nc")[0]["kT"].size > 0


# The lock beside a result: who is at work, and who is no more.


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


def test_a_lock_that_was_left_empty_is_removed(marker):
    """By a run that was killed as it made it; a new one may yet be written."""
    begun = time.monotonic()
    LOCK.touch()
    with alone("run.nc", print):
        assert time.monotonic() - begun >= 0.05
        assert f"pid={os.getpid()}" in LOCK.read_text()
    assert os.listdir() == []


@pytest.mark.parametrize("wait", [False, True])
def test_a_dead_lock_of_another_machine_is_taken_over(marker, wait):
    """After a while without a sign of life, and not before."""
    said, begun = [], time.monotonic()
    elsewhere(marker, age=9)
    with alone("run.nc", said.append, wait):
        assert time.monotonic() - begun >= 0.6
        assert f"pid={os.getpid()}" in LOCK.read_text()
    assert os.listdir() == [] and len(said) == 2
    assert "no sign of life" in said[0] and "taking over" in said[1]


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


def test_what_is_no_lock_stays(marker):
    """A text, and a link."""
    Path("mine").write_text("")
    for make in (lambda: os.symlink("mine", LOCK), lambda: LOCK.write_text("mine")):
        make()
        with pytest.raises(UserError, match="not a lock"), alone("run.nc", print):
            pass
        os.remove(LOCK)
    assert os.listdir() == ["mine"] and Path("mine").read_text() == ""
