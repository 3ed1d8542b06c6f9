"""Progress of long work: a bar at a terminal, plain lines in a log."""

from __future__ import annotations

import sys
import time
import warnings

LINE_EVERY = 20.0  # seconds between lines in a log


class Progress:
    """Callable with the number of steps done; a context manager.

    Parameters
    ----------
    total : int
        Steps of the whole run; with none there is nothing to show.
    label : str
    bar : bool, optional
        Whether to show a bar. If not given: at a terminal and in a notebook, and elsewhere lines.
    """

    def __init__(self, total: int, label: str, bar: bool | None = None) -> None:
        self._total, self._label = total, label
        self._bar = None
        # A program without a terminal, or a script, may have none, or have closed it.
        self._silent = bar is False or sys.stderr is None or getattr(sys.stderr, "closed", False)
        if total and not self._silent and (_for_people() if bar is None else bar):
            self._bar = _bar(total=total, desc=label, unit="step", dynamic_ncols=True)
        self._last = time.monotonic()

    def __call__(self, done: int) -> None:
        if self._bar is not None:
            self._bar.update(done - self._bar.n)
        elif not self._silent and time.monotonic() - self._last >= LINE_EVERY:
            self._last = time.monotonic()
            share = done / self._total
            print(f"{self._label}: step {done} of {self._total} ({share:.0%})", file=sys.stderr)

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
