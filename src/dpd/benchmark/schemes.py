"""What a step of each scheme costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.benchmark.timing import TURNS, in_turns, labelled, simulation_of, starts_of
from dpd.benchmark.workloads import workload
from dpd.engine.simulation import Unstable
from dpd.physics.integrator import SCHEMES
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray as xr

PREDICTIONS = (0.5, 0.65)  # lambda of gw-vv, Groot and Warren 1997
DT = 0.01  # tau; all schemes stand it, and pairs are found as at the workloads' own
SHARE = 0.25  # of a workload's steps, in one turn


def labelled_schemes() -> dict[str, dict[str, Any]]:
    """Name to what a scene says of it, for every scheme; gw-vv once for each lambda."""
    found: dict[str, dict[str, Any]] = {}
    for scheme in SCHEMES:
        if scheme == "gw-vv":
            found |= {f"gw-vv-{p:g}": {"scheme": scheme, "lambda": p} for p in PREDICTIONS}
        else:
            found[scheme] = {"scheme": scheme}
    return found


def schemes(
    scenes: Mapping[str, Scene] | None = None, turns: int = TURNS, dt: float = DT,
    say: Callable[[str], None] = print,
) -> xr.Dataset:  # fmt: skip
    """Seconds per bead and step of each scheme.

    Parameters
    ----------
    scenes : dict of str to Scene
        Workloads, W1 and W2 if not given.
    turns : int
    dt : float
        Time step in tau.
    say : callable

    Returns
    -------
    xarray.Dataset
        NaN where a scheme blows up.
    """
    scenes = scenes or {name: workload(name) for name in ("W1", "W2")}
    starts, named = starts_of(scenes, say), labelled_schemes()
    wild = []
    cost = np.full((len(scenes), len(named), turns), np.nan)
    for w, (name, scene) in enumerate(scenes.items()):
        steps = max(1, round(SHARE * scene.steps.sample))
        running = {}
        for s, (label, integrator) in enumerate(named.items()):
            say(f"{name}: {label}")
            simulation = simulation_of(_with(scene, integrator, dt), starts[name])
            try:
                simulation.advance((turns + 1) * steps)  # stands what is to come, and compiles
            except Unstable as problem:
                say(f"{name}: {label}: {problem}")
                wild.append(f"{label} on {name}")
                continue
            running[s] = simulation.advance
        seconds = in_turns(list(running.values()), steps, turns)
        cost[w, list(running)] = seconds / (scene.beads * steps)
    variables = {
        "workload": (("workload",), list(scenes), "1", "workload"),
        "scheme": (("scheme",), list(named), "1", "scheme, and lambda of gw-vv"),
        "beads": (("workload",), [s.beads for s in scenes.values()], "1", "number of beads"),
        "cost": (("workload", "scheme", "turn"), cost, "s", "seconds per bead and step"),
    }
    description = f"every scheme from the same state, one thread, {turns} turns."
    if wild:
        description += f" Left out, as they blow up at that time step: {', '.join(wild)}."
    return labelled(variables, description)


def _with(scene, integrator, dt):
    """The scene with another scheme and step."""
    changed = {"dt": dt} | integrator
    return Scene(scene.data | {"integrator": changed}, scene.where)
