"""`import dpd`: runs, results and sweeps from Python, a script, a notebook, a thread."""

import doctest
import json
import os
import re
import signal
import sys
import time
from importlib import import_module
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml

import dpd
from dpd.analysis.statistics import mean_and_error
from dpd.files import read
from dpd.page import Observable, names
from dpd.runs import Progress
from tests.conftest import SCENE, Command, python, wait_for

MODULES = ("dpd.api.live", "dpd.api")
FLUID = SCENE | {"observe": ["thermo"], "steps": {"equilibrate": 200, "sample": 800}}
CHAINS = SCENE | {
    "box": 6,
    "molecules": [{"architecture": "A 4", "density": 3}],
    "bond": {"stiffness": 4, "length": 0},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 20, "sample": 300},
}


@pytest.fixture(scope="module")
def fluid():
    """The result of a run."""
    return dpd.run(FLUID, progress=False)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", MODULES)
def test_examples(name, folder):
    """They say what happens."""
    scene, given = doctest.DocTestParser().get_examples(dpd.run.__doc__)[1], {"dpd": dpd}
    exec(scene.source, given)
    found = doctest.testmod(import_module(name), extraglobs=given)
    assert found.attempted > 2 and not found.failed


def test_an_import_is_light():
    """Neither arrays nor compilers, until they are needed; all names are known."""
    done = python("-c", "import dpd, sys; print(*sys.modules); dir(dpd); assert dpd.UserError")
    assert done.returncode == 0, done.stderr
    assert not {"numpy", "numba", "xarray", "yaml"} & set(done.stdout.split())
    assert set(dpd.__all__) <= set(dir(dpd))


def test_a_run_is_that_of_the_command(folder, dpd, fluid):
    """The same bits; nothing else is left on the disk, or anything at all without an output."""
    before = set(os.listdir())
    Path("scene.yaml").write_text(yaml.safe_dump(FLUID))
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    variables, _ = read("run.nc")
    for name, values in variables.items():
        assert np.array_equal(values, fluid[name].values), name
    assert set(os.listdir()) == before | {"run.nc"}


def test_forms_of_a_scene(folder, fluid):
    """A file, a dict with numbers of NumPy, a Scene; the dict is left as it is."""
    given = FLUID | {"seed": 2}
    Path("scene.yaml").write_text(yaml.safe_dump(given))
    expected = dpd.run(given, progress=False)
    assert expected.seed == 2 and not np.array_equal(expected.kT, fluid.kT)
    arrays = given | {"box": np.full(3, 4.0), "seed": np.int64(2)}
    for form in ("scene.yaml", arrays, dpd.Scene(given)):
        assert np.array_equal(dpd.run(form, progress=False, threads=2).kT, expected.kT)
    assert "thermostat" not in given


def test_a_result_is_described(fluid):
    """Time as a coordinate, units, and what a command prints."""
    assert fluid.kT.dims == ("time",) and fluid.time.attrs["units"] == "tau"
    assert np.allclose(fluid.time, 0.4 * np.arange(1, 81))
    assert fluid.sel(time=slice(4, 8)).kT.size == 11
    assert all({"units", "long_name"} <= set(fluid[name].attrs) for name in fluid.variables)
    assert fluid.pressure.units == "kT / r_c^3" and {"scene", "seed", "sources"} <= set(fluid.attrs)
    for name in ("kT", "pressure", "total_energy"):
        said = [fluid[name].attrs[key] for key in ("mean", "error", "correlation_time")]
        mean, error, samples = mean_and_error(fluid[name].values)
        np.testing.assert_allclose(said, [mean, error, 0.4 * samples], rtol=1e-12)
    assert 0 < fluid.kT.error < 0.1 and "mean" not in fluid.momentum.attrs


