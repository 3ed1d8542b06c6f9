"""Files between the stages that are missing or damaged: a sentence with the file, no traceback."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from dpd.analysis.collect import save
from dpd.analysis.verdicts import COLUMNS
from dpd.pipeline.paper import read_paper
from tests.test_faults import assert_refused

PAPER = "groot_warren_1997"
RESULTS = Path("results/smoke")


def whole(path):
    """A dataset like that of a sweep."""
    path.parent.mkdir(parents=True, exist_ok=True)
    values = np.random.default_rng(1).random((30, 4))
    data = xr.Dataset({"kT": (("a", "replica"), values, {"units": "1"})}, attrs={"seconds": 1.0})
    data["scene"] = ("a", np.array(["a scene"] * 30, dtype=object))
    save(data, path)


def cut(path):
    whole(path)
    path.write_bytes(path.read_bytes()[:-700])


DAMAGES = {"missing": lambda path: path.parent.mkdir(parents=True), "cut": cut}


@pytest.mark.parametrize("name", DAMAGES)
@pytest.mark.parametrize(
    ("stage", "sweep"),
    [(("figure", "smoke", PAPER, "fig06_interface", "--data"), f"{PAPER}/sweeps/interface.nc"),
     (("derive", "smoke", "liu_2008", "rigidity", "--data"), "liu_2008/sweeps/contacts.nc"),
     (("schemes", "smoke"), "benchmark/figures/fluid_accuracy.nc")],
    ids=lambda part: part[0] if isinstance(part, tuple) else "",
)  # fmt: skip
def test_a_sweep_that_is_damaged(folder, dpd, stage, sweep, name):
    """It is named, with what to do; nothing is written."""
    path = RESULTS / sweep
    DAMAGES[name](path)
    output = {"derive": "made.csv", "schemes": "made.yaml"}.get(stage[0], "made")
    files = [path] if stage[-1] == "--data" else []
    assert_refused(dpd(*stage, *files, "-o", output), word=str(path))
    assert not Path(output).exists()


@pytest.mark.parametrize("name", DAMAGES)
@pytest.mark.parametrize("stage", ["verdicts", "report"])
def test_a_verdict_table_that_is_damaged(folder, dpd, stage, name):
    """The same of what verdict table and page are made from."""
    path = RESULTS / PAPER / "figures" / "fig01_time_step.csv"
    DAMAGES[name](path)
    output = "made.csv" if stage == "verdicts" else "made.html"
    asked = [path] if stage == "verdicts" else ["smoke", PAPER, "--results", RESULTS]
    assert_refused(dpd(stage, *asked, "-o", output), word=str(path))
    assert not Path(output).exists()


def test_an_archive_of_a_damaged_table(folder, dpd):
    """README.md is filled from what was kept of a study, so nothing bad is kept."""
    path = RESULTS / "verdicts.csv"
    cut(path)
    assert_refused(dpd("archive", "smoke"), word=str(path))


@pytest.mark.parametrize("name", ["missing", "cut"])
def test_a_sweep_of_the_report_that_is_damaged(folder, dpd, name):
    """The page has a line on each sweep."""
    paper = read_paper(PAPER, "smoke", only=[])
    figures = RESULTS / PAPER / "figures"
    figures.mkdir(parents=True)
    for figure in paper.figures:
        pd.DataFrame(columns=COLUMNS).to_csv(figures / f"{figure}.csv", index=False)
    path = RESULTS / PAPER / "sweeps" / "time_step_verlet.nc"
    DAMAGES[name](path)
    asked = ["smoke", PAPER, "--results", RESULTS]
    assert_refused(dpd("report", *asked, "-o", "made.html"), word=str(path))
