"""A scene as an input of LAMMPS: its beads in a data file, and the lines of what acts.

Each term gives its own lines (`dpd.page.Term.lammps`). What acts between pairs beyond the soft
repulsion, a rigid core or forces of one's own, comes as a table of the difference.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from dpd.digests import text_digest
from dpd.engine.space import nearest
from dpd.engine.state import State
from dpd.page.laws import energies
from dpd.particles.lammps import as_data, style_of
from dpd.particles.particles import of_state
from dpd.physics.repulsion import Soft
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

SKIN = 0.3  # r_c, of its neighbour list
NEAREST, ROWS = 1e-7, 20_000  # r_c, and rows of a table: nearer pairs end a run, which none are
BITS = 16  # of its lookup: equal steps of the logarithm, 1024 a factor of 1.4 in distance
RARE = 30.0  # kT above the least, up to which bonds get long
SEEDS = 900_000_000  # that LAMMPS allows
ORDER = "pair_style", "bond_style", "angle_style", "pair_coeff", "bond_coeff", "angle_coeff"


class Input(NamedTuple):
    lines: list[str]  # commands up to where it can run
    files: dict[str, str]  # what they read, by name


def input_of(scene: Scene, state: State, name: str = "beads", skin: float = SKIN) -> Input:
    """What sets LAMMPS up for a scene at a state; its files are ``name``.data and .table."""
    particles, members = of_state(scene, state), scene.joined
    laws = {kind: members[size][1] for kind, size in (("bond", 2), ("angle", 3))}
    types = {kind: law.astype(int) + 1 for kind, law in laws.items() if law is not None}
    lines = [line for term in scene.terms.values() for line in term.lammps(scene)]
    more, table = _beyond_repulsion(scene, f"{name}.table")
    lines = sorted([*lines, *more], key=_place)  # which leaves others of one place as they were
    seed = 1 + int(text_digest(f"{scene.data['seed']} {state.step}"), 16) % SEEDS
    head = [
        "units lj", f"atom_style {style_of(particles)}", f"dimension {scene.dimension}",
        "newton on", "special_bonds lj 1.0 1.0 1.0", f"variable seed equal {seed}",
        f"read_data {name}.data", f"comm_modify vel yes cutoff {_ghosts(scene, particles, skin):g}",
        f"neighbor {skin} bin", "neigh_modify delay 0 every 1 check yes",
    ]  # fmt: skip
    flat = ["fix flat all enforce2d"] if scene.dimension == 2 else []
    files = {f"{name}.data": as_data(particles, types)}
    if table:
        files[f"{name}.table"] = table
    styles = [line.removeprefix("pair_style ") for line in lines if line.startswith("pair_style")]
    rest = [line for line in lines if not line.startswith("pair_style")]
    style = f"hybrid/overlay {' '.join(styles)}" if len(styles) > 1 else styles[0]
    if len(styles) == 1:  # coefficients say which they are of if there are several
        of = f" {style.split()[0]} "
        rest = [e.replace(of, " ") if e.startswith("pair_coeff") else e for e in rest]
    return Input([*head, f"pair_style {style}", *rest, *flat], files)


def _place(line):
    word = line.split()[0]
    return ORDER.index(word) if word in ORDER else len(ORDER)


def _beyond_repulsion(scene, file):
    """Lines and table of what acts between pairs beside the soft repulsion, if anything does."""
    law = system_of(scene).forces.pair
    if isinstance(law, Soft):
        return [], ""
    lines, parts, r = [f"pair_style table bitmap {BITS}"], [], np.linspace(NEAREST, 1.0, ROWS)
    for i, j in combinations_with_replacement(range(len(scene.species)), 2):
        a, name = scene.repulsion[i, j], f"BEYOND_{i + 1}_{j + 1}"
        values = zip(r.tolist(), (1.0 - r).tolist())
        rows = [
            (x, law.energy(law.repulsion[i, j], x, w) - 0.5 * a * w * w,
             law.force(law.repulsion[i, j], x, w) - a * w)
            for x, w in values
        ]  # fmt: skip
        lines.append(f"pair_coeff {i + 1} {j + 1} table {file} {name} 1.0")
        text = [f"{n} {x!r} {float(u)!r} {float(f)!r}" for n, (x, u, f) in enumerate(rows, 1)]
        parts += [name, f"N {ROWS} R {NEAREST} 1.0", "", *text, ""]
    return lines, "\n".join(parts)


def _ghosts(scene: Scene, particles: Any, skin: float) -> float:
    """How far a process sees beads of others: as far as bonds get, or it would lose their ends."""
    longest, half = 1.0, max(scene.box) / 2
    if scene.bond_force:
        r = np.linspace(0.0, half, 1001)[1:]
        for law in scene.bond_force.laws(scene).values():
            energy = energies(law, r)
            longest = max(longest, r[energy <= energy.min() + RARE * scene.kT].max())
        one, other = particles.position[:, particles.bonds.T].swapaxes(0, 1)
        apart = nearest(one - other, particles.box)
        longest = max(longest, np.sqrt((apart**2).sum(axis=0)).max())
    return min(longest, half) + skin
