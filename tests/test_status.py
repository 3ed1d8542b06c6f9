"""`dpd status`: what is seen of runs and studies from outside, while they are at work and after."""

import json
import os
import signal
import socket
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
import yaml

from dpd.commands.main import main
from dpd.engine.loop import stored_in
from dpd.files import read, write
from dpd.folders import ROOT
from dpd.pipeline.jobs import USUAL, as_text, plan
from dpd.pipeline.paper import read_paper
from dpd.pipeline.paths import results_of
from dpd.pipeline.status import AT_WORK, DONE, FAILS, STOPPED, WAITS, RunStatus, seconds_left
from dpd.runs import Progress, worker_on
from tests.conftest import SCENE, begin, folder_with, wait_for
from tests.test_interrupted import dpd

THERMO = {"observe": [{"thermo": {"every": 10}}]}
LONG = SCENE | {
    "steps": {"equilibrate": 20, "sample": 10_000_000}, "observe": [{"thermo": {"every": 1000}}],
}  # fmt: skip
MEDIUM = SCENE | THERMO | {"steps": {"equilibrate": 20, "sample": 120_000}}
PAPER, POINT = "groot_warren_1997", "replica=0"
RESULT = Path("results/smoke", PAPER, "runs/fluid", POINT, "run.nc")
LOG = Path("results/smoke/logs", PAPER, "runs/fluid", f"{POINT}.log")
AT_ONCE = ("--checkpoint-every", "0.5")


here = folder_with({"scene.yaml": MEDIUM, "long.yaml": LONG})


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


def reported(path="run.nc"):
    """What a run says of how far it is, once its rate is known."""
    worker = worker_on(path)
    return worker.report if worker and worker.report.get("rate") else None


def checkpoint_step():
    """The step of the checkpoint; 0 without one."""
    stored = stored_in("run.checkpoint")
    return int(stored.arrays["step"]) if stored else 0


def test_a_run_at_work_and_after(here):
    """Its process, step, speed and what it has measured; killed it is stopped."""
    with begin("run", "long.yaml", "-o", "run.nc", *AT_ONCE) as process:
        wait_for(lambda: reported() and checkpoint_step() > 3000)
        run = only_run("run.nc")
        who = f"process {process.pid} on {socket.gethostname()}"
        assert run["state"] == AT_WORK and run["why"].startswith(who)
        assert 0 < run["step"] < run["steps"] == 10_000_020 and run["rate"] > 0
        assert run["measured"]["kT"][0] == pytest.approx(1, abs=0.2)
        assert "at work: run.nc" in look("run.nc")[1] and "at work: run.nc" in look(".")[1]
        process.kill()
        process.wait()
    run = only_run("run.nc")
    assert run["state"] == STOPPED and "killed" in run["why"]
    step = checkpoint_step()
    assert run["step"] == step and f"goes on from step {step}" in run["why"]
    os.remove("run.checkpoint")
    assert "begins anew" in only_run("run.nc")["why"]


def test_kT_and_pressure_are_means_of_the_samples_so_far(here):
    """Those that stand in the result in the end."""
    with begin("run", "scene.yaml", "-o", "run.nc", *AT_ONCE) as process:
        wait_for(lambda: checkpoint_step() > 2000)
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
        mean, error = run["measured"][name]
        assert mean == pytest.approx(values[name][:samples].mean(), rel=1e-12)
        assert error < 0.1 * mean
    done = only_run("run.nc")
    assert done["state"] == DONE and done["step"] == 120_020 and done["rate"] > 0
    assert done["measured"]["pressure"][0] == pytest.approx(values["pressure"].mean(), rel=1e-12)


def test_the_rate_is_that_of_the_last_minute(monkeypatch):
    """A run that begins at 1000 steps/s and slows down to 100."""
    now, said = [0.0], []
    monkeypatch.setattr("dpd.runs.time.monotonic", lambda: now[0])
    progress = Progress(10**6, "run", False, SimpleNamespace(report=said.append))
    done = 500_000  # as one that goes on from a checkpoint
    for second in range(300):
        now[0] = float(second)
        done += 1000 if second < 150 else 100
        progress(done)
    assert said[0]["rate"] is None and said[0]["step"] == 501_000
    assert said[20]["rate"] == pytest.approx(1000) and said[-1]["rate"] == pytest.approx(100)


