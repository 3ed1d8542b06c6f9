"""Read configurations from data files of LAMMPS, which it writes by ``write_data``.

https://docs.lammps.org/read_data.html: a title, a header with counts and the box, and sections.
What this program has no use for, as coefficients of potentials, is skipped.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.errors import UserError, reason, shown
from dpd.particles.particles import Particles, checked

if TYPE_CHECKING:
    from pathlib import Path

# Columns of a line of Atoms before its coordinates, by style.
STYLES = {
    "atomic": ("id", "type"),
    "bond": ("id", "molecule", "type"),
    "angle": ("id", "molecule", "type"),
    "molecular": ("id", "molecule", "type"),
    "charge": ("id", "type", "charge"),
    "full": ("id", "molecule", "type", "charge"),
}
GUESSED = {5: "atomic", 6: "molecular", 7: "full"}  # by the number of columns, without images
COUNT = re.compile(r"(\d+)\s+(atoms|bonds|angles|dihedrals|impropers|(?:atom|bond|angle) types)")
EDGE = re.compile(r"(\S+)\s+(\S+)\s+([xyz])lo\s+\3hi")
TILT = re.compile(r"(\S+)\s+(\S+)\s+(\S+)\s+xy\s+xz\s+yz")
STEP = re.compile(r"timestep = (\d+)")  # in the title, where LAMMPS puts it
THIN = 2.0  # r_c: no box of three dimensions may be thinner
MOST_TYPES = 256


class Line(NamedTuple):
    """A line of the file: its number, its text before ``#``, and what stands behind."""

    number: int
    text: str
    comment: str


class Data(NamedTuple):
    """A file taken apart.

    Attributes
    ----------
    title : str
    counts : dict of str to int
        Of the header: atoms, bonds, atom types ...
    box : (3, 2) array
        Lower and upper ends along x, y and z.
    sections : dict of str to list of Line
        Bodies by name; the line with the name itself stands first.
    """

    title: str
    counts: dict[str, int]
    box: np.ndarray
    sections: dict[str, list[Line]]


def read_data(path: Path) -> Particles:
    """Read a data file.

    It is of two dimensions if all beads are at the same z. Units are taken to be ``lj``, with
    lengths in r_c and energies in kT.

    Raises
    ------
    UserError
        If the file cannot be read, or holds what no simulation can begin with.
    """
    data = _taken_apart(path)
    _check_header(path, data)
    atoms = _Table(path, data, "Atoms", data.counts["atoms"])
    style, has_images = _style(path, data, atoms)
    before = len(STYLES[style])
    labels, names = _names(path, data)
    rows = atoms.numbers(before + 3 + 3 * has_images, labels, STYLES[style].index("type"))
    order = np.argsort(rows[:, 0], kind="stable")
    rows = rows[order]
    identities = _whole(path, atoms, rows[:, 0], order)
    if (twice := identities[1:] == identities[:-1]).any():
        raise UserError(
            f"{path}: atom {identities[np.argmax(twice)]} is there twice; number atoms differently"
        )
    kinds = _whole(path, atoms, rows[:, STYLES[style].index("type")], order)
    _check_kinds(path, identities, kinds, len(names))
    place, image = rows[:, before : before + 3], np.zeros((len(rows), 3))
    if has_images:
        image = rows[:, before + 3 :]
        _whole(path, atoms, image, order)
    velocity = _velocities(path, data, identities)
    dimension = _dimension(path, data, place)
    low, high = data.box[:dimension].T
    return checked(
        Particles(
            box=tuple(high - low),
            position=(place[:, :dimension] - low).T,
            image=image[:, :dimension].T.astype(np.int64),
            velocity=None if velocity is None else velocity[:, :dimension].T,
            species=kinds - 1,
            names=names,
            bonds=_members(path, data, identities, "Bond", 2),
            angles=_members(path, data, identities, "Angle", 3),
            step=int(found[1]) if (found := STEP.search(data.title)) else 0,
            left_out=tuple(_left_out(data, style, rows)),
            masses=_masses(path, data, labels),
        ),
        path,
    )


def _taken_apart(path):
    """Header and sections of a file."""
    try:
        text = path.read_bytes().decode("utf-8", errors="replace")
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    title, _, _ = text.partition("\n")
    counts = {}
    box, sections = np.array([[-0.5, 0.5]] * 3), {}
    body = None
    for number, line in enumerate(text.split("\n")[1:], start=2):
        words, _, comment = line.partition("#")
        found = Line(number, words.strip(), comment.strip())
        if not found.text:
            continue
        if _is_name(found.text):
            name = " ".join(found.text.split())
            if name in sections:
                raise UserError(f"{path}: line {number}: a second section {name!r}; keep one")
            body = sections[name] = [found]
        elif body is not None:
            body.append(found)
        else:
            _read_header(path, found, counts, box)
    if "atoms" not in counts or "Atoms" not in sections:
        what = "line '<number> atoms' in the header" if "atoms" not in counts else "section Atoms"
        raise UserError(
            f"{path}: not a whole data file of LAMMPS: there is no {what}; write it again with "
            "write_data"
        )
    if not text.endswith("\n"):
        raise UserError(
            f"{path}: the last line has no end, so the file may be cut off there; write it again, "
            "or end the line if it is whole"
        )
    return Data(title, counts, box, sections)


