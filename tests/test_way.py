"""A value of a paper's file reaches a verdict by the functions that src/dpd/README.md lists."""

import json
import re
from importlib import import_module

import pandas as pd
import xarray as xr

from dpd.analysis.collect import collect, save
from dpd.folders import PACKAGE
from dpd.pipeline.paper import read_paper
from dpd.report.figures import make_figure
from dpd.runs.run import run
from dpd.scene.yaml import read_yaml

STEPS = {"equilibrate": 20, "sample": 400}


def test_there_are_eight_hops():
    """Each is there under its name."""
    text = (PACKAGE / "README.md").read_text().partition("## The way of a value")[2]
    hops = re.findall(r"^\| (\d) \| `(dpd\.[a-z_.]+)\.(\w+)` \|", text, re.M)
    assert [int(number) for number, _, _ in hops] == list(range(1, 9))
    assert all(callable(getattr(import_module(module), name)) for _, module, name in hops)


def test_every_room_is_on_the_map():
    """And nothing else."""
    rooms = (PACKAGE / "README.md").read_text().partition("## The way of a value")[0]
    named = set(re.findall(r"`(\w+)(?:\.py)?`", "".join(re.findall(r"^\| (`.+?) \|", rooms, re.M))))
    there = {path.stem for path in PACKAGE.iterdir() if (path / "__init__.py").is_file()}
    there |= {path.stem for path in PACKAGE.glob("[a-z]*.py")}
    assert named == there


def test_dt_reaches_a_verdict(tmp_path, monkeypatch):
    """Another dt in the paper's file is that of scene, run, sweep and figure."""

    def edited(path):
        data = read_yaml(path)
        if path.stem == "example":
            sweep = data["sweeps"]["pressure"]
            sweep["scene"]["integrator"]["dt"], sweep["scene"]["steps"] = 0.02, STEPS
            sweep["axes"]["density"]["values"], sweep["replicas"] = [3, 4], 1
        return data

    monkeypatch.setattr("dpd.pipeline.paper.read_yaml", edited)
    sweep = read_paper("example", "quick").sweeps["pressure"]
    paths = [tmp_path / point.name / "run.nc" for point in sweep.points]
    for point, path in zip(sweep.points, paths):
        assert point.scene.dt == 0.02
        run(point.scene, path)
    with xr.open_dataset(paths[0]) as data:
        assert json.loads(data.attrs["scene"])["integrator"]["dt"] == 0.02
        assert float(data.time[-1]) == 0.02 * STEPS["sample"]
    gathered = collect(sweep, paths)
    assert {json.loads(text)["integrator"]["dt"] for text in gathered.scene.values.flat} == {0.02}
    save(gathered, tmp_path / "pressure.nc")
    make_figure("example", "scaled_pressure", {"pressure": tmp_path / "pressure.nc"}, tmp_path)
    (row,) = pd.read_csv(tmp_path / "scaled_pressure.csv").itertuples()
    assert row.published == 0.101 and 0.05 < row.value < 0.15
