"""The run loop: steps between samples, observers, progress; and checkpoints to go on from.

A checkpoint is the state of a run and what its observers have, in a file of `numpy.savez`.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.state import State, System
from dpd.errors import LostRun, Stopped, UserError, reason
from dpd.files import draft_of

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation

LONGEST_CALL = 500  # steps between looks at the clock,
MOST_WORK = 20_000_000  # and bead-steps: two seconds of a large system


def run(
    simulation: Simulation, steps: tuple[int, int], observers: Sequence[Any],
    checkpoint: Checkpoint | None = None, progress: Callable[[int], object] | None = None,
    every_seconds: float = 60.0, stopping: Callable[[], int] | None = None,
    say: Callable[[str], object] | None = None,
    systems: Sequence[tuple[int, System]] = (),
) -> int:  # fmt: skip
    """Equilibrate, then sample; return the steps done by this call, fewer than all after a resume.

    An observer has ``every`` (steps between its samples), and ``arrays``, a dict of all that a
    checkpoint has of it. One with ``equilibration`` counts its steps from the beginning of the run.
    It has ``sample(simulation)``, for which the compiled loop ends; or ``record(sums)``, of
    `dpd.engine.state.Sums` that the loop adds up on its way, of one or more of its steps, and
    ``needs_forces`` says whether it reads virial or energy.

    ``steps`` are those to equilibrate and to sample; ``progress`` gets the number done so far. The
    checkpoint is read first, and saved every ``every_seconds`` of wall clock; where one is refused,
    or cannot be written, ``say`` gets a sentence. ``stopping`` gives the signal that asks to save
    and stop (`Stopped` is raised), or 0. ``systems`` are steps behind which the system is another
    one, the first of them 0; none if it stays.
    """
    equilibrate, sample = steps
    last = equilibrate + sample
    say = say or (lambda sentence: None)
    if checkpoint is not None:
        say(checkpoint.resume(simulation, observers))
    recorders = [each for each in observers if hasattr(each, "record")]
    lookers = [each for each in observers if not hasattr(each, "record")]
    length = call_length(max(1, simulation.state.identity.size // simulation.shares))
    begun = simulation.state.step
    saved, former = time.monotonic(), ""
    while (now := simulation.state.step) < last:
        samples = [next_sample(observer, now, equilibrate) for observer in lookers]
        # Looks at the clock are equally far apart after the last sample.
        sampled = [at - observer.every for observer, at in zip(lookers, samples)]
        since = now - max((step for step in sampled if step <= now), default=0)
        stop = min([now + length - since % length, last, *samples])
        while simulation.state.step < stop:
            end = _entered(simulation, systems, stop)
            advance_recording(simulation, end, recorders, equilibrate)
        for observer, at in zip(lookers, samples):
            if at == stop:
                observer.sample(simulation)
        if progress is not None:
            progress(stop)
        stop_now = stopping() if stopping is not None and stop < last else 0
        if checkpoint is not None and (stop_now or time.monotonic() - saved >= every_seconds):
            problem = checkpoint.save(simulation, observers)
            say(f"{problem}; going on" if problem not in ("", former) else "")  # once is enough
            saved, former = time.monotonic(), problem
        if stop_now:
            raise Stopped(f"stopped at step {stop} of {last}, as asked", stop_now)
    return last - begun


def _entered(simulation, systems, stop):
    """Let a simulation go on with the system of its step; how far that goes, at most to a stop."""
    now = simulation.state.step
    entered = [each for each in systems if each[0] <= now] or [(0, simulation.system)]
    *former, (step, system) = entered
    if system is not simulation.system:
        before = former[-1][1] if former and step == now else None
        simulation.go_on_with(system, anew=step == now, before=before)
    return min([stop, *(step for step, _ in systems if step > now)])


def advance_recording(
    simulation: Simulation, stop: int, recorders: Sequence[Any], equilibrate: int
) -> None:
    """Advance to a step; recorders get the sums of their steps, also before a run blows up."""
    now = simulation.state.step
    due = [
        np.arange(next_sample(each, now, equilibrate), stop + 1, each.every) for each in recorders
    ]
    steps = reduce(np.union1d, due, np.empty(0, np.int64))
    measure = any(each.needs_forces for each in recorders)
    try:
        sums = simulation.sample(stop - now, steps, measure)
    except LostRun as lost:
        if len(steps) and steps[0] < lost.step:
            advance_recording(simulation, lost.step - 1, recorders, equilibrate)
        raise
    for each, own in zip(recorders, due):
        if len(own):
            each.record(sums.of(np.isin(steps, own)))


def advance_looking(simulation: Simulation, steps: int, look: Callable[[], object]) -> None:
    """Advance by some steps, to the same bits, with a look a few times a second."""
    length = call_length(simulation.state.identity.size)
    while steps > length:
        simulation.advance(length)
        steps -= length
        look()
    simulation.advance(steps)


def call_length(beads: int) -> int:
    return max(1, min(LONGEST_CALL, MOST_WORK // beads))


def counts_from(observer: Any, equilibrate: int) -> int:
    """Step from which on the observer counts: 0 if it looks at the equilibration as well."""
    return 0 if getattr(observer, "equilibration", False) else equilibrate


def next_sample(observer: Any, now: int, equilibrate: int) -> int:
    first = counts_from(observer, equilibrate)
    return first + (max(now - first, 0) // observer.every + 1) * observer.every


# --- checkpoints

# What is no array: the first of the file, which tells it from any other; and the note.
MARK, NOTE = "dpd_checkpoint", "note"


class Stored(NamedTuple):
    """What stands in a `Checkpoint`."""

    key: dict[str, Any]
    note: dict[str, Any]
    arrays: dict[str, np.ndarray]


def stored_in(path: str | os.PathLike[str]) -> Stored | None:
    """What stands in a checkpoint; None where there is none, or a damaged one."""
    if not os.path.isfile(path):  # a pipe would let us wait
        return None
    try:
        with np.load(path) as file:  # which holds each array to its CRC
            arrays = dict(file)
        key, note = (json.loads(str(arrays.pop(name))) for name in (MARK, NOTE))
    except Exception:  # NumPy and zipfile have a dozen for files that are damaged
        return None
    return Stored(key, note or {}, arrays)


def refuse_other_file(path: str | Path) -> None:
    """Refuse to let a checkpoint take the place of what is no checkpoint, whole or damaged."""
    if not os.path.lexists(path):
        return
    try:
        if os.path.isfile(path):
            with open(path, "rb") as file:
                head = file.read(64)
            if not head or (head.startswith(b"PK") and MARK.encode() in head):
                return
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    raise UserError(
        f"{path}: the checkpoint of this run would take its place, and it is no checkpoint; move "
        "it away, or choose another name for the result"
    )


class Checkpoint:
    """State and observers' arrays in one file, written whole or not at all, with checksums.

    The key is what the run is, scene and code digests: a file with another one is ignored. The note
    is plain data.
    """

    def __init__(self, path: str | Path, key: dict[str, Any], note: Any = None) -> None:
        self.path, self.key, self.note = Path(path), key, note or {}
        self.is_ours = False  # whether the file is of this run: saved by it, or resumed from

    def save(self, simulation: Simulation, observers: Sequence[Any]) -> str:
        """Write the state; why it could not be, or nothing. A kill leaves the previous file."""
        for file in filter(None, map(file_of, observers)):
            file.flush()
        texts = {MARK: json.dumps(self.key, sort_keys=True), NOTE: json.dumps(self.note)}
        arrays = {name: np.array(text) for name, text in texts.items()}
        arrays |= arrays_of(simulation.state, observers)
        try:
            with draft_of(self.path) as draft, open(draft, "wb") as file:
                np.savez(file, **arrays)  # type: ignore[arg-type]  # no key is allow_pickle
            self.is_ours = True
        except OSError as problem:
            return f"{self.path}: no checkpoint could be written ({reason(problem)})"
        return ""

    def resume(self, simulation: Simulation, observers: Sequence[Any]) -> str:
        """Go on where the file left simulation and observers; why it is refused, or nothing."""
        if not os.path.lexists(self.path):
            return ""
        stored = stored_in(self.path)
        if stored is None:
            return f"{self.path}: a damaged checkpoint; starting anew"
        if stored.key != self.key:
            return f"{self.path}: a checkpoint of another scene or other sources; starting anew"
        held = stored.arrays
        for i, observer in enumerate(observers):  # those with files go on where these were
            if file := file_of(observer):
                frames, digests = int(held[f"{i}.frames"][0]), held.get(f"{i}.digests")
                if wrong := file.cut(frames, digests):
                    text = f"a checkpoint that cannot be right ({wrong})"
                    return f"{self.path}: {text}; starting anew"
        simulation.state = put_back(held, observers)
        self.is_ours = True
        return ""

    def discard(self) -> None:
        self.path.unlink(missing_ok=True)


def file_of(observer: Any) -> Any:
    """The file that an observer writes beside the result; None for one that writes none."""
    return getattr(observer, "file", None)


def arrays_of(state: State, observers: Sequence[Any]) -> dict[str, np.ndarray]:
    """All that a run consists of, by name: its state, and ``0.NAME`` of the first observer..."""
    arrays = {name: np.asarray(value) for name, value in vars(state).items() if value is not None}
    if state.slid is not None:
        arrays["slid"] = np.array(state.slid, np.uint64)
    for i, observer in enumerate(observers):
        arrays |= {f"{i}.{name}": array for name, array in observer.arrays.items()}
    return arrays


def put_back(
    stored: Mapping[str, np.ndarray], observers: Sequence[Any], equilibrate: int = 0
) -> State:
    """What `arrays_of` took apart: the state; observers are filled with what they had.

    A run planned longer has more room for series and levels of correlations, a shorter one enough.
    An observer that looks less often there, and not yet, begins anew.
    """
    found: dict[str, Any] = {each.name: stored.get(each.name) for each in fields(State)}
    for name, plain in (("step", int), ("slid", int), ("box", lambda box: tuple(map(float, box)))):
        found[name] = None if found[name] is None else plain(found[name])
    state = State(**found)
    for i, observer in enumerate(observers):
        if state.step - counts_from(observer, equilibrate) < observer.every:
            continue
        for name, array in observer.arrays.items():
            kept = stored[f"{i}.{name}"]
            room = min(len(array), len(kept))
            array[:room] = kept[:room]
    return state
