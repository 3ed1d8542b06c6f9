"""A run made longer is the run that was planned that long, bit for bit."""

import os
from pathlib import Path

import numpy as np
import pytest

from dpd import files
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.observe.common.accumulators import Series
from dpd.page import Observable, names
from dpd.runs.result import STATE, read_former
from dpd.runs.run import Options, extend, simulate
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge
from dpd.start.common.files import write_start
from dpd.start.common.make import make_start
from tests.conftest import SCENE
from tests.systems import Killed, frames_of, kill_at

# Files of observables that belong to papers.
PAGES = {
    "trace": str(ROOT / "paper_figures" / "nikunen_2007" / "trace.py"),
    "passes": str(ROOT / "paper_figures" / "nikunen_2007" / "bond_passes.py"),
    "pair_energies": str(ROOT / "paper_figures" / "crgw_2019" / "pair_energies.py"),
}
CHAINS = {
    "dimension": 2,
    "box": 6,
    "molecules": [{"architecture": "A 2 B", "count": 25}, {"architecture": "B", "count": 11}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 20, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.004},
    "steps": {"equilibrate": 7, "sample": 700},
    "pages": [*PAGES.values()],
    "observe": [
        "configuration", {"thermo": {"every": 4}}, {"rdf": {"range": 2, "every": 3}},
        {"profile": {"every": 11}}, {"bonds": {"every": 7}}, {"chains": {"every": 5}},
        {"displacement": {"every": 2}}, {"end_to_end": {"every": 3}}, {"trace": {"every": 10}},
        {"configurational": {"every": 50}}, {"density_field": {"every": 13, "average": 7}},
        {"structure_factor": {"every": 17, "max": 3}}, {"mixing": {"every": 9}},
        {"diffusion": {"every": 6}}, {"end_points": {"every": 8}}, {"bond_lengths": {"every": 7}},
        {"stress_profile": {"every": 8}}, {"clusters": {"of": ["B"], "within": 0.6, "every": 6}},
    ],
}  # fmt: skip
IN_PLANE = CHAINS | {  # with so many frames that the index of their file grows three times
    "observe": [*CHAINS["observe"], {"crossings": {"every": 6}}, {"trajectory": {"every": 1}}]
}
IN_SPACE = CHAINS | {
    "dimension": 3,
    "box": [4, 4.5, 5],
    "observe": [
        *CHAINS["observe"],
        {"passes": {"every": 6}},
        {"membrane": {"every": 6}},
        {"trajectory": {"every": 3, "per_decade": 9}},
    ],
    "integrator": {"scheme": "dpd-vv", "dt": 0.02},
}
FLUID = SCENE | {
    "pages": [*PAGES.values()],
    "steps": {"equilibrate": 20, "sample": 1300},
    "observe": [
        "thermo", {"rdf": {"range": 2}}, {"displacement": {"every": 1}},
        {"pair_energies": {"every": 2}},
    ],
}  # fmt: skip
CORE = {"core": {"radius": 0.2, "force": 50}, "observe": [{"displacement": {"every": 1}}]}
WALLED = merge(IN_SPACE, {
    "walls": {"axis": "z", "repulsion": {"A": 25, "B": 40}, "gamma": 9},
    "body_force": {"axis": "x", "strength": {"A": 0.1, "B": 0}},
    "observe": [
        "thermo", {"walls": {"every": 3}}, {"velocity_profile": {"every": 7}},
        {"profile": {"every": 5}}, {"displacement": {"every": 2}}, {"trajectory": {"every": 9}},
        {"stress_profile": {"every": 8}},
    ],
})  # fmt: skip
# In a box that changes no chain can be traced, and g(r) has to fit into half of it.
PRESSED = IN_SPACE | {
    "pressure": {"target": 2.5, "time": 0.3},
    "observe": [
        {"rdf": {"range": 1.5, "every": 3}} if "rdf" in item else item
        for item in IN_SPACE["observe"]
        if not {"trace", "structure_factor"} & set(item)
    ],
}  # fmt: skip
TREES = IN_SPACE | {
    "molecules": [{"architecture": "A 3 (B 2) A 3", "count": 30}],
    "angle": {"A A A": {"stiffness": 5}, "B A A": {"stiffness": 4, "angle": 90},
              "A B B": {"stiffness": 3, "angle": 120}},
    "thermostat": {"gamma": {"A A": 4.5, "A B": 12, "B B": 0.5}}, "mass": {"A": 0.5, "B": 3},
    "integrator": {"scheme": "dpd-vv", "dt": 0.01},
    "observe": [{name: {"every": 5}} for name in ("thermo", "chains", "trace")],
}  # fmt: skip
# Systems, steps of sampling of the shorter run, and threads.
CASES = {
    "2D, chains, a list": (IN_PLANE, 333, 1),
    "2D, one step is missing, threads": (IN_PLANE, 699, 2),
    "3D, chains, cells": (merge(IN_SPACE, {"pairs": {"search": "cells"}}), 345, 1),
    "3D, fluid, longer than a stretch": (FLUID, 777, 1),
    "lowe-andersen": (merge(FLUID, {"integrator": {"scheme": "lowe-andersen"}}), 777, 1),
    "walls and a body force": (WALLED, 345, 1),
    "constant pressure, a list": (merge(PRESSED, {"pairs": {"search": "list"}}), 345, 2),
    "trees, frictions, masses": (TREES, 345, 2),
    "core": (FLUID | CORE | {"integrator": {"scheme": "gw-vv", "dt": 0.005}}, 777, 1),
}


