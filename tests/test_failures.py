"""What a workflow says last: the sentences of the jobs that failed."""

import os
from pathlib import Path

import pytest

from dpd.report.workflow import failures
from tests.test_pipeline import SMOKE, copy_repository, snakemake


def log(path, text, when):
    """A log that was written at some time."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode())
    os.utime(path, (when, when))


def test_sentences_of_this_workflow_are_found_once(tmp_path):
    """With the path of the log; those of older logs, and other lines, are not."""
    log(tmp_path / "old.log", "error: long ago\n", 999)
    log(tmp_path / "a" / "one.log", "warning: kT\nerror: no room\nthe end\n", 1000)
    log(tmp_path / "b" / "two.log", "error: no room\nerror: no start\n", 1001)
    log(tmp_path / "b" / "three.made", "error: no log\n", 1001)
    log(tmp_path / "good.log", "no error: at all\n", 1001)
    assert failures(tmp_path, 1000) == [
        f"error: no room ({tmp_path}/a/one.log)",
        f"error: no start ({tmp_path}/b/two.log)",
    ]
    assert failures(tmp_path, 1002) == failures(tmp_path / "none", 0) == []


@pytest.mark.thorough
def test_a_workflow_ends_with_them(tmp_path):
    """Below all that Snakemake says."""
    folder = copy_repository(tmp_path / "copy")
    place = folder / "results" / "smoke" / "groot_warren_1997" / "runs" / "fluid" / "replica=0"
    (place / "run.checkpoint").mkdir(parents=True)
    done = snakemake(folder, str(place.parent.relative_to(folder) / "0.made"), *SMOKE)
    assert done.returncode != 0
    last = done.stderr.rstrip().splitlines()[-1]
    assert last.startswith("error: ") and "run.checkpoint" in last
    assert last.endswith("(results/smoke/logs/groot_warren_1997/runs/fluid/0.log)")
