"""Speed and physics beside LAMMPS: one system in both codes, and each measurement made small."""

import numpy as np
import pytest
import xarray as xr

from benchmarks.costs import whole_run
from benchmarks.measure import measure
from benchmarks.systems import workload
from dpd.errors import UserError
from dpd.pipeline.paper import read_paper
from dpd.report.figures import load_module, make_figure
from dpd.report.text import typeset
from dpd.start.common.make import make_start
from tests.test_pipeline import assert_drawn, copy_repository, planned


@pytest.mark.few("oligomers")
@pytest.mark.parametrize("name", ["oligomers", "shear"])
def test_whole_runs_beside_the_bare_loop(name):
    """Of a small system in the place of the real one: both rates."""
    scene = workload(name, box=6, steps={"sample": 60}, start={})
    assert (whole_run(scene, make_start(scene), turns=2) > 0).all()


FIGURES = ("lammps", "scaling", "features", "tension")
FEW = {"steps": {"sample": 20}}
FLUID = workload("W1", box=7, start={"relax": {"steps": 100, "dt": 0.02}}, **FEW)
CHAINS = {
    "box": 8, "molecules": [{"architecture": "A 16", "count": 32}],
    "start": {"relax": {"steps": 500, "dt": 0.005}},
} | FEW  # fmt: skip
SMALL = {
    "W1": FLUID,
    "W2": workload("W2", **CHAINS),
    "W2, dpd-vv": workload("W2, dpd-vv", **CHAINS),
}
SMALL_SLABS = workload("W4", box=[4, 4, 12], start={"method": "slabs"}, **FEW)
SIZES = {
    "lammps": {"scenes": SMALL, "turns": 2, "snapshots": 20, "reach": 3.0},
    "scaling": {
        "beads": (1000, 100_000), "densities": (1, 3), "at": 1000, "work": 2e4, "turns": 2,
        "begins": 1,
    },
    "schemes": {"scenes": {name: SMALL[name] for name in ("W1", "W2")}, "turns": 2},
    "features": {"scene": FLUID, "steps": 10, "turns": 2},
    "tension": {"scene": SMALL_SLABS, "settling": 500, "samples": 400},
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Folder of a study, for measurements made small."""
    return tmp_path_factory.mktemp("results")


def path_of(results, name):
    """File of a measurement, made if it is not there."""
    path = results / "benchmark" / "measurements" / f"{name}.nc"
    if not path.exists():
        measure(name, path, str, **SIZES[name])
    return path


def made(results, name):
    """A measurement."""
    return xr.load_dataset(path_of(results, name))


def drawn(results, name):
    """Files of a figure, made."""
    folder = results / "benchmark" / "figures"
    make_figure("benchmark", name, {name: path_of(results, name)}, folder)
    return folder


def test_unknown_measurements_are_refused(tmp_path):
    """With the names that there are; nothing is written."""
    with pytest.raises(UserError, match="did you mean 'features'"):
        measure("feature", tmp_path / "x.nc", str)
    assert not list(tmp_path.iterdir())


@pytest.mark.thorough
def test_what_is_planned(tmp_path):
    """The benchmark's own jobs and no other paper's; one figure's; none by default."""
    folder = copy_repository(tmp_path / "copy")
    paper = read_paper("benchmark", "quick")
    jobs = planned(folder, "benchmark")
    assert jobs["measure"] == len(paper.measurements) and jobs["benchmark"] == 1
    assert jobs["draw_figure"] == len(paper.figures) and "write_report" not in jobs
    one = planned(folder, "results/quick/benchmark/figures/lammps.png")
    assert one == {"measure": 1, "draw_figure": 1}
    assert "measure" not in planned(folder)
    section = planned(folder, "--config", "papers=[benchmark]")
    assert section["measure"] == len(paper.measurements) and section["write_report"] == 1


def test_rates_and_physics_beside_lammps(results):
    """Rates in all turns; both codes find the same temperature, pressure and bonds."""
    data = made(results, "lammps")
    assert data.own_rate.shape == (3, 2) and (data.own_rate > 1e4).all()
    assert np.isfinite(data.kT.sel(code="own")).all()
    assert np.isnan(data.lammps_rate.sel(workload="W2, dpd-vv")).all()
    assert np.isnan(data.bond.sel(workload="W1")).all()
    means = data.mean("snapshot").sel(workload=["W1", "W2"])
    assert 0.9 < float(means.bond.sel(workload="W2", code="own")) < 1.1
    for name, tolerance in (("kT", 0.05), ("pressure", 0.05), ("bond", 0.01)):
        own, other = (means[name].sel(code=code) for code in ("own", "lammps"))
        np.testing.assert_allclose(own, other, rtol=tolerance, err_msg=name)
    assert float(abs(means.rdf.diff("code")).mean()) < 0.05


def test_tension_beside_lammps(results):
    """Both codes find the same tension; the normal pressure is the same in all slices."""
    data = made(results, "tension")
    assert data.normal.shape == data.tangential.shape == (2, 50, 24)
    numbers = load_module("benchmark", "tension").compute({"tension": data})
    tension, error = numbers.tension.values, numbers.tension_error.values
    assert 0 < error[0] < 0.3
    assert abs(tension[0] - 0.656) < 4 * np.hypot(error[0], 0.018)  # of a run 40 times as long
    normal = data.normal.sel(code="own").mean("block")
    assert float(normal.std() / normal.mean()) < 0.03
    assert abs(tension[0] - tension[1]) < 4 * np.hypot(*error)


@pytest.mark.thorough
def test_scaling(results):
    """Positive rates of every size, density and number of threads; memory and start sensible."""
    data = made(results, "scaling")
    assert data.rate.dims == ("beads", "threads", "turn")
    assert (data.rate.sel(threads=1) > 1e4).all() and (data.density_rate.sel(threads=1) > 1e4).all()
    less, more = data.memory.values
    # A bead has 20 numbers of 8 bytes at the very least, in two copies while it moves.
    assert 100 < (more - less) / np.ptp(data.beads.values) < 5000
    assert 0.1 < float(data.start_up[0]) < 60


@pytest.mark.few(1)
@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_made(results, name):
    """Picture, numbers with units, and a caption with what was measured, and a table."""
    folder = drawn(results, name)
    assert_drawn(folder, name)
    caption = (folder / f"{name}.html").read_text()
    assert typeset(made(results, name).attrs["description"]) in caption
    assert '<th scope="col">' in caption
