"""What the measurements share: clocks in turns, starts, labelled numbers."""

from __future__ import annotations

import os
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import xarray as xr

from dpd.engine.simulation import Simulation
from dpd.start import start_digest
from dpd.start.common.make import make_start, system_of

TURNS = 5


def seconds_of(advance, steps):
    """Wall clock of one call."""
    begun = time.perf_counter()
    advance(steps)
    return time.perf_counter() - begun


def in_turns(advances, steps, turns):
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


@contextmanager
def on_one_core():
    """Stay on one core: rates scatter less than where the system moves the process."""
    usable = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(usable)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, usable)


def starts_of(scenes, say):
    """First configurations of scenes by name; those that share one get it made once."""
    made, starts = {}, {}
    for name, scene in scenes.items():
        digest = start_digest(scene)
        if digest not in made:
            say(f"{name}: first configuration of {scene.beads} beads")
            made[digest] = make_start(scene)
        starts[name] = made[digest]
    return starts


def simulation_of(scene, start, threads=1):
    """A simulation that leaves the start to others as it is."""
    return Simulation(system_of(scene), replace(start), threads)


def labelled(variables, description):
    """A dataset of (dimensions, array, units, long_name) by name; a sentence for captions."""
    data = xr.Dataset(attrs={"description": description})
    for name, (dimensions, values, units, long_name) in variables.items():
        data[name] = (dimensions, values, {"units": units, "long_name": long_name})
    return data
