"""What the measurements share: clocks in turns, starts, labelled numbers."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from dpd.engine.simulation import Simulation
from dpd.scene.start import start_digest
from dpd.start.common.make import make_start, system_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from dpd.engine.state import State
    from dpd.scene.scene import Scene

    Advance = Callable[[int], Any]  # of a number of steps; what it returns does not matter
    # Name to (dimensions, values, units, long_name).
    Variables = Mapping[str, tuple[tuple[str, ...], Any, str, str]]

TURNS = 5


def seconds_of(advance: Advance, steps: int) -> float:
    """Wall clock of one call."""
    begun = time.perf_counter()
    advance(steps)
    return time.perf_counter() - begun


def in_turns(advances: Sequence[Advance], steps: int | Sequence[int], turns: int) -> np.ndarray:
    """Wall clock of several calls, one after the other in every turn.

    A disturbance of the machine then falls on all of them alike.

    Parameters
    ----------
    advances : list of callable
        Each of a number of steps.
    steps : int or sequence of int
        That all take, or each.
    turns : int

    Returns
    -------
    (len(advances), turns) array
        Seconds.
    """
    taken = list(zip(advances, np.broadcast_to(steps, len(advances)).tolist()))
    return np.array([[seconds_of(*each) for each in taken] for _ in range(turns)]).T


def starts_of(scenes: Mapping[str, Scene], say: Callable[[str], None]) -> dict[str, State]:
    """First configurations of some scenes; those that share one get it made once.

    Parameters
    ----------
    scenes : dict of str to Scene
    say : callable
        Called with a sentence before each is made.

    Returns
    -------
    dict of str to State
    """
    made, starts = {}, {}
    for name, scene in scenes.items():
        digest = start_digest(scene)
        if digest not in made:
            say(f"{name}: first configuration of {scene.beads} beads")
            made[digest] = make_start(scene)
        starts[name] = made[digest]
    return starts


def simulation_of(scene: Scene, start: State, threads: int = 1) -> Simulation:
    """A simulation that leaves the start to others as it is."""
    return Simulation(system_of(scene), replace(start), threads)


def labelled(variables: Variables, description: str) -> xr.Dataset:
    """A dataset.

    Parameters
    ----------
    variables : dict
        Name to (dimensions, array, units, long_name).
    description : str
        One sentence for the caption: what was measured, and how.
    """
    data = xr.Dataset(attrs={"description": description})
    for name, (dimensions, values, units, long_name) in variables.items():
        data[name] = (dimensions, values, {"units": units, "long_name": long_name})
    return data
