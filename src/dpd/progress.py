"""Progress of long work: a bar at a terminal, plain lines in a log; and reported to a lock."""

from __future__ import annotations

import sys
import time
import warnings
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from typing import Self

LINE_EVERY = 20.0  # seconds between lines in a log
REPORT_EVERY = 5.0  # seconds between reports
REMEMBERED = 13  # reports that a rate comes from: the last minute, in which a machine may slow down


class Listener(Protocol):
    """What hears how far a run is, as `dpd.runs.lock.Lock`."""

    def report(self, data: dict[str, Any]) -> None:
        """Called every few seconds with what the run is ``doing`` (its ``start``, or the ``run``),
        ``step``, ``steps``, ``rate`` in steps per second and ``time``."""


class Progress:
    """Callable with the number of steps done out of a ``total``; a context manager.

    ``bar``: whether to show one; if not given, at a terminal and in a notebook, elsewhere lines.
    """

    def __init__(
        self, total: int, label: str, bar: bool | None = None, lock: Listener | None = None,
        doing: str = "run",
    ) -> None:  # fmt: skip
        self._total, self._label, self._lock, self._doing = total, label, lock, doing
        # A program without a terminal, or a script, may have none, or have closed it.
        self._silent = bar is False or sys.stderr is None or getattr(sys.stderr, "closed", False)
        self._bar = None
        notebook = "ipykernel" in sys.modules
        if total and not self._silent and (bar or notebook or sys.stderr.isatty()):
            with warnings.catch_warnings():  # that bars in notebooks are an experiment
                warnings.simplefilter("ignore")
                from tqdm.auto import tqdm  # which hundreds of jobs without a terminal do not need

                self._bar = tqdm(total=total, desc=label, unit="step", dynamic_ncols=True)
        self._last = time.monotonic()
        self._marks: deque[tuple[float, int]] = deque(maxlen=REMEMBERED)

    def __call__(self, done: int) -> None:
        now = time.monotonic()
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        elif not self._silent and now - self._last >= LINE_EVERY:
            self._last = now
            text = f"{self._label}: step {done} of {self._total} ({done / self._total:.0%})"
            with suppress(OSError):  # nobody reads it any more
                print(text, file=sys.stderr)
        early = self._marks and now - self._marks[-1][0] < REPORT_EVERY and done < self._total
        if self._lock is not None and not early:
            before, first = self._marks[0] if self._marks else (now, done)
            self._marks.append((now, done))
            rate = (done - first) / (now - before) if now > before else None
            report = {"doing": self._doing, "step": done, "steps": self._total, "rate": rate}
            self._lock.report(report | {"time": time.time()})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.close()
