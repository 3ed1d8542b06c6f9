"""One run at a time on an output: a lease on a file beside it; and how far the run is.

A lease is taken over from a process that is no more on this machine, and from one that has not
renewed it for two minutes on another machine of a cluster.
"""

import json
import os
import socket
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from filelock import SoftFileLease, Timeout

from dpd.errors import UserError
from dpd.files import TEMPORARY, writing

POLL = 1.0  # s between looks whether the other run has ended
SIGN = 10.0  # s between the owner's signs of life
SILENCE = 120.0  # s without a sign after which a run on another machine is no more
LINE_EVERY = 20.0  # seconds between lines in a log
REPORT_EVERY = 5.0  # seconds between reports
REMEMBERED = 13  # reports that a rate comes from: the last minute, in which a machine may slow down


class Worker(NamedTuple):
    """Who is at work on an output, or was; and the last report on how far, see `Lock.report`."""

    process: int
    host: str
    alive: bool
    report: dict[str, Any]


class Lock(NamedTuple):
    """A lease that is ours."""

    lease: SoftFileLease
    progress: Path

    def report(self, data: dict[str, Any]) -> None:
        """Tell others how far this run is; `UserError` if one has taken it for dead."""
        if self.lease.compromise:
            raise UserError(
                f"{self.lease.lock_file}: another run took this one for dead, for it gave no sign "
                f"of life for {SILENCE:g} s; it goes on there"
            )
        with suppress(OSError):  # a disk that is full, or away for a moment: the run goes on
            self.progress.write_text(json.dumps(data))


def _lease(path):
    return SoftFileLease(
        f"{path}.lock", lease_duration=SILENCE, heartbeat_interval=SIGN,
        thread_local=False, is_singleton=False,
    )  # fmt: skip


@contextmanager
def alone(
    path: str | Path, say: Callable[[str], None], wait: bool = False,
    look: Callable[[], object] = bool,
) -> Iterator[Lock]:  # fmt: skip
    """Be the only run at work on an output, or ``wait`` for that; `UserError` if it cannot be.

    ``look`` is called now and then while it waits, and may raise.
    """
    lease, progress = _lease(path), Path(f"{path}.progress")
    place = Path(lease.lock_file)
    with writing(place):
        place.parent.mkdir(parents=True, exist_ok=True)
        _take(lease, path, say, wait, look)
    TEMPORARY.update((place, progress))
    try:
        yield Lock(lease, progress)
    finally:
        if not lease.compromise:
            progress.unlink(missing_ok=True)
        lease.release()
        TEMPORARY.difference_update((place, progress))


def _take(lease, path, say, wait, look):
    """Take a lease, if need be from a run that is no more."""
    said = ""
    while True:
        owner = worker_on(path)
        who = f"(process {owner.process} on {owner.host})" if owner else ""
        with suppress(FileNotFoundError):  # one that was killed as it made its lock left it empty:
            status = os.lstat(lease.lock_file)  # filelock takes that for held, for ever
            if not status.st_size and time.time() - status.st_mtime > SIGN:
                os.unlink(lease.lock_file)
        with suppress(Timeout):
            lease.acquire(blocking=False)
            if owner:
                say(f"{lease.lock_file}: left by a run that was killed {who}; taking over")
            return
        busy = f"{path}: another run is at work on it {who}"
        if owner and owner.alive and not wait:
            raise UserError(f"{busy}; wait for it, stop it, or choose another output")
        if owner and busy != said:
            say(f"{busy}; waiting for it, or until it has given no sign of life for {SILENCE:g} s")
            said = busy
        look()
        time.sleep(POLL)


def worker_on(path: str | Path) -> Worker | None:
    """Who is at work on an output; None where there is no lock, `UserError` if it is none."""
    lease = _lease(path)
    try:
        status, owner = os.lstat(lease.lock_file), lease.owner
    except FileNotFoundError:
        return None
    if owner is None:
        if status.st_size > 0 and os.path.lexists(lease.lock_file):
            raise UserError(
                f"{lease.lock_file}: not a lock of this program, which would put one there; move "
                "it away"
            )
        return None  # only just made, or just removed
    alive = time.time() - status.st_mtime < SILENCE
    if owner.hostname == socket.gethostname():
        alive = alive and os.path.exists(f"/proc/{owner.pid}")
    report: dict[str, Any] = {}
    with suppress(OSError, ValueError):
        report = dict(json.loads(Path(f"{path}.progress").read_text()))
    return Worker(owner.pid, owner.hostname, alive, report)


class Progress(AbstractContextManager["Progress"]):
    """Callable with steps done of a ``total``; a ``bar``, if not given, only where one is seen."""

    def __init__(
        self, total: int, label: str, bar: bool | None = None, lock: Lock | None = None
    ) -> None:
        self._total, self._label, self._lock = total, label, lock
        # A program without a terminal, or a script, may have none, or have closed it.
        self._silent = bar is False or sys.stderr is None or getattr(sys.stderr, "closed", False)
        self._bar = None
        notebook = "ipykernel" in sys.modules
        if total and not self._silent and (bar or notebook or sys.stderr.isatty()):
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
            self._lock.report({"step": done, "steps": self._total, "rate": rate})

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.close()
