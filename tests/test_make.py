"""`make resume`: one command after Snakemake was killed."""

import os
import signal
import subprocess
import sys

import pytest
import yaml

from dpd.files import read
from tests.conftest import SCENE, wait_for
from tests.test_pipeline import copy_repository

PAPER = {
    "title": "A paper of mine",
    "sweeps": {"fluid": {"scene": SCENE | {"steps": {"sample": 60_000}}, "replicas": 4}},
}
OPTIONS = ("--config", "study=smoke", "papers=[mine]", "batch=0")  # a job for each run


@pytest.fixture
def mine(tmp_path):
    """A copy of the repository with a paper of four runs, and an environment that is set up."""
    folder = copy_repository(tmp_path / "copy")
    (folder / "config" / "papers" / "mine.yaml").write_text(yaml.safe_dump(PAPER))
    command = folder / ".venv" / "bin" / "snakemake"
    command.parent.mkdir(parents=True)
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m snakemake "$@"\n')
    command.chmod(0o755)
    (folder / ".venv" / "ready").touch()
    return folder


def resume(folder, *more):
    """What the command says."""
    done = subprocess.run(
        ["make", "resume", f"OPTIONS={' '.join([*OPTIONS, *more])}"], cwd=folder,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.thorough
@pytest.mark.parametrize("jobs", ["have ended", "are at work", "are killed too"])
def test_make_resume_goes_on_after_a_kill(mine, jobs):
    """No other command is needed; what the jobs made after the kill is taken."""
    runs = mine / "results" / "smoke" / "mine" / "runs" / "fluid"

    def at_work():
        return [lock.parent for lock in runs.glob("*/run.nc.lock")]

    with subprocess.Popen(
        [mine / ".venv" / "bin" / "snakemake", "--cores", "2", *OPTIONS], cwd=mine,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    ) as snakemake:  # fmt: skip
        wait_for(lambda: len(at_work()) == 2 or snakemake.poll() is not None)
        begun = at_work()
        if jobs == "are killed too":
            os.killpg(snakemake.pid, signal.SIGKILL)
        snakemake.kill()
    assert len(begun) == 2
    made = {}
    if jobs == "have ended":
        wait_for(lambda: not at_work())
        made = {run: (run / "run.nc").stat().st_ino for run in begun}
    assert "Nothing to be done" not in resume(mine)
    assert (mine / "results" / "smoke" / "report-mine.html").is_file()
    assert len(list(runs.glob("*/run.nc"))) == 4
    assert {run: (run / "run.nc").stat().st_ino for run in made} == made
    for path in runs.glob("*/run.nc"):
        assert read(path)[1]["lost_step"] == -1
    assert "Nothing to be done" in resume(mine, "-n")
