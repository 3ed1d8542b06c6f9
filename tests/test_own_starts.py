"""Starts of a user's own: beads where a file outside of the package puts them."""

import json
import os
import shutil

import numpy as np
import pytest
import yaml

import dpd
from dpd.errors import UserError
from dpd.files import attributes
from dpd.files import read as read_netcdf
from dpd.folders import PACKAGE
from dpd.particles import read
from dpd.runs.result import is_made
from dpd.scene.scene import Scene
from dpd.start import start_work
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import compile_start, make_start
from tests import test_bond_pages, test_own_forces, test_own_pages
from tests.conftest import command, documented, folder_with

PAGE = '''"""Beads on a line."""

import numpy as np

from dpd.page import Start, setting


class Line(Start, key="line"):
    """Beads along x, one after the other."""

    step: float = setting("Distance of two beads.", 0.1, unit="r_c", gt=0, le=5)

    def positions(self, scene, rng):
        x = rng.random((scene.beads, scene.dimension))
        x[:, 0] = self.step * np.arange(len(x))
        return x
'''
MOVING = """
    def velocities(self, scene, rng):
        return np.full((scene.beads, 3), [0.5, 0, -0.5])
"""
SCENE = test_own_pages.SCENE | {
    "steps": {"sample": 20},
    "observe": ["thermo"],
    "start": {"method": "line", "step": 0.05, "seed": 4},
    "pages": ["line.py"],
}
RELAXED = SCENE | {"start": SCENE["start"] | {"relax": {"steps": 10, "dt": 0.01}}}


folder = folder_with({"line.py": PAGE, "scene.yaml": SCENE | {"pages": []}})


def test_from_the_command_line(folder):
    """The first configuration that a run keeps is that of the page, with thermal velocities."""
    done = command("run", "scene.yaml", "-o", "run.nc", "--page", "line.py", "--start", "start.nc")
    assert done.returncode == 0, done.stderr
    start = read("start.nc")
    line = np.random.default_rng(4).random((192, 3))
    line[:, 0] = 0.05 * np.arange(192)
    np.testing.assert_allclose(start.position, line.T % 4, atol=1e-12)
    assert np.mean(start.velocity**2) == pytest.approx(1, abs=0.3)
    np.testing.assert_allclose(start.velocity.sum(axis=1), 0, atol=1e-10)
    assert json.loads(attributes("start.nc")["start"])["settings"] == {"step": 0.05}
    assert command("extend", "run.nc", "--sample", 20).returncode == 0


def test_velocities_of_the_page(folder):
    """As it gives them."""
    (folder / "line.py").write_text(PAGE + MOVING)
    np.testing.assert_array_equal(
        make_start(Scene(SCENE)).velocity, [[0.5] * 192, [0] * 192, [-0.5] * 192]
    )


def test_an_edited_page_makes_the_start_again_and_a_comment_does_not(folder):
    """And its runs; one that begins otherwise stays, though its scene names the file."""
    scene, plain = Scene(RELAXED), RELAXED | {"start": {"method": "slabs"}}
    dpd.run(plain, output="plain.nc", progress=False)
    write_start(scene, "start.nc")
    dpd.run(scene, output="run.nc", progress=False)
    (folder / "line.py").write_text(PAGE.replace("return x", "# all of them\n        return x"))
    assert is_made(Scene(RELAXED), "run.nc")
    read_start(Scene(RELAXED), "start.nc")
    (folder / "line.py").write_text(PAGE.replace("np.arange", "0.5 * np.arange"))
    assert not is_made(Scene(RELAXED), "run.nc") and is_made(Scene(plain), "plain.nc")
    with pytest.raises(UserError, match=r"start\.nc: "):
        read_start(Scene(RELAXED), "start.nc")


