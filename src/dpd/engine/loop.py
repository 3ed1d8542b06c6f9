"""The run loop: steps between samples, observers, checkpoints, progress."""

import json
import os
import time
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from dpd.engine.simulation import State

LONGEST_STRETCH = 500  # steps between looks at the clock


def run(simulation, steps, observers, checkpoint=None, progress=None, every_seconds=60.0):
    """Equilibrate, then sample.

    An observer has ``every`` (steps between its samples), ``needs_forces`` (whether it
    reads virial or energy), ``sample(simulation, sums)``, and ``arrays``, a dict of the
    arrays that it fills, which is all that a checkpoint keeps of it.

    Parameters
    ----------
    simulation : Simulation
    steps : (int, int)
        To equilibrate, to sample.
    observers : list
    checkpoint : Checkpoint or None
        Saved every ``every_seconds`` of wall clock; read first if it is there.
    progress : callable or None
        Called with the number of steps done so far.

    Returns
    -------
    int
        Steps done by this call: less than all of them after a resume.
    """
    equilibrate, sample = steps
    last = equilibrate + sample
    if checkpoint is not None:
        checkpoint.resume(simulation, observers)
    begun = simulation.state.step
    saved = time.monotonic()
    while (now := simulation.state.step) < last:
        stop = min([now + LONGEST_STRETCH, last, *(_next(o, now, equilibrate) for o in observers)])
        due = [o for o in observers if stop > equilibrate and (stop - equilibrate) % o.every == 0]
        sums = simulation.advance(stop - now, measure=any(o.needs_forces for o in due))
        for observer in due:
            observer.sample(simulation, sums)
        if progress is not None:
            progress(stop)
        if checkpoint is not None and time.monotonic() - saved >= every_seconds:
            checkpoint.save(simulation, observers)
            saved = time.monotonic()
    return last - begun


def _next(observer, now, equilibrate):
    """Step of the observer's next sample after ``now``."""
    done = max(now - equilibrate, 0) // observer.every
    return equilibrate + (done + 1) * observer.every


class Checkpoint:
    """State and observers' arrays in one file, written whole or not at all.

    Parameters
    ----------
    path : path
    key : dict
        What the run is: scene and code digests. A file with another key is ignored.
    """

    def __init__(self, path, key):
        self.path = Path(path)
        self.key = json.dumps(key, sort_keys=True)

    def save(self, simulation, observers):
        """Write the state; a kill while writing leaves the previous file."""
        state = simulation.state
        arrays = {
            "key": np.array(self.key),
            "step": np.array(state.step),
            "position": state.position,
            "velocity": state.velocity,
            "force": state.force,
            "identity": state.identity,
        }
        for name in ("species", "reference"):
            if getattr(state, name) is not None:
                arrays[name] = getattr(state, name)
        for i, observer in enumerate(observers):
            arrays |= {f"{i}/{name}": array for name, array in observer.arrays.items()}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        draft = self.path.with_name(self.path.name + ".writing")
        with open(draft, "wb") as file:
            np.savez(file, **arrays)
        os.replace(draft, self.path)

    def resume(self, simulation, observers):
        """Put simulation and observers where the file left them.

        Without a file, with one of another run, or with a damaged one, do nothing.
        """
        try:
            with np.load(self.path) as file:
                stored = dict(file)
        except (OSError, ValueError, EOFError, BadZipFile):
            return
        if str(stored.get("key")) == self.key:
            self._restore(stored, simulation, observers)

    def _restore(self, stored, simulation, observers):
        simulation.state = State(
            stored["position"],
            stored["velocity"],
            stored["force"],
            stored["identity"],
            stored.get("species"),
            int(stored["step"]),
            stored.get("reference"),
        )
        for i, observer in enumerate(observers):
            for name, array in observer.arrays.items():
                array[...] = stored[f"{i}/{name}"]

    def discard(self):
        """Remove the file once the run's result is written."""
        self.path.unlink(missing_ok=True)
