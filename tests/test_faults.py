"""Bad inputs and faults on the command line: one sentence, no traceback, nothing lost.

Commands run in this process where they can, so that the campaign is fast.
"""

import itertools
import os
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
import yaml

from dpd.analysis.collect import save
from dpd.analysis.verdicts import COLUMNS
from tests.conftest import SCENE

POINT = ("smoke", "groot_warren_1997", "fluid", "replica=0")
NOT_UTF8 = os.fsdecode(b"run\xff.nc")


def everything():
    """Each file here with its kind and contents."""
    found = {}
    for path in sorted(Path().rglob("*")):
        status = path.lstat()
        kept = path.read_bytes() if path.is_file() else b""
        found[str(path)] = (status.st_mode, status.st_rdev, kept)
    return found


def assert_refused(found, before=None, word=""):
    """A code that says so, one short sentence, and all files as they were."""
    code, errors = found
    assert code in (1, 2), (code, errors)
    said = [line for line in errors.splitlines() if "error: " in line]
    assert len(said) == 1 and len(said[0]) < 1000, errors
    assert "Traceback" not in errors and word in errors, errors
    if before is not None:
        assert everything() == before


def device(name):
    """/dev/null under another name; only root can make one."""
    try:
        os.mknod(name, 0o666 | 0o020000, os.makedev(1, 3))
    except PermissionError:
        os.symlink("/dev/null", name)


# What is made before, and the output asked for.
OUTPUTS = {
    "a device": (lambda: device("run.nc"), "run.nc"),
    "a pipe": (lambda: os.mkfifo("run.nc"), "run.nc"),
    "a folder": (lambda: os.mkdir("run.nc"), "run.nc"),
    "no suffix": (None, "run"),
    "capitals, with the same files beside it": (None, "run.NC"),
    "a scene": (None, "scene.yaml"),
    "in a file": (None, "scene.yaml/run.nc"),
    "not UTF-8": (None, NOT_UTF8),
}
# The same for the stages that keep a checkpoint and a lock beside it.
BESIDE = {
    "checkpoint is a text": (lambda: Path("run.checkpoint").write_text("a: 1"), "run.nc"),
    "lock is a text": (lambda: Path("run.nc.lock").write_text("mine"), "run.nc"),
    "too long": (None, "r" * 250 + ".nc"),
}
STAGES = {
    "run": ("run", "scene.yaml"),
    "simulate": ("simulate", *POINT),
    "start": ("start", *POINT),
    "collect": ("collect", *POINT[:3], "--runs", "runs"),
}
BAD_OUTPUTS = [
    *itertools.product(("run",), OUTPUTS | BESIDE),
    *itertools.product(STAGES, ("a pipe", "a folder", "no suffix", "in a file", "not UTF-8")),
    *itertools.product(("simulate",), BESIDE),
]


@pytest.mark.parametrize(("stage", "name"), BAD_OUTPUTS)
def test_a_result_goes_to_a_file_of_its_own_or_nowhere(folder, dpd, stage, name):
    """Nothing that was there is replaced, and nothing is left behind."""
    make, output = (OUTPUTS | BESIDE)[name]
    if make:
        make()
    before = everything()
    assert_refused(dpd(*STAGES[stage], "-o", output), before)


@pytest.mark.parametrize("bad", [np.nan, None])
def test_a_start_that_is_no_good_is_refused(folder, dpd, bad):
    """A sentence that names the file; no run."""
    assert dpd("run", "scene.yaml", "--start", "start.nc", "-o", "first.nc")[0] == 0
    with netCDF4.Dataset("start.nc", "a") as file:
        if bad is None:
            file["state"].renameVariable("position", "other")
        else:
            file["state"]["position"][0, 0] = bad
    before = everything()
    found = dpd("run", "scene.yaml", "--start", "start.nc", "-o", "run.nc")
    assert_refused(found, before, "start")


INPUTS = {
    "the start is the output": ("scene.yaml", "run.nc", "run.nc"),
    "the start is to be the scene": ("scene.yaml", "run.nc", "scene.yaml"),
    "the output is the scene": ("scene.nc", "scene.nc", None),
    "the output is the scene under another name": ("scene.nc", "same.nc", None),
    "the checkpoint is the scene": ("run.checkpoint", "run.nc", None),
    "the scene is a folder": (".", "run.nc", None),
}


@pytest.mark.parametrize("name", INPUTS)
def test_no_input_is_lost(tmp_path, monkeypatch, dpd, name):
    """An output that is an input, by name or by inode, and inputs that are no files."""
    monkeypatch.chdir(tmp_path)
    scenes = ["scene.yaml", "scene.nc", "run.checkpoint"]
    for scene in scenes[: 3 if name == "the checkpoint is the scene" else 2]:
        Path(scene).write_text(yaml.safe_dump(SCENE))
    os.link("scene.nc", "same.nc")
    scene, output, start = INPUTS[name]
    before = everything()
    assert_refused(dpd("run", scene, "-o", output, *(["--start", start] if start else [])), before)


# Files between the stages that are missing or damaged.

RESULTS = Path("results/smoke")
SWEEPS = RESULTS / POINT[1] / "sweeps"
FIGURES = RESULTS / POINT[1] / "figures"
# The file, and the command that reads it.
READERS = {
    "figure": (
        SWEEPS / "interface.nc",
        ("figure", *POINT[:2], "fig06_interface", "--data", SWEEPS / "interface.nc", "-o", "made"),
    ),
    "verdicts": (FIGURES / "one.csv", ("verdicts", FIGURES / "one.csv", "-o", "made.csv")),
    "archive": (FIGURES / "fig06_interface.csv", ("archive", "smoke")),
    "report": (
        FIGURES / "fig06_interface.csv",  # of a figure that is made: others do not stand there yet
        ("report", *POINT[:2], "--results", RESULTS, "-o", "made.html"),
    ),
}  # fmt: skip

BESIDES = {"report": ".png", "archive": ".nc"}  # by which they know that a figure is made
DAMAGED = [("missing", stage) for stage in READERS if stage != "report"] + [("row", "verdicts")]


@pytest.mark.parametrize("damage, stage", DAMAGED + [("cut", stage) for stage in READERS])
def test_a_file_between_stages_that_is_damaged(folder, dpd, stage, damage):
    """It is named, and nothing is written."""
    path, asked = READERS[stage]
    path.parent.mkdir(parents=True)
    if stage in BESIDES:
        path.with_suffix(BESIDES[stage]).touch()
    if damage == "cut":
        save(xr.Dataset({"kT": ("a", np.arange(120.0), {"units": "1"})}), path)
        path.write_bytes(path.read_bytes()[:-700])
    if damage == "row":  # of which the last ends before its verdict
        path.write_text(f"{','.join(COLUMNS)}\nliu_2008,fig02_radial_distribution,a peak,Sec. II")
    before = everything()
    assert_refused(dpd(*asked), before, str(path))
