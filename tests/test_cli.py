"""The command line as a user meets it: in a process of its own."""

import json
import os

import numpy as np
import pytest

import dpd as package
from dpd.commands.main import main
from dpd.errors import UserError
from dpd.files import read
from dpd.folders import PACKAGE
from dpd.scene.scene import Scene
from dpd.scene.yaml import read_yaml
from tests.conftest import SCENE


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


# Example scenes that the package holds.


SCENES = {path.stem: path for path in sorted((PACKAGE / "scenes").glob("*.yaml"))}
SMALLER = {
    "melt_2d": {"box": 10, "start": {"method": "polymerize", "relax": {"steps": 100, "dt": 0.002}}},
    "rest_after_shear": {"schedule": [{"step": 50, "set": {"shear.rate": 0}}]},
}


@pytest.mark.filterwarnings("ignore:kT is")  # after so few steps
@pytest.mark.few("fluid")
@pytest.mark.parametrize("name", SCENES)
def test_examples_run(name, tmp_path):
    """For a few steps, in each of which all that they observe is looked at."""
    scene = read_yaml(SCENES[name]) | SMALLER.get(name, {})
    scene.pop("duration", None)
    scene["steps"] = {"equilibrate": 0, "sample": 100}
    for place, item in enumerate(scene["observe"]):
        settings = item if isinstance(item, dict) else {item: {}}
        scene["observe"][place] = {key: own | {"every": 1} for key, own in settings.items()}
    run = package.run(scene, output=tmp_path / "run.nc", progress=False)
    assert run.attrs["steps"] == 100 and np.isfinite(run.kT).all()


def test_an_example_is_written_and_never_over_another_file(folder, dpd):
    """As the package has it; elsewhere if asked; edited ones stay."""
    assert dpd("new", "fluid")[0] == 0
    assert (folder / "fluid.yaml").read_text() == SCENES["fluid"].read_text()
    (folder / "fluid.yaml").write_text("box: 3\n")
    code, said = dpd("new", "fluid")
    assert code == 1 and "fluid.yaml: is there already" in said and "--overwrite" in said
    assert (folder / "fluid.yaml").read_text() == "box: 3\n"
    assert dpd("new", "fluid", "-o", "mine/other.yaml")[0] == 0
    assert dpd("new", "fluid", "--overwrite")[0] == 0
    for name in ("fluid.yaml", "mine/other.yaml"):
        assert read_yaml(folder / name) == read_yaml(SCENES["fluid"])


def test_all_are_listed_and_names_are_checked(folder, dpd, capsys):
    """A sentence each; nothing is written for a name that is none."""
    assert main(["new"]) == 0
    listed = " ".join(capsys.readouterr().out.split())
    for name, path in SCENES.items():
        first = path.read_text().splitlines()[0]
        assert first.startswith("# ") and first.endswith(".") and f"{name}: {first[2:]}" in listed
    code, said = dpd("new", "triblok")
    assert code == 1 and "did you mean 'triblock'?" in said
    assert not list(folder.glob("tri*"))
