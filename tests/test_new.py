"""`dpd new`: example scenes that the package holds."""

import json

import jsonschema
import numpy as np
import pytest

import dpd as package
from dpd.commands.main import main
from dpd.digest import PACKAGE
from dpd.scene.yaml import read_yaml

SCENES = {path.stem: path for path in sorted((PACKAGE / "scenes").glob("*.yaml"))}
SMALLER = {
    "melt_2d": {"box": 10, "start": {"method": "polymerize", "relax": {"steps": 100, "dt": 0.002}}},
}


def shortened(name):
    """An example with a few steps, in each of which everything is looked at."""
    scene = read_yaml(SCENES[name]) | SMALLER.get(name, {})
    scene.pop("duration", None)
    scene["steps"] = {"equilibrate": 0, "sample": 100}
    for place, item in enumerate(scene["observe"]):
        settings = item if isinstance(item, dict) else {item: {}}
        scene["observe"][place] = {key: own | {"every": 1} for key, own in settings.items()}
    return scene


@pytest.mark.filterwarnings("ignore:kT is")  # after so few steps
@pytest.mark.few("fluid")
@pytest.mark.parametrize("name", SCENES)
def test_examples_run(name):
    """For a few steps, and with all that they observe."""
    run = package.run(shortened(name), progress=False)
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


def test_an_editor_completes_the_keys(capsys):
    """By the schema, which examples fit."""
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    for name in ("fluid", "shear"):
        jsonschema.Draft202012Validator(schema).validate(read_yaml(SCENES[name]))
