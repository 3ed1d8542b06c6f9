"""`make resume`: one command after Snakemake was killed."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest
import yaml

from dpd.files import read
from tests.conftest import SCENE
from tests.test_pipeline import copy_repository

PAPER = {
    "title": "A paper of mine",
    "reference": "nowhere",
    "sweeps": {"fluid": {"scene": SCENE | {"steps": {"sample": 150_000}}, "replicas": 4}},
    "figures": {},
}
OPTIONS = ("--config", "study=smoke", "papers=[mine]")


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


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["go on", "are killed too"])
def test_make_resume_goes_on_after_a_kill(mine, jobs):
    """No other command is needed; what the orphans make is taken, and nothing is made twice."""
    runs = mine / "results" / "smoke" / "mine" / "runs" / "fluid"
    with subprocess.Popen(
        [mine / ".venv" / "bin" / "snakemake", "--cores", "2", *OPTIONS], cwd=mine,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    ) as snakemake:  # fmt: skip
        end = time.monotonic() + 300
        while len(list(runs.glob("*/run.nc.lock"))) < 2:
            assert time.monotonic() < end and snakemake.poll() is None
            time.sleep(0.05)
        at_work = list(runs.glob("*/run.nc.lock"))
        killed_at = time.time()
        snakemake.kill() if jobs == "go on" else os.killpg(snakemake.pid, signal.SIGKILL)
    again = subprocess.run(
        ["make", "resume", f"OPTIONS={' '.join(OPTIONS)}"], cwd=mine, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    said = again.stdout + again.stderr
    assert again.returncode == 0, said
    assert (mine / "results" / "smoke" / "report-mine.html").is_file()
    results = sorted(runs.glob("*/run.nc"))
    assert len(results) == 4 and not list(runs.glob("*/run.left"))
    for lock in at_work:
        _, attributes = read(lock.with_name("run.nc"))
        began = lock.with_name("run.nc").stat().st_mtime - attributes["seconds"]
        assert jobs != "go on" or began < killed_at + 1, said
    assert len(re.findall(r"^rule simulate:", said, re.M)) == 4, said
    once_more = subprocess.run(
        ["make", "resume", f"OPTIONS={' '.join(OPTIONS)} -n"], cwd=mine, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert "Nothing to be done" in once_more.stdout + once_more.stderr
