"""Bad inputs and faults on the command line: one sentence, no traceback, nothing lost.

Commands run in this process where they can, so that the campaign is fast.
"""

import itertools
import os
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import yaml

from dpd.runs import run as running
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
    "measure": ("measure", "lammps"),
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


STAGES_OF_TEXT = {
    "compile": ("smoke", POINT[1], "-o", "made.txt"),
    "verdicts": ("some.csv", "-o", "made.csv"),
    "report": ("smoke", POINT[1], "--results", "results", "-o", "made.html"),
    "schemes": ("smoke", "-o", "made.yaml"),
}


@pytest.mark.parametrize("stage", STAGES_OF_TEXT)
@pytest.mark.parametrize("make", [device, os.mkdir])
def test_no_stage_replaces_what_is_no_file(folder, dpd, stage, make, monkeypatch):
    """The same for files that are no results of runs."""
    monkeypatch.setattr("dpd.pipeline.jobs.compile_for", lambda scenes: ["compiled"])
    *words, output = STAGES_OF_TEXT[stage]
    make(output)
    assert_refused(dpd(stage, *words, output), everything(), output)


def rename(file):
    file.renameVariable("position", "other")


def spoil(file):
    file["position"][0, 0] = np.nan


@pytest.mark.parametrize("change", [rename, spoil])
def test_a_start_that_is_no_good_is_refused(folder, dpd, change):
    """A sentence that names the file; no run."""
    assert dpd("run", "scene.yaml", "--start", "start.nc", "-o", "first.nc")[0] == 0
    with netCDF4.Dataset("start.nc", "a") as file:
        change(file)
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


@pytest.mark.parametrize(
    ("option", "value"),
    [("--threads", "0"), ("--threads", "1.5"), ("--checkpoint-every", "nan")],
)
def test_options_out_of_range(folder, dpd, option, value):
    """Refused before anything is written."""
    before = everything()
    found = dpd("run", "scene.yaml", "-o", "run.nc", f"{option}={value}")
    assert found[0] in (1, 2) and option.strip("-") in found[1]
    assert "allowed" in found[1] or "invalid" in found[1]
    assert everything() == before


TEXTS = {
    "empty": b"",
    "a list": b"[1, 2]",
    "not closed": b"box: [1, 2",
    "huge number": b"box: 1" + b"0" * 5000,
    "python": b"box: !!python/object/apply:os.system [ls]",
    "contains itself": b"box: &a [*a]",
    "number as key": b"1: 2\nbox: 3",
    "aliases of aliases": b"a: &a [x,x,x,x,x,x,x,x]\n"
    + b"\n".join(
        b"%c: &%c [%s]" % (k, k, b",".join([b"*%c" % (k - 1)] * 8)) for k in range(98, 106)
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_files_that_are_no_scenes(folder, dpd, name):
    """Whatever stands in the file."""
    Path("scene.yaml").write_bytes(TEXTS[name])
    before = everything()
    assert_refused(dpd("run", "scene.yaml", "-o", "run.nc"), before, "scene.yaml")


def test_more_beads_than_memory(folder, dpd, monkeypatch):
    """Refused before they are placed: the system would kill the process later."""
    monkeypatch.setattr(running, "make_start", None)
    Path("scene.yaml").write_text(yaml.safe_dump(SCENE | {"box": 100}))
    monkeypatch.setattr(os, "sysconf", {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 2**16}.get)
    found = dpd("run", "scene.yaml", "-o", "run.nc")
    assert_refused(found, word="3000000 beads take about 0.872 GiB of memory")


HOSTILE = (
    None, True, -1, 0, 0.5, 1e300, -1e300, 1e-300, 5e-324, float("nan"), float("inf"),
    10**30, -(10**30), 10**400, "", "x", "A", "1e400", "A A A A", "é\u202e\n", "x" * 3000, [], [[]],
    [None], {}, {"": None},
    {"x": {"y": [1]}}, [1e300] * 3, [2, 2], [3.0, float("nan"), 3],
)  # fmt: skip


def places(data, at=()):
    """Every place in nested dicts and lists."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        yield (*at, key)
        if isinstance(value, dict | list):
            yield from places(value, (*at, key))


def changed(data, place, value):
    """A copy with another value in one place."""
    copy = dict(data) if isinstance(data, dict) else list(data)
    copy[place[0]] = value if len(place) == 1 else changed(copy[place[0]], place[1:], value)
    return copy


FULL = SCENE | {
    "molecules": [{"architecture": "A 3 B", "count": 10}, {"architecture": "B", "density": 1}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 20, "length": 0.4},
    "core": {"radius": 0.1, "force": 50, "smooth": 0.1},
    "thermostat": {"kind": "dpd", "kT": 1, "gamma": 4.5, "noise": "uniform"},
    "integrator": {"scheme": "gw-vv", "dt": 0.04, "lambda": 0.5},
    "duration": {"equilibrate": 1, "sample": 2},
    "pairs": {"search": "cells", "skin": 0.2},
    "start": {"method": "random", "kT": 1, "seed": 3, "relax": {"steps": 10, "dt": 0.01}},
    "seed": 5,
    "unstable": "fail",
    "observe": [
        "thermo",
        {"rdf": {"range": 2, "bin": 0.05, "every": 5}},
        {"profile": {"bin": 0.1}},
    ],
}
EVERY_PLACE = list(places(FULL))


def test_the_full_scene_is_good(folder, dpd, monkeypatch):
    """What is changed in the next test is a scene that runs."""
    monkeypatch.setattr(running, "_run", lambda *given: {})
    Path("scene.yaml").write_text(yaml.safe_dump(FULL))
    assert dpd("run", "scene.yaml", "-o", "run.nc") == (0, "")


@pytest.mark.few(12)
@pytest.mark.parametrize("place", EVERY_PLACE, ids=lambda place: ".".join(map(str, place)))
def test_a_value_that_is_hostile_is_refused_or_taken(folder, dpd, place, monkeypatch):
    """In every place of a scene: a sentence, or a scene that could run."""
    monkeypatch.setattr(running, "_run", lambda *given: {})
    refused = 0
    for value in HOSTILE:
        Path("scene.yaml").write_text(yaml.safe_dump(changed(FULL, place, value)))
        before = everything()
        found = dpd("run", "scene.yaml", "-o", "run.nc")
        assert everything() == before, value
        if found[0]:
            refused += 1
            assert_refused(found, word="scene.yaml")
    assert refused > len(HOSTILE) / 3
