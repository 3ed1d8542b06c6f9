"""What each feature of a scene costs, and each observable."""

from __future__ import annotations

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from dpd.benchmark.timing import TURNS, in_turns, labelled, simulation_of, starts_of
from dpd.benchmark.workloads import CHANNEL, FLAT_MELT, FLUID, MELT, SLABS, workload
from dpd.engine.loop import run
from dpd.errors import UserError
from dpd.observe import observables
from dpd.page import Observable, names
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray as xr

    from dpd.benchmark.timing import Advance
    from dpd.engine.simulation import Simulation

BARE = "bare fluid"
DIMERS = {
    "molecules": [{"architecture": "A 2", "density": 3}],
    "bond": {"stiffness": 2, "length": 0},
}
TWO = {
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 25},
}
# What a scene names for each feature.
NAMED: dict[str, dict[str, Any]] = {
    "bonds (dimers)": DIMERS,
    "two species": TWO,
    "rigid core": {"core": {"radius": 0.1, "force": 25}},
    "Gaussian noise": {"thermostat": {"noise": "gaussian"}},
    "Langevin bath": {"thermostat": {"kind": "langevin"}},
    "friction twice": {"integrator": {"scheme": "dpd-vv", "dt": 0.04}},
}
VIRIAL = "virial every step"
STEPS = 60  # in a turn
# Systems on which observables are measured.
OBSERVED: dict[str, dict[str, Any]] = {
    "fluid": FLUID | {"box": 10},
    "slabs": SLABS,
    "channel": CHANNEL,
    "melt": MELT,
    "2D melt": FLAT_MELT | {"box": 31.6228},
}
WATCHED, LONGEST = 200, 2000  # steps of a turn with an observable: at least, at most


def features(
    scene: Scene | None = None, steps: int = STEPS, turns: int = TURNS,
    say: Callable[[str], None] = print,
) -> xr.Dataset:  # fmt: skip
    """Cost of features, each in turns with the bare fluid.

    Parameters
    ----------
    scene : Scene or None
        The bare fluid, W1 if not given.
    steps : int
        In a turn.
    turns : int
    say : callable

    Returns
    -------
    xarray.Dataset
        ``cost`` and ``bare_cost`` (feature, turn) in s per bead and step.
    """
    bare = scene or workload("W1")
    scenes = {BARE: bare} | {
        name: Scene(bare.data | changes, bare.where) for name, changes in NAMED.items()
    }
    starts = starts_of(scenes, say)
    still = simulation_of(bare, starts[BARE])
    pairs: dict[str, tuple[Advance, Advance]] = {
        name: (still.advance, simulation_of(scenes[name], starts[name]).advance) for name in NAMED
    }
    pairs[VIRIAL] = one_by_one(still, False), one_by_one(still, True)
    cost = {}
    for name, advances in pairs.items():
        say(f"cost of {name}")
        for advance in advances:
            advance(steps)
        cost[name] = in_turns(advances, steps, turns) / (bare.beads * steps)
    reference, costs = np.array(list(cost.values())).transpose(1, 0, 2)
    along, per = ("feature", "turn"), "s"
    variables = {
        "feature": (("feature",), list(cost), "1", "feature"),
        "cost": (along, costs, per, "seconds per bead and step with the feature"),
        "bare_cost": (along, reference, per, "seconds per bead and step without, in turn"),
    }
    description = (
        f"{bare.beads} beads, rho {bare.density:.3g}, a 25, one thread, {turns} turns of feature "
        "and bare fluid."
    )
    return labelled(variables, description)


def one_by_one(simulation: Simulation, measure: bool) -> Advance:
    """Steps in calls of their own, measuring in each or in none."""

    def advance(steps):
        for _ in range(steps):
            simulation.advance_measured(1) if measure else simulation.advance(1)

    return advance


def observing(
    systems: Mapping[str, dict[str, Any]] = OBSERVED, turns: int = TURNS,
    say: Callable[[str], None] = print,
) -> pd.DataFrame:  # fmt: skip
    """What each observable adds to a run at its default interval, on one thread.

    Parameters
    ----------
    systems : dict of str to dict
        Scenes by name.
    turns : int
    say : callable

    Returns
    -------
    pandas.DataFrame
        ``observable``, ``system``, ``every`` (steps), ``share`` (% of the run without it); a row
        for each observable that a system allows.
    """
    scenes = {name: Scene(data, name) for name, data in systems.items()}
    starts, rows = starts_of(scenes, say), []
    for system, scene in scenes.items():
        say(f"{system}: measuring what observables cost")
        for key in names(Observable):
            simulation = simulation_of(scene, starts[system])
            try:
                rows.append((key, system, *_share(simulation, scene, key, turns)))
            except UserError:  # nothing to measure there
                continue
    return pd.DataFrame(rows, columns=["observable", "system", "every", "share"])


def _share(simulation, scene, key, turns):
    """Steps between samples, and what they add in % of the time of the processor."""
    seen = Scene(scene.data | {"observe": [key], "steps": {"sample": LONGEST}}, scene.where)
    every = seen.observe[key].every
    steps, added = -(-WATCHED // every) * every, []
    asked = {"observe": [{key: {"every": every}}], "steps": {"sample": (turns + 1) * steps}}
    seen = Scene(scene.data | asked, scene.where)
    with TemporaryDirectory() as folder:
        observers = observables(seen, simulation.system, Path(folder) / "run.nc", simulation.state)
        for _ in range(turns + 1):  # the first one compiles
            begun = time.process_time()
            run(simulation, (0, simulation.state.step + steps), observers)
            ended = time.process_time()
            simulation.advance(steps)
            added.append((ended - begun) / (time.process_time() - ended) - 1)
    return every, 100 * float(np.median(added[1:]))


def as_text(table: pd.DataFrame) -> str:
    """Costs as lines of text: a column for each system, a line for each observable."""
    systems = list(dict.fromkeys(table.system))
    lines = ["cost of each observable, % of a run (steps between its samples)"]
    lines.append(" " * 20 + "".join(f"{system:>16s}" for system in systems))
    for key, rows in table.groupby("observable", sort=False):
        found = {row.system: f"{row.share:.1f} ({row.every})" for row in rows.itertuples()}
        lines.append(f"{key:20s}" + "".join(f"{found.get(each, '-'):>16s}" for each in systems))
    return "\n".join(lines)
