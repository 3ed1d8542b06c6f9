"""One run at a time on an output: a lease on a file beside it, and a report of how far the run is.

The owner of a lease renews it every few seconds. It is taken over from a process that is no more on
this machine, and from one that has not renewed it for two minutes on another machine of a cluster.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from filelock import SoftFileLease, Timeout

from dpd.errors import UserError, reason, remedy
from dpd.files import TEMPORARY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

POLL = 1.0  # s between looks whether the other run has ended
SIGN = 10.0  # s between the owner's signs of life
SILENCE = 120.0  # s without a sign after which a run on another machine is no more
ROOM = 512  # bytes of a report, always as many: one write replaces the former


class Worker(NamedTuple):
    """Who is at work on an output, or was; and the last report on how far, see `Lock.report`."""

    process: int
    host: str
    alive: bool
    report: dict[str, Any]


class Lock:
    """A lease that is ours; ``left`` is the last report of a run that was killed here before."""

    def __init__(self, lease: SoftFileLease, progress: Path) -> None:
        self.left, self.has_begun = _report(progress), False
        self._lease, self._progress = lease, progress

    def report(self, data: dict[str, Any]) -> None:
        """Tell others how far this run is; refuse to go on if one has taken it for dead."""
        if self._lease.compromise:
            raise UserError(
                f"{self._lease.lock_file}: another run took this one for dead, for it gave no sign "
                f"of life for {SILENCE:g} s; it goes on there"
            )
        self.has_begun = True
        TEMPORARY.add(self._progress)
        with suppress(OSError):  # a disk that is full, or away for a moment: the run goes on
            place = os.open(self._progress, os.O_WRONLY | os.O_CREAT, 0o666)
            with open(place, "wb", buffering=0) as file:  # in one piece, for who reads it
                file.write(json.dumps(data).ljust(ROOM).encode())

    def end(self, refused: bool) -> None:
        """Let others in; a run that was refused leaves what a killed one had reported."""
        if not self._lease.compromise and (self.has_begun or not refused):
            self._progress.unlink(missing_ok=True)
        self._lease.release()


def lock_of(path: str | Path) -> Path:
    """Where the lock of an output lies."""
    return Path(path).with_name(Path(path).name + ".lock")


def _progress_of(path):
    return Path(path).with_name(Path(path).name + ".progress")


def _lease(path):
    return SoftFileLease(
        lock_of(path), lease_duration=SILENCE, heartbeat_interval=SIGN, thread_local=False,
        is_singleton=False,
    )  # fmt: skip


@contextmanager
def alone(path: str | Path, say: Callable[[str], None], wait: bool = False) -> Iterator[Lock]:
    """Be the only run at work on an output; ``wait`` for the other one instead of refusing.

    ``say`` is called where a lock is taken over or waited for. Raises `UserError` if another run is
    at work, or if there can be no lock.
    """
    place, lease = lock_of(path), _lease(path)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        _take(lease, path, say, wait)
    except BaseException as problem:
        lease.release()
        TEMPORARY.discard(place)
        if not isinstance(problem, OSError):
            raise
        raise UserError(
            f"{place}: cannot be written ({reason(problem)}); {remedy(problem, place.parent)}"
        ) from None
    lock, refused = Lock(lease, _progress_of(path)), True
    try:
        yield lock
        refused = False
    finally:
        lock.end(refused)
        TEMPORARY.difference_update((place, _progress_of(path)))


def _take(lease: SoftFileLease, path: str | Path, say: Callable[[str], None], wait: bool) -> None:
    """Take a lease, if need be from a run that is no more."""
    said, signs = "", set()
    while True:
        owner = _owner(lease)
        who = f"process {owner.pid} on {owner.hostname}" if owner else ""
        if _taken(lease):
            if owner:
                say(f"{lease.lock_file}: left by a run that was killed ({who}); taking over")
            return
        with suppress(FileNotFoundError):  # it has just ended
            signs.add(os.stat(lease.lock_file).st_mtime_ns)
        silent = owner and owner.hostname != socket.gethostname() and len(signs) < 2
        busy = f"another run is at work on it ({who})"
        if not who:  # this moment, or it was killed in it
            busy = (
                f"another run begins (if there is none, remove {lease.lock_file}, which is empty)"
            )
        if silent:
            busy = f"left on another machine ({who}); waiting {SILENCE:g} s for a sign"
        elif not wait:
            raise UserError(f"{path}: {busy}; wait for it, stop it, or choose another output")
        if busy != said:
            say(f"{path}: {busy}{'' if silent else '; waiting for it'}")
        said = busy
        time.sleep(POLL)


def _taken(lease):
    """Whether the lease is ours now; a signal waits until that is known, and leaves no lock."""
    came: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if is_main else ()
    former = {n: was for n in numbers if callable(was := signal.getsignal(n))}
    try:
        for number in former:
            signal.signal(number, lambda number, frame: came.append(number))
        lease.acquire(blocking=False)
        TEMPORARY.add(Path(lease.lock_file))
    except Timeout:
        return False
    finally:
        for number, was in former.items():
            signal.signal(number, was)
        for number in came:
            signal.raise_signal(number)
    return True


def _owner(lease):
    """Who has a lease, or had it; None where there is no file, or one that was only just made."""
    place, owner = lease.lock_file, lease.owner
    if owner is None and os.path.lexists(place) and os.lstat(place).st_size > 0:
        raise UserError(
            f"{place}: not a lock of this program, which would put one there; move it away"
        )
    return owner


def worker_on(path: str | Path) -> Worker | None:
    """Who is at work on an output; None where there is no lock, `UserError` if it is none."""
    try:
        owner = _owner(_lease(path))
        alive = time.time() - lock_of(path).stat().st_mtime < SILENCE
    except FileNotFoundError:
        return None
    if owner is None:
        return None
    if owner.hostname == socket.gethostname():
        alive = alive and os.path.exists(f"/proc/{owner.pid}")
    return Worker(owner.pid, owner.hostname, alive, _report(_progress_of(path)))


def _report(place):
    with suppress(OSError, ValueError):
        return dict(json.loads(place.read_text()))
    return {}
