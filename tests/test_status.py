"""`dpd status`: what is seen of runs and studies from outside, while they are at work and after."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import yaml

from dpd.commands.main import main
from dpd.digest import ROOT
from dpd.files import read
from dpd.pipeline.jobs import open_logs
from dpd.pipeline.lock import alone, lock_of, worker_on
from dpd.pipeline.own_runs import OwnRuns
from dpd.pipeline.pace import RUN, Pace, Told
from dpd.pipeline.run_status import AT_WORK, DONE, FAILS, STOPPED, WAITS, RunStatus
from dpd.pipeline.sight import sight_of
from dpd.pipeline.status import Study, left_of
from dpd.pipeline.status_text import as_json, as_text, duration, number
from dpd.progress import Progress
from tests.conftest import SCENE
from tests.test_interrupted import ENVIRONMENT, begin, dpd

THERMO = {"observe": [{"thermo": {"every": 10}}]}
LONG = SCENE | {
    "steps": {"equilibrate": 20, "sample": 10_000_000}, "observe": [{"thermo": {"every": 1000}}],
}  # fmt: skip
MEDIUM = SCENE | THERMO | {"steps": {"equilibrate": 20, "sample": 30_000}}
PAPER, POINT = "groot_warren_1997", "replica=0"
RESULT = Path("results/smoke", PAPER, "runs/fluid", POINT, "run.nc")
LOG = Path("results/smoke/logs", PAPER, "runs/fluid", f"{POINT}.log")
AT_ONCE = ("--checkpoint-every", "0.5")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with scenes."""
    monkeypatch.chdir(tmp_path)
    for name, scene in {"scene": MEDIUM, "long": LONG}.items():
        Path(f"{name}.yaml").write_text(yaml.safe_dump(scene))
    return tmp_path


def look(*arguments):
    """The command in this process: exit code, output and errors."""
    with redirect_stdout(StringIO()) as output, redirect_stderr(StringIO()) as errors:
        code = main(["status", *map(str, arguments)])
    return code, output.getvalue(), errors.getvalue()


def status(*arguments):
    """What the command says as JSON; it must not fail, nor warn."""
    code, output, errors = look("--json", *arguments)
    assert code == 0 and errors == "", errors
    return json.loads(output)


def only_run(*arguments):
    """The same of a single run."""
    (run,) = status(*arguments)["runs"]
    return run


def point_of(found, sweep="fluid", point=POINT):
    """One run of a study."""
    (run,) = [run for run in found["runs"] if run["name"] == [PAPER, sweep, point]]
    return run


def simulate(*options):
    """Run a point of a study to where Snakemake would have its result; its log as well."""
    LOG.parent.mkdir(parents=True, exist_ok=True)
    words = ("simulate", "smoke", PAPER, "fluid", POINT, *options, "-o", str(RESULT))
    code, output, errors = dpd(*words)
    LOG.write_text(output + errors)
    return code


def wait_for(condition):
    """Until something holds; kernels may have to be compiled first."""
    end = time.monotonic() + 300
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


def told(path="run.nc"):
    """How far a run says it is, once its rate is known."""
    worker = worker_on(path)
    return worker.told if worker and worker.told.get("rate") else None


def sight_step():
    """The step of the checkpoint; 0 without one."""
    sight = sight_of(Path("run.checkpoint"))
    return sight.step if sight else 0


def everything(folder):
    """All files below a folder, with their bytes and times."""
    return {
        path: (path.read_bytes() if path.is_file() else None, path.stat().st_mtime_ns)
        for path in sorted(Path(folder).rglob("*"))
    }


