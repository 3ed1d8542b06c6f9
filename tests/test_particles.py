"""Configurations of beads in files: there and back, and what is wrong with a file."""

import os
import random
import re

import gsd.hoomd
import MDAnalysis
import numpy as np
import pytest

from dpd.errors import UserError
from dpd.particles import read, write
from dpd.particles.particles import Particles
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.files import write_start
from dpd.start.common.make import make_start
from tests.conftest import SCENE

BOXES = {2: (5.0, 6.3), 3: (5.0, 6.3, 7.1)}
KINDS = ("gsd", "data", "nc")


def melt(dimension, velocities=True, bonds=True):
    """Sixty beads of two species, in chains of twenty."""
    rng, n, box = np.random.default_rng(dimension), 60, BOXES[dimension]
    first = np.delete(np.arange(n - 1), [19, 39])
    return Particles(
        box=box,
        position=rng.random((dimension, n)) * np.array(box)[:, None],
        image=rng.integers(-3, 4, (dimension, n)).astype(np.int32),
        velocity=rng.normal(size=(dimension, n)) if velocities else None,
        species=rng.integers(0, 2, n).astype(np.uint8),
        names=("A", "Solvent"),
        bonds=np.stack([first, first + 1], axis=1).astype(np.uint32)[: 57 * bonds],
        angles=np.array([[0, 1, 2], [5, 4, 3]], np.uint32)[: 2 * bonds],
        step=1200,
    )


def assert_same(found, expected, position=0.0):
    """The same beads; positions as near as said, in r_c."""
    assert (found.box, found.names, found.step) == (expected.box, expected.names, expected.step)
    np.testing.assert_allclose(found.position, expected.position, rtol=0, atol=position)
    for name in ("image", "species", "bonds", "angles"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), err_msg=name)
        assert getattr(found, name).dtype == getattr(expected, name).dtype
    if expected.velocity is None:
        assert found.velocity is None
    else:
        np.testing.assert_array_equal(found.velocity, expected.velocity)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("whole", [True, False])
