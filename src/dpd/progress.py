"""Progress of long work: a bar at a terminal, plain lines in a log; and reported to a lock."""

from __future__ import annotations

import sys
import time
import warnings
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from typing import Protocol

    class Lock(Protocol):
        """What hears how far a run is, see `dpd.runs.lock.Lock`."""

        def report(self, data: dict[str, Any]) -> None: ...


LINE_EVERY = 20.0  # seconds between lines in a log
REPORT_EVERY = 5.0  # seconds between reports
REMEMBERED = 13  # reports that a rate comes from: the last minute, in which a machine may slow down


class _Mark(NamedTuple):
    """Steps that were done at a time in seconds."""

    time: float
    done: int


class Progress:
    """Callable with the number of steps done; a context manager.

    Parameters
    ----------
    total : int
        Steps of the whole run; with none there is nothing to show.
    label : str
    bar : bool, optional
        Whether to show a bar. If not given: at a terminal and in a notebook, and elsewhere lines.
    lock : optional
        Told every few seconds what the run is ``doing`` (its ``start``, or the ``run``), with
        ``step``, ``steps``, ``rate`` in steps per second and ``time``.
    doing : str
    """

    def __init__(
        self, total: int, label: str, bar: bool | None = None, lock: Lock | None = None,
        doing: str = "run",
    ) -> None:  # fmt: skip
        self._total, self._label, self._lock, self._doing = total, label, lock, doing
        self._bar = None
        # A program without a terminal, or a script, may have none, or have closed it.
        self._silent = bar is False or sys.stderr is None or getattr(sys.stderr, "closed", False)
        if total and not self._silent and (_for_people() if bar is None else bar):
            self._bar = _bar(total=total, desc=label, unit="step", dynamic_ncols=True)
        self._last = time.monotonic()
        self._marks: deque[_Mark] = deque(maxlen=REMEMBERED)

    def __call__(self, done: int) -> None:
        now = _Mark(time.monotonic(), done)
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        elif not self._silent and now.time - self._last >= LINE_EVERY:
            self._last = now.time
            share = done / self._total
            with suppress(OSError):  # nobody reads it any more
                print(f"{self._label}: step {done} of {self._total} ({share:.0%})", file=sys.stderr)
        if self._lock is not None:
            self._report(now)

    def _report(self, now):
        is_early = self._marks and now.time - self._marks[-1].time < REPORT_EVERY
        if is_early and now.done < self._total:
            return
        first = self._marks[0] if self._marks else now
        rate = (now.done - first.done) / (now.time - first.time) if now.time > first.time else None
        self._marks.append(now)
        report = {"doing": self._doing, "step": now.done, "steps": self._total, "rate": rate}
        self._lock.report(report | {"time": time.time()})

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.close()


def _for_people() -> bool:
    """Whether somebody sees a bar as it moves."""
    return sys.stderr.isatty() or _in_notebook()


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def _bar(**settings):
    """A bar of tqdm, which the hundreds of jobs without a terminal do not import."""
    with warnings.catch_warnings():  # that bars in notebooks are an experiment
        warnings.simplefilter("ignore")
        if _in_notebook():
            from tqdm.autonotebook import tqdm
        else:
            from tqdm import tqdm
        return tqdm(**settings)
