"""The run loop: steps between samples, observers, checkpoints, progress."""

import json
import os
import time
import zlib
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from dpd.engine.simulation import State
from dpd.errors import UserError

LONGEST_STRETCH = 500  # steps between looks at the clock


class Stopped(UserError):
    """A run that was asked to stop, with its state kept."""


def run(
    simulation, steps, observers, checkpoint=None, progress=None, every_seconds=60.0,
    stopping=None, say=None,
):  # fmt: skip
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
    every_seconds : float
    stopping : callable or None
        Whether to save and stop, asked a few times a second on small systems.
    say : callable or None
        Called with a sentence where a person should know: a checkpoint that is refused, or
        that cannot be written.

    Returns
    -------
    int
        Steps done by this call: less than all of them after a resume.

    Raises
    ------
    Stopped
        If ``stopping`` says so, after saving the state.
    """
    equilibrate, sample = steps
    last = equilibrate + sample
    say = say or (lambda sentence: None)
    if checkpoint is not None:
        say(checkpoint.resume(simulation, observers))
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
        stop_now = stopping is not None and stopping()
        if checkpoint is not None and (stop_now or time.monotonic() - saved >= every_seconds):
            say(checkpoint.save(simulation, observers))
            saved = time.monotonic()
        if stop_now:
            raise Stopped(f"stopped at step {stop} of {last}, as asked")
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
        """Write the state; a kill while writing leaves the previous file.

        Returns
        -------
        str
            Why it could not be written, or nothing.
        """
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
        draft = self.path.with_name(self.path.name + ".writing")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with open(draft, "wb") as file:
                np.savez(file, **arrays)
            os.replace(draft, self.path)
        except OSError as problem:
            draft.unlink(missing_ok=True)
            return f"{self.path}: no checkpoint could be written ({problem.strerror}); going on"
        return ""

    def resume(self, simulation, observers):
        """Put simulation and observers where the file left them, wholly or not at all.

        Returns
        -------
        str
            Why the file is refused, or nothing.
        """
        if not self.path.exists():
            return ""
        try:
            with np.load(self.path) as file:
                stored = dict(file)
            key = str(stored["key"])
        except (OSError, ValueError, EOFError, KeyError, BadZipFile, zlib.error):
            return f"{self.path}: a damaged checkpoint; starting anew"
        if key != self.key:
            return f"{self.path}: a checkpoint of another scene or other sources; starting anew"
        kept = {f"{i}/{n}": a for i, o in enumerate(observers) for n, a in o.arrays.items()}
        wanted = {"step", "position", "velocity", "force", "identity", *kept}
        shapes = all(name in stored and stored[name].shape == kept[name].shape for name in kept)
        if not wanted <= stored.keys() or not shapes:
            return f"{self.path}: a checkpoint with parts missing; starting anew"
        simulation.state = State(
            stored["position"],
            stored["velocity"],
            stored["force"],
            stored["identity"],
            stored.get("species"),
            int(stored["step"]),
            stored.get("reference"),
        )
        for name, array in kept.items():
            array[...] = stored[name]
        return ""

    def discard(self):
        """Remove the file once the run's result is written."""
        self.path.unlink(missing_ok=True)