def _check_header(path, data):
    """Refuse counts of nothing, or of more types than a byte can number."""
    atoms, types = data.counts["atoms"], data.counts.get("atom types", 0)
    if not atoms:
        raise UserError(f"{path}: the header says 0 atoms; at least one is needed")
    if not 1 <= types <= MOST_TYPES:
        raise UserError(f"{path}: the header says {types} atom types; allowed: 1 to {MOST_TYPES}")


def _is_name(text):
    """Whether a line is the name of a section: words that begin with capitals, no numbers."""
    return all(re.fullmatch(r"[A-Z][A-Za-z0-9]*", word) for word in text.split())


def _read_header(path, line, counts, box):
    """Take counts or an edge from a line; other lines say what is of no use here."""
    if count := COUNT.fullmatch(line.text):
        counts[count[2]] = int(count[1])
    elif edge := EDGE.fullmatch(line.text):
        try:
            box["xyz".index(edge[3])] = float(edge[1]), float(edge[2])
        except ValueError:
            raise UserError(
                f"{path}: line {line.number}: {shown(line.text)} is not two numbers and the names "
                "of the ends"
            ) from None
    elif (tilt := TILT.fullmatch(line.text)) and any(_number(part) != 0 for part in tilt.groups()):
        raise UserError(
            f"{path}: line {line.number}: the box is tilted; allowed: right angles, 0 0 0 xy xz yz"
        )


def _number(text):
    try:
        return float(text)
    except ValueError:
        return np.nan


class _Table:
    """A section whose lines are numbers, as many lines as the header says."""

    def __init__(self, path, data, name, count):
        self.path, self.name = path, name
        head, *self.lines = data.sections[name]
        self.comment = head.comment
        if len(self.lines) != count:
            raise UserError(
                f"{path}: line {head.number}: section {name} has {len(self.lines)} lines, and the "
                f"header says {count}; the file is cut off or damaged, write it again"
            )

    def columns(self):
        """Columns of the first line."""
        return len(self.lines[0].text.split()) if self.lines else 0

    def numbers(self, columns, labels=None, labelled=-1):
        """(lines, columns) array; names in column ``labelled`` become their numbers."""
        rows = np.empty((len(self.lines), columns))
        for row, line in zip(rows, self.lines):
            words = line.text.split()
            if len(words) != columns:
                self.refuse(line, f"has {len(words)} columns, and {columns} are expected")
            if labels and words[labelled] in labels:
                words[labelled] = labels[words[labelled]]
            try:
                row[:] = words
            except ValueError:
                self.refuse(line, "is not made of numbers")
        return rows

    def refuse(self, line, problem):
        raise UserError(
            f"{self.path}: line {line.number}, in section {self.name}: {shown(line.text)} {problem}"
            "; mend the line"
        )


def _whole(path, table, values, order):
    """Whole numbers, as whole numbers."""
    bad = ~np.isfinite(values) | (values != np.rint(values)) | (np.abs(values) > 2**53)
    if bad.any():
        row = int(np.argmax(bad.reshape(len(values), -1).any(axis=1)))
        table.refuse(table.lines[order[row]], "has a fraction where a whole number is needed")
    return values.astype(np.int64)


def _style(path, data, atoms):
    """Style of the atoms, and whether they have image flags."""
    columns = atoms.columns()
    if atoms.comment:
        style = atoms.comment.split()[0]
        if style not in STYLES:
            raise UserError(
                f"{path}: atom style {shown(style)} after 'Atoms #'; allowed: {', '.join(STYLES)}"
            )
        plain = len(STYLES[style]) + 3
        if columns not in (0, plain, plain + 3):
            raise UserError(
                f"{path}: line {atoms.lines[0].number}: {columns} columns in section Atoms; style "
                f"{style!r} has {plain}, or {plain + 3} with image flags"
            )
        return style, columns == plain + 3
    for plain, style in GUESSED.items():
        if columns in (plain, plain + 3):
            return style, columns == plain + 3
    raise UserError(
        f"{path}: section Atoms has {columns} columns, which no known style has; write the style "
        f"behind its name, as 'Atoms # molecular'; allowed: {', '.join(STYLES)}"
    )


