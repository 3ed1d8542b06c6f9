"""What each feature of a scene costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.benchmark.timing import TURNS, in_turns, labelled, simulation_of, starts_of
from dpd.benchmark.workloads import workload
from dpd.engine.loop import run
from dpd.observe import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

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
EVERY = 10  # steps between samples of an observable
WATCHED = {
    f"g(r) every {EVERY} steps": {"rdf": {"every": EVERY}},
    f"displacement every {EVERY} steps": {"displacement": {"every": EVERY}},
}
VIRIAL = "virial every step"
STEPS = 60  # in a turn


def features(
    scene: Scene | None = None, steps: int = STEPS, turns: int = TURNS,
    watched: Mapping[str, dict[str, Any]] | None = None, say: Callable[[str], None] = print,
) -> xr.Dataset:  # fmt: skip
    """Cost of features, each in turns with the bare fluid.

    Parameters
    ----------
    scene : Scene or None
        The bare fluid, W1 if not given.
    steps : int
        In a turn, a multiple of `EVERY`.
    turns : int
    watched : dict or None
        Observables, `WATCHED` if not given.
    say : callable

    Returns
    -------
    xarray.Dataset
        ``cost`` and ``bare_cost`` (feature, turn) in s per bead and step.
    """
    bare = scene or workload("W1")
    watched = WATCHED if watched is None else watched
    scenes = {BARE: bare} | {
        name: Scene(bare.data | changes, bare.where) for name, changes in NAMED.items()
    }
    starts = starts_of(scenes, say)
    still = simulation_of(bare, starts[BARE])
    pairs: dict[str, tuple[Advance, Advance]] = {
        name: (still.advance, simulation_of(scenes[name], starts[name]).advance) for name in NAMED
    }
    pairs[VIRIAL] = one_by_one(still, False), one_by_one(still, True)
    for name, observed in watched.items():
        seen = Scene(bare.data | {"observe": [observed]} | _length(turns, steps), bare.where)
        pairs[name] = still.advance, watching(simulation_of(bare, starts[BARE]), seen)
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


def _length(turns, steps):
    """What an observable is told of the length of the run."""
    return {"steps": {"sample": (turns + 1) * steps}}


def one_by_one(simulation: Simulation, measure: bool) -> Advance:
    """Steps in calls of their own, measuring in each or in none."""

    def advance(steps):
        for _ in range(steps):
            simulation.advance_measured(1) if measure else simulation.advance(1)

    return advance


def watching(simulation: Simulation, scene: Scene) -> Advance:
    """Steps of the run loop with the observables of a scene."""
    observers = observables(scene, system_of(scene))

    def advance(steps):
        run(simulation, (0, simulation.state.step + steps), observers)

    return advance
