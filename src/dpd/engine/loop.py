"""The run loop: steps between samples, observers, checkpoints, progress."""

from __future__ import annotations

import time
from functools import reduce
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from dpd.errors import LostRun, Stopped

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from dpd.engine.checkpoint import Checkpoint
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System

    class Observer(Protocol):
        """What `run` needs of an observer, see there."""

        @property
        def every(self) -> int: ...

        @property
        def arrays(self) -> dict[str, np.ndarray]: ...

    class Recorder(Observer, Protocol):
        """What it needs of one that takes sums."""

        @property
        def needs_forces(self) -> bool: ...

        def record(self, sums: Sums) -> None: ...


LONGEST_CALL = 500  # steps between looks at the clock,
MOST_WORK = 20_000_000  # and bead-steps: two seconds of a large system


def run(
    simulation: Simulation, steps: tuple[int, int], observers: Sequence[Observer],
    checkpoint: Checkpoint | None = None, progress: Callable[[int], object] | None = None,
    every_seconds: float = 60.0, stopping: Callable[[], int] | None = None,
    say: Callable[[str], object] | None = None,
    systems: Sequence[tuple[int, System]] = (),
) -> int:  # fmt: skip
    """Equilibrate, then sample; return the steps done by this call, fewer than all after a resume.

    An observer has ``every`` (steps between its samples), and ``arrays``, a dict of the arrays that
    it fills, which is all that a checkpoint has of it. One with ``equilibration`` counts its
    steps from the beginning of the run. It looks at a configuration with ``sample(simulation)``,
    for which the compiled loop ends; or it takes sums over beads and pairs, which the loop adds up
    on its way: ``record(sums)``, with `dpd.engine.state.Sums` of one or more of its steps;
    ``needs_forces`` says whether it reads virial or energy.

    ``steps`` are those to equilibrate and to sample, and ``progress`` gets the number done so far.
    The checkpoint is read first if it is there, and saved every ``every_seconds`` of wall clock;
    where one is refused, or cannot be written, ``say`` gets a sentence. ``stopping`` gives the
    signal that asks to save and stop (`Stopped` is raised), or 0. ``systems`` are steps behind
    which the system is another one, the first of them 0; none if it stays.
    """
    equilibrate, sample = steps
    last = equilibrate + sample
    say = say or (lambda sentence: None)
    if checkpoint is not None:
        say(checkpoint.resume(simulation, observers))
    recorders: Any = [each for each in observers if hasattr(each, "record")]
    lookers: Any = [each for each in observers if not hasattr(each, "record")]
    beads = simulation.state.identity.size
    begun = simulation.state.step
    saved, former = time.monotonic(), ""
    while (now := simulation.state.step) < last:
        samples = [next_sample(observer, now, equilibrate) for observer in lookers]
        stop = min([next_look(now, lookers, equilibrate, beads), last, *samples])
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
    for step, system in [each for each in systems if each[0] <= now][-1:]:
        if system is not simulation.system:
            simulation.go_on_with(system, anew=step == now)
    return min([stop, *(step for step, _ in systems if step > now)])


def advance_recording(
    simulation: Simulation, stop: int, recorders: Sequence[Recorder], equilibrate: int
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
    """Steps between looks at the clock."""
    return max(1, min(LONGEST_CALL, MOST_WORK // beads))


def counts_from(observer: Any, equilibrate: int) -> int:
    """Step from which on the observer counts: 0 if it looks at the equilibration as well."""
    return 0 if getattr(observer, "equilibration", False) else equilibrate


def next_sample(observer: Observer, now: int, equilibrate: int) -> int:
    """Step of the observer's next sample after ``now``."""
    first = counts_from(observer, equilibrate)
    return first + (max(now - first, 0) // observer.every + 1) * observer.every


def next_look(now: int, observers: Sequence[Any], equilibrate: int, beads: int) -> int:
    """The next step at which the clock is looked at: equally far apart after the last sample."""
    sampled = [next_sample(each, now, equilibrate) - each.every for each in observers]
    last, length = max((step for step in sampled if step <= now), default=0), call_length(beads)
    return now + length - (now - last) % length
