"""Configurations as the text of data files, which LAMMPS reads by ``read_data``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.particles.particles import FACTORS, in_tilted_box, molecules_of, tilt_factors

if TYPE_CHECKING:
    from dpd.particles.particles import Particles

HALF = 0.5  # r_c: half the thickness with which a box of two dimensions is written


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
    """Lines of the section Masses, with the names of the species."""
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
    """Lines of the section Atoms."""
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
