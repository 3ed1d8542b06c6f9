"""Runs that begin with a configuration from a file of any origin."""

import json
import os
import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import yaml

from dpd import files
from dpd.errors import UserError
from dpd.particles import read, write
from dpd.runs.result import of_state
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge
from dpd.start import start_digest
from dpd.start.common.files import order_of
from dpd.start.common.make import make_start, species_of
from tests.conftest import SCENE
from tests.test_extend import run

MELT = SCENE | {
    "box": [4, 4.5, 5],
    "molecules": [
        {"architecture": "A 2 B", "count": 20}, {"architecture": "B", "count": 9},
        {"architecture": "A 2 (B) A", "count": 5}, {"architecture": "B", "count": 4},
    ],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 20, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 10, "sample": 40},
    "observe": [{"thermo": {"every": 5}}, {"chains": {"every": 5}}],
}  # fmt: skip


def from_file(path, **more):
    return MELT | {"start": {"method": "file", "path": str(path)} | more}


@pytest.fixture
def melt():
    """A scene, and particles that are a start of it."""
    scene = Scene(MELT)
    return scene, of_state(scene, make_start(scene))


@pytest.mark.parametrize("kind", ["nc", "gsd", "data"])
def test_a_file_is_the_start(melt, tmp_path, kind):
    """With its velocities, as exactly as the format has them."""
    _, particles = melt
    path = tmp_path / f"melt.{kind}"
    write(particles, path)
    said = []
    state = make_start(Scene(from_file(path)), say=said.append)
    close = {"nc": 0, "gsd": 1e-15, "data": 0}[kind]
    np.testing.assert_allclose(state.position, particles.position, rtol=0, atol=10 * close)
    np.testing.assert_array_equal(state.velocity, particles.velocity)
    np.testing.assert_array_equal(state.species, particles.species)
    assert state.step == 0 and state.force is None and said == []


def test_molecules_in_another_order(melt, tmp_path):
    """Mixed with each other, their beads in the order of the architecture: each gets its place."""
    scene, particles = melt
    rng, molecule = np.random.default_rng(1), np.repeat(np.arange(38), scene.lengths)
    order = rng.permutation(scene.beads)
    order[np.argsort(molecule[order], kind="stable")] = np.arange(scene.beads)
    number = np.argsort(order).astype(np.uint32)
    arrays = ("position", "velocity", "image")
    mixed = {name: getattr(particles, name)[:, order] for name in arrays}
    mixed |= {"species": particles.species[order], "bonds": number[particles.bonds][::-1]}
    path = tmp_path / "melt.nc"
    write(particles._replace(**mixed), path)
    said = []
    state = make_start(Scene(from_file(path)), say=said.append)
    assert len(said) == 1 and "are in another order" in said[0]
    # Which bead of the scene's own numbering each one was.
    was = order[order_of(scene, read(path), "melt.nc")]
    assert np.array_equal(np.sort(was), np.arange(scene.beads))
    np.testing.assert_array_equal(state.position, particles.position[:, was])
    np.testing.assert_array_equal(state.velocity, particles.velocity[:, was])
    np.testing.assert_array_equal(species_of(scene)[was], species_of(scene))
    bonds = {frozenset(bond) for bond in scene.bonded.tolist()}
    assert {frozenset(bond) for bond in was[scene.bonded].tolist()} == bonds


def bonded(particles, *more):
    bonds = np.concatenate([particles.bonds, np.array(more, np.uint32)])
    return particles._replace(bonds=bonds)


DIFFERENT = {
    "box": (
        lambda p: p._replace(box=(4, 4.5, 5.001)), ["its box is [4, 4.5, 5.001]", "[4, 4.5, 5]"],
    ),
    "name": (lambda p: p._replace(names=("A", "W")), ["species 'W'", "has A, B"]),
    "a bead less": (
        lambda p: p.only(np.arange(p.beads) != 62), ["3 molecules B for 4", "55 A, 37 B"]
    ),
    "a branch": (lambda p: bonded(p, [1, 60]), ["19 molecules A 2 B for 20"]),
    "a ring": (lambda p: bonded(p, [2, 0]), ["19 molecules A 2 B for 20"]),
}  # fmt: skip


@pytest.mark.parametrize("name", DIFFERENT)
def test_another_system_is_refused(melt, tmp_path, name):
    """For what it is, with the first difference."""
    change, words = DIFFERENT[name]
    path = tmp_path / "melt.nc"
    write(change(melt[1]), path)
    with pytest.raises(UserError) as caught:
        make_start(Scene(from_file(path), "scene.yaml"))
    said = str(caught.value)
    assert said.startswith(str(path)) and all(word in said for word in words), said


def test_velocities_that_are_missing(melt, tmp_path):
    """They are drawn at the temperature of the start, by its seed, and that is said."""
    write(melt[1]._replace(velocity=None), tmp_path / "melt.gsd")
    said = []
    one, other = (
        make_start(Scene(from_file(tmp_path / "melt.gsd", kT=4, seed=seed)), say=said.append)
        for seed in (1, 2)
    )
    np.testing.assert_array_equal(one.position, other.position)
    assert (one.velocity != other.velocity).all()
    assert 3 < np.mean(one.velocity**2) < 5 and np.abs(one.velocity.mean(axis=1)).max() < 1e-12
    assert len(said) == 2 and "no velocities, so they are drawn at kT 4" in said[0]