def test_there_and_back(tmp_path, dimension, kind, whole):
    """With all that a configuration has, and with as little as it can have.

    A GSD file counts from the middle of the box, which rounds once, and has velocities of 0.
    """
    expected = melt(dimension, velocities=whole, bonds=whole)
    lost = write(expected, tmp_path / f"melt.{kind}")
    said = {"gsd": ["there are no velocities"] * (not whole), "data": ["names of the species"]}
    assert [sentence[:20] for sentence in lost] == [each[:20] for each in said.get(kind, [])]
    rounding = 1e-15 * max(expected.box) if kind == "gsd" else 0.0
    assert_same(read(tmp_path / f"melt.{kind}"), expected, rounding)
    assert os.listdir(tmp_path) == [f"melt.{kind}"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_other_programs_read_what_is_written(tmp_path, dimension):
    """MDAnalysis reads the data file and the GSD file; the latter is in the middle of its box."""
    expected = melt(dimension)
    middle = np.zeros(3)
    middle[:dimension] = np.array(expected.box) / 2
    for name, shift in (("melt.data", 0), ("melt.gsd", middle)):
        write(expected, tmp_path / name)
        found = MDAnalysis.Universe(tmp_path / name)
        place = found.atoms.positions + shift
        np.testing.assert_allclose(place[:, :dimension].T, expected.position, atol=1e-6)
        assert not place[:, dimension:].any()
        np.testing.assert_allclose(found.dimensions[:dimension], expected.box, rtol=1e-6)
        assert {tuple(sorted(bond)) for bond in found.bonds.indices.tolist()} == {
            tuple(bond) for bond in expected.bonds.tolist()
        }
    assert found.atoms.types.tolist() == [expected.names[kind] for kind in expected.species]


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_file_of_another_program(tmp_path, dimension):
    """Single precision, a bead on the very edge, several frames, and things that are left out."""
    expected = melt(dimension)
    half = np.array(expected.box)[:, None] / 2
    with gsd.hoomd.open(tmp_path / "other.gsd", "w") as file:
        for shift in range(3):
            frame = gsd.hoomd.Frame()
            frame.configuration.step = 10 * shift
            frame.configuration.box = [*expected.box, *[0] * (6 - dimension)]
            frame.particles.N, frame.particles.types = expected.beads, ["B", "A"]
            frame.particles.typeid = expected.species
            frame.particles.charge = np.ones(expected.beads)
            place = (expected.position + shift) % (2 * half) - half
            place[:, 0] = half[:, 0]  # belongs to the other face
            frame.particles.position = np.zeros((expected.beads, 3))
            frame.particles.position[:, :dimension] = place.T
            frame.dihedrals.N, frame.dihedrals.group = 1, [[0, 1, 2, 3]]
            file.append(frame)
    for number, shift in ((0, 0), (1, 1), (-1, 2), (-3, 0)):
        found = read(tmp_path / "other.gsd", number)
        apart = found.position[:, 1:] - (expected.position + shift)[:, 1:]
        apart -= 2 * half * np.rint(apart / (2 * half))
        np.testing.assert_allclose(apart, 0, atol=1e-6)
        assert found.position[0, 0] == 0 and found.image[0, 0] == 1  # 5 is exact, 6.3 is not
        assert (found.step, found.velocity, found.names) == (10 * shift, None, ("B", "A"))
        assert found.box == expected.box  # not 6.300000191
        assert ["charge" in said or "dihedrals" in said for said in found.left_out] == [True] * 2
    for number in (3, -4):
        with pytest.raises(UserError, match=r"there is no frame -?\d; allowed: 0 to 2, or -1"):
            read(tmp_path / "other.gsd", number)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a file of each kind; the checkpoint is that of a run that was stopped."""
    folder = tmp_path_factory.mktemp("made")
    for kind in KINDS:
        write(melt(3), folder / f"melt.{kind}")
    watched = [{"thermo": {"every": 50}}, {"rdf": {"every": 50, "range": 2}}, "configuration"]
    scene = Scene(SCENE | {"observe": watched})
    simulate(scene, folder / "run.nc", make_start(scene))
    write_start(scene, folder / "start.nc")
    with pytest.raises(UserError, match="stopped"):
        simulate(
            scene, folder / "stopped.nc", make_start(scene), Options(every_seconds=60),
            stopping=lambda: 15,
        )  # fmt: skip
    (folder / "stopped.checkpoint").rename(folder / "run.checkpoint")
    return folder


def test_files_of_this_program(made):
    """Beads of a start are those that a run begins with, and a checkpoint has the same."""
    begun, start, last = make_start(Scene(SCENE)), read(made / "start.nc"), read(made / "run.nc")
    np.testing.assert_array_equal(start.position, begun.position)
    np.testing.assert_array_equal(start.velocity, begun.velocity)
    kept = read(made / "run.checkpoint")
    for found in (start, last, kept):
        assert (found.box, found.names, found.bonds.shape) == ((4, 4, 4), ("A",), (0, 2))
    assert (start.step, last.step, last.velocity) == (0, 220, None)
    assert 0 < kept.step < 220 and kept.velocity is not None
    assert np.abs(kept.position - start.position).max() > 0.01


def test_the_command_converts(folder, dpd, capsys):
    """Round through all formats; what is lost is said; a bad source writes nothing."""
    write(melt(3), "melt.nc")
    for source, target in (("melt.nc", "a.gsd"), ("a.gsd", "b.data"), ("b.data", "c.nc")):
        assert dpd("convert", source, target) == (0, "")
    assert_same(read("c.nc"), melt(3), 1e-14)
    for source, target, said in (
        ("melt.nc", "x.xyz", "suffix '.xyz'.*allowed: .gsd, .data, .lmp, .nc"),
        ("scene.yaml", "x.gsd", "suffix '.yaml'.*allowed: .*checkpoint"),
        ("none.gsd", "x.gsd", "there is no such file"),
        ("melt.nc", "melt.nc", "would take the place of what is read"),
        ("melt.nc --frame 2", "x.gsd", "there is no frame 2: the file holds one"),
    ):
        code, errors = dpd("convert", *source.split(), target)
        assert code == 1 and "Traceback" not in errors
        assert re.search(said, errors), errors
    assert not list(folder.glob("x.*"))


@pytest.mark.parametrize("name", ["melt.gsd", "melt.data", "melt.nc", "run.nc", "run.checkpoint"])
def test_files_that_are_damaged(made, tmp_path, name):
    """Cut off, or some bytes are others: it is read, or refused in a sentence that names the file.

    The part of the GSD library that is written in C ends the process for some of these.
    """
    whole = (made / name).read_bytes()
    path = tmp_path / name
    for size in (0, 7, 256, len(whole) // 2, len(whole) - 40):
        path.write_bytes(whole[:size])
        with pytest.raises(UserError, match=name):
            read(path)
    for seed in range(40):
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
            assert_same(found.checked(path), found)


def test_a_gsd_file_that_is_wrong(tmp_path):
    """Each is a whole GSD file."""
    path = tmp_path / "wrong.gsd"
    cases = (
        ("frame.configuration.box = [4, 4, 4, 0.1, 0.2, 0]", "tilt factors 0.1, 0.2, 0; allowed"),
        ("frame.configuration.box = [4, 0, 4, 0, 0, 0]", "an edge that is not a positive"),
        ("frame.particles.position[3, 1] = np.nan", "bead 3 has a position"),
        ("frame.particles.position[5, 2] = 4", "bead 5 is outside of the box of 4 x 4 x 4"),
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


# Data files of LAMMPS: as other programs write them, there and back, and what is refused.


UPRIGHT = "0 5 xlo xhi\n0 5 ylo yhi\n0 5 zlo zhi\n"
# moltemplate: counts with two blanks, no flags, comments; unwrapped as packmol leaves it.
MOLTEMPLATE = """LAMMPS Description

     3  atoms
     2  bonds
     1  angles

     2  atom types
     1  bond types
     1  angle types

  -2.5 2.5 xlo xhi
  -2.5 2.5 ylo yhi
  -2.5 2.5 zlo zhi

Masses

1 1.0  # W1
2 2.0  # tail

Atoms  # full

1 1 2 0.0 1.7 0.0 0.0
2 1 2 0.0 2.4 0.0 0.0
3 1 2 0.0 3.1 0.0 0.0

Bonds

1 1 1 2
2 1 2 3

Angles

1 1 1 2 3
"""
# write_data of LAMMPS: labels, coefficients with styles behind them, atoms in any order.
WRITE_DATA = """LAMMPS data file via write_data, version 2 Aug 2023, timestep = 70, units = lj

3 atoms
2 atom types
1 bonds
1 bond types

-1.0 3.0 xlo xhi
0.5 4.5 ylo yhi
-2.0 2.0 zlo zhi
-2.2e-14 0.0 0.0 xy xz yz

Atom Type Labels

1 W1
2 C-3

Bond Type Labels

1 W1-C

Masses

W1 1
C-3 1

Pair Coeffs # dpd

1 25 4.5
2 25 4.5

Bond Coeffs # harmonic

W1-C 2 0

Atoms # bond

3 1 C-3 -0.5 1.5 0 1 1 0
1 1 W1 2.5 4.25 1 0 0 -2
2 0 W1 0.0 0.5 -2 0 0 0

Velocities

3 1 2 3
1 4 5 6
2 7 8 9

Bonds

1 W1-C 3 1
"""
# What they are, in turn: box, names, positions of all beads, images of the last one.
PUBLIC = {
    "moltemplate": (
        MOLTEMPLATE, (5, 5, 5), ("W1", "tail"),
        [[4.2, 2.5, 2.5], [4.9, 2.5, 2.5], [0.6, 2.5, 2.5]], [1, 0, 0], "1 beads outside",
    ),
    "write_data": (
        WRITE_DATA, (4, 4, 4), ("W1", "C-3"), [[3.5, 3.75, 3], [1, 0, 0], [0.5, 1, 2]], [1, 1, 0],
        None,
    ),
}  # fmt: skip


def read_text(folder, text, name="small.data"):
    """What is read of a file with this text."""
    (folder / name).write_text(text)
    return read(folder / name)


@pytest.mark.parametrize("program", PUBLIC)
def test_files_of_other_programs(tmp_path, program):
    """Beads outside are put in and keep their place by their images, so molecules stay whole."""
    text, box, names, position, image, said = PUBLIC[program]
    found = read_text(tmp_path, text)
    assert (found.box, found.names) == (box, names)
    np.testing.assert_allclose(found.position.T, position, atol=1e-12)
    assert found.image[:, -1].tolist() == image
    assert said is None or any(said in sentence for sentence in found.left_out), found.left_out
    assert found.left_out or said is None
    if program == "write_data":
        assert found.step == 70 and found.bonds.tolist() == [[2, 0]]
        np.testing.assert_array_equal(found.velocity.T, [[4, 5, 6], [7, 8, 9], [1, 2, 3]])
    if program == "moltemplate":
        assert found.masses.tolist() == [1, 2] and found.angles.tolist() == [[0, 1, 2]]
        unwrapped = found.position + found.image * np.array(box)[:, None]
        one, other = unwrapped[:, found.bonds.T].swapaxes(0, 1)
        np.testing.assert_allclose(np.linalg.norm(one - other, axis=0), 0.7)
    assert read_text(tmp_path, text.replace("\n", "\r\n"), "data.small").names == names
    write(found, tmp_path / "data.again")
    again = read(tmp_path / "data.again")
    assert_same(again, found, 1e-14)
    assert again.masses_by_name() == found.masses_by_name()


def atoms(columns, style=""):
    """Text of a file with two rows, each begun by the number of its atom."""
    head = f"small\n\n2 atoms\n2 atom types\n{UPRIGHT}\nAtoms {style}\n\n"
    return f"{head}1 {columns}\n2 {columns}\n"


@pytest.mark.parametrize("columns, style, lost", [
    ("1 0.5 0.5 0.5", "", None),
    ("1 0.0 0.5 0.5 0.5 0 0 0", "# charge", None),
    ("1 1.1 0.5 0.5 0.5", "# dpd", "theta of"),
    ("1 1 0.5 0.5 0.5 0.5", "# full", "charge of"),
    ("1 0.0 0.5 0.5 0.5", "", UserError("6 columns .* do not fit to the style 'atomic'")),
    ("1 0.5 0.5 0.5", "# hybrid", UserError("'hybrid'; write the right one .*'Atoms # full'")),
])  # fmt: skip
def test_columns_of_styles(tmp_path, columns, style, lost):
    """No style is guessed."""
    if isinstance(lost, UserError):
        with pytest.raises(UserError, match=rf"small\.data: .*{lost}"):
            read_text(tmp_path, atoms(columns, style))
        return
    found = read_text(tmp_path, atoms(columns, style))
    assert found.species.tolist() == [0, 0]
    np.testing.assert_array_equal(found.position, 0.5)
    said = [sentence for sentence in found.left_out if "of the atoms left out" in sentence]
    assert len(said) == bool(lost) and (not lost or lost in said[0])


def test_a_box_by_its_vectors(tmp_path):
    text = atoms("1 0.5 1.5 2.5", "# atomic")
    edges = "5 0 0 avec\n0 6 0 bvec\n0 0 7 cvec\n-1 0 0 abc origin\n"
    found = read_text(tmp_path, text.replace(UPRIGHT, edges))
    assert found.box == (5, 6, 7) and found.position[:, 0].tolist() == [1.5, 1.5, 2.5]


def test_a_thin_box_is_two_dimensions(tmp_path):
    text = atoms("1 0.5 0.5 0.0", "# atomic") + "\nVelocities\n\n2 4 5 6\n1 1 2 3\n"
    assert read_text(tmp_path, text).box == (5, 5, 5)
    found = read_text(tmp_path, text.replace("0 5 zlo", "-0.1 0.1 zlo"))
    assert found.box == (5, 5) and found.velocity.tolist() == [[1, 4], [2, 5]]
    assert any("velocities along z are left out" in said for said in found.left_out)


# What is replaced by what in the file of write_data, and what is said.
WRONG = {
    "no atoms": ("3 atoms\n", "", "there is no line 'atoms' in the header"),
    "header": ("3 atoms", "3 particles", "line 3: '3 particles' is not known in a header"),
    "two boxes": (
        "0.5 4.5 ylo",
        "5 0 0 avec\n0 5 0 bvec\n0 0 5 cvec\n0.5 4.5 ylo",
        "avec, and one by xlo xhi",
    ),
    "no right angle": ("0.5 4.5 ylo yhi", "5 1 0 avec", "avec, bvec and cvec .*not along x, y"),
    "tilted": ("-2.2e-14 0.0", "0.5 1", "tilt factors 0.125, 0.25, 0; allowed: one"),
    "thin": ("-2.0 2.0 zlo", "-2.0 -0.5 zlo", "1.5 thick along z"),
    "no bonds": ("Bonds\n\n1 W1-C 3 1\n", "", "section Bonds has 0 lines, .* says 1"),
    "short line": ("2.5 4.25 1 ", "2.5 4.25 ", "section Atoms: .*with 8 columns"),
    "not a number": ("4.25", "nan", "atom 1 has a position that is not a finite number"),
    "fraction": ("3 1 C-3", "3.5 1 C-3", "has 3.5 where a whole number"),
    "twice": ("3 1 C-3", "1 1 C-3", "atom 1 is there twice"),
    "type": ("3 1 C-3", "3 1 3", "atom 3 is of a kind that is not one of the 2"),
    "bond to nobody": ("W1-C 3 1", "W1-C 3 8", "section Bonds: there is no atom 8"),
    "velocity of nobody": ("1 4 5", "13 4 5", "section Velocities: there is no atom 13"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_refused(tmp_path, case):
    """One sentence with the file, the place and what to do."""
    old, new, said = WRONG[case]
    assert WRITE_DATA.count(old) == 1
    with pytest.raises(UserError, match=rf"small\.data: .*{said}") as caught:
        read_text(tmp_path, WRITE_DATA.replace(old, new))
    assert len(str(caught.value)) < 400
