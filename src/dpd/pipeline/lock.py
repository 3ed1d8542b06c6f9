"""One run at a time on an output: a lock that says who is at work.

The lock is a file beside the output. The system's own lock on that file (flock) ends with the
process, however it ends; what stands in the file tells others who it was.
"""

from __future__ import annotations

import fcntl
import json
import os
import socket
import time
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.drafts import TEMPORARY
from dpd.errors import UserError, reason, remedy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

POLL = 1.0  # s between looks whether the other run has ended
BOOT = Path("/proc/sys/kernel/random/boot_id")


class _Busy(Exception):
    """Somebody is at work; the text says who."""


@contextmanager
def alone(path: str | Path, say: Callable[[str], None], wait: bool = False) -> Iterator[bool]:
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
    bool
        Whether another run was waited for: its result may be there.

    Raises
    ------
    UserError
        If another run is at work, or may be on another machine, or if there can be no lock.
    """
    lock = Path(path).with_name(Path(path).name + ".lock")
    waited = False
    while True:
        try:
            handle = _take(lock, say)
            break
        except _Busy as who:
            if not wait:
                raise UserError(
                    f"{path}: {who}; wait for it, stop it, or choose another output"
                ) from None
            if not waited:
                say(f"{path}: {who}; waiting for it")
            waited = True
            time.sleep(POLL)
        except OSError as problem:
            raise UserError(
                f"{lock}: cannot be written ({reason(problem)}); {remedy(problem, lock.parent)}"
            ) from None
    TEMPORARY.add(lock)
    try:
        yield waited
    finally:
        with suppress(OSError):
            if _is_at(handle, lock):
                lock.unlink()
        TEMPORARY.discard(lock)
        os.close(handle)


def _take(lock, say):
    """Make the lock ours; its open file."""
    lock.parent.mkdir(parents=True, exist_ok=True)
    while True:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            held = _held_by_another(handle)
            if not held and not _is_at(handle, lock):  # its owner has ended meanwhile
                os.close(handle)
                continue
            _judge(lock, _owner(handle, lock), held, say)
            os.ftruncate(handle, 0)
            os.pwrite(handle, json.dumps(_ourselves()).encode(), 0)
        except BaseException as problem:
            if isinstance(problem, OSError):  # it is ours, and could not be written
                with suppress(OSError):
                    lock.unlink()
            os.close(handle)
            raise
        return handle


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


def _owner(handle, lock):
    """Who wrote the lock, as `_ourselves` has it; None for one who had no time to write."""
    text = os.pread(handle, 4096, 0)
    if not text:
        return None
    try:
        owner = json.loads(text)
        return {key: owner[key] for key in _ourselves()}
    except (ValueError, TypeError, KeyError):
        raise UserError(
            f"{lock}: not a lock of this program, which would put one there; move it away"
        ) from None


def _judge(lock, owner, held, say):
    """Go on if the lock is free, with a sentence if its owner was killed."""
    if owner is None:
        if held:
            raise _Busy("another run is at work on it")
        return
    who = f"process {owner['pid']} on {owner['host']}, begun {owner['since']}"
    here = _ourselves()
    same_host = owner["boot"] == here["boot"] or owner["host"] == here["host"]
    if held or (held is None and same_host and _lives(owner)):
        raise _Busy(f"another run is at work on it ({who})")
    if not same_host:
        raise UserError(
            f"{lock}: left by a run on another machine ({who}), which may still be at work; if it "
            "is not, remove that file"
        )
    say(f"{lock}: left by a run that was killed ({who}); taking over")


def _ourselves():
    boot = BOOT.read_text().strip() if BOOT.is_file() else ""
    return {
        "pid": os.getpid(),
        "host": socket.gethostname(),
        "boot": boot,
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
    """When a process began, in the system's own count; 0 where it does not say."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return 0
    return int(text.rpartition(")")[2].split()[19])
