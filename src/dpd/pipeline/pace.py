"""How far a run is and how fast it goes, reported to whoever asks with `dpd status`."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from dpd.progress import Progress

EVERY = 5.0  # s between reports
REMEMBERED = 13  # reports that a rate comes from: the last minute, in which a machine may slow down
START, RUN = "start", "run"  # what a run is doing: its first configuration, or its steps

Report = Callable[[dict[str, Any]], None]


class Told(NamedTuple):
    """What a run reports.

    Attributes
    ----------
    doing : str
        `START` or `RUN`.
    step, steps : int
        Done, and in all.
    rate : float or None
        Steps per second of the last minute; None at first.
    time : float
        When that was so, as `time.time` has it.
    """

    doing: str
    step: int
    steps: int
    rate: float | None
    time: float


def told_by(data: dict[str, Any]) -> Told | None:
    """A report, from plain data; None where it is something else."""
    try:
        rate = None if data["rate"] is None else float(data["rate"])
        doing, step, steps = str(data["doing"]), int(data["step"]), int(data["steps"])
        return Told(doing, step, steps, rate, float(data["time"]))
    except (KeyError, TypeError, ValueError):
        return None


class _Mark(NamedTuple):
    """Steps that were done at a time in seconds."""

    time: float
    done: int


class Pace:
    """Progress that others see as well; called as `dpd.progress.Progress`, and a context like it.

    Parameters
    ----------
    progress : Progress
        Shows the same to the person who began the run.
    report : callable
        Called every few seconds with a `Told` as a dict.
    doing : str
    steps : int
        Of the whole.
    """

    def __init__(self, progress: Progress, report: Report, doing: str, steps: int) -> None:
        self._progress, self._report = progress, report
        self._doing, self._steps = doing, steps
        self._marks: deque[_Mark] = deque(maxlen=REMEMBERED)

    def __call__(self, done: int) -> None:
        self._progress(done)
        now = _Mark(time.monotonic(), done)
        if self._marks and now.time - self._marks[-1].time < EVERY:
            return
        rate = None
        if self._marks:
            first = self._marks[0]
            rate = (done - first.done) / (now.time - first.time)
        self._marks.append(now)
        self._report(Told(self._doing, done, self._steps, rate, time.time())._asdict())

    def __enter__(self) -> Pace:
        self._progress.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._progress.__exit__(*exception)
