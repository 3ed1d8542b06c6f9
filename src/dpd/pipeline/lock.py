"""One run at a time on an output: a lock that says who is at work.

The lock is a file beside the output. The system's own lock on that file (flock) ends with the
process, however it ends; what stands in the file tells others who it was. That is its first line;
in the second one the owner reports how far it is, for `dpd status`; in the third stands how far
one had come that was killed before. Between the machines of
a cluster not every file system passes on such locks, and none says what became of a process. So
the owner also gives a sign of life: every few seconds it sets the time of the file. A lock from
another machine that is without a sign for two minutes was left by a run that is no more.
"""

from __future__ import annotations

import fcntl
import json
import os
import socket
import threading
import time
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.drafts import TEMPORARY
from dpd.errors import UserError, reason, remedy
from dpd.interrupts import ask

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from dpd.pipeline.pace import Report

POLL = 1.0  # s between looks whether the other run has ended
SIGN = 10.0  # s between the owner's signs of life
SILENCE = 120.0  # s without a sign after which a run on another machine is no more
LONGEST = 4096  # bytes of a lock
ROOM = 256  # bytes of a report: always as many, so that one write replaces the former
LARGEST_PID = 2**31 - 1
ENDED = ("Z", "X")  # states of a process that is over, and whose parent has not asked after it
BOOT = Path("/proc/sys/kernel/random/boot_id")


class _Busy(Exception):
    """Somebody is at work; the text says who."""


class _Doubtful(Exception):
    """The lock is of a run on another machine, which may be no more; the text says whose."""


class _Watch:
    """What is seen of a lock by one who waits: times of its file, compared with each other alone.

    Clocks of machines differ.

    Attributes
    ----------
    alive : bool
        The owner has given a sign since we look, and lately.
    silent : bool
        It has given none for so long that it is no more.
    """

    def __init__(self):
        self.alive = self.silent = False
        self._last, self._since = None, 0.0

    def look(self, handle):
        """Look at the lock."""
        time_of_file, now = os.fstat(handle).st_mtime_ns, time.monotonic()
        if time_of_file != self._last:
            self.alive = self._last is not None
            self._last, self._since = time_of_file, now
        self.silent = now - self._since >= SILENCE
        self.alive = self.alive and not self.silent


class Worker(NamedTuple):
    """Who is at work on an output, or was, as its lock says.

    Attributes
    ----------
    process : int
    host : str
    since : str
    alive : bool
        Whether the process is there; of one on another machine, whether it gave a sign of life
        within the last two minutes.
    told : dict
        How far it is, see `dpd.pipeline.pace.told_by`; nothing where it has not said so.
    """

    process: int
    host: str
    since: str
    alive: bool
    told: dict[str, Any]


def lock_of(path: str | Path) -> Path:
    """Where the lock of an output lies."""
    return Path(path).with_name(Path(path).name + ".lock")


def worker_on(path: str | Path) -> Worker | None:
    """Who is at work on an output, without disturbing anybody: no lock is taken.

    Parameters
    ----------
    path : path
        Of the output, which need not be there.

    Returns
    -------
    Worker or None
        None where there is no lock, or one that is being written.

    Raises
    ------
    UserError
        If the lock cannot be read, or is none.
    """
    lock = lock_of(path)
    try:
        handle = os.open(lock, os.O_RDONLY | os.O_NONBLOCK)
    except FileNotFoundError:
        return None
    except OSError as problem:
        raise UserError(f"{lock}: cannot be read ({reason(problem)})") from None
    try:
        owner, second = _owner(handle, lock), _line(handle, 1)
        sign = os.fstat(handle).st_mtime
    except OSError as problem:
        raise UserError(f"{lock}: cannot be read ({reason(problem)})") from None
    finally:
        os.close(handle)
    if owner is None:
        return None
    if owner["host"] == socket.gethostname():
        alive = owner["boot"] == _boot() and _lives(owner)
    else:
        alive = time.time() - sign < SILENCE
    return Worker(owner["pid"], owner["host"], owner["since"], alive, _told(second))


def told_before(path: str | Path) -> dict[str, Any]:
    """What a run on an output had reported that was killed before ours; nothing if none was."""
    lines = lock_of(path).read_bytes().split(b"\n")
    return _told(lines[2])


def _told(line):
    """What a line of a lock says; nothing for one that is empty, or being written."""
    try:
        told = json.loads(line)
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}


@contextmanager
def alone(path: str | Path, say: Callable[[str], None], wait: bool = False) -> Iterator[Report]:
    """Be the only run at work on an output.

    Parameters
    ----------
    path : path
        Of the output.
    say : callable
        Called with a sentence where a lock is taken over or waited for.
    wait : bool
        Wait for the end of the other run instead of refusing.

    Yields
    ------
    callable
        Called with plain data it writes into the lock how far this run is, see `worker_on`.

    Raises
    ------
    UserError
        If another run is at work, or if there can be no lock.
    """
    lock = lock_of(path)
    watch, said = _Watch(), None
    while True:
        try:
            handle, left = _take(lock, watch, say)
            break
        except _Busy as who:
            if not wait:
                raise UserError(
                    f"{path}: {who}; wait for it, stop it, or choose another output"
                ) from None
            sentence = f"{path}: {who}; waiting for it"
        except _Doubtful as who:
            sentence = f"{lock}: {who}; waiting {SILENCE:g} s for a sign that it is at work"
        except OSError as problem:
            raise UserError(
                f"{lock}: cannot be written ({reason(problem)}); {remedy(problem, lock.parent)}"
            ) from None
        if sentence != said:
            say(sentence)
        said = sentence
        time.sleep(POLL)
    if not left:  # which a signal does not take away
        TEMPORARY.add(lock)
    ended = threading.Event()
    signs = threading.Thread(target=_give_signs, args=(handle, ended, say), daemon=True)
    signs.start()
    try:
        yield partial(_report, handle, len(_line(handle, 0)) + 1)
        left = b""
    finally:
        ended.set()
        signs.join()
        with suppress(OSError):
            if _is_at(handle, lock) and _is_ours(handle):
                if left and not _line(handle, 1).strip():  # we have failed, and begun nothing
                    _write(handle, left)
                else:
                    lock.unlink()
        TEMPORARY.discard(lock)
        os.close(handle)


