"""One run at a time on an output: the kernel's lock on a file beside it.

The kernel frees that lock when the process ends, however it ends. What stands in the file tells
others who is at work and how far, for `dpd status`. Between the machines of a cluster not every
file system passes locks on, so the owner also sets the time of the file every few seconds: a lock
of another machine whose time stands still for two minutes was left by a run that is no more.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
import threading
import time
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from filelock import FileLock, Timeout

from dpd.errors import UserError, reason, remedy
from dpd.files import TEMPORARY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

POLL = 1.0  # s between looks whether the other run has ended
SIGN = 10.0  # s between the owner's signs of life
SILENCE = 120.0  # s without a sign after which a run on another machine is no more
ROOM = 512  # bytes of a lock, always as many: one write replaces the former


class Worker(NamedTuple):
    """Who is at work on an output, or was; and the last report on how far, see `Lock.report`."""

    process: int
    host: str
    since: str
    alive: bool
    report: dict[str, Any]


class Lock:
    """A lock that is ours; ``left`` is the last report of a run that was killed here before."""

    def __init__(self, path: Path, left: dict[str, Any]) -> None:
        self.left, self._path, self._ended = left, path, threading.Event()
        self._has_begun = False
        self._owner = {
            "pid": os.getpid(), "host": socket.gethostname(),
            "since": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC",
        }  # fmt: skip
        _write(path, self._owner)
        self._signs = threading.Thread(target=self._give_signs, daemon=True)
        self._signs.start()

    def report(self, data: dict[str, Any]) -> None:
        """Tell others how far this run is; refuse to go on if one has taken it for dead."""
        self._has_begun = True
        with suppress(OSError):  # a disk that is full, or away for a moment: the run goes on
            self._check()
            _write(self._path, self._owner | data)

    def _check(self):
        there = _read(self._path)
        if there and any(there.get(key) != value for key, value in self._owner.items()):
            raise UserError(
                f"{self._path}: another run took this one for dead, for it gave no sign of life "
                f"for {SILENCE:g} s; it goes on there"
            )

    def _give_signs(self):
        while not self._ended.wait(SIGN):
            with suppress(OSError):
                os.utime(self._path)

    def end(self, refused: bool) -> None:
        """Remove the file, unless it has become another's.

        A run that was refused leaves there what one that was killed before had said.
        """
        self._ended.set()
        self._signs.join()
        with suppress(OSError, UserError):
            self._check()
            if refused and self.left and not self._has_begun:
                _write(self._path, self.left)
            else:
                self._path.unlink()


def lock_of(path: str | Path) -> Path:
    """Where the lock of an output lies."""
    return Path(path).with_name(Path(path).name + ".lock")


@contextmanager
def alone(path: str | Path, say: Callable[[str], None], wait: bool = False) -> Iterator[Lock]:
    """Be the only run at work on an output.

    Parameters
    ----------
    path : path
        Of the output.
    say : callable
        Called with a sentence where a lock is taken over or waited for.
    wait : bool
        Wait for the end of the other run instead of refusing.

    Raises
    ------
    UserError
        If another run is at work, or if there can be no lock.
    """
    place, said = lock_of(path), ""
    held = FileLock(place, fallback_to_soft=False)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        while busy := _take(held, place, say):
            if not wait:
                raise UserError(f"{path}: {busy}; wait for it, stop it, or choose another output")
            if busy != said:
                say(f"{path}: {busy}; waiting for it")
            said = busy
            time.sleep(POLL)
        TEMPORARY.add(place)
        ours = Lock(place, _read(place))
    except BaseException as problem:
        held.release()
        TEMPORARY.discard(place)
        if not isinstance(problem, OSError):
            raise
        raise UserError(
            f"{place}: cannot be written ({reason(problem)}); {remedy(problem, place.parent)}"
        ) from None
    refused = True
    try:
        yield ours
        refused = False
    finally:
        ours.end(refused)
        TEMPORARY.discard(place)
        held.release()


def _take(held: FileLock, place: Path, say: Callable[[str], None]) -> str:
    """Take a lock; who has it, if it cannot be taken."""
    knows = True  # whether this file system knows of locks
    try:
        held.acquire(blocking=False)
    except Timeout:
        owner = _read(place)
        return f"another run is at work on it ({_who(owner)})" if owner else "another run begins"
    except OSError as problem:
        if problem.errno != errno.ENOSYS:
            raise
        knows = False
    if not (owner := _read(place)):
        return ""
    elsewhere = owner["host"] != socket.gethostname()
    if elsewhere:
        say(f"{place}: left on another machine ({_who(owner)}); waiting {SILENCE:g} s for a sign")
    if _gives_signs(place) if elsewhere else not knows and _lives(owner["pid"]):
        held.release()
        return f"another run is at work on it ({_who(owner)})"
    say(f"{place}: left by a run that was killed ({_who(owner)}); taking over")
    return ""


def worker_on(path: str | Path) -> Worker | None:
    """Who is at work on an output; None where there is no lock.

    Raises
    ------
    UserError
        If the lock cannot be read, or is none.
    """
    place = lock_of(path)
    try:
        owner, silent = _read(place), time.time() - place.stat().st_mtime
    except FileNotFoundError:
        return None
    except OSError as problem:
        raise UserError(f"{place}: cannot be read ({reason(problem)})") from None
    if not owner:
        return None
    alive = silent < SILENCE
    if owner["host"] == socket.gethostname():
        alive = _lives(owner["pid"]) if (held := _is_held(place)) is None else held
    return Worker(owner["pid"], owner["host"], owner["since"], alive, owner)


def _who(owner):
    return f"process {owner['pid']} on {owner['host']}, begun {owner['since']}"


def _write(place, data):
    with open(place, "r+b", buffering=0) as file:
        file.write(json.dumps(data).ljust(ROOM).encode())


def _read(place):
    """What stands in a lock; nothing in one that was only just made."""
    try:
        with open(os.open(place, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            text = file.read(ROOM).strip()
        owner = json.loads(text) if text else {}
        if text and not {"pid", "host", "since"} <= owner.keys():
            raise ValueError
        return owner
    except (ValueError, AttributeError):
        raise UserError(
            f"{place}: not a lock of this program, which would put one there; move it away"
        ) from None


def _gives_signs(place):
    """Whether the time of a lock changes, or its owner ends; clocks of machines differ."""
    first, end = os.stat(place).st_mtime_ns, time.monotonic() + SILENCE
    while time.monotonic() < end:
        if not place.exists() or os.stat(place).st_mtime_ns != first:
            return True
        time.sleep(POLL)
    return False


def _is_held(place):
    """Whether a process has the kernel's lock; None where the file system does not know."""
    with open(place, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError as problem:
            return True if isinstance(problem, BlockingIOError) else None
    return False


def _lives(pid):
    with suppress(PermissionError):
        try:
            os.kill(pid, 0)
        except (ProcessLookupError, OverflowError):
            return False
    return True