def test_a_study_without_results(here):
    """All of its runs wait; nothing is made."""
    found = status("smoke")
    assert {run["state"] for run in found["runs"]} == {WAITS} and found["seconds_left"] is None
    assert look("results/smoke")[1].startswith(f"results/smoke: {len(found['runs'])} waiting")
    assert not Path("results").exists()
    study = yaml.safe_load((ROOT / "config/config.yaml").read_text())["study"]
    assert look("--papers", PAPER)[1].startswith(f"results/{study}: ")


def test_a_point_of_a_study(here):
    """Done; then edited; then of other sources."""
    assert simulate() == 0
    run = point_of(status("results/smoke", "--papers", PAPER))
    assert run["state"] == DONE and run["measured"]["kT"][0] == pytest.approx(1, abs=0.2)
    assert f"{PAPER} fluid: 1 done" in look("results/smoke", "--papers", PAPER)[1]
    for name in ("sources", "scene_digest"):
        with netCDF4.Dataset(RESULT, "a") as file:
            file.setncattr(name, "another")
        run = point_of(status("results/smoke"))
        assert run["state"] == WAITS and "changed since" in run["why"]


def test_a_point_that_failed(here):
    """The last sentence of its log; not if it was only stopped."""
    assert simulate("--threads", "1000") == 1
    run = point_of(status("results/smoke"))
    assert run["state"] == FAILS and run["why"].startswith("threads: 1000 is out of range")
    assert "threads: 1000 is out of range" in look("results/smoke")[1]
    for last in ("scene: stopped at step 5 of 9, as asked", "interrupted"):
        LOG.write_text(f"error: {last}\n")
        assert point_of(status("results/smoke"))["state"] == WAITS


def test_time_left():
    """By the mean rate of what has run, on as many cores as are at work."""
    done = RunStatus(("p", "s", "x"), "", DONE, step=100, steps=100, beads=10, rate=10.0)
    half = RunStatus(("p", "s", "y"), "", AT_WORK, step=50, steps=100, beads=10, rate=10.0)
    rest = RunStatus(("p", "s", "z"), "", steps=100, beads=10)
    assert seconds_left([done, half, rest]) == pytest.approx((500 + 1000) / 100)
    assert seconds_left([done, half, half, rest]) == pytest.approx((500 + 500 + 1000) / 100 / 2)
    assert seconds_left([done, rest]) is seconds_left([rest]) is None


def test_what_a_study_will_cost(here):
    """By the rates of its runs, or of another study's; assumed, and said to be, without any."""
    papers = [read_paper(PAPER, "smoke", only=["springs", "relaxation"])]
    rows = plan(papers, "smoke", 60)
    assert {row["rate"] for row in rows} == {USUAL} and "not measured" in as_text(rows, 2)
    for study, rates in {"quick": (2e6,), "smoke": (5e5, 1e6, 3e6)}.items():
        for number, rate in enumerate(rates):
            path = results_of(study).run(PAPER, "springs", f"point={number}")
            write(path, {}, {"bead_steps_per_second": rate})
    rows = {row["sweep"]: row for row in plan(papers, "smoke", 60)}
    assert rows["springs"]["rate"] == 1e6 and not rows["relaxation"]["measured"]
    assert plan(papers, "paper", 60)[0]["rate"] == 3e6  # the fastest of all studies
    scenes = [point.scene for point in papers[0].sweeps["springs"].points]
    work = sum(scene.beads * sum(scene.steps) for scene in scenes)
    assert rows["springs"]["core_hours"] == pytest.approx(work / 1e6 / 3600)
    assert all(row["memory"] > 100 and row["disk"] > 0 for row in rows.values())
    assert "6 runs in 26 jobs" in as_text(list(rows.values()), 2)


@pytest.mark.parametrize("file", ["run.nc", "run.checkpoint", "run.nc.lock"])
def test_garbage_among_results(here, file):
    """The run is not done; no traceback, no harm."""
    RESULT.parent.mkdir(parents=True)
    RESULT.with_name(file).write_bytes(np.random.default_rng(1).bytes(3000))
    run = point_of(status("results/smoke", "--papers", PAPER))
    assert run["state"] in (STOPPED, FAILS, WAITS) and run["why"]
    assert [path.name for path in RESULT.parent.iterdir()] == [file]


def test_what_is_no_study_and_no_run(here):
    """One sentence that says what is allowed."""
    os.mkdir("folder")
    Path("text.nc").write_text("mine")
    cases = {
        "folder": "no study in config/config.yaml has the name 'folder'",
        "text.nc": "not a whole NetCDF file",
        "gone.nc": "there is no such run; name a run.nc",
    }
    for path, words in cases.items():
        code, output, errors = look(path)
        assert code == 1 and output == "" and errors.startswith(f"error: {path}: {words}"), errors
