"""Data files of LAMMPS, which it writes by ``write_data`` and reads by ``read_data``.

What this program has no use for is left out on reading: coefficients of potentials without a
word, as a scene has its own, all else with one.
"""

from __future__ import annotations

import re
from itertools import product
from string import ascii_uppercase
from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError, shown
from dpd.particles.lammps_file import GENERAL, KINDS, UPRIGHT, WHOLE, WHOLES, Table, taken_apart
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
    from pathlib import Path

# Columns of a line of Atoms by style, as https://docs.lammps.org/read_data.html has them.
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
OTHERS = (
    "body", "bpm/sphere", "dielectric", "electron", "hybrid", "line", "peri", "smd", "sph", "spin",
    "tdpd", "template", "tri", "wavepacket",
)  # fmt: skip
TITLE = re.compile(r"atom_style (\S+)")  # where TopoTools, of VMD, has it
FLAGS = ("ix", "iy", "iz")
SAID = {"id", "molecule", "type", "x", "y", "z", *FLAGS}  # columns that are not left out
EXTRAS = ("ellipsoids", "lines", "triangles", "bodies")
KNOWN = {"Velocities", "Masses", *(f"{kind}s".title() for kind in KINDS), *map(str.title, EXTRAS)}
THIN = 2.0  # r_c: no box of three dimensions may be thinner
HALF = 0.5  # r_c: half the thickness with which a box of two dimensions is written
MOST_TYPES = 256
LETTERS = [*ascii_uppercase, *map("".join, product(ascii_uppercase, repeat=2))]  # A, B ... AA, AB


def read_data(path: Path) -> Particles:
    """Read a data file.

    It is of two dimensions if its box is too thin along z for three. Beads outside of the box are
    wrapped into it, and counted in their images. Units are taken to be ``lj``, with lengths in r_c
    and energies in kT. Refused is what no simulation can begin with.
    """
    data = taken_apart(path)
    atoms, types, labels = data.count("atoms"), data.types("Atom"), data.labels("Atom")
    if not atoms:
        raise UserError(f"{path}: the header says 0 atoms; at least one is needed")
    if not 1 <= types <= MOST_TYPES:
        raise UserError(f"{path}: the header says {types} atom types; allowed: 1 to {MOST_TYPES}")
    table = Table(data, "Atoms", atoms)
    columns = _columns(data, table, labels)
    rows = table.numbers(columns, labels)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    identities, kinds = rows[:, [0, columns.index("type")]].T.astype(np.int64)
    if (twice := identities[1:] == identities[:-1]).any():
        raise UserError(
            f"{path}: atom {identities[np.argmax(twice)]} is there twice; number atoms differently"
        )
    if (bad := (kinds < 1) | (kinds > types)).any():
        raise UserError(
            f"{path}: atom {identities[np.argmax(bad)]} is of type {kinds[np.argmax(bad)]}; the "
            f"header allows 1 to {types}"
        )
    names, unnamed = _names(data, labels)
    corner, turn, edges, tilts = _box(data)
    first = columns.index("x")
    place = (rows[:, first : first + 3] - corner) @ turn
    velocity, spins = _velocities(data, identities)
    image = rows[:, -3:] if columns[-1] == "iz" else np.zeros((atoms, 3))
    dimension, flat = 2 + (edges[2] >= THIN), np.ptp(place[:, 2]) <= FLAT
    if dimension == 2 and not flat:
        raise UserError(
            f"{path}: the box is {edges[2]:g} thick along z, as for two dimensions, and beads are "
            f"at different z; give beads one z, or the box three edges of at least {THIN:g}"
        )
    box = box_of_file(edges[:dimension], tilts, path)
    left_out = [*unnamed, *_left_out(data, columns, rows)]
    if dimension == 3 and atoms > 1 and flat:
        left_out.append(
            f"all beads are at one height, in a box {edges[2]:g} high: three dimensions (the box "
            f"of two is lower than {THIN:g})"
        )
    if spins:
        left_out.append("velocities of rotation are left out: beads have none here")
    if velocity is not None:
        velocity = velocity @ turn
        if dimension == 2 and velocity[:, 2].any():
            left_out.append("velocities along z are left out: there are two dimensions")
        velocity = velocity[:, :dimension].T
    return checked(
        Particles(
            box=box,
            position=place[:, :dimension].T,
            image=image[:, :dimension].T,
            velocity=velocity,
            species=kinds - 1,
            names=names,
            bonds=_members(data, identities, "Bond", 2),
            angles=_members(data, identities, "Angle", 3),
            step=data.step,
            left_out=tuple(left_out),
            masses=_masses(data, labels),
            identity=identities,
        ),
        path,
        periodic=True,
    )