@pytest.mark.thorough
def test_results_of_all_observables_can_be_kept(folder):
    """A dataset goes into a file of xarray's and back; load reads that too."""
    plane = CHAINS | {
        "dimension": 2, "box": 8, "molecules": [{"architecture": "A 2 B 2", "density": 3}],
        "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    }  # fmt: skip
    missing = {"membrane", "walls", "trajectory"}  # of three dimensions, walls, its own file
    asked = sorted(set(names(Observable)) - missing)
    run = dpd.run(plane | {"observe": asked}, progress=False)
    run.to_netcdf("kept.nc")
    assert dpd.load("kept.nc").identical(run)
    assert not any("dimension" in run[name].units for name in run.variables)


AXES = {"repulsion.A A": [15, 25]}
WRONG = {
    "a number": (lambda: dpd.run(3), "3 is no scene"),
    "threads": (lambda: dpd.run(FLUID, threads=0), "threads: 0 is out of range"),
    "no run": (lambda: dpd.load("other.nc"), "other.nc: neither the result of a run"),
    "a trajectory": (
        lambda: dpd.sweep(FLUID | {"observe": ["thermo", {"trajectory": {"every": 5}}]}, AXES),
        "observe.trajectory: writes a file beside the result",
    ),
    "an axis": (lambda: dpd.sweep(FLUID, {"boxx": [4]}), "unknown key 'boxx'"),
    "no list": (lambda: dpd.sweep(FLUID, {"box": 4}), "sweep.axes.box: 4 is no list"),
    "auto": (
        lambda: dpd.sweep(FLUID | {"integrator": {"scheme": "auto"}}, {"box": [4]}), "name scheme"
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_what_is_refused(folder, what):
    """With the sentence of the command, and nothing written."""
    xr.Dataset({"a": 1}).to_netcdf("other.nc")
    before = set(os.listdir())
    call, words = WRONG[what]
    with pytest.raises(dpd.UserError, match=re.escape(words)):
        call()
    assert set(os.listdir()) == before


@pytest.mark.parametrize(
    ("terminal", "bar", "seen"),
    [(True, None, True), (False, None, False), (True, False, False), (False, True, True)],
)
def test_who_sees_a_bar(monkeypatch, terminal, bar, seen):
    """People at a terminal, if they do not say otherwise."""
    screen = StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: terminal)
    monkeypatch.setattr(sys, "stderr", screen)
    with Progress(10, "label", bar) as progress:
        progress(10)
    assert ("label: 100%" in screen.getvalue()) == bool(screen.getvalue()) == seen


LONG = FLUID | {"steps": {"equilibrate": 20, "sample": 1_000_000}}


def test_a_stopped_run_goes_on(folder, monkeypatch, fluid):
    """To the same bits, in the same process."""
    looks = []

    def interrupt(self, done):
        looks.append(done)
        if len(looks) == 1:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(Progress, "__call__", interrupt)
        with pytest.raises(KeyboardInterrupt, match=r"stopped at step \d+ .* run.checkpoint"):
            dpd.run(FLUID, output="run.nc", progress=False)
    assert sorted(os.listdir()) == ["run.checkpoint", "scene.yaml"]
    run = dpd.run(FLUID, output="run.nc", progress=False)
    assert np.array_equal(run.pressure, fluid.pressure)
    assert sorted(os.listdir()) == ["run.nc", "scene.yaml"]


THREADS = """
import json, sys, dpd
from concurrent.futures import ThreadPoolExecutor
scene = json.loads(sys.argv[1])
def again(number):
    name = f"{number}.nc" if number % 2 else None
    run = dpd.run(scene, output=name, start="start.nc" if number % 3 else None, progress=False)
    return all(dpd.load("run.nc").kT.equals(run.kT) for _ in range(20))
with ThreadPoolExecutor(6) as pool:
    print(sum(pool.map(again, range(24))))
"""


@pytest.mark.thorough
def test_several_threads_run_and_load(folder):
    """In a process of their own, which the library would end; all with the bits of one alone."""
    dpd.run(SCENE, output="run.nc", progress=False)
    done = python("-c", THREADS, json.dumps(SCENE))
    assert (done.returncode, done.stdout) == (0, "24\n"), done.stderr


@pytest.mark.thorough
def test_a_sweep_keeps_what_is_finished(folder):
    """More values and replicas leave former runs alone, and each has noise of its own."""
    first = dpd.sweep(FLUID, AXES, replicas=np.int64(2), output="sweep", progress=False)
    assert first.pressure.dims == ("repulsion.A A", "replica")
    assert len(np.unique(first.seed)) == 4 and (first.kT_error > 0).all()
    assert dpd.load("sweep/sweep.nc").identical(first)
    runs = {path: path.stat().st_mtime_ns for path in Path("sweep").rglob("run.nc")}
    assert len(runs) == 4
    more = {"repulsion.A A": np.array([15, 20, 25])}
    second = dpd.sweep(FLUID, more, replicas=2, output="sweep", progress=False)
    assert second.sel({"repulsion.A A": [15, 25]}).pressure.equals(first.pressure)
    assert all(path.stat().st_mtime_ns == runs[path] for path in runs)
    one = dpd.run("sweep/repulsion.A A=20,replica=1/scene.yaml", progress=False)
    assert one.pressure.mean() == second.pressure.sel({"repulsion.A A": 20, "replica": 1})


def test_a_sweep_of_text(folder):
    """By a name, as in a paper; a scene from a file; nothing is left."""
    Path("scene.yaml").write_text(yaml.safe_dump(CHAINS))
    length = {"set": "molecules.0.architecture", "text": "A {}", "values": [2, 4], "units": "1"}
    found = dpd.sweep("scene.yaml", {"length": length}, threads=2, progress=False)
    assert found.length.values.tolist() == [2, 4] and (found.beads == 648).all()
    assert os.listdir() == ["scene.yaml"]


def test_a_sweep_with_a_run_that_fails(folder):
    """The others are kept; the sentence names the point."""
    with pytest.raises(dpd.UserError, match=r"^1 of 2 runs failed; the first: integrator.dt=3"):
        dpd.sweep(FLUID, {"integrator.dt": [0.04, 3]}, output="sweep", progress=False)
    assert [path.parent.name for path in Path("sweep").rglob("run.nc")] == [
        "integrator.dt=0.04,replica=0"
    ]


SWEPT = """
import json, sys, dpd
try:
    dpd.sweep(json.loads(sys.argv[1]), {"thermostat.gamma": [3, 4, 5]}, processes=2, output="sweep")
except KeyboardInterrupt:
    print("stopped")
"""


def test_ctrl_c_stops_a_sweep(folder):
    """Its runs keep their states and end."""
    with Command("-c", SWEPT, json.dumps(LONG)) as script:
        wait_for(lambda: len(list(Path("sweep").rglob("run.nc.lock"))) == 2)
        time.sleep(2)
        script.send_signal(signal.SIGINT)
        output, errors = script.communicate(timeout=100)
    assert script.returncode == 0 and output == "stopped\n", errors
    assert not list(Path("sweep").rglob("*.lock")) and not list(Path("sweep").rglob("run.nc"))
    assert len(list(Path("sweep").iterdir())) == 2