def test_kernels_are_compiled_without_one_that_takes_long(folder):
    """It says so by its `work`."""
    assert not start_work(Scene(SCENE))
    slow = PAGE.replace("    step:", "    work = 500\n    step:")
    (folder / "line.py").write_text(slow)
    assert start_work(Scene(SCENE)) == 192
    (folder / "line.py").write_text(slow.replace("x = rng", "raise ValueError\n        x = rng"))
    compile_start(Scene(SCENE))


def test_between_walls_beads_are_counted_from_the_lower_one(folder):
    """And one behind a wall is refused: nothing repeats there."""
    walled = SCENE | {"walls": {"axis": "z", "repulsion": 25}, "box": [8, 4, 4]}
    scene = Scene(walled)
    z = make_start(scene).position[2] - scene.origin[2]
    np.testing.assert_allclose(z, np.random.default_rng(4).random((384, 3))[:, 2], atol=1e-12)
    (folder / "line.py").write_text(PAGE.replace("return x", "return x[:, ::-1]"))
    with pytest.raises(UserError, match=r"bead 81 is at 4\.05 along z, behind a wall"):
        make_start(Scene(walled))


def test_the_page_of_the_documentation(folder):
    """Tails are in the middle, heads outside of them, and water anywhere."""
    (folder / "bilayer.py").write_text(documented("## A start of your own"))
    kinds = [{"architecture": "A B 3", "count": 20}, {"architecture": "A", "count": 9}]
    start = {"start": {"method": "bilayer", "spacing": 0.4}, "pages": ["bilayer.py"]}
    bond = {"bond": {"stiffness": 50, "length": 0.5}}
    scene = Scene(SCENE | {"molecules": kinds} | bond | start)
    state = make_start(scene)
    z = np.abs(state.position[2] - 2)[:80].reshape(20, 4)
    np.testing.assert_allclose(z, np.tile([1.4, 1.0, 0.6, 0.2], (20, 1)), atol=1e-12)
    assert (state.position[2, :80] > 2).sum() == 40


# Files that are dropped into the package.


PAGES = {
    "physics/morse.py": test_own_forces.MORSE,
    "physics/quartic.py": test_bond_pages.QUARTIC,
    "observe/neighbours.py": test_own_pages.PAGE,
    "start/line.py": PAGE,
}
DROPPED = {
    "dimension": 3, "box": 4,
    "molecules": [{"architecture": "A 3", "density": 2}, {"architecture": "B", "density": 1}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 20},
    "morse": {"depth": {"A A": 1, "A B": 0, "B B": 3}},
    "quartic": {"stiffness": 5, "fourth": 2},
    "start": {"method": "line", "step": 0.02},
    "integrator": {"scheme": "gw-vv", "dt": 0.001},
    "steps": {"sample": 4},
    "observe": [{"neighbours": {"every": 2}}],
}  # fmt: skip


def run(house, scene, result):
    """Run a scene with a package, without the compiler: what it does is the same."""
    without = {"PYTHONPATH": str(house), "NUMBA_DISABLE_JIT": "1"}
    done = command("run", scene, "-o", result, **without)
    assert done.returncode == 0, done.stderr
    return read_netcdf(result)[0]


def test_files_dropped_into_the_package_are_its_own(tmp_path, monkeypatch):
    """The same beads and numbers, and no scene has to name a file."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(PACKAGE, "house/dpd", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in PAGES.items():
        (tmp_path / "house" / "dpd" / name).write_text(text)
        (tmp_path / os.path.basename(name)).write_text(text)
    (tmp_path / "plain.yaml").write_text(yaml.safe_dump(DROPPED))
    files = [os.path.basename(name) for name in PAGES]
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(DROPPED | {"pages": files}))
    own = run(PACKAGE.parent, "own.yaml", "own.nc")
    dropped = run("house", "plain.yaml", "dropped.nc")
    assert own["neighbours"].std() > 0
    for name in ("last_position", "last_velocity", "neighbours"):
        assert own[name].tobytes() == dropped[name].tobytes(), name