def _names(path, data):
    """Numbers of types by label, if there are labels; and names of the species.

    They are the type labels, or what stands as a comment behind a mass, or letters.
    """
    count = data.counts.get("atom types", 0)
    names = {}
    for line in data.sections.get("Atom Type Labels", [])[1:]:
        words = line.text.split()
        if len(words) != 2 or not words[0].isdigit():
            raise UserError(
                f"{path}: line {line.number}: {shown(line.text)} is not a number and a label"
            )
        names[int(words[0])] = words[1]
    labels = {name: number for number, name in names.items()}
    if not names:
        for line in data.sections.get("Masses", [])[1:]:
            number = line.text.split()[0]
            if number.isdigit() and line.comment:
                names[int(number)] = line.comment.split()[0]
    return labels, tuple(names.get(number) or _letters(number) for number in range(1, count + 1))


def _masses(path, data, labels):
    """(types,) array of masses by type; None if all are 1 or none are given."""
    masses = np.ones(data.counts.get("atom types", 0))
    for line in data.sections.get("Masses", [])[1:]:
        words = line.text.split()
        number = labels.get(words[0], words[0])
        mass = _number(words[-1]) if len(words) == 2 else None
        if mass is None or not str(number).isdigit() or not 1 <= int(number) <= len(masses):
            raise UserError(
                f"{path}: line {line.number}: {shown(line.text)} is not a type and its mass"
            )
        masses[int(number) - 1] = mass
    return None if (masses == 1).all() else masses


def _letters(number):
    """A to Z for 1 to 26, then AA, AB ..."""
    text = ""
    while number > 0:
        number, digit = divmod(number - 1, 26)
        text = chr(ord("A") + digit) + text
    return text


def _check_kinds(path, identities, kinds, count):
    bad = (kinds < 1) | (kinds > count)
    if bad.any():
        raise UserError(
            f"{path}: atom {identities[np.argmax(bad)]} is of type {kinds[np.argmax(bad)]}; the "
            f"header allows 1 to {count}"
        )


def _places(identities, wanted):
    """Places of atoms by their identities in the file; -1 for those that are not there."""
    places = np.searchsorted(identities, wanted).clip(max=len(identities) - 1)
    return np.where(identities[places] == wanted, places, -1)


def _velocities(path, data, identities):
    """(n, 3) array in the order of identities, or None."""
    if "Velocities" not in data.sections:
        return None
    table = _Table(path, data, "Velocities", len(identities))
    rows = table.numbers(4)
    places = _places(identities, rows[:, 0])
    if not np.array_equal(np.sort(places), np.arange(len(identities))):
        raise UserError(
            f"{path}: section Velocities does not have each of the atoms once; write it again"
        )
    velocity = np.empty((len(rows), 3))
    velocity[places] = rows[:, 1:]
    return velocity


def _members(path, data, identities, kind, size):
    """(n, size) array of the places of the atoms of bonds or angles, in the order of identities."""
    section, name = f"{kind}s", f"{kind.lower()}s"
    count = data.counts.get(name, 0)
    if section not in data.sections:
        if count:
            raise UserError(
                f"{path}: the header says {count} {name}, and there is no section {section}; the "
                "file is cut off or damaged, write it again"
            )
        return np.zeros((0, size), np.int64)
    table = _Table(path, data, section, count)
    kinds = data.sections.get(f"{kind} Type Labels", [])[1:]
    labels = {line.text.split()[-1]: line.text.split()[0] for line in kinds}
    places = _places(identities, table.numbers(2 + size, labels, 1)[:, 2:])
    if (places < 0).any():
        row = int(np.argmax((places < 0).any(axis=1)))
        table.refuse(table.lines[row], "ties an atom that is not there")
    return places


def _dimension(path, data, place):
    """2 if all beads are at the same height, otherwise 3."""
    height = data.box[2, 1] - data.box[2, 0]
    flat = (place[:, 2] == place[0, 2]).all()
    if flat and (len(place) > 1 or height < THIN):
        return 2
    if height < THIN:
        raise UserError(
            f"{path}: the box is {height:g} thick along z, as for two dimensions, and beads are at "
            "different z; give all beads the same z, or the box three edges of at least "
            f"{THIN:g}"
        )
    return 3


def _left_out(data, style, rows):
    """What a file has that is lost, a sentence each."""
    if "charge" in STYLES[style] and rows[:, STYLES[style].index("charge")].any():
        yield "charges are left out: there are none here"
    for name in ("dihedrals", "impropers"):
        if data.counts.get(name):
            yield f"{data.counts[name]} {name} are left out: there are none here"
    for name in ("bond", "angle"):
        if (types := data.counts.get(f"{name} types", 0)) > 1:
            yield f"{name}s of {types} types become {name}s of one type"
    if "Atom Type Labels" not in data.sections and not any(
        line.comment for line in data.sections.get("Masses", [])
    ):
        yield "types have no names: they are called A, B ..."