def test_a_run_at_work_and_after(here):
    """Its process, step, speed and time left; killed it is stopped; resumed it is done."""
    with begin("run", "long.yaml", "-o", "run.nc", *AT_ONCE) as process:
        wait_for(told)
        run = only_run("run.nc")
        assert run["state"] == AT_WORK and run["process"] == process.pid
        assert run["host"] == socket.gethostname() and run["doing"] == RUN
        assert 0 < run["step"] < run["steps"] == 10_000_020 and run["rate"] > 0
        left = (run["steps"] - run["step"]) / run["rate"]
        assert run["seconds_left"] == pytest.approx(left)
        assert run["measured"]["kT"] == pytest.approx(1, abs=0.2)
        assert "at work: run.nc" in look()[1] + look(".")[1]
        process.kill()
        wait_for(lambda: worker_on("run.nc") is None or not worker_on("run.nc").alive)
        run = only_run("run.nc")  # nobody has asked after the process yet
    assert run["state"] == STOPPED and "killed" in run["why"]
    with np.load("run.checkpoint") as stored:
        step = int(stored["step"])
    assert run["step"] == step and f"goes on from step {step}" in run["why"]
    os.remove("run.checkpoint")
    assert "begins anew" in only_run("run.nc")["why"]


def test_a_run_before_its_first_step(here):
    """It has a lock and has told nothing yet."""
    with alone("run.nc", print):
        run = only_run("run.nc")
        assert run["state"] == AT_WORK and run["step"] is None
        assert "it begins" in look("run.nc")[1]


def test_kT_and_pressure_are_means_of_the_samples_so_far(here):
    """Those that stand in the result in the end."""
    with begin("run", "scene.yaml", "-o", "run.nc", *AT_ONCE) as process:
        wait_for(lambda: sight_step() > 2000)
        process.send_signal(signal.SIGTERM)
        errors = process.communicate(timeout=60)[1]
    assert "stopped at step" in errors
    run = only_run("run.nc")
    assert run["state"] == STOPPED and "stopped" in run["why"]
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    values, _ = read("run.nc")
    samples = (run["step"] - 20) // 10
    assert 0 < samples < len(values["kT"])
    for name in ("kT", "pressure"):
        assert run["measured"][name] == pytest.approx(values[name][:samples].mean(), rel=1e-12)
        assert run["measured"][f"{name}_error"] < 0.1 * run["measured"][name]
    done = only_run("run.nc")
    assert done["state"] == DONE and done["step"] == 30_020 and done["rate"] > 0
    assert done["measured"]["pressure"] == pytest.approx(values["pressure"].mean(), rel=1e-12)


def test_kT_of_the_moment_while_it_equilibrates(here):
    """Without an error, and no pressure."""
    scene = LONG | {"steps": {"equilibrate": 10_000_000, "sample": 10_000}}
    Path("long.yaml").write_text(yaml.safe_dump(scene))
    with begin("run", "long.yaml", "-o", "run.nc", *AT_ONCE):
        wait_for(Path("run.checkpoint").exists)
        measured = only_run("run.nc")["measured"]
    assert measured["kT"] == pytest.approx(1, abs=0.3)
    assert measured["kT_error"] is measured["pressure"] is None


@pytest.mark.thorough
def test_a_look_changes_nothing(here):
    """Neither files nor the bits of a run that is watched all the time."""
    assert dpd("run", "scene.yaml", "-o", "alone.nc")[0] == 0
    with (
        begin("run", "scene.yaml", "-o", "watched.nc", *AT_ONCE) as process,
        begin("status", "watched.nc", "--watch", "0.5"),
    ):
        assert process.wait(timeout=100) == 0, process.stderr.read()
    alone_, watched = read("alone.nc")[0], read("watched.nc")[0]
    assert alone_.keys() == watched.keys()
    assert all(alone_[name].tobytes() == watched[name].tobytes() for name in alone_)
    before = everything(here)
    assert {run["state"] for run in status(".")["runs"]} == {DONE}
    assert everything(here) == before


