"""Rates of whole runs, with all that they observe and write, beside that of the bare loop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from dpd.benchmark.timing import TURNS, in_turns, simulation_of, starts_of
from dpd.benchmark.workloads import STUDIES, workload
from dpd.pipeline.simulate import simulate

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.engine.state import State
    from dpd.scene.scene import Scene


def beside_bare(name: str, scene: Scene, start: State, turns: int = TURNS) -> pd.DataFrame:
    """Rates of a run and of the bare loop on the same scene, in turns.

    A run is what follows the first configuration: the loop, its observables, and the file. Both are
    done once before, so that neither compiles.

    Parameters
    ----------
    name : str
    scene : Scene
    start : State
    turns : int

    Returns
    -------
    pandas.DataFrame
        One row per turn: ``workload``, ``turn``, ``beads``, and in bead-steps per second ``bare``
        and ``whole``.
    """
    steps, bare = scene.steps.sample, simulation_of(scene, start)
    with TemporaryDirectory() as folder:

        def whole(steps):
            return simulate(scene, Path(folder) / "run.nc", replace(start))

        advances = [bare.advance, whole]
        in_turns(advances, steps, 1)
        seconds = in_turns(advances, steps, turns)
    rates = dict(zip(("bare", "whole"), scene.beads * steps / seconds))
    return pd.DataFrame({"workload": name, "turn": np.arange(turns), "beads": scene.beads, **rates})


def whole_runs(say: Callable[[str], None]) -> pd.DataFrame:
    """`beside_bare` on what studies are made of; ``say`` is called with a sentence before each."""
    scenes = {name: workload(name) for name in STUDIES}
    starts = starts_of(scenes, say)
    tables = []
    for name, scene in scenes.items():
        say(f"{name}: measuring a whole run")
        tables.append(beside_bare(name, scene, starts[name]))
    return pd.concat(tables, ignore_index=True)


def as_text(table: pd.DataFrame) -> str:
    """Medians and ratios as lines of text."""
    lines = ["million bead-steps per second: the bare loop, and the whole run with its observables"]
    for name, rows in table.groupby("workload", sort=False):
        bare, whole = rows.bare.median() / 1e6, rows.whole.median() / 1e6
        ratio = (rows.whole / rows.bare).median()
        lines.append(
            f"{name:10s} {bare:6.2f} {whole:6.2f}   ratio {ratio:.2f}   {STUDIES[name].system}"
        )
    return "\n".join(lines)
