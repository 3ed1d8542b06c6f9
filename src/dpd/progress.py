"""Progress of long work: a bar at a terminal, plain lines in a log."""

from __future__ import annotations

import sys
import time

LINE_EVERY = 20.0  # seconds between lines in a log


class Progress:
    """Callable with the number of steps done; a context manager.

    Parameters
    ----------
    total : int
        Steps of the whole run; with none there is nothing to show.
    label : str
    """

    def __init__(self, total: int, label: str) -> None:
        self._total, self._label = total, label
        self._bar = None
        if total and sys.stderr.isatty():
            from tqdm import tqdm  # not imported by the hundreds of jobs without a terminal

            self._bar = tqdm(total=total, desc=label, unit="step", dynamic_ncols=True)
        self._last = time.monotonic()

    def __call__(self, done: int) -> None:
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        elif time.monotonic() - self._last >= LINE_EVERY:
            self._last = time.monotonic()
            share = done / self._total
            print(f"{self._label}: step {done} of {self._total} ({share:.0%})", file=sys.stderr)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.close()