def _columns(data, table, labels):
    """What stands in each column of Atoms: of the style that is named, or the only one that fits.

    A comment that is no style says nothing. Columns of whole numbers tell styles apart.
    """
    path, width = data.path, table.width()
    named = (table.head.comment.lower().split() or [""])[0]
    if named not in (*STYLES, *OTHERS) and (said := TITLE.search(data.title)):
        named = said[1]
    if named in OTHERS:
        raise UserError(
            f"{path}: line {table.head.number}: atom style {named!r} cannot be read; write the "
            f"file in another one; allowed: {', '.join(STYLES)}"
        )
    if named in STYLES:
        plain = STYLES[named].split()
        if width not in (len(plain), len(plain) + 3):
            raise UserError(
                f"{path}: line {table.lines[0].number}: {width} columns in section Atoms; style "
                f"{named!r} has {len(plain)}, or {len(plain) + 3} with image flags"
            )
        return (*plain, *FLAGS[: width - len(plain)])
    rows = (line.text.split(" ") for line in table.lines)
    along = list(enumerate(zip(*(row for row in rows if len(row) == width))))
    whole = {k for k, words in along if all(re.fullmatch(WHOLE, word) for word in words)}
    numbers = {*map(str, range(1, data.types("Atom") + 1)), *labels}
    types = {k for k, words in along if numbers.issuperset(words)}
    fits: dict[tuple, list[str]] = {}
    for style, text in STYLES.items():
        for columns in (tuple(text.split()), (*text.split(), *FLAGS)):
            wholes = {k for k, name in enumerate(columns) if name in WHOLES and name != "type"}
            if len(columns) == width and wholes <= whole and columns.index("type") in types:
                fits.setdefault(columns, []).append(style)
    if len(fits) > 1 and data.count("bonds"):
        fits = {each: fits[each] for each in fits if "molecule" in each} or fits
    if len(fits) > 1:  # coordinates have points somewhere, image flags have none
        pointed = [each for each in fits if {each.index(axis) for axis in "xyz"} - whole]
        fits = {each: fits[each] for each in pointed} or fits
    if len(fits) == 1:
        return next(iter(fits))
    styles = [style for each in fits.values() for style in each] or list(STYLES)
    why = "fit to several styles" if fits else "fit to no style that is known"
    raise UserError(
        f"{path}: line {table.head.number}: the {width} columns of section Atoms {why}; write "
        f"'Atoms # {styles[0]}' if that is the style; allowed: {', '.join(styles)}"
    )


def _names(data, labels):
    """Names of the species, and a sentence on those that have none.

    They are the type labels, or what stands as a comment behind a mass, or letters.
    """
    names = {int(number): label for label, number in labels.items()}
    if not names:
        for line in data.sections.get("Masses", [])[1:]:
            number = line.text.split(" ")[0]
            if data.is_type(number, "Atom") and line.comment:
                names[int(number)] = line.comment.split()[0]
    numbers = range(1, data.types("Atom") + 1)
    found = tuple(names.get(number, LETTERS[number - 1]) for number in numbers)
    if twice := [name for name in found if found.count(name) > 1]:
        raise UserError(
            f"{data.path}: {len(twice)} types are called {shown(twice[0])}; types are called by "
            "their labels, or by the comments behind the masses, or by letters where there are "
            "none; write a name of its own behind the mass of each"
        )
    without = ", ".join(LETTERS[number - 1] for number in numbers if number not in names)
    return found, [f"types have no names: they are called {without}"] if without else []