def _report(handle: int, place: int, told: dict[str, Any]) -> None:
    """Write below the first line of our lock what we have to tell."""
    with suppress(OSError):  # a disk that is full, or away for a moment: the run goes on
        if _is_ours(handle):
            os.pwrite(handle, json.dumps(told).ljust(ROOM).encode(), place)


def _give_signs(handle, ended, say):
    """Set the time of the lock now and then; ask this run to stop if another has taken it over."""
    while not ended.wait(SIGN):
        with suppress(OSError):  # a disk that is away for a moment
            if not _is_ours(handle):
                say("another run took this one for dead, for it gave no sign of life; stopping")
                ask()
                return
            os.utime(handle)


def _take(lock, watch, say):
    """Make the lock ours; its open file, and all that one had left in it who was killed."""
    lock.parent.mkdir(parents=True, exist_ok=True)
    while True:
        handle, left = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644), b""
        try:
            held = _held_by_another(handle)
            if not held and not _is_at(handle, lock):  # its owner has ended meanwhile
                os.close(handle)
                continue
            watch.look(handle)
            _judge(lock, _owner(handle, lock), held, watch, say)
            left, before = os.pread(handle, LONGEST, 0), _line(handle, 1).strip()
            first, second = json.dumps(_ourselves()).encode(), b" " * ROOM
            _write(handle, b"\n".join([first, second, before or _line(handle, 2), b""]))
        except BaseException as problem:
            if isinstance(problem, OSError) and not left:  # it is ours, and could not be written
                with suppress(OSError):
                    lock.unlink()
            os.close(handle)
            raise
        return handle, left


def _write(handle, text):
    """Replace all that stands in the lock; after a kill in between the first lines are there."""
    os.pwrite(handle, text, 0)
    os.ftruncate(handle, len(text))


def _held_by_another(handle):
    """Whether a living process has the file locked; None where the file system cannot say."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return None
    return False


def _is_at(handle, lock):
    """Whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(lock))
    except FileNotFoundError:
        return False


def _line(handle, number):
    """A line of the lock as it stands in the file; nothing where there is none."""
    lines = os.pread(handle, LONGEST, 0).split(b"\n")
    return lines[number] if number < len(lines) else b""


def _is_ours(handle):
    """Whether this process is the owner that stands in the lock."""
    try:
        owner, here = json.loads(_line(handle, 0)), _ourselves()
        return all(owner[key] == here[key] for key in ("pid", "host", "boot", "ticks"))
    except (ValueError, TypeError, KeyError):
        return False


def _owner(handle, lock):
    """Who wrote the lock, as `_ourselves` has it; None for one who had no time to write."""
    text = _line(handle, 0)
    if not text:
        return None
    try:
        owner = json.loads(text)
        if not 0 < owner["pid"] <= LARGEST_PID:
            raise ValueError
        return {key: owner[key] for key in _ourselves()}
    except (ValueError, TypeError, KeyError):
        raise UserError(
            f"{lock}: not a lock of this program, which would put one there; move it away"
        ) from None


def _judge(lock, owner, held, watch, say):
    """Go on if the lock is free, with a sentence if its owner was killed."""
    if owner is None:
        if held:
            raise _Busy("another run is at work on it")
        return
    who = f"process {owner['pid']} on {owner['host']}, begun {owner['since']}"
    here = _ourselves()
    if owner["boot"] == here["boot"] or owner["host"] == here["host"]:
        at_work = held or (held is None and _lives(owner))
    else:  # the file system may know of another machine's lock, or not, or too long
        at_work = (held or watch.alive) and not watch.silent
        if not at_work and not watch.silent:
            raise _Doubtful(f"left by a run on another machine ({who})")
    if at_work:
        raise _Busy(f"another run is at work on it ({who})")
    say(f"{lock}: left by a run that was killed ({who}); taking over")


def _boot():
    """The name of this start of the machine, where the system gives it one."""
    return BOOT.read_text().strip() if BOOT.is_file() else ""


def _ourselves():
    return {
        "pid": os.getpid(),
        "host": socket.gethostname(),
        "boot": _boot(),
        "ticks": _ticks(os.getpid()),
        "since": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC",
    }


def _lives(owner):
    """Whether the process that wrote the lock is there, and not another of the same number."""
    try:
        os.kill(owner["pid"], 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return owner["ticks"] == _ticks(owner["pid"])


def _ticks(pid):
    """When a process began, in the system's own count; 0 where it does not say, or has ended."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return 0
    state, *fields = text.rpartition(")")[2].split()
    return 0 if state in ENDED else int(fields[18])