@pytest.mark.parametrize("age", [0, 1000])
def test_a_run_on_another_machine(here, age):
    """It is at work as long as it writes into its lock; a process of that number says nothing."""
    with alone("run.nc", print) as report:
        report(Told(RUN, 50, 100, 2.0, time.time())._asdict())
        text = lock_of("run.nc").read_text()
    text = text.replace(f'"{socket.gethostname()}"', '"elsewhere"')
    lock_of("run.nc").write_text(text)
    os.utime("run.nc.lock", (time.time() - age,) * 2)
    run = only_run("run.nc")
    assert run["state"] == (STOPPED if age else AT_WORK)
    assert ("elsewhere is gone" in run["why"]) == bool(age)
    assert age or (run["step"] == 50 and run["seconds_left"] == 25)


def test_what_is_told_is_read_whole_or_not_at_all(here):
    """Who has the lock stays in its first line; the second may be anything."""
    with alone("run.nc", print) as report:
        for told in ({"step": 10**9, "name": "a" * 100}, {"step": 1}):
            report(told)
            assert worker_on("run.nc").told == told
        first, *_ = lock_of("run.nc").read_text().split("\n")
        for second in ("{", "[]", "", "\x00", '{"step": "x", "steps": 1, "rate": 1, "doing": 1}'):
            lock_of("run.nc").write_text(f"{first}\n{second}")
            assert worker_on("run.nc").process == os.getpid()
            assert only_run("run.nc")["step"] is None
    assert worker_on("run.nc") is None


def test_who_has_lost_a_lock_reports_no_more(here):
    """It would write into that of the run which took it for dead."""
    with alone("run.nc", print) as report:
        lock = lock_of("run.nc")
        lock.write_text(lock.read_text().replace(f'"pid": {os.getpid()}', '"pid": 1'))
        before = lock.read_text()
        report({"step": 1})
        assert lock.read_text() == before
    lock.unlink()


def test_the_rate_is_that_of_the_last_minute(monkeypatch):
    """A run that begins at 1000 steps/s and slows down to 100."""
    now, said = [0.0], []
    monkeypatch.setattr("dpd.pipeline.pace.time.monotonic", lambda: now[0])
    pace = Pace(Progress(10**6, "run"), said.append, RUN, 10**6)
    done = 500_000  # as one that goes on from a checkpoint
    for second in range(300):
        now[0] = float(second)
        done += 1000 if second < 150 else 100
        pace(done)
    assert said[0]["rate"] is None and said[0]["step"] == 501_000
    assert said[20]["rate"] == pytest.approx(1000) and said[-1]["rate"] == pytest.approx(100)
    assert 55 <= len(said) <= 61  # every five seconds


def test_a_study_without_results(here):
    """All of its runs wait; nothing is made."""
    found = status("smoke")
    assert found["study"] == "smoke" and found["folder"] == "results/smoke"
    assert found["counts"] == {AT_WORK: 0, DONE: 0, STOPPED: 0, FAILS: 0, WAITS: len(found["runs"])}
    assert {job["state"] for job in found["jobs"]} == {WAITS}
    assert "there are no results yet" in look("results/smoke")[1]
    assert not Path("results").exists()
    assert status()["study"] == yaml.safe_load((ROOT / "config/config.yaml").read_text())["study"]


def test_a_point_of_a_study(here):
    """Done; then edited; then of other sources; and how long the others take by its rate."""
    assert simulate() == 0
    found = status("results/smoke", "--papers", PAPER)
    run = point_of(found)
    assert run["state"] == DONE and run["work"] == 0 and found["counts"][DONE] == 1
    rest = sum(run["work"] for run in found["runs"])
    assert found["left"]["core_seconds"] == pytest.approx(rest / (run["rate"] * run["beads"]))
    assert found["left"]["seconds"] is None and found["left"]["cores"] == 0
    assert found["left"]["borrowed"] == found["counts"][WAITS]
    text = look("results/smoke", "--papers", PAPER)[1]
    assert "by the rates of other sweeps; nothing is at work" in text
    for name, words in (("sources", "other sources"), ("scene_digest", "edited")):
        with netCDF4.Dataset(RESULT, "a") as file:
            file.setncattr(name, "another")
        run = point_of(status("results/smoke"))
        assert run["state"] == WAITS and words in run["why"]