def _masses(data, labels):
    """Masses by type; None if all are 1 or none are given."""
    masses = np.ones(data.types("Atom"))
    if "Masses" not in data.sections:
        return None
    table = Table(data, "Masses", len(data.sections["Masses"]) - 1)
    rows = table.numbers(("type", "mass"), labels)
    for line, (number, mass) in zip(table.lines, rows):
        if not 1 <= number <= len(masses):
            table.refuse(line, f"is not of a type from 1 to {len(masses)}")
        masses[int(number) - 1] = mass
    return None if (masses == 1).all() else masses


def _box(data):
    """Lower corner, the turn to the axes of the box, edges, and tilt factors.

    Vectors of any direction are turned so that the first is along x and the second has no z.
    """
    header = data.header
    general, upright = ([name for name in names if name in header] for names in (GENERAL, UPRIGHT))
    needed = ("avec", "bvec") if general else ("xlo xhi", "ylo yhi")
    if missing := [name for name in needed if name not in header]:
        raise UserError(f"{data.path}: the header has no line {missing[0]!r}; write the whole box")
    if general and upright:
        raise UserError(
            f"{data.path}: the header has a box by {general[0]!r} and one by {upright[0]!r}; keep "
            "one"
        )
    if general:
        vectors = [header[name] for name in needed] + [header.get("cvec", (0, 0, 1))]
        corner, vectors = np.array(header.get("abc origin", (0, 0, 0))), np.array(vectors).T
        turn, vectors = np.linalg.qr(vectors)
        forward = np.where(np.diag(vectors) < 0, -1.0, 1.0)
        turn, vectors = turn * forward, vectors * forward[:, None]
        if np.linalg.det(turn) < 0:
            raise UserError(f"{data.path}: avec, bvec and cvec are left-handed; swap two of them")
    else:
        ends = np.array([header.get(f"{axis}lo {axis}hi", (-0.5, 0.5)) for axis in "xyz"])
        corner, turn, vectors = ends[:, 0], np.eye(3), np.diag(ends[:, 1] - ends[:, 0])
        for (along, across), tilt in zip(FACTORS, header.get("xy xz yz", (0, 0, 0))):
            vectors[along, across] = tilt
    edges = np.diag(vectors)
    tilts = [vectors[pair] / edges[pair[1]] if edges[pair[1]] else 0.0 for pair in FACTORS]
    return corner, turn, edges, tilts


def _places(identities, wanted):
    """Places of atoms by their identities in the file; -1 for those that are not there."""
    places = np.searchsorted(identities, wanted).clip(max=len(identities) - 1)
    return np.where(identities[places] == wanted, places, -1)


def _velocities(data, identities):
    """(n, 3) array in the order of identities, or None; and whether there are those of rotation."""
    if "Velocities" not in data.sections:
        return None, False
    table = Table(data, "Velocities", len(identities))
    more = max(0, min(3, table.width() - 4))  # spheres and ellipsoids have three more
    rows = table.numbers(("id", "x", "y", "z", *["spin"] * more), {})
    places = _places(identities, rows[:, 0])
    if not np.array_equal(np.sort(places), np.arange(len(identities))):
        raise UserError(
            f"{data.path}: section Velocities does not have each of the atoms once; write it again"
        )
    velocity = np.empty((len(rows), 3))
    velocity[places] = rows[:, 1:4]
    return velocity, rows[:, 4:].any()