def test_the_content_counts(melt, tmp_path):
    """And not the place: an edited file is another start, and another scene."""
    write(melt[1], tmp_path / "one.nc")
    shutil.copy(tmp_path / "one.nc", tmp_path / "two.nc")
    one, two = (Scene(from_file(tmp_path / name)) for name in ("one.nc", "two.nc"))
    assert (one.digest, start_digest(one)) == (two.digest, start_digest(two))
    write(melt[1]._replace(position=melt[1].position[:, ::-1]), tmp_path / "two.nc")
    edited = Scene(from_file(tmp_path / "two.nc"))
    assert edited.digest != one.digest and start_digest(edited) != start_digest(one)
    with pytest.raises(UserError, match=r"not that of start\.sha256"):
        make_start(two)  # which was read before the edit
    first = Scene(from_file(tmp_path / "one.nc", frame=0))
    assert first.digest != one.digest and start_digest(first) != start_digest(one)
    # A scene that knows the content needs no file before it begins: as that of a finished run.
    (tmp_path / "one.nc").unlink()
    assert Scene(one.data).digest == one.digest


def test_where_a_path_counts_from(melt, tmp_path, monkeypatch):
    """From the file of the scene; without one, from the working folder."""
    for folder in ("scenes", "work"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path / "work")
    write(melt[1], tmp_path / "scenes" / "melt.nc")
    path = tmp_path / "scenes" / "scene.yaml"
    path.write_text(yaml.safe_dump(from_file("melt.nc")))
    assert Scene.read(path).data["start"]["path"] == str(tmp_path / "scenes" / "melt.nc")
    with pytest.raises(UserError, match=r"start\.path: .*work/melt\.nc: there is no such file"):
        Scene(from_file("melt.nc"))
    assert Scene(from_file("../scenes/melt.nc")).digest == Scene.read(path).digest


# The command.


@pytest.fixture
def work(folder):
    """A scene in the working folder, and the finished run of it."""
    Path("melt.yaml").write_text(yaml.safe_dump(MELT))
    run(MELT, "run.nc")
    return folder


def test_a_run_begins_where_another_ended(work, dpd):
    """With its velocities, and other parameters; the same noise is said."""
    assert dpd("run", "melt.yaml", "--start", "run.nc", "-o", "next.nc")[0] == 0
    assert "the same noise comes again" in dpd.output
    other = merge(MELT, {"repulsion": {"A B": 40}, "thermostat": {"kT": 0.9}, "seed": 7})
    Path("melt.yaml").write_text(yaml.safe_dump(other))
    assert dpd("run", "melt.yaml", "--start", "run.nc", "-o", "third.nc")[0] == 0
    assert "noise" not in dpd.output
    attributes = files.read("third.nc")[1]
    start = json.loads(attributes["scene"])["start"]
    assert start["method"] == "file" and start["path"] == os.path.abspath("run.nc")
    last, begun = files.read("run.nc")[0], make_start(Scene(from_file("run.nc")))
    np.testing.assert_array_equal(begun.position, last["last_position"])
    np.testing.assert_array_equal(begun.velocity, last["last_velocity"])


def test_a_start_of_other_sources(work, dpd):
    """One's own run takes it and says so."""
    assert dpd("run", "melt.yaml", "--start", "start.nc", "-o", "one.nc")[0] == 0
    with netCDF4.Dataset("start.nc", "a") as file:
        file.start_sources = "0" * 12
    assert dpd("run", "melt.yaml", "--start", "start.nc", "-o", "two.nc")[0] == 0
    assert "start.nc: made by other sources than today's" in dpd.output
    one, two = (files.read(name)[0] for name in ("one.nc", "two.nc"))
    for name, values in one.items():
        np.testing.assert_array_equal(values, two[name], err_msg=name)


def test_files_that_no_run_can_begin_with(work, dpd):
    """One sentence that names the file, whether by option or in the scene; nothing is written."""
    write(read("run.nc"), "cut.gsd")
    Path("cut.gsd").write_bytes(Path("cut.gsd").read_bytes()[:-50])
    Path("melt.txt").write_text("A 0 0 0")
    shutil.copy("run.nc", "nan.nc")
    with netCDF4.Dataset("nan.nc", "a") as file:
        file["last_velocity"][0, 5] = np.nan
    for name, words in (
        ("none.gsd", "no such file"), ("cut.gsd", "cut.gsd: "), ("melt.txt", "suffix '.txt'"),
        ("nan.nc", "bead 5 has a velocity that is not a finite number"),
    ):  # fmt: skip
        Path("other.yaml").write_text(yaml.safe_dump(from_file(name)))
        before = sorted(os.listdir())
        for given in (("melt.yaml", "--start", name), ("other.yaml",)):
            code, said = dpd("run", *given, "-o", "out.nc")
            assert code == 1 and said.startswith("error: ") and said.count("\n") == 1, said
            assert words in said, said
        assert sorted(os.listdir()) == before