def test_a_point_that_failed(here):
    """The last sentence of its log; not if it was only stopped; a traceback's last line."""
    Path("start.nc").write_bytes(b"garbage")
    assert simulate("--start", "start.nc") == 1
    run = point_of(status("results/smoke"))
    assert run["state"] == FAILS and run["why"].startswith("start.nc: not a whole NetCDF file")
    assert "start.nc: not a whole NetCDF file" in look("results/smoke")[1]
    LOG.write_text("Traceback (most recent call last):\n  File ...\nKeyError: 'kT'\n")
    assert point_of(status("results/smoke"))["why"] == "KeyError: 'kT'"
    for last in ("scene: stopped at step 5 of 9, as asked", "interrupted"):
        LOG.write_text(f"error: {last}\n")
        run = point_of(status("results/smoke"))
        assert run["state"] == STOPPED and "begins anew" in run["why"]


@pytest.mark.thorough
def test_a_point_at_work_and_killed(here):
    """As Snakemake starts it; and one that is not in the study any more."""
    folder = Path("results/paper", PAPER, "runs")
    runs = {
        "fluid": folder / "fluid" / POINT / "run.nc",
        "gone": folder / "gone" / "a=1" / "run.nc",
    }
    names = ("simulate", "paper", PAPER, "fluid", POINT, "-o")
    with begin(*names, str(runs["fluid"])) as one, begin(*names, str(runs["gone"])) as other:
        wait_for(lambda: all(map(told, runs.values())))
        found = status("results/paper", "--papers", PAPER)
        run, stray = point_of(found), point_of(found, "gone", "a=1")
        assert run["state"] == stray["state"] == AT_WORK
        assert run["process"] == one.pid and stray["process"] == other.pid
        assert "not in the study" in stray["why"]
        left = found["left"]
        assert left["cores"] == 2 and left["seconds"] >= left["core_seconds"] / 2 * 0.99
        text = look("results/paper", "--papers", PAPER)[1]
        assert (
            f"at work: {PAPER} fluid {POINT}" in text and "on the 2 cores that are at work" in text
        )
        one.kill()
        other.kill()
    found = status("results/paper", "--papers", PAPER)
    assert point_of(found)["state"] == STOPPED and f"process {one.pid}" in point_of(found)["why"]
    assert found["counts"][STOPPED] == 1 and len(found["runs"]) == sum(found["counts"].values())


def test_jobs_at_work_have_their_logs_open(here):
    """Who only reads a log is no job."""
    os.mkdir("logs")
    command = "sleep 60 2>&1 | tee -i logs/written.log"
    with subprocess.Popen(["bash", "-c", command], start_new_session=True) as shell:
        try:
            wait_for(Path("logs/written.log").exists)
            Path("logs/read.log").write_text("")
            with open("logs/read.log"):
                assert open_logs("logs") == {str(here / "logs" / "written.log")}
        finally:
            os.killpg(shell.pid, signal.SIGKILL)
    wait_for(lambda: open_logs("logs") == set())  # `tee` may end later than the shell


def runs_of(*works, state=WAITS, **known):
    """Runs with some work."""
    return [RunStatus(("p", "s", str(i)), "", state, work=work, **known) for i, work in
            enumerate(works)]  # fmt: skip


