"""Data files of LAMMPS, which it writes by ``write_data`` and reads by ``read_data``.

https://docs.lammps.org/read_data.html. What this program has no use for is left out on reading:
coefficients of potentials too, as a scene has its own laws; all with a sentence.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from string import ascii_uppercase
from typing import NamedTuple, NoReturn

import numpy as np

from dpd.errors import UserError, shown
from dpd.particles.particles import FACTORS, FLAT, Particles, box_of_file, tilt_factors

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
FLAGS = ["ix", "iy", "iz"]
WHOLE = ["id", "molecule", "type", *FLAGS]  # columns of whole numbers
USED = {*WHOLE, "x", "y", "z"}
STEP = re.compile(r"timestep = ([0-9]{1,18})")  # in the title, where LAMMPS puts it
HEADER = re.compile(  # what may stand behind numbers there
    r"(atom|bond|angle|dihedral|improper)(s| types)|extra .* per atom|ellipsoids|lines|triangles"
    r"|bodies|([xyz])lo \3hi|xy xz yz|[abc]vec|abc origin"
)
SECTION = re.compile(r"[A-Z][A-Za-z0-9]*( [A-Z][A-Za-z0-9]*)*")  # its name
KNOWN = {"Atoms", "Velocities", "Masses", "Bonds", "Angles"}  # sections that are not left out
MOST_TYPES = 256
THIN = 2.0  # r_c: no box of three dimensions may be thinner
HALF = 0.5  # r_c: half the thickness with which a box of two dimensions is written
LETTERS = [*ascii_uppercase, *map("".join, product(ascii_uppercase, repeat=2))]  # A, B ... AA, AB


class Data(NamedTuple):
    """A file taken apart."""

    path: Path
    title: str
    header: dict[str, list[float]]  # by what stands behind the numbers: xlo xhi, bond types ...
    sections: dict[str, list[str]]  # their lines
    comments: dict[str, str]  # behind the names of sections

    def refuse(self, problem: str) -> NoReturn:
        raise UserError(f"{self.path}: {problem}")

    def count(self, name: str) -> int:
        """A count of the header; 0 if it is not there."""
        return int(self.header.get(name, [0.0])[0])

    def labels(self, kind: str) -> dict[str, int]:
        """Numbers of types by their labels; ``kind`` is ``Atom``, ``Bond`` ..."""
        words = (line.split() for line in self.sections.get(f"{kind} Type Labels", []))
        return {label: int(number) for number, label, *_ in words}

    def table(
        self, name: str, count: int, columns: Sequence[str], labels: Mapping[str, int]
    ) -> np.ndarray:
        """(count, columns) numbers of a section, labels as the numbers of their types."""
        lines, where = self.sections.get(name, []), f"section {name}"
        if len(lines) != count:
            self.refuse(
                f"{where} has {len(lines)} lines, and the header says {count}; the file is cut off "
                "or damaged, write it again"
            )
        if not count:
            return np.zeros((0, len(columns)))
        try:
            rows = np.loadtxt(
                lines, ndmin=2, usecols=range(len(columns)),
                converters=(lambda word: float(labels.get(word, word))) if labels else None,
            )  # fmt: skip
        except ValueError as problem:
            said = shown(str(problem).partition(";")[0], str).rstrip(".")
            self.refuse(f"{where}: {said} of the section; mend the line")
        broken = np.isin(columns, WHOLE) & (rows % 1 != 0)
        for row, column in np.argwhere(broken)[:1]:
            found = f"{shown(lines[row])} has {rows[row, column]:.16g}"
            self.refuse(f"{where}: {found} where a whole number is needed; mend the line")
        return rows


def read_data(path: Path) -> Particles:
    """Read a data file, in units ``lj``; of two dimensions if its box is too thin for three."""
    data = _taken_apart(path)
    types, labels, columns = data.count("atom types"), data.labels("Atom"), _columns(data)
    if not 1 <= types <= MOST_TYPES:
        data.refuse(f"the header says {types} atom types; allowed: 1 to {MOST_TYPES}")
    rows = data.table("Atoms", data.count("atoms"), columns, labels)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    identities, kinds = rows[:, [0, columns.index("type")]].T.astype(np.int64)
    if (twice := identities[1:] == identities[:-1]).any():
        data.refuse(f"atom {identities[np.argmax(twice)]} is there twice; number atoms differently")
    names, left_out = _names(data, labels)
    left_out += _left_out(data, columns, rows)
    low, high = np.array([data.header.get(f"{k}lo {k}hi", (-HALF, HALF)) for k in "xyz"]).T
    edges, tilts = high - low, data.header.get("xy xz yz", (0, 0, 0))
    factors = [tilt / edges[across] if tilt else 0 for tilt, (_, across) in zip(tilts, FACTORS)]
    dimension = 2 + (edges[2] >= THIN)
    first = columns.index("x")
    position = rows[:, first : first + 3] - low
    if dimension == 2 and np.ptp(position[:, 2]) > FLAT:
        data.refuse(
            f"the box is {edges[2]:g} thick along z, as for two dimensions, and beads are at "
            f"different z; give beads one z, or the box three edges of at least {THIN:g}"
        )
    velocity = None
    if "Velocities" in data.sections:
        found = data.table("Velocities", len(identities), ["id", *"xyz"], {})
        velocity = np.full((len(identities), 3), np.nan)  # refused where one is not given
        velocity[_places(data, "Velocities", identities, found[:, 0])] = found[:, 1:]
        if dimension == 2 and velocity[:, 2].any():
            left_out.append("velocities along z are left out: there are two dimensions")
    bonds, bond_types = _members(data, identities, "Bond", 2)
    angles, angle_types = _members(data, identities, "Angle", 3)
    image = rows[:, -3:] if columns[-3:] == FLAGS else np.zeros(position.shape)
    return Particles(
        box=box_of_file(edges[:dimension], factors, path),
        position=position[:, :dimension].T,
        image=image[:, :dimension].T,
        velocity=None if velocity is None else velocity[:, :dimension].T,
        species=kinds - 1,
        names=names,
        bonds=bonds,
        angles=angles,
        types=bond_types | angle_types,
        step=int(step[1]) if (step := STEP.search(data.title)) else 0,
        left_out=tuple(left_out),
        masses=_masses(data, labels),
        identity=identities,
    ).checked(path, periodic=True)


def _taken_apart(path):
    title, *lines = path.read_text(errors="replace").splitlines() or [""]
    data, section = Data(path, title, {}, {}, {}), None
    for number, line in enumerate(lines, 2):
        before, _, comment = line.partition("#")
        words = before.split()
        if SECTION.fullmatch(name := " ".join(words)):
            section = data.sections[name] = []
            data.comments[name] = comment
        elif words and section is not None:
            section.append(line)
        elif words:
            size = next((k for k, word in enumerate(words) if word[0].isalpha()), len(words))
            if not HEADER.fullmatch(name := " ".join(words[size:])):
                data.refuse(
                    f"line {number}: {shown(line)} is not known in a header; mend or remove it"
                )
            data.header[name] = [float(word) for word in words[:size]]
    if vectors := [data.header[name] for name in ("avec", "bvec", "cvec") if name in data.header]:
        if np.shape(vectors) != (3, 3) or np.any(vectors * (1 - np.eye(3))):
            data.refuse(
                "the edges avec, bvec and cvec of its box are not along x, y and z; write it with "
                "write_data without triclinic/general"
            )
        if twice := data.header.keys() & {"xlo xhi", "ylo yhi", "zlo zhi"}:
            data.refuse(f"the header has a box by avec, and one by {min(twice)}; keep one of them")
        low = np.array(data.header.get("abc origin", [0.0] * 3))
        for axis, ends in zip("xyz", np.transpose([low, low + np.diag(vectors)])):
            data.header[f"{axis}lo {axis}hi"] = list(ends)
    for name in ("atoms", "xlo xhi", "ylo yhi"):
        if name not in data.header:
            data.refuse(
                f"not a whole data file of LAMMPS: there is no line {name!r} in the header; write "
                "it again with write_data"
            )
    return data


def _columns(data):
    """Names of the columns of Atoms, by the style behind its name; 5 and 8 are of ``atomic``."""
    lines = data.sections.get("Atoms", [])
    size = len(lines[0].partition("#")[0].split()) if lines else 0
    style = (data.comments["Atoms"].split() or ["atomic"])[0] if lines else "atomic"
    plain = STYLES.get(style, "").split()
    if lines and (not plain or size not in (len(plain), len(plain) + 3)):
        data.refuse(
            f"the {size} columns of section Atoms do not fit to the style {style!r}; write the "
            f"right one behind it, as in 'Atoms # full'; allowed: {', '.join(STYLES)}"
        )
    return plain + FLAGS * (size > len(plain))


def _names(data, labels):
    """Labels of types, or comments behind masses, or letters; and a sentence on those."""
    names = {number: label for label, number in labels.items()}
    if not names:
        parts = (line.partition("#")[::2] for line in data.sections.get("Masses", []))
        names = {int(before.split()[0]): name.split()[0] for before, name in parts if name.strip()}
    numbers = range(1, data.count("atom types") + 1)
    found = tuple(names.get(number, LETTERS[number - 1]) for number in numbers)
    without = ", ".join(LETTERS[number - 1] for number in numbers if number not in names)
    return found, [f"types have no names: they are called {without}"] if without else []


def _masses(data, labels):
    """Masses by type; None if all are 1 or none are given."""
    if "Masses" not in data.sections:
        return None
    masses = np.full(data.count("atom types"), np.nan)  # refused where one is not given
    rows = data.table("Masses", len(masses), ("type", "mass"), labels)
    masses[rows[:, 0].astype(int) - 1] = rows[:, 1]
    return None if (masses == 1).all() else masses


def _members(data, identities, kind, size):
    """(n, size) places of the atoms of bonds or angles by identities, and their types."""
    columns, labels = ["id", "type", *["id"] * size], data.labels(kind)
    rows = data.table(f"{kind}s", data.count(f"{kind.lower()}s"), columns, labels)
    names = {number: label for label, number in labels.items()}
    members = _places(data, f"{kind}s", identities, rows[:, 2:])
    numbers = rows[:, 1].tolist() if labels or len({*rows[:, 1]}) > 1 else ()
    types = {tuple(one): names.get(n, f"{n:.0f}") for one, n in zip(members.tolist(), numbers)}
    return members, types


def _places(data, section, identities, wanted):
    """Places of atoms by their identities in the file."""
    places = np.searchsorted(identities, wanted).clip(max=len(identities) - 1)
    if (bad := identities[places] != wanted).any():
        data.refuse(f"section {section}: there is no atom {wanted[bad][0]:g}; mend it")
    return places


def _left_out(data: Data, columns: Sequence[str], rows: np.ndarray) -> Iterator[str]:
    """What a file has that is lost, a sentence each."""
    if lost := [name for k, name in enumerate(columns) if name not in USED and rows[:, k].any()]:
        yield f"{', '.join(lost)} of the atoms left out: beads have none here"
    for name in data.sections:
        if name not in KNOWN and not name.endswith(" Type Labels"):
            yield f"section {name} is left out: laws, and all that beads have, are the scene's"


def style_of(particles: Particles) -> str:
    """The atom style that a configuration needs."""
    return "angle" if len(particles.angles) else "bond" if len(particles.bonds) else "atomic"


def as_data(particles: Particles, types: Mapping[str, np.ndarray] = {}) -> str:
    """A configuration as the text of a data file, of atom style ``angle``, ``bond`` or ``atomic``.

    In two dimensions the box is 1 thick along z. Under shear velocities are those about the flow.
    ``types`` are those of each ``bond`` and ``angle``, from 1 on, if not those of the particles.
    """
    bonds, angles, box = particles.bonds, particles.angles, particles.box
    style = style_of(particles)
    factors, masses = tilt_factors(box), particles.masses_by_name()
    position, image = (_three(each) for each in particles.in_tilted_box())
    kinds = [particles.species.astype(int) + 1]
    if style != "atomic":
        kinds.insert(0, particles.molecules + 1)
    counts = {"atoms": particles.beads, "atom types": len(particles.names)}
    joined, labels = {}, {}
    for name, members in (("bond", bonds), ("angle", angles)):
        if len(members):
            found, numbers = particles.numbered(name)
            named = any(not each.isdigit() for each in found)
            own = numbers + 1 if named else np.array(found, int)[numbers]
            type = types.get(name, own)
            counts |= {f"{name}s": len(type), f"{name} types": type.max()}
            joined[name] = type, *members.astype(int).T + 1
            if named and len(found) > 1 and name not in types:
                said = (each if each[0].isalpha() else f"{name}{each}" for each in found)
                lines = [f"{number} {label}" for number, label in enumerate(said, 1)]
                labels[f"{name.capitalize()} Type Labels"] = lines
    ends = [f"0 {float(edge)!r}" for edge in box] + [f"{-HALF} {HALF}"]
    header = [f"{number} {name}" for name, number in counts.items()]
    header += [f"{end} {axis}lo {axis}hi" for end, axis in zip(ends, "xyz")]
    if any(factors):
        tilts = [float(f * box[across]) if f else 0.0 for f, (_, across) in zip(factors, FACTORS)]
        header.append(" ".join(map(repr, tilts)) + " xy xz yz")
    sections = labels | {
        "Masses": [
            f"{k} {masses.get(name, 1)} # {name}" for k, name in enumerate(particles.names, 1)
        ],
        f"Atoms # {style}": _lines(*kinds, *position, *image),
    }
    if particles.velocity is not None:
        sections["Velocities"] = _lines(*_three(particles.velocity))
    sections |= {f"{name.capitalize()}s": _lines(*each) for name, each in joined.items()}
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