def test_all_observables_are_in_the_cases():
    """One that is new has to be put into one of them."""
    seen = {name for data, _, _ in CASES.values() for name in Scene(data).observe}
    assert seen == {*names(Observable), *PAGES}


def sampled(data, sample):
    """The same scene with another number of steps of sampling."""
    return merge(data, {"steps": {"sample": sample}})


def run(data, path, progress=None, **settings):
    """A run of a scene that keeps its state."""
    scene = Scene(data)
    simulate(scene, path, make_start(scene), Options(own=True, **settings), progress)
    return path


def assert_goes_on(folder, data, sample, threads, killed=None):
    """A run that is killed on its way, gone on with, and made longer is as planned that long."""
    whole = run(data, folder / "whole.nc")
    short, part, said = sampled(data, sample), folder / "part.nc", []
    with pytest.raises(Killed):
        run(short, part, kill_at(killed or sample // 2), every_seconds=0.0)
    assert part.with_suffix(".checkpoint").exists()
    run(short, part, every_seconds=60, threads=threads, say=said.append)
    assert not any("anew" in sentence for sentence in said)
    more = Scene(data).steps.sample - sample
    extend(part, more, folder / "longer.nc", Options(threads, own=True))
    assert_same(whole, folder / "longer.nc")
    assert read_former(part).scene.steps.sample == sample  # it stays as it was


def assert_same(one, other):
    """All variables of two results, the last configuration, and the state for longer ones."""
    (first, told), (second, also) = files.read(one), files.read(other)
    groups = files.read(one, STATE)[0], files.read(other, STATE)[0]
    for mine, its in ((first, second), groups):
        assert mine.keys() == its.keys() and mine
        for name, values in mine.items():
            assert values.dtype == its[name].dtype, name
            np.testing.assert_array_equal(values, its[name], err_msg=name)
    beside = [Path(path).with_suffix(".gsd") for path in (one, other)]
    if beside[0].exists() or beside[1].exists():
        assert frames_of(beside[0]) == frames_of(beside[1])
    for name in ("steps", "scene_digest", "sources", "last_step", "lost_step"):
        assert told[name] == also[name], name


@pytest.mark.few("2D, chains, a list", "constant pressure, a list")
@pytest.mark.parametrize("case", CASES)
def test_longer_is_as_planned_that_long(tmp_path, case):
    """Every variable of every observable, whatever it looked at when the shorter run was killed
    and when it ended."""
    assert_goes_on(tmp_path, *CASES[case])


def test_a_trajectory_that_is_gone(tmp_path):
    """Or cut, or another one: said, and nothing is lost."""
    part = run(sampled(IN_PLANE, 100), tmp_path / "part.nc")
    trajectory = tmp_path / "part.gsd"
    before, frames = part.read_bytes(), trajectory.read_bytes()
    other = run(sampled(IN_PLANE | {"seed": 2}, 100), tmp_path / "other.nc")
    for left, words in (
        (frames[: len(frames) // 2], r"part\.gsd"),
        (other.with_suffix(".gsd").read_bytes(), "not those that the run has"),
    ):
        trajectory.write_bytes(left)
        with pytest.raises(UserError, match=words):
            extend(part, 100, tmp_path / "longer.nc")
        assert part.read_bytes() == before and not (tmp_path / "longer.nc").exists()


@pytest.mark.parametrize("samples", [1, 3, 49, 50, 51, 399, 400, 401, 1000, 12_345])
def test_blocks_of_a_series(samples):
    """Means over 50 parts that follow each other, alike but for a quarter, of all samples; the
    largest of each."""
    series = np.random.default_rng(samples).normal(size=(samples, 2)) + np.arange(samples)[:, None]
    blocks = Series({"mean": ("block", (2,)), "most": ("largest", ())}, samples)
    for taken, sample in enumerate(series):
        blocks.add(taken, {"mean": sample, "most": abs(sample[0])})
    (means, largest), each = blocks.results(samples).values(), int(blocks.each[0])
    short = -(-samples // each)
    assert len(means) == min(50, samples)
    of = np.repeat(np.arange(short) * len(means) // short, each)[:samples]
    sizes = np.bincount(of)
    assert sizes.max() - sizes.min() <= max(2 * each, sizes.max() / 4)
    for number, mean in enumerate(means):
        part = series[: len(of)][of == number]
        np.testing.assert_allclose(mean, part.mean(axis=0), rtol=1e-12, atol=1e-12)
        assert largest[number] == abs(part[:, 0]).max()


@pytest.mark.parametrize("asked", [None, True, False])
def test_who_keeps_a_state(tmp_path, asked):
    """A run of one's own, or one whose scene says so; both measure the same."""
    scene = Scene(sampled(IN_PLANE, 60) | ({} if asked is None else {"keep_state": asked}))
    found = []
    for own in (False, True):
        simulate(scene, tmp_path / "run.nc", make_start(scene), Options(own=own))
        found.append(files.read(tmp_path / "run.nc")[0])
        kept = own if asked is None else asked
        assert bool(files.read(tmp_path / "run.nc", STATE)[0]) is kept
        assert ("last_position" in found[-1]) is kept
    for name in found[0].keys() & found[1].keys():
        np.testing.assert_array_equal(found[0][name], found[1][name], err_msg=name)


# The command.


@pytest.fixture
def finished(folder, dpd):
    """A run in the folder, made by the command."""
    assert dpd("run", "scene.yaml", "-o", "run.nc", "--set=steps.sample=100")[0] == 0
    return Path("run.nc")


def test_the_command(finished, dpd):
    """In place, and elsewhere."""
    assert dpd("extend", "run.nc", "--sample", 130, "-o", "longer.nc", "--threads", 2)[0] == 0
    before = finished.read_bytes()
    assert dpd("extend", "run.nc", "--sample", 130)[0] == 0
    assert finished.read_bytes() != before
    assert dpd("run", "scene.yaml", "-o", "whole.nc", "--set=steps.sample=230")[0] == 0
    assert_same("whole.nc", "longer.nc")
    assert_same("whole.nc", "run.nc")
    assert sorted(os.listdir()) == ["longer.nc", "run.nc", "scene.yaml", "whole.nc"]


def put(more, own):
    """Puts the result of another scene there."""

    def make(path):
        scene = Scene(FLUID | {"steps": {"sample": 50}} | more)
        simulate(scene, path, make_start(scene), Options(own=own))

    return make


LOST = {"unstable": "record", "integrator": {"scheme": "gw-vv", "dt": 2}}
REFUSED = {
    "a start": (lambda path: write_start(Scene(FLUID), path), "a first configuration"),
    "no state": (put({}, own=False), "keep_state: true"),
    "lost": (put(LOST, own=True), "was lost at step"),
    "cut": (lambda path: os.truncate(path, path.stat().st_size - 100), "not a whole NetCDF"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(finished, dpd, name):
    """In one sentence, with all files left as they are."""
    make, words = REFUSED[name]
    make(finished)
    before = {path: path.read_bytes() for path in Path().iterdir()}
    code, said = dpd("extend", "run.nc", "--sample", 10)
    assert code == 1 and said.startswith("error: run.") and words in said, said
    assert {path: path.read_bytes() for path in Path().iterdir()} == before
