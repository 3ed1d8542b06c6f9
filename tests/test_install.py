"""The package as pip installs it, away from the repository: a wheel, a command, figures."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from dpd.digests import run_sources
from dpd.files import read
from dpd.folders import PACKAGE
from dpd.scene.scene import Scene
from tests.conftest import SCENE
from tests.test_pipeline import copy_repository

FLUID = SCENE | {"observe": ["thermo"]}
NO_SOURCE = {"__pycache__", "build"}


def call(*command, cwd, **environment):
    """A process that does not see the sources of this repository."""
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [str(word) for word in command], cwd=cwd, env=clean | environment, capture_output=True,
        text=True, check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of a copy of the repository: building leaves files beside the sources."""
    folder = tmp_path_factory.mktemp("wheel")
    source = copy_repository(folder / "source")
    for left in [source / "build", *source.glob("src/*.egg-info")]:
        shutil.rmtree(left, ignore_errors=True)
    done = call(
        sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index",
        "--wheel-dir", folder, source, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = folder.glob("*.whl")
    return path


class Installed(NamedTuple):
    """An environment of its own with the wheel, and an empty folder to work in."""

    environment: Path
    folder: Path

    def dpd(self, *arguments, cwd=None):
        """The program that pip has put there."""
        return call(self.environment / "bin" / "dpd", *arguments, cwd=cwd or self.folder)

    def python(self, program, *arguments):
        """A program in Python."""
        python = self.environment / "bin" / "python"
        return call(python, "-c", program, *arguments, cwd=self.folder, MPLBACKEND="Agg")


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """It sees the libraries of this environment, and not what is installed for editing in it."""
    folder = tmp_path_factory.mktemp("environment")
    assert call(sys.executable, "-m", "venv", "--without-pip", folder, cwd=folder).returncode == 0
    done = call(
        sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "--no-deps",
        "--no-index", wheel, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    (own,) = folder.glob("lib/python*/site-packages")
    shared = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    (own / "libraries.pth").write_text("".join(f"{path}\n" for path in shared))
    return Installed(folder, tmp_path_factory.mktemp("away"))


def test_a_wheel_holds_all_files_that_the_package_reads(wheel):
    """Code, tables, templates; pages for people stay in the repository."""
    held = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("dpd/")}
    there = {
        f"dpd/{path.relative_to(PACKAGE)}"
        for path in PACKAGE.rglob("*")
        if path.is_file() and path.suffix != ".md" and not NO_SOURCE & set(path.parts)
    }
    assert held == there
    assert {"dpd/scenes/fluid.yaml", "dpd/report/page.html"} <= held
    assert "dpd/physics/common/automatic.yaml" in held


@pytest.mark.thorough
def test_a_scene_away_from_the_repository(installed):
    """The command makes a result; Python reads it and draws a figure; digests are the same."""
    scene = installed.folder / "fluid.yaml"
    scene.write_text(yaml.safe_dump(FLUID))
    done = installed.dpd("run", scene, "-o", "run.nc")
    assert done.returncode == 0, done.stderr
    assert "kT" in done.stdout and "warning" not in done.stderr
    variables, attributes = read(installed.folder / "run.nc")
    assert abs(variables["kT"].mean() - 1) < 0.2
    assert attributes["sources"] == run_sources(Scene(FLUID))
    drawn = installed.python(DRAW)
    assert drawn.returncode == 0, drawn.stderr
    assert Path(drawn.stdout.strip()).is_relative_to(installed.environment)
    names = ["figure.png", "fluid.yaml", "run.nc"]
    assert sorted(path.name for path in installed.folder.iterdir()) == names


DRAW = """
import dpd
run = dpd.load("run.nc")
run.pressure.plot()
from matplotlib import pyplot
pyplot.savefig("figure.png")
print(dpd.__file__)
"""


def test_the_pipeline_wants_the_repository(installed, tmp_path):
    """It says so in one sentence; called in a clone, it finds it."""
    done = installed.dpd("plan", cwd=tmp_path)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {tmp_path}/config: ") and "change to the folder" in line
    assert not list(tmp_path.iterdir())
