"""Pair forces from files: as exact as their spline, and part of the scene that names them."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import dpd
from dpd.physics.common.forces import pair_record
from dpd.physics.pair import CELLS, on_grid, read_table
from dpd.scene.scene import Scene
from dpd.start import start_digest
from tests.test_bad_input import refusal
from tests.test_own_forces import PLAIN

OWN = PLAIN | {"pair": {"B A": "unlike.csv"}}
R = np.linspace(0.02, 0.9, 45)
W = 0.9 - R
UNLIKE = (R, 60 * W**3 - 30 * W**2, 180 * W**2 - 60 * W)  # a well, and a wall


def write(path, r, energy, force, header="r,energy,force", form="%.8g"):
    """A file with these columns."""
    columns = np.stack([r, energy, force], axis=1)
    np.savetxt(path, columns, delimiter=",", header=header, comments="", fmt=form)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to work in, with two tables."""
    monkeypatch.chdir(tmp_path)
    write("unlike.csv", *UNLIKE)
    r = np.linspace(0, 1, 51)
    write("soft.csv", r, 5 * (1 - r) ** 2, 10 * (1 - r))
    return tmp_path


def test_a_table_of_the_soft_force_gives_the_same_run(folder):
    """Of one of three pairs; the others, which have none, feel the repulsion alone."""
    less = PLAIN | {"repulsion": PLAIN["repulsion"] | {"A B": 20}, "pair": {"A B": "soft.csv"}}
    found, expected = dpd.run(less, progress=False), dpd.run(PLAIN, progress=False)
    np.testing.assert_allclose(found.position, expected.position, atol=1e-8)
    np.testing.assert_allclose(found.pressure, expected.pressure, rtol=1e-8)
    np.testing.assert_allclose(found.pair_energy, expected.pair_energy, rtol=1e-8)


def test_the_grid_is_as_exact_as_it_should_be(folder):
    """Its force within 1e-8 of the largest of the spline, and minus the slope of its energy."""
    r = np.linspace(0.01, 1, 100)
    w = 1 - r
    write("wave.csv", r, -(np.sin(np.pi * w) ** 2), -np.pi * np.sin(2 * np.pi * w), form="%.12g")
    scene = Scene(PLAIN | {"pair": {"A A": "wave.csv"}})
    record = pair_record(scene.terms["pair"], scene)
    law = record._replace(table=1, end=1.0)
    spline = CubicSpline(r, -np.pi * np.sin(2 * np.pi * w))
    for x in np.random.default_rng(1).uniform(0.011, 0.999, 200):
        assert law.force(x, 1 - x) == pytest.approx(spline(x), abs=3e-8)
        slope = (law.energy(x + 1e-6, 0) - law.energy(x - 1e-6, 0)) / 2e-6
        assert law.force(x, 0) == pytest.approx(-slope, abs=1e-7)
        assert law.energy(x, 0) == pytest.approx(-(np.sin(np.pi * (1 - x)) ** 2), abs=1e-5)
    assert on_grid(read_table(Path("wave.csv"), "my.yaml")).shape == (CELLS, 5)
    nearer = spline(0.01) - 0.01 * spline(0.01, 1)  # straight on to 0, and nothing behind the end
    assert law.force(0.0, 1.0) == pytest.approx(nearer, abs=3e-8)
    assert law._replace(end=0.9).force(0.95, 0.05) == law._replace(end=0.9).energy(0.95, 0.05) == 0
    none = record._replace(table=0, end=1.0)
    assert none.force(0.3, 0.7) == none.energy(0.3, 0.7) == 0


def test_what_is_in_the_file_is_part_of_the_scene(folder):
    """Where it lies is not; a result has it, and needs no file."""
    relaxed = OWN | {"start": {"relax": {"steps": 5, "dt": 0.01}}}
    scene = Scene(relaxed)
    (folder / "deeper").mkdir()
    os.rename("unlike.csv", "deeper/unlike.csv")
    for same in (Scene(relaxed, folder="deeper"), Scene(scene.data)):
        assert (same.digest, start_digest(same)) == (scene.digest, start_digest(scene))
    write("deeper/unlike.csv", UNLIKE[0], 2 * UNLIKE[1], 2 * UNLIKE[2])
    other = Scene(relaxed, folder="deeper")
    assert other.digest != scene.digest and start_digest(other) != start_digest(scene)


GOOD = "r,energy,force\n" + "".join(f"{r},{(1 - r) ** 2},{2 * (1 - r)}\n" for r in np.arange(9) / 8)
BAD = [
    ("", "r: List should have at least 5 items"),
    (GOOD.replace("force", "push"), "row 2: 'force'; needed are numbers in the columns r, energy"),
    (GOOD.replace("0.25,0.5625", "0.25,o.5625"), "row 4: could not convert string to float: 'o"),
    (GOOD.replace("0.25,", "0.5,"), "r: 0.375 is not above that before, 0.5"),
    (GOOD.replace("0.0,1.0,2.0\n0.125,0.765625,1.75\n", ""), "r: from 0.25 to 1; allowed: from 0"),
    (GOOD.replace("1.0,0.0,0.0\n", ""), "energy: 0.015625 where the force ends"),
    (GOOD.replace("0.5625,1.5", "0.5625,1.2"), "energy: 0.5625 at r = 0.25, and the integral"),
]


@pytest.mark.parametrize(("text", "said"), BAD, ids=range(len(BAD)))
def test_what_is_wrong_is_told(folder, text, said):
    """And with the file."""
    (folder / "unlike.csv").write_text(text)
    message = refusal(Scene, OWN)
    assert said in message and "pair.B A: " in message and "unlike.csv: " in message, message
