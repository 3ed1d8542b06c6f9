"""A study through a Slurm cluster of one node, which fails in the middle."""

import importlib.util
import re
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml

from dpd.files import read
from tests.conftest import SCENE, command
from tests.slurm.one_node import boot, environment, kill_node, missing, start, state_of_node, stop
from tests.test_pipeline import copy_repository

PLUGIN = "snakemake_executor_plugin_slurm"
absent = [*missing(), *([PLUGIN] if importlib.util.find_spec(PLUGIN) is None else [])]
pytestmark = [
    pytest.mark.slurm,
    pytest.mark.skipif(bool(absent), reason=f"not installed: {', '.join(absent)}"),
]

THERMO = SCENE | {"observe": [{"thermo": {"every": 100, "pressure": False}}]}
LONG = {"equilibrate": 20, "sample": 6_000_000}  # more than a minute, the least limit in Slurm
KT = {"set": "thermostat.kT", "values": [1, 2]}
PAPER = {
    "title": "A paper of mine",
    "sweeps": {
        "short": {"scene": SCENE, "replicas": 2, "axes": {"temperature": KT}},
        "long": {"scene": THERMO | {"steps": LONG}},
    },
}
SHORT = [f"temperature={kT},replica={replica}" for kT in (1, 2) for replica in (0, 1)]
POINTS = [*(("short", point) for point in SHORT), ("long", "replica=0")]
# What differs from the profile: the node is small, and has no accounting; the disk is fast.
OPTIONS = (
    "--profile", "profiles/slurm", "--latency-wait", "10",
    "--slurm-init-seconds-before-status-checks", "3", "--slurm-status-command", "squeue",
    "--config", "papers=[mine]",
)  # fmt: skip


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Folder of a cluster that is up; all its daemons end with the test."""
    folder = tmp_path_factory.mktemp("cluster")
    start(folder)
    yield folder
    stop(folder)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """What the runs have on this machine, without Snakemake, Slurm and faults."""
    folder, found = new_copy(tmp_path_factory.mktemp("expected")), {}
    for sweep, point in POINTS:
        words = ["simulate", "quick", "mine", sweep, point, "-o", f"{sweep}.nc"]
        done = command(*words, cwd=folder, PYTHONPATH=str(folder / "src"))
        assert done.returncode == 0, done.stderr
        found[sweep, point] = read(folder / f"{sweep}.nc")[0]
        (folder / f"{sweep}.nc").unlink()
    return found


def new_copy(folder):
    """A copy of the repository with a paper of short runs and a long one."""
    copy_repository(folder)
    (folder / "config" / "papers" / "mine.yaml").write_text(yaml.safe_dump(PAPER))
    # However fast the machine is, a checkpoint is there long before the run ends.
    rule = folder / "rules" / "simulate.smk"
    rule.write_text(rule.read_text().replace("q} simulate", "q} simulate --checkpoint-every 5"))
    return folder


def wait_for(condition, process):
    """Until something holds, or a process has ended, or half an hour is over."""
    end = time.monotonic() + 1800
    while not condition() and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.5)


def kill_and_boot(cluster, process):
    """The node loses its power, Slurm notices, and the node comes back."""
    kill_node(cluster)
    wait_for(lambda: state_of_node(cluster) == "down", process)
    boot(cluster)
    # Slurm waits for two minutes, for a node that may still be at work on the job, and begins anew.


FAULTS = {
    "the node is killed": ((), kill_and_boot, "has been submitted with SLURM jobid"),
    # A minute is the least that Slurm knows, and what each try has here.
    "the time is over": (
        ("--set-resources", "simulate:runtime=1", "--retries", "15"),
        lambda *_: None,
        "Trying to restart job",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_study_survives(cluster, expected, tmp_path, fault):
    """The long run goes on from its checkpoint, and all have the bits of an undisturbed run."""
    more, strike, said = FAULTS[fault]
    folder = new_copy(tmp_path / "copy")
    runs = folder / "results" / "quick" / "mine" / "runs"
    variables = {k: v for k, v in environment(cluster).items() if k != "PYTHONPATH"}
    with open(folder / "said", "w") as out:
        process = subprocess.Popen(
            [sys.executable, "-m", "snakemake", *OPTIONS, *more], cwd=folder, env=variables,
            stdout=out, stderr=out,
        )  # fmt: skip
        try:
            wait_for((runs / "long" / "replica=0" / "run.checkpoint").exists, process)
            strike(cluster, process)
            code = process.wait(timeout=3600)
        finally:
            process.kill()
    text = (folder / "said").read_text()
    assert code == 0 and said in text, text[-5000:]
    assert len(set(re.findall(r" output: (\S+\.made)", text))) == 2  # of four runs, of the long one
    log = folder / "results" / "quick" / "logs" / "mine" / "runs" / "long" / "0.log"
    # The last try goes on from a checkpoint, or finds what the one before has finished in time.
    assert re.search("a run to resume may be in|is there already", log.read_text())
    for (sweep, point), arrays in expected.items():
        made = read(runs / sweep / point / "run.nc")[0]
        assert made.keys() == arrays.keys()
        for name, array in arrays.items():
            np.testing.assert_array_equal(made[name], array, err_msg=f"{sweep} {point} {name}")
    results = folder / "results" / "quick"
    assert "A paper of mine" in (results / "report-mine.html").read_text()
    assert (results / "logs" / "report-mine.log").read_text() == ""
    assert not list(runs.rglob("*.checkpoint")) and not list(runs.rglob("*.lock"))
