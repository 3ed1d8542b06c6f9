"""The run loop: steps between samples, observers, checkpoints, progress."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

from dpd.engine.checkpoint import next_look, next_sample, stretch_of
from dpd.errors import Stopped

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np

    from dpd.engine.checkpoint import Checkpoint
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums

    class Observer(Protocol):
        """What `run` needs of an observer, see there."""

        @property
        def every(self) -> int: ...

        @property
        def needs_forces(self) -> bool: ...

        @property
        def arrays(self) -> dict[str, np.ndarray]: ...

        def sample(self, simulation: Simulation, sums: Sums) -> None: ...


def run(
    simulation: Simulation, steps: tuple[int, int], observers: Sequence[Observer],
    checkpoint: Checkpoint | None = None, progress: Callable[[int], object] | None = None,
    every_seconds: float = 60.0, stopping: Callable[[], bool] | None = None,
    say: Callable[[str], object] | None = None,
) -> int:  # fmt: skip
    """Equilibrate, then sample.

    An observer has ``every`` (steps between its samples), ``needs_forces`` (whether it
    reads virial or energy), ``sample(simulation, sums)``, and ``arrays``, a dict of the
    arrays that it fills, which is all that a checkpoint keeps of it. One with ``equilibration``
    counts its steps from the beginning of the run.

    Parameters
    ----------
    simulation : Simulation
    steps : (int, int)
        To equilibrate, to sample.
    observers : list
    checkpoint : dpd.engine.checkpoint.Checkpoint or None
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
        say(checkpoint.resume(simulation, observers, steps))
    beads = simulation.state.identity.size
    begun = simulation.state.step
    saved, former = time.monotonic(), ""
    while (now := simulation.state.step) < last:
        samples = [next_sample(observer, now, equilibrate) for observer in observers]
        stop = min([next_look(now, observers, equilibrate, beads), last, *samples])
        due = [observer for observer, at in zip(observers, samples) if at == stop]
        sums = simulation.advance(stop - now, measure=any(o.needs_forces for o in due))
        for observer in due:
            observer.sample(simulation, sums)
        if progress is not None:
            progress(stop)
        stop_now = stop < last and stopping is not None and stopping()
        if checkpoint is not None and (stop_now or time.monotonic() - saved >= every_seconds):
            problem = checkpoint.save(simulation, observers)
            say(f"{problem}; going on" if problem not in ("", former) else "")  # once is enough
            saved, former = time.monotonic(), problem
        if stop_now:
            raise Stopped(f"stopped at step {stop} of {last}, as asked")
    return last - begun


def advance_looking(
    simulation: Simulation, steps: int, look: Callable[[], object], measure: bool = False
) -> Sums:
    """Advance by some steps, to the same bits, with a look now and then.

    Parameters
    ----------
    simulation : Simulation
    steps : int
    look : callable
        Called between stretches of steps, a few times a second on small systems; it may raise
        something to end that.
    measure : bool
        See `dpd.engine.simulation.Simulation.advance`, also for what is returned.
    """
    stretch = stretch_of(simulation.state.identity.size)
    while steps > stretch:
        simulation.advance(stretch)
        steps -= stretch
        look()
    return simulation.advance(steps, measure)
