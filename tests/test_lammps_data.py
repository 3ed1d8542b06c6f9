"""Data files of LAMMPS: as other programs write them, there and back, and what is refused."""

import numpy as np
import pytest

from dpd.errors import UserError
from dpd.particles.formats import read, write
from tests.test_particles import assert_same

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


@pytest.mark.parametrize("columns, style, said", [
    ("1 0.0 0.5 0.5 0.5", "", "6 columns .* do not fit to the style 'atomic'"),
    ("1 0.5 0.5 0.5", "# charge", "5 columns .* do not fit to the style 'charge'"),
    ("1 0.5 0.5 0.5", "# hybrid", "style 'hybrid'; write the right one .*'Atoms # full'"),
])  # fmt: skip
def test_no_style_is_guessed(tmp_path, columns, style, said):
    with pytest.raises(UserError, match=rf"small\.data: .*{said}"):
        read_text(tmp_path, atoms(columns, style))


@pytest.mark.parametrize("columns, style, lost", [
    ("1 0.5 0.5 0.5", "", None),
    ("1 0.0 0.5 0.5 0.5 0 0 0", "# charge", None),
    ("1 1.1 0.5 0.5 0.5", "# dpd", "theta of"),
    ("1 1 0.5 0.5 0.5 0.5", "# full", "charge of"),
])  # fmt: skip
def test_columns_of_styles(tmp_path, columns, style, lost):
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
    "no right angle": ("0.5 4.5 ylo yhi", "5 1 0 avec", "avec, bvec and cvec .*not along x, y"),
    "fewer atoms": ("3 atoms", "4 atoms", "section Atoms has 3 lines.*header says 4"),
    "no box": ("-1.0 3.0 xlo xhi\n", "", "there is no line 'xlo xhi'"),
    "tilted": ("-2.2e-14 0.0", "0.5 1", "tilt factors 0.125, 0.25, 0; allowed: one"),
    "thin": ("-2.0 2.0 zlo", "-2.0 -0.5 zlo", "1.5 thick along z"),
    "no bonds": ("Bonds\n\n1 W1-C 3 1\n", "", "section Bonds has 0 lines, .* says 1"),
    "short line": ("2.5 4.25 1 ", "2.5 4.25 ", "section Atoms: .*with 8 columns"),
    "text": ("4.25", "4.2.5", "section Atoms: could not convert string.*4.2.5"),
    "not a number": ("4.25", "nan", "atom 1 has a position that is not a finite number"),
    "fraction": ("3 1 C-3", "3.5 1 C-3", "has 3.5 where a whole number"),
    "twice": ("3 1 C-3", "1 1 C-3", "atom 1 is there twice"),
    "type": ("3 1 C-3", "3 1 3", "atom 3 is of a kind that is not one of the 2"),
    "mass": ("C-3 1\n", "", "section Masses has 1 lines, and the header says 2"),
    "bond to nobody": ("W1-C 3 1", "W1-C 3 8", "section Bonds: there is no atom 8"),
    "velocity of nobody": ("1 4 5", "13 4 5", "section Velocities: there is no atom 13"),
    "velocity twice": ("1 4 5", "2 4 5", "atom 1 has a velocity that is not a finite number"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_refused(tmp_path, case):
    """One sentence with the file, the place and what to do."""
    old, new, said = WRONG[case]
    assert WRITE_DATA.count(old) == 1
    with pytest.raises(UserError, match=rf"small\.data: .*{said}") as caught:
        read_text(tmp_path, WRITE_DATA.replace(old, new))
    assert len(str(caught.value)) < 400
