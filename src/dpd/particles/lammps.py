"""Data files of LAMMPS, which it writes by ``write_data`` and reads by ``read_data``.

https://docs.lammps.org/read_data.html. What this program has no use for is left out on reading:
coefficients of potentials without a word, as a scene has its own, all else with one.
"""

from __future__ import annotations

import re
from itertools import product
from string import ascii_uppercase
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from dpd.errors import UserError, reason, shown
from dpd.particles.particles import (
    FACTORS,
    FLAT,
    Particles,
    box_of_file,
    checked,
    in_tilted_box,
    molecules_of,
    tilt_factors,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

# Columns of a line of Atoms by style; image flags may stand behind them.
STYLES = {
    "charge": "id type charge x y z",
    "full": "id molecule type charge x y z",
    "molecular": "id molecule type x y z",
    "bond": "id molecule type x y z",
    "angle": "id molecule type x y z",
    "atomic": "id type x y z",
    "dpd": "id type theta x y z",
    "mdpd": "id type rho x y z",
    "edpd": "id type temperature capacity x y z",
    "sphere": "id type diameter density x y z",
    "ellipsoid": "id type flag density x y z",
    "dipole": "id type charge x y z mu_x mu_y mu_z",
}
FLAGS = "ix", "iy", "iz"
WHOLE = ["id", "molecule", "type", "flag", *FLAGS]  # columns of whole numbers
USED = {"id", "molecule", "type", "x", "y", "z", *FLAGS}
TITLE = re.compile(r"atom_style (\S+)")  # where TopoTools, of VMD, has the style
STEP = re.compile(r"timestep = ([0-9]+)")  # in the title, where LAMMPS puts it
SECTION = re.compile(r"[A-Z][A-Za-z0-9]*( [A-Z][A-Za-z0-9]*)*")  # its name
EDGES = {"xlo xhi": 2, "ylo yhi": 2, "zlo zhi": 2, "xy xz yz": 3}  # and how many numbers each has
KNOWN = {"Atoms", "Velocities", "Masses", "Bonds", "Angles"}  # sections that are not left out
LARGEST = 1e15  # of a whole number, which double precision holds exactly
THIN = 2.0  # r_c: no box of three dimensions may be thinner
HALF = 0.5  # r_c: half the thickness with which a box of two dimensions is written
MOST_TYPES = 256
LETTERS = [*ascii_uppercase, *map("".join, product(ascii_uppercase, repeat=2))]  # A, B ... AA, AB


class Section(NamedTuple):
    line: int  # number of the line with its name
    comment: str  # behind the name
    lines: list[str]


class Data(NamedTuple):
    """A file taken apart."""

    path: Path
    title: str
    header: dict[str, list[float]]  # by what stands behind the numbers: xlo xhi, bond types ...
    sections: dict[str, Section]

    def refuse(self, problem: str) -> NoReturn:
        raise UserError(f"{self.path}: {problem}")

    def count(self, name: str) -> int:
        """A count of the header; 0 if it is not there."""
        number = self.header.get(name, [0.0])[0]
        if number % 1 or not 0 <= number <= LARGEST:
            self.refuse(f"the header says {number:.16g} {name}; allowed: a whole number")
        return int(number)

    def labels(self, kind: str) -> dict[str, int]:
        """Numbers of types by their labels; ``kind`` is ``Atom``, ``Bond`` ..."""
        found, types = {}, self.count(f"{kind.lower()} types")
        for line in self.sections.get(f"{kind} Type Labels", Section(0, "", [])).lines:
            number, *label = line.partition("#")[0].split()
            if len(label) != 1 or not number.isdecimal() or not 1 <= int(number[:9]) <= types:
                self.refuse(f"{shown(line)} is not a type, from 1 to {types}, and a label")
            found[label[0]] = int(number)
        return found

    def table(
        self, name: str, count: int, columns: Sequence[str], labels: Mapping[str, int]
    ) -> np.ndarray:
        """(count, columns) numbers of a section, labels as the numbers of their types."""
        section = self.sections[name]
        where = f"line {section.line}: section {name}"
        if len(section.lines) != count or not count:
            self.refuse(
                f"{where} has {len(section.lines)} lines, and the header says {count or 'more'}; "
                "the file is cut off or damaged, write it again"
            )
        convert = (lambda word: float(labels.get(word, word))) if labels else None
        try:
            rows = np.loadtxt(section.lines, ndmin=2, converters=convert)
        except ValueError as problem:
            said = shown(str(problem).partition(";")[0], str).rstrip(".")
            self.refuse(f"{where}: {said} of the section; mend the line")
        if rows.shape[1] < len(columns):
            self.refuse(f"{where} has {rows.shape[1]} columns; needed are {len(columns)}")
        rows = rows[:, : len(columns)]  # behind velocities of spheres stand those of rotation
        whole = np.isin(columns, WHOLE)
        with np.errstate(invalid="ignore"):
            bad = ~np.isfinite(rows) | (whole & ((rows % 1 != 0) | (abs(rows) > LARGEST)))
        for row, column in np.argwhere(bad)[:1]:
            kind = "whole number" if whole[column] else "finite number"
            found = f"{shown(section.lines[row])} has {rows[row, column]:.16g}"
            self.refuse(f"{where}: {found} where a {kind} is needed; mend the line")
        return rows


def read_data(path: Path) -> Particles:
    """Read a data file.

    It is of two dimensions if its box is too thin along z for three. Beads outside of the box are
    wrapped into it, and counted in their images. Units are taken to be ``lj``, with lengths in r_c
    and energies in kT. Refused is what no simulation can begin with.
    """
    data = _taken_apart(path)
    atoms, types, labels = data.count("atoms"), data.count("atom types"), data.labels("Atom")
    if not 1 <= types <= MOST_TYPES:
        data.refuse(f"the header says {types} atom types; allowed: 1 to {MOST_TYPES}")
    columns = _columns(data)
    rows = data.table("Atoms", atoms, columns, labels)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    identities, kinds = rows[:, [0, columns.index("type")]].T.astype(np.int64)
    if (twice := identities[1:] == identities[:-1]).any():
        data.refuse(f"atom {identities[np.argmax(twice)]} is there twice; number atoms differently")
    if (bad := (kinds < 1) | (kinds > types)).any():
        atom, kind = identities[np.argmax(bad)], kinds[np.argmax(bad)]
        data.refuse(f"atom {atom} is of type {kind}; the header allows 1 to {types}")
    names, left_out = _names(data, labels)
    left_out += _left_out(data, columns, rows)
    corner, edges, factors = _box(data)
    dimension = 2 + (edges[2] >= THIN)
    first = columns.index("x")
    position = rows[:, first : first + 3] - corner
    if dimension == 2 and np.ptp(position[:, 2]) > FLAT:
        data.refuse(
            f"the box is {edges[2]:g} thick along z, as for two dimensions, and beads are at "
            f"different z; give beads one z, or the box three edges of at least {THIN:g}"
        )
    velocity = _velocities(data, identities)
    if velocity is not None:
        if dimension == 2 and velocity[:, 2].any():
            left_out.append("velocities along z are left out: there are two dimensions")
        velocity = velocity[:, :dimension].T
    image = rows[:, -3:] if columns[-1] == FLAGS[-1] else np.zeros((atoms, 3))
    return checked(
        Particles(
            box=box_of_file(edges[:dimension], factors, path),
            position=position[:, :dimension].T,
            image=image[:, :dimension].T,
            velocity=velocity,
            species=kinds - 1,
            names=names,
            bonds=_members(data, identities, "Bond", 2),
            angles=_members(data, identities, "Angle", 3),
            step=int(found[1][:19]) if (found := STEP.search(data.title)) else 0,
            left_out=tuple(left_out),
            masses=_masses(data, labels),
            identity=identities,
        ),
        path,
        periodic=True,
    )


def _taken_apart(path):
    try:
        text = path.read_bytes().decode(errors="replace")
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    title, *lines = text.splitlines() or [""]
    data = Data(path, title, {}, {})
    section = None
    for number, line in enumerate(lines, start=2):
        before, _, comment = line.partition("#")
        words = before.split()
        if SECTION.fullmatch(name := " ".join(words)):
            if name in data.sections:
                data.refuse(f"line {number}: {name!r} is there as a section before; keep one")
            section = data.sections[name] = Section(number, comment.strip(), [])
        elif words and section is not None:
            section.lines.append(line)
        elif words:
            _read_header(data, number, words)
    if "atoms" not in data.header or "Atoms" not in data.sections:
        what = "section Atoms" if "atoms" in data.header else "line '<number> atoms' in the header"
        data.refuse(
            f"not a whole data file of LAMMPS: there is no {what}; write it again with write_data"
        )
    if not text.endswith("\n"):
        data.refuse(
            "the last line has no end, so the file may be cut off there; write it again, or end "
            "the line if it is whole"
        )
    return data


def _read_header(data, number, words):
    size = next((k for k, word in enumerate(words) if word[0].isalpha()), len(words))
    name = " ".join(words[size:])
    try:
        data.header[name] = [float(word) for word in words[:size]]
        good = size == EDGES.get(name, 1) and np.isfinite(data.header[name]).all()
    except ValueError:
        good = False
    if not good:
        data.refuse(
            f"line {number}: {shown(' '.join(words))} is neither a section nor a line that a "
            "header has, such as '3 atoms', '0 5 xlo xhi' or '0 0 0 xy xz yz'; mend or remove it"
        )


def _columns(data):
    """Names of the columns of Atoms: of the style that is named, or of the only one that fits."""
    section = data.sections["Atoms"]
    words = section.lines[0].partition("#")[0].split() if section.lines else []
    named = (section.comment.lower().split() or [""])[0]
    if named not in STYLES and (said := TITLE.search(data.title)):
        named = said[1]
    styles = [named] if named in STYLES else list(STYLES)
    plain = [tuple(STYLES[style].split()) for style in styles]
    with_flags = [columns + FLAGS for columns in plain]
    fits = [names for names in dict.fromkeys(plain + with_flags) if len(names) == len(words)]
    if named not in STYLES:
        fits = [
            columns for columns in fits
            if not any(name in WHOLE and "." in word for name, word in zip(columns, words))
            and ("molecule" in columns or not data.count("bonds"))
        ]  # fmt: skip
    if len(fits) != 1:
        data.refuse(
            f"line {section.line}: the {len(words)} columns of section Atoms fit to "
            f"{'several styles' if fits else 'no style that is known'}; write the right one behind "
            f"it, as in 'Atoms # {styles[0]}'; allowed: {', '.join(STYLES)}"
        )
    return fits[0]


def _names(data, labels):
    """Labels of types, or comments behind masses, or letters; and a sentence on those."""
    names = {number: label for label, number in labels.items()}
    if not names and "Masses" in data.sections:
        for line in data.sections["Masses"].lines:
            before, _, comment = line.partition("#")
            if comment.strip() and before.split()[0].isdecimal():
                names[int(before.split()[0][:9])] = comment.split()[0]
    numbers = range(1, data.count("atom types") + 1)
    found = tuple(names.get(number, LETTERS[number - 1]) for number in numbers)
    without = ", ".join(LETTERS[number - 1] for number in numbers if number not in names)
    return found, [f"types have no names: they are called {without}"] if without else []


def _masses(data, labels):
    """Masses by type; None if all are 1 or none are given."""
    if "Masses" not in data.sections:
        return None
    masses = np.ones(data.count("atom types"))
    rows = data.table("Masses", len(data.sections["Masses"].lines), ("type", "mass"), labels)
    kinds = rows[:, 0].astype(np.int64)
    if ((kinds < 1) | (kinds > len(masses))).any():
        data.refuse(f"section Masses: a type is not from 1 to {len(masses)}; mend it")
    masses[kinds - 1] = rows[:, 1]
    return None if (masses == 1).all() else masses


def _box(data):
    """Lower corner, edges, and tilt factors."""
    for name in ("xlo xhi", "ylo yhi"):
        if name not in data.header:
            data.refuse(f"the header has no line {name!r}; write the whole box")
    low, high = np.array([data.header.get(f"{k}lo {k}hi", (-0.5, 0.5)) for k in "xyz"]).T
    edges, tilts = high - low, data.header.get("xy xz yz", (0, 0, 0))
    factors = [
        tilt / edges[across] if edges[across] else 0.0
        for tilt, (_, across) in zip(tilts, FACTORS)
    ]  # fmt: skip
    return low, edges, factors


def _places(identities, wanted):
    """Places of atoms by their identities in the file; -1 for those that are not there."""
    places = np.searchsorted(identities, wanted).clip(max=len(identities) - 1)
    return np.where(identities[places] == wanted, places, -1)


def _velocities(data, identities):
    """(n, 3) array in the order of identities, or None."""
    if "Velocities" not in data.sections:
        return None
    rows = data.table("Velocities", len(identities), ["id", *"xyz"], {})
    places = _places(identities, rows[:, 0])
    if not np.array_equal(np.sort(places), np.arange(len(identities))):
        data.refuse("section Velocities does not have each of the atoms once; write it again")
    return rows[np.argsort(places), 1:]


def _members(data, identities, kind, size):
    """(n, size) array of the places of the atoms of bonds or angles, in the order of identities."""
    section, count = f"{kind}s", data.count(f"{kind.lower()}s")
    if section not in data.sections:
        if count:
            data.refuse(f"the header says {count} {section}, and there is no such section")
        return np.zeros((0, size), np.int64)
    columns = ["id", "type", *["id"] * size]
    rows = data.table(section, count, columns, data.labels(kind))
    places = _places(identities, rows[:, 2:])
    if (bad := (places < 0).any(axis=1)).any():
        line = data.sections[section].lines[int(np.argmax(bad))]
        data.refuse(f"section {section}: {shown(line)} ties an atom that is not there; mend it")
    return places


def _left_out(data: Data, columns: tuple[str, ...], rows: np.ndarray) -> Iterable[str]:
    """What a file has that is lost, a sentence each."""
    lost = [name for k, name in enumerate(columns) if name not in USED and rows[:, k].any()]
    if lost:
        yield f"{', '.join(lost)} of the atoms left out: beads have none here"
    for name in ("bond", "angle"):
        if (types := data.count(f"{name} types")) > 1:
            yield f"{name}s of {types} types become {name}s of one type"
    for name in data.sections:
        if name not in KNOWN and not name.endswith((" Coeffs", " Type Labels")):
            yield f"section {name} is left out: it says nothing that is known here"


def as_data(particles: Particles) -> str:
    """A configuration as the text of a data file, of atom style ``angle``, ``bond`` or ``atomic``.

    All numbers have as many digits as it takes to read the same ones again. In two dimensions
    the box is 1 thick along z. Names of species stand as comments behind the masses. A box that
    shear has tilted is written as such; velocities are those about the flow.
    """
    bonds, angles, box = particles.bonds, particles.angles, particles.box
    style = "angle" if len(angles) else "bond" if len(bonds) else "atomic"
    factors, masses = tilt_factors(box), particles.masses_by_name()
    position, image = (_three(each) for each in in_tilted_box(particles))
    kinds = [particles.species.astype(int) + 1]
    if style != "atomic":
        kinds.insert(0, molecules_of(particles) + 1)
    counts = {"atoms": particles.beads, "atom types": len(particles.names)}
    for name, members in (("bond", bonds), ("angle", angles)):
        counts |= {f"{name}s": len(members), f"{name} types": 1} if len(members) else {}
    ends = [f"0 {float(edge)!r}" for edge in box] + [f"{-HALF} {HALF}"]
    header = [f"{number} {name}" for name, number in counts.items()]
    header += [f"{end} {axis}lo {axis}hi" for end, axis in zip(ends, "xyz")]
    if any(factors):
        tilts = [float(f * box[across]) if f else 0.0 for f, (_, across) in zip(factors, FACTORS)]
        header.append(" ".join(map(repr, tilts)) + " xy xz yz")
    sections = {
        "Masses": [
            f"{k} {masses.get(name, 1)} # {name}" for k, name in enumerate(particles.names, 1)
        ],
        f"Atoms # {style}": _lines(*kinds, *position, *image),
    }
    if particles.velocity is not None:
        sections["Velocities"] = _lines(*_three(particles.velocity))
    for name, members in (("Bonds", bonds), ("Angles", angles)):
        if len(members):
            sections[name] = _lines(np.ones(len(members), int), *members.astype(int).T + 1)
    title = f"LAMMPS data file, written by dpd-papers, timestep = {particles.step}, units = lj"
    parts = ["\n".join(header), *("\n\n".join((k, "\n".join(v))) for k, v in sections.items())]
    return "\n\n".join([title, *parts]) + "\n"


def _three(array):
    """A (dimension, n) array with three rows."""
    return np.pad(array, ((0, 3 - len(array)), (0, 0)))


def _lines(*columns):
    """Lines of a section: a number from 1 on, and columns."""
    rows = zip(*(column.tolist() for column in columns))
    return [f"{number} {' '.join(map(repr, row))}" for number, row in enumerate(rows, 1)]