def _members(data, identities, kind, size):
    """(n, size) array of the places of the atoms of bonds or angles, in the order of identities."""
    section, name = f"{kind}s", f"{kind.lower()}s"
    if section not in data.sections:
        if data.count(name):
            raise UserError(
                f"{data.path}: the header says {data.count(name)} {name}, and there is no section "
                f"{section}; the file is cut off or damaged, write it again"
            )
        return np.zeros((0, size), np.int64)
    table = Table(data, section, data.count(name))
    rows = table.numbers(("id", "type", *["id"] * size), data.labels(kind))
    places = _places(identities, rows[:, 2:])
    if (places < 0).any():
        row = int(np.argmax((places < 0).any(axis=1)))
        table.refuse(table.lines[row], "ties an atom that is not there")
    return places


def _left_out(data, columns, rows):
    """What a file has that is lost, a sentence each."""
    lost = [name for k, name in enumerate(columns) if name not in SAID and rows[:, k].any()]
    if lost:
        yield f"{', '.join(lost)} of the atoms left out: beads have none here"
    for name in ("dihedrals", "impropers", *EXTRAS):
        if data.count(name):
            yield f"{data.count(name)} {name} are left out: there are none here"
    for name in ("bond", "angle"):
        if (types := data.types(name)) > 1:
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
    bonds, angles = particles.bonds, particles.angles
    style = "angle" if len(angles) else "bond" if len(bonds) else "atomic"
    edges = [f"0 {edge!r}" for edge in map(float, particles.box)] + [f"{-HALF} {HALF}"]
    lines = [
        f"LAMMPS data file, written by dpd-papers, timestep = {particles.step}, units = lj", "",
        f"{particles.beads} atoms", f"{len(particles.names)} atom types",
        *([f"{len(bonds)} bonds", "1 bond types"] if len(bonds) else []),
        *([f"{len(angles)} angles", "1 angle types"] if len(angles) else []), "",
        *(f"{edge} {axis}lo {axis}hi" for edge, axis in zip(edges, "xyz")),
        *_tilt_line(particles.box), "",
        "Masses", "", *_mass_lines(particles), "",
        f"Atoms # {style}", "", *_atom_lines(particles),
    ]  # fmt: skip
    if particles.velocity is not None:
        rows = _padded(particles.velocity, 0.0).T.tolist()
        lines += ["", "Velocities", ""]
        lines += [f"{i + 1} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(rows)]
    for name, members in (("Bonds", bonds), ("Angles", angles)):
        if len(members):
            rows = (" ".join(map(str, row)) for row in (members.astype(int) + 1).tolist())
            lines += ["", name, "", *(f"{i + 1} 1 {row}" for i, row in enumerate(rows))]
    return "\n".join(lines) + "\n"


def _mass_lines(particles):
    masses = particles.masses_by_name()
    return [f"{i + 1} {masses.get(name, 1)} # {name}" for i, name in enumerate(particles.names)]


def _tilt_line(box):
    """How far vectors of the box go along other axes, in r_c; no line for right angles."""
    factors = tilt_factors(box)
    if not any(factors):
        return []
    lengths = [f * box[across] if f else 0.0 for f, (_, across) in zip(factors, FACTORS)]
    return [" ".join(f"{length!r}" for length in lengths) + " xy xz yz"]


def _atom_lines(particles):
    kinds = (particles.species.astype(int) + 1).tolist()
    if len(particles.bonds) or len(particles.angles):
        molecules = molecules_of(particles).tolist()
        kinds = [f"{molecule + 1} {kind}" for molecule, kind in zip(molecules, kinds)]
    position, image = in_tilted_box(particles)
    places = _padded(position, 0.0).T.tolist()
    images = _padded(image, 0).T.tolist()
    for i, (kind, (x, y, z), (a, b, c)) in enumerate(zip(kinds, places, images)):
        yield f"{i + 1} {kind} {x!r} {y!r} {z!r} {a} {b} {c}"


def _padded(array, nothing):
    """A (dimension, n) array with three rows."""
    missing = 3 - len(array)
    return np.pad(array, ((0, missing), (0, 0)), constant_values=nothing)
