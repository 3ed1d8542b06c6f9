"""Files of particles that are wrong or damaged: a sentence, and nothing else."""

import os
import random

import gsd.hoomd
import numpy as np
import pytest

from dpd.errors import UserError
from dpd.files import write as write_netcdf
from dpd.particles.formats import read
from dpd.particles.particles import checked
from tests.test_particles import assert_same, write_each_kind


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a file of each kind."""
    folder = tmp_path_factory.mktemp("made")
    write_each_kind(folder)
    return folder


@pytest.mark.parametrize("name", ["melt.gsd", "melt.data", "melt.nc", "start.nc", "run.checkpoint"])
def test_files_that_are_cut_off(made, tmp_path, name):
    """At any size that has not all of the beads; nothing but a sentence."""
    whole = (made / name).read_bytes()
    path = tmp_path / name
    rng = random.Random(name)
    sizes = {0, 1, 7, 100, 255, 256, len(whole) // 2, len(whole) - 1}
    for size in sizes | {rng.randrange(len(whole)) for _ in range(30)}:
        path.write_bytes(whole[:size])
        with pytest.raises(UserError, match=name):
            read(path)


@pytest.mark.parametrize("name", ["melt.gsd", "melt.data", "melt.nc", "run.nc", "run.checkpoint"])
def test_files_with_other_bytes(made, tmp_path, name):
    """Some bytes are others: it is read, or refused in a sentence that names the file.

    The part of the GSD library that is written in C ends the process for some of these.
    """
    whole = (made / name).read_bytes()
    path = tmp_path / name
    for seed in range(150):
        rng, damaged = random.Random(seed), bytearray(whole)
        reach = len(whole) if seed % 2 else min(300, len(whole))  # half of them in the header
        for _ in range(rng.choice([1, 2, 8])):
            damaged[rng.randrange(reach)] = rng.randrange(256)
        path.write_bytes(damaged)
        try:
            found = read(path)
        except UserError as problem:
            assert name in str(problem) and "\n" not in str(problem)
        else:
            assert_same(checked(found, path), found)


@pytest.mark.parametrize("suffix", ["gsd", "data", "lmp", "nc", "checkpoint"])
def test_what_is_no_such_file(tmp_path, suffix):
    """Nothing, a folder, a pipe, an empty file, random bytes, a text."""
    path = tmp_path / f"x.{suffix}"
    with pytest.raises(UserError, match="there is no such file"):
        read(path)
    for make in (path.mkdir, lambda: os.mkfifo(path)):
        make()
        with pytest.raises(UserError, match="is not a file"):
            read(path)
        path.rmdir() if path.is_dir() else path.unlink()
    for content in (b"", random.Random(1).randbytes(5000), b"some text\nof two lines\n"):
        path.write_bytes(content)
        with pytest.raises(UserError, match=rf"x\.{suffix}: "):
            read(path)
    path.chmod(0)
    if not os.access(path, os.R_OK):  # it is, for the superuser
        with pytest.raises(UserError, match="Permission denied"):
            read(path)


def test_a_gsd_file_that_is_wrong(tmp_path):
    """Each is a whole GSD file."""
    path = tmp_path / "wrong.gsd"
    cases = (
        ("frame.configuration.box = [4, 4, 4, 0.1, 0.2, 0]", "tilt factors 0.1, 0.2, 0; allowed"),
        ("frame.configuration.box = [4, 4, 4, 0.6, 0, 0]", "by up to half an edge"),
        ("frame.configuration.box = [4, 0, 4, 0, 0, 0]", "an edge that is not a positive"),
        ("frame.configuration.dimensions = 1", "1 dimensions; allowed: 2 or 3"),
        ("frame.configuration.dimensions = 2", "two dimensions, and beads that are not at z"),
        ("frame.particles.position[3, 1] = np.nan", "bead 3 has a position"),
        ("frame.particles.velocity[4, 0] = np.inf", "bead 4 has a velocity"),
        ("frame.particles.position[5, 2] = 4", "bead 5 is outside of the box of 4 x 4 x 4"),
        ("frame.particles.typeid[6] = 7", "bead 6 is of a kind that is not one of the 1"),
        ("frame.bonds.group = [[0, 9]]", "bonds have beads that are not from 0 to 7"),
        ("frame.bonds.group = [[2, 2]]", "twice in the bond of bead 2, bead 2"),
        ("frame.particles.position = None", "has position for 0; the file .* lacks them"),
        ("frame.bonds.N, frame.bonds.group = 2, [[0, 1], [1, 0]]", "0 and bead 1 are bonded more"),
    )
    for change, said in cases:
        frame = gsd.hoomd.Frame()
        frame.configuration.box = [4, 4, 4, 0, 0, 0]
        frame.particles.N, frame.particles.types = 8, ["A"]
        frame.particles.position = np.random.default_rng(1).random((8, 3))
        frame.particles.velocity = np.ones((8, 3))
        frame.particles.typeid = np.zeros(8, int)
        frame.bonds.N, frame.bonds.types, frame.bonds.group = 1, ["b"], [[0, 1]]
        exec(change)
        with gsd.hoomd.open(path, "w") as file:
            file.append(frame)
        with pytest.raises(UserError, match=rf"wrong\.gsd: .*{said}"):
            read(path)
    with gsd.hoomd.open(path, "w"):
        pass
    with pytest.raises(UserError, match="there is no frame -1; allowed: none"):
        read(path)


def test_a_netcdf_file_without_beads(tmp_path):
    write_netcdf(tmp_path / "other.nc", {"x": (("y",), np.zeros(3), "1", "nothing")}, {})
    with pytest.raises(UserError, match="holds no last configuration"):
        read(tmp_path / "other.nc")