def test_time_left():
    """The longest first, on as many cores as are at work; by the rates of runs like them."""
    done = RunStatus(("p", "s", "x"), "", DONE, step=100, steps=100, beads=10, rate=10.0, work=0.0)
    other = RunStatus(("p", "t", "x"), "", DONE, step=100, steps=100, beads=10, rate=1.0, work=0.0)
    at_work = runs_of(
        500.0, 1.0, state=AT_WORK, step=50, steps=100, beads=10, rate=10.0, seen=time.time()
    )
    left = left_of([done, other, *at_work, *runs_of(300.0, 200.0, 400.0)])
    assert left.core_seconds == pytest.approx(5 + 5 + 3 + 2 + 4, abs=0.1) and left.cores == 2
    assert left.seconds == pytest.approx(5 + 3 + 2, abs=0.1) and left.borrowed == 0
    lone = RunStatus(("p", "u", "x"), "", work=110.0)  # its rate: 2000 bead-steps in 110 s
    assert left_of([done, other, lone]).core_seconds == pytest.approx(110 / (2000 / 110))
    assert left_of([done, other, lone]).borrowed == 1
    assert left_of([lone]).core_seconds is None and left_of([done]).core_seconds == 0


DAMAGE = {
    "empty": lambda path, whole: path.write_bytes(b""),
    "random": lambda path, whole: path.write_bytes(np.random.default_rng(1).bytes(3000)),
    "text": lambda path, whole: path.write_text("{}\n[1, 2"),
    "null": lambda path, whole: path.write_text("null"),
    "folder": lambda path, whole: path.mkdir(),
    "pipe": lambda path, whole: os.mkfifo(path),
    "loop": lambda path, whole: path.symlink_to(path.name),
    "nowhere": lambda path, whole: path.symlink_to("gone"),
} | {
    f"cut to {share}": lambda path, whole, share=share: path.write_bytes(
        whole[: int(share * len(whole))]
    )
    for share in (0.02, 0.3, 0.7, 0.99)
}  # fmt: skip


# For a lock: without its second line, or without a word.
HARMLESS = ("empty", "nowhere", "cut to 0.7", "cut to 0.99")


@pytest.fixture(scope="module")
def stopped_point(tmp_path_factory):
    """A point of the study smoke with a result and a log, and another with lock and checkpoint."""
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert simulate() == 0
        Path("long.yaml").write_text(yaml.safe_dump(LONG))
        with begin("run", "long.yaml", "-o", "run.nc", *AT_ONCE) as process:
            wait_for(Path("run.checkpoint").exists)
            process.kill()
    shutil.copy(folder / "run.checkpoint", folder / RESULT.with_suffix(".checkpoint"))
    shutil.copy(folder / "run.nc.lock", folder / f"{RESULT}.lock")
    return folder


@pytest.mark.few(4)
@pytest.mark.parametrize("name", DAMAGE)
@pytest.mark.parametrize("file", ["run.nc", "run.checkpoint", "run.nc.lock", "log"])
def test_garbage_among_results(stopped_point, tmp_path, monkeypatch, file, name):
    """The run is not done, or that file is of no importance; no traceback, no harm."""
    folder = shutil.copytree(stopped_point, tmp_path / "study")
    monkeypatch.chdir(folder)
    path = LOG if file == "log" else RESULT.with_name(file)
    if file != "run.nc":
        RESULT.unlink()
    whole = path.read_bytes()
    path.unlink()
    DAMAGE[name](path, whole)
    before = sorted(Path().rglob("*"))
    found = Study("smoke", "results/smoke", [PAPER]).look()
    (run,) = [run for run in found.runs if run.name == (PAPER, "fluid", POINT)]
    assert as_text(found) and json.loads(as_json(found))
    own = OwnRuns(RESULT.parent).look()
    assert as_text(own) and json.loads(as_json(own))
    assert sorted(Path().rglob("*")) == before
    if file == "run.nc.lock" and name not in HARMLESS:
        assert run.state == FAILS and f"{RESULT}.lock" in run.why
    else:
        assert run.state == STOPPED
    if file == "run.checkpoint" and name != "nowhere":
        assert str(path) in run.why and "begins anew" in run.why


