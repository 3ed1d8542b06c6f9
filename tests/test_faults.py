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


def archive():
    with open("run.checkpoint", "wb") as file:
        np.savez(file, a=1)


# What is made before, and the output asked for.
OUTPUTS = {
    "a device": (lambda: device("run.nc"), "run.nc"),
    "a pipe": (lambda: os.mkfifo("run.nc"), "run.nc"),
    "a folder": (lambda: os.mkdir("run.nc"), "run.nc"),
    "no name": (None, ""),
    "no suffix": (None, "run"),
    "capitals, with the same files beside it": (None, "run.NC"),
    "suffix of a checkpoint": (None, "run.checkpoint"),
    "a scene": (None, "scene.yaml"),
    "too long": (None, "r" * 253 + ".nc"),
    "in a file": (None, "scene.yaml/run.nc"),
    "not UTF-8": (None, NOT_UTF8),
}
# The same for the stages that keep a checkpoint and a lock beside it.
BESIDE = {
    "checkpoint is a text": (lambda: Path("run.checkpoint").write_text("a: 1"), "run.nc"),
    "checkpoint is an archive": (archive, "run.nc"),
    "checkpoint is a folder": (lambda: os.mkdir("run.checkpoint"), "run.nc"),
    "checkpoint is a pipe": (lambda: os.mkfifo("run.checkpoint"), "run.nc"),
    "checkpoint leads nowhere": (lambda: os.symlink("gone", "run.checkpoint"), "run.nc"),
    "lock is a text": (lambda: Path("run.nc.lock").write_text("mine"), "run.nc"),
    "lock is a folder": (lambda: os.mkdir("run.nc.lock"), "run.nc"),
    "too long for a checkpoint": (None, "r" * 235 + ".nc"),
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


@pytest.mark.parametrize("stage", ["compile", "verdicts", "report", "schemes"])
@pytest.mark.parametrize("make", [device, os.mkfifo, os.mkdir])
def test_no_stage_replaces_what_is_no_file(folder, dpd, stage, make, monkeypatch):
    """The same for files that are no results of runs; nor a file of another kind."""
    names = {"compile": ("smoke", POINT[1]), "verdicts": ("some.csv",)}
    names |= {"report": ("smoke", POINT[1], "--results", "results"), "schemes": ("smoke",)}
    monkeypatch.setattr("dpd.pipeline.compiling.compile_for", lambda scenes: ["compiled"])
    made = {"compile": "made.txt", "verdicts": "made.csv", "report": "made.html"}
    made |= {"schemes": "made.yaml", "document": "made.md"}
    make(made[stage])
    for output in (made[stage], "scene.yaml" if stage != "schemes" else "scene.nc"):
        before = everything()
        assert_refused(dpd(stage, *names.get(stage, ()), "-o", output), before, output)


def kept_start(dpd):
    """A start of the scene, in start.nc."""
    assert dpd("run", "scene.yaml", "--start", "start.nc", "-o", "first.nc")[0] == 0
    os.remove("first.nc")


def spoil_start(change):
    with netCDF4.Dataset("start.nc", "a") as file:
        change(file)


def without(name):
    def change(file):
        file.renameVariable(name, "other")

    return change


def cut(name):
    """Keep the first half of a file."""
    data = Path(name).read_bytes()
    Path(name).write_bytes(data[: len(data) // 2])


def put(name, value):
    def change(file):
        file[name][0, 0] = value

    return change


STARTS = {
    "no position": lambda: spoil_start(without("position")),
    "position is not a number": lambda: spoil_start(put("position", np.nan)),
    "cut": lambda: cut("start.nc"),
    "a text": lambda: Path("start.nc").write_text("start"),
}


@pytest.mark.parametrize("spoil", STARTS)
def test_a_start_that_is_no_good_is_refused(folder, dpd, spoil):
    """A sentence that names the file; no run."""
    kept_start(dpd)
    STARTS[spoil]()
    before = everything()
    found = dpd("run", "scene.yaml", "--start", "start.nc", "-o", "run.nc")
    assert_refused(found, before, "start" if "is" in spoil else "start.nc")


INPUTS = {
    "the start is the output": ("scene.yaml", "run.nc", "run.nc"),
    "the start is to be the scene": ("scene.yaml", "run.nc", "scene.yaml"),
    "the start is a device": ("scene.yaml", "run.nc", "/dev/null"),
    "the start is not UTF-8": ("scene.yaml", "run.nc", NOT_UTF8),
    "a start without suffix": ("scene.yaml", "run.nc", "start"),
    "the output is the scene": ("scene.nc", "scene.nc", None),
    "the output is a link to the scene": ("scene.nc", "link.nc", None),
    "the output is the scene under another name": ("scene.nc", "same.nc", None),
    "the checkpoint is the scene": ("run.checkpoint", "run.nc", None),
    "the scene is a folder": (".", "run.nc", None),
    "the scene is a pipe": ("pipe", "run.nc", None),
    "no scene": ("none.yaml", "run.nc", None),
    "a scene of no name": ("", "run.nc", None),
}


@pytest.mark.parametrize("name", INPUTS)
def test_no_input_is_lost(tmp_path, monkeypatch, dpd, name):
    """An output that is an input, by name or by inode, and inputs that are no files."""
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    for scene in ("scene.yaml", "scene.nc", "run.checkpoint"):
        if name != "the checkpoint is the scene" and scene == "run.checkpoint":
            continue
        Path(scene).write_text(yaml.safe_dump(SCENE))
    os.symlink("scene.nc", "link.nc")
    os.link("scene.nc", "same.nc")
    os.mkfifo("pipe")
    scene, output, start = INPUTS[name]
    before = everything()
    assert_refused(dpd("run", scene, "-o", output, *(["--start", start] if start else [])), before)


OPTIONS = {
    "--threads": ("0", "2000", "1.5", "", "two"),
    "--checkpoint-every": ("-1", "nan", "inf", "", "often"),
}
BAD_OPTIONS = [(option, value) for option, values in OPTIONS.items() for value in values]


@pytest.mark.parametrize(("option", "value"), BAD_OPTIONS)
def test_options_out_of_range(folder, dpd, option, value):
    """Refused before anything is written."""
    before = everything()
    found = dpd("run", "scene.yaml", "-o", "run.nc", f"{option}={value[:9999]}")
    assert found[0] in (1, 2) and option.strip("-") in found[1]
    assert "allowed" in found[1] or "invalid" in found[1]
    assert everything() == before


TEXTS = {
    "empty": b"",
    "a number": b"3",
    "a list": b"[1, 2]",
    "not UTF-8": b"box: \xff\xfe",
    "zeros": bytes(100),
    "control characters": b"box: \x07",
    "tabs": b"box:\n\t- 1",
    "not closed": b"box: [1, 2",
    "deep keys": b"{a: " * 3000 + b"1" + b"}" * 3000,
    "no date": b"box: 2026-99-99",
    "no time": b"box: 2026-01-01 99:99:99",
    "a date": b"box: 2026-01-01",
    "huge number": b"box: 1" + b"0" * 5000,
    "python": b"box: !!python/object/apply:os.system [ls]",
    "bytes": b"box: !!binary aGVsbG8=",
    "a set": b"box: !!set {a, b}",
    "no bytes": b"box: !!binary x",
    "contains itself": b"box: &a [*a]",
    "keys contain themselves": b"&a {box: *a}",
    "list as key": b"[1, 2]: 3",
    "number as key": b"1: 2\nbox: 3",
    "null as key": b"null: 2",
    "unknown alias": b"box: *a",
    "two documents": b"box: 1\n---\nbox: 2",
    "binary number": b"box: 0b",
    "sexagesimal": b"box: 190:20:30",
    "merge of a number": b"<<: 3\nbox: 1",
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
    """Before they are placed: the system would kill the process later."""
    monkeypatch.setattr(running, "make_start", None)
    scene = SCENE | {"box": 100}
    Path("scene.yaml").write_text(yaml.safe_dump(scene))
    sizes = {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 2**16}
    monkeypatch.setattr(os, "sysconf", sizes.get)
    before = everything()
    found = dpd("run", "scene.yaml", "-o", "run.nc")
    assert_refused(found, before, "3000000 beads take about 0.872 GiB of memory")
    assert "has 0.25" in found[1]


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
