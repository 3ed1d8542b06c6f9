"""Signals that ask a process to end: SIGTERM, Ctrl-C, and a terminal that is closed.

A run that can keep its state is only asked to stop; at any other moment, and at a second Ctrl-C,
the process ends at once. A thread of its own attends to that: Python looks at signals in its main
thread, which comes back from a kernel seconds later, and a KeyboardInterrupt that a kernel meets
comes out of it as another error.
"""

from __future__ import annotations

import os
import select
import signal
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from dpd.drafts import remove_temporary

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
TOGETHER = 0.5  # s within which two signals count as one: make and snakemake pass them on
PATIENCE = 2.0  # s after which a person is told that the run is about to stop


class _Asked:
    """What has come so far."""

    listening = False
    number = 0
    at = 0.0


def watch() -> None:
    """From now on attend to signals, but for those that the caller has ignored (as nohup does)."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda number, frame: None)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_attend, args=(read,), daemon=True).start()


@contextmanager
def listening() -> Iterator[None]:
    """While a run looks whether it is `asked` to stop."""
    _Asked.listening = True
    try:
        yield
    finally:
        _Asked.listening = False


def asked() -> int:
    """The number of the signal that asks to stop, or 0."""
    return _Asked.number


@contextmanager
def ctrl_c() -> Iterator[Callable[[], int]]:
    """While a run that was called from Python looks whether it is asked to stop.

    The first Ctrl-C asks for it, a second one does what it did before. Python tells its main thread
    alone of signals: nobody asks a run in another one.

    Yields
    ------
    callable
        Returns the number of the signal that asks to stop, or 0.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: 0
        return
    came = []
    former = signal.getsignal(signal.SIGINT)

    def ask(number, frame):
        signal.signal(signal.SIGINT, former)
        came.append(number)

    signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: came[0] if came else 0
    finally:
        signal.signal(signal.SIGINT, former)


def ask() -> None:
    """Ask a run to stop as SIGTERM does; nothing if none looks."""
    if _Asked.listening:
        _Asked.number, _Asked.at = signal.SIGTERM, time.monotonic()


def _attend(read):
    told = False
    while True:
        wait = PATIENCE if _Asked.number and not told else None
        if not select.select([read], [], [], wait)[0]:
            told = True
            if _Asked.listening:
                _tell("stopping after the steps under way; a second Ctrl-C ends at once")
            continue
        number = os.read(read, 1)[0]
        if _Asked.number:
            if number == signal.SIGINT and time.monotonic() - _Asked.at > TOGETHER:
                _end(number)
        elif _Asked.listening:
            _Asked.number, _Asked.at = number, time.monotonic()
        else:
            _end(number)


def _end(number):
    """End here and now, with nothing left that is half done."""
    remove_temporary()
    _tell("error: interrupted")
    os._exit(128 + number)


def _tell(sentence):
    """To the terminal, unless that would make us wait."""
    try:
        if select.select([], [2], [], 0)[1]:
            os.write(2, f"{sentence}\n".encode())
    except OSError:
        pass
