"""The command line as a user meets it: in a process of its own."""

import json
import os
import subprocess
import sys

import pytest
import yaml

from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import read
from dpd.scene.scene import Scene
from tests.conftest import SCENE


def dpd(*arguments, cwd):
    """Run ``python -m dpd``."""
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    return subprocess.run(
        [sys.executable, "-m", "dpd", *map(str, arguments)],
        cwd=cwd, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


def write(path, scene):
    path.write_text(yaml.safe_dump(scene))
    return path


def test_other_values_than_the_scene_has(tmp_path):
    """By their keys; what is refused names them."""
    path = write(tmp_path / "scene.yaml", SCENE)
    settings = ("repulsion.A A=30", "steps={sample: 20}", "molecules.0.density=2.0")
    done = dpd(
        "run", path, "-o", tmp_path / "run.nc", *(f"--set={each}" for each in settings),
        cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    scene = json.loads(read(tmp_path / "run.nc")[1]["scene"])
    assert scene["repulsion"] == {"A A": 30} and scene["molecules"][0]["density"] == 2
    assert scene["steps"] == SCENE["steps"] | {"sample": 20}
    for wrong, said in (
        ("boxx=3", "scene.yaml, --set boxx=3: unknown key 'boxx'; .* did you mean 'box'"),
        ("integrator.dtt=3", "integrator: unknown key 'dtt'; .* did you mean 'dt'"),
        ("molecules.3.density=4", "molecules.3: no item '3' in a list of 1"),
        ("seed=[", "--set seed=.*: this is not YAML"),
    ):
        with pytest.raises(UserError, match=said):
            Scene.read(path, settings=[wrong])


def test_a_run_that_blows_up_says_when_and_why(tmp_path):
    """Step, bead, distance, remedy; exit code 1; no result."""
    wild = SCENE | {"integrator": {"scheme": "euler", "dt": 0.5}}
    done = dpd("run", write(tmp_path / "wild.yaml", wild), "-o", tmp_path / "run.nc", cwd=tmp_path)
    assert done.returncode == 1 and not (tmp_path / "run.nc").exists()
    assert "blew up: bead" in done.stderr and "dt 0.5 is too large" in done.stderr


def test_misspelt_names_of_stages(tmp_path):
    """Study, paper, sweep, point, figure: what there is instead."""
    paper = "groot_warren_1997"
    cases = [
        (["simulate", "quik", paper, "fluid", "replica=0"], "did you mean 'quick'"),
        (["simulate", "quick", "groot", "fluid", "replica=0"], paper),
        (["simulate", "quick", paper, "fluids", "replica=0"], "did you mean 'fluid'"),
        (["simulate", "quick", paper, "fluid", "replica=7"], "replica=0"),
    ]
    for names, word in cases:
        done = dpd(*names, "-o", "run.nc", cwd=tmp_path)
        assert done.returncode == 1 and word in done.stderr, done.stderr
    done = dpd("figure", "quick", paper, "fig99", "-o", "figures", cwd=tmp_path)
    assert done.returncode == 1 and "fig01_time_step" in done.stderr
    assert not list(tmp_path.iterdir())
