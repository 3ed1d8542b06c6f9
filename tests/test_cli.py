"""The command line as a user meets it: in a process of its own."""

import json
import os
import subprocess
import sys

import pytest

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


def test_other_values_than_the_scene_has(folder, dpd):
    """By their keys; what is refused names them."""
    settings = ("repulsion.A A=30", "steps={sample: 20}", "molecules.0.density=2.0")
    assert dpd("run", "scene.yaml", "-o", "run.nc", *(f"--set={each}" for each in settings))[0] == 0
    scene = json.loads(read("run.nc")[1]["scene"])
    assert scene["repulsion"] == {"A A": 30} and scene["molecules"][0]["density"] == 2
    assert scene["steps"] == SCENE["steps"] | {"sample": 20}
    for wrong, said in (
        ("boxx=3", "scene.yaml, --set boxx=3: unknown key 'boxx'; .* did you mean 'box'"),
        ("integrator.dtt=3", "integrator: unknown key 'dtt'; .* did you mean 'dt'"),
        ("molecules.3.density=4", "molecules.3: no item '3' in a list of 1"),
        ("seed=[", "--set seed=.*: this is not YAML"),
    ):
        with pytest.raises(UserError, match=said):
            Scene.read("scene.yaml", settings=[wrong])


def test_a_run_that_blows_up_says_when_and_why(folder, dpd):
    """Step, bead, distance, remedy; exit code 1; no result."""
    wild = "--set=integrator={scheme: euler, dt: 0.5}"
    code, said = dpd("run", "scene.yaml", "-o", "run.nc", wild)
    assert code == 1 and "blew up: bead" in said and "dt 0.5 is too large" in said
    assert os.listdir() == ["scene.yaml"]


def test_misspelt_names_of_stages(folder, dpd):
    """Study, paper, sweep, point, figure: what there is instead."""
    paper = "groot_warren_1997"
    for names, word in (
        (["simulate", "quik", paper, "fluid", "replica=0"], "did you mean 'quick'"),
        (["simulate", "quick", "groot", "fluid", "replica=0"], paper),
        (["simulate", "quick", paper, "fluids", "replica=0"], "did you mean 'fluid'"),
        (["simulate", "quick", paper, "fluid", "replica=7"], "replica=0"),
        (["figure", "quick", paper, "fig99"], "fig01_time_step"),
    ):
        code, said = dpd(*names, "-o", "run.nc")
        assert code == 1 and word in said, said
    assert os.listdir() == ["scene.yaml"]