def test_what_is_no_study_and_no_run(here):
    """One sentence that says what is allowed."""
    os.mkdir("folder")
    Path("text.nc").write_text("mine")
    Path("note.txt").write_text("mine")
    cases = {
        "folder": "no study in config/config.yaml has the name 'folder'",
        "text.nc": "not a whole NetCDF file",
        "note.txt": "not a whole NetCDF file",
        "gone.nc": "there is no such run; allowed: ",
        "gone/quickly": "there is no such run; allowed: ",
    }
    for path, words in cases.items():
        code, output, errors = look(path)
        assert code == 1 and output == "" and errors.count("\n") == 1, errors
        assert errors.startswith(f"error: {path}: {words}"), errors
    code, _, errors = dpd("status", "--watch", "0", "smoke")
    assert code == 2 and "0.5 seconds or more" in errors
    code, _, errors = dpd("status", "smoke", "--papers", "liu")
    assert code == 1 and "'liu' is not in config/papers; allowed: " in errors
    assert sorted(os.listdir()) == ["folder", "long.yaml", "note.txt", "scene.yaml", "text.nc"]


def without_privileges(*arguments):
    """The command as one whom the system may refuse to read files, also if we are root."""
    privileges = "-dac_override,-dac_read_search"
    words = ["setpriv", "--bounding-set", privileges] if os.getuid() == 0 else []
    done = subprocess.run(
        [*words, sys.executable, "-m", "dpd", "status", *arguments], capture_output=True, text=True,
        env=ENVIRONMENT,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.thorough
@pytest.mark.skipif(
    os.getuid() == 0 and not shutil.which("setpriv"), reason="root may read all, without setpriv"
)
def test_what_may_not_be_read(stopped_point, tmp_path, monkeypatch):
    """A folder: one sentence. A file of a run: said of that run."""
    folder = shutil.copytree(stopped_point, tmp_path / "study")
    monkeypatch.chdir(folder)
    for name, state in ((RESULT, STOPPED), (f"{RESULT}.lock", DONE)):
        os.chmod(name, 0)
        code, output, errors = without_privileges("results/smoke", "--json")
        assert code == 0 and errors == "", errors
        assert point_of(json.loads(output))["state"] == state
        os.chmod(name, 0o644)
    RESULT.unlink()
    for ending in (".nc.lock", ".checkpoint"):
        path = RESULT.with_name(f"run{ending}")
        os.chmod(path, 0)
        run = point_of(json.loads(without_privileges("results/smoke", "--json")[1]))
        assert f"{path}: cannot be read (Permission denied)" in run["why"]
        os.chmod(path, 0o644)
    os.chmod("results/smoke", 0)
    code, output, errors = without_privileges("results/smoke")
    os.chmod("results/smoke", 0o755)
    assert code == 1 and output == ""
    assert errors == "error: results/smoke: cannot be read (Permission denied)\n"


@pytest.mark.few(1)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_watching_ends_when_asked(here, number):
    """Having looked several times; that is no failure."""
    with alone("run.nc", print), begin("status", "run.nc", "--watch", "0.5", "--json") as process:
        lines = [process.stdout.readline() for _ in range(3)]
        process.send_signal(number)
        _, errors = process.communicate(timeout=20)
    times = [json.loads(line)["time"] for line in lines]
    assert times == sorted(set(times)) and process.returncode == 0 and errors == ""


def test_watching_ends_when_nobody_reads(here):
    """As with `| head`."""
    with alone("run.nc", print), begin("status", "run.nc", "--watch", "0.5") as process:
        assert "run.nc" in process.stdout.readline()
        process.stdout.close()
        assert process.wait(timeout=20) == 0
        assert process.stderr.read() == ""


def test_words_for_numbers():
    """A unit that suits, two digits of an error."""
    assert [duration(t) for t in (None, 5.4, 600, 10_000, 1e6)] == [
        "-", "5 s", "10 min", "2.8 h", "11.6 days",
    ]  # fmt: skip
    assert number(23.7317, 0.123) == "23.73 +- 0.12" and number(np.nan, 1) == ""
    assert number(1.02806, np.nan) == "1.028" and number(1500.0, 250.0) == "1500 +- 250"
