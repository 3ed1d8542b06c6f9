"""What is known of one run, at work or not, from the files that lie beside its result.

The lock says who is at work, and how far: that is a few seconds old. The checkpoint has the state
and all samples so far: it is up to a minute old. The log has what a run said that failed. All of
them are only read.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dpd import files
from dpd.errors import FAILED, UserError, reason
from dpd.pipeline.lock import worker_on
from dpd.pipeline.pace import START, told_by
from dpd.pipeline.sight import NOTHING, RECENT, Measured, sight_of
from dpd.pipeline.simulate import checkpoint_path
from dpd.stages import run_sources

if TYPE_CHECKING:
    from collections.abc import Collection

    from dpd.scene.scene import Scene

AT_WORK, DONE, STOPPED, FAILS, WAITS = "at work", "done", "stopped", "failed", "waiting"
STATES = (AT_WORK, DONE, STOPPED, FAILS, WAITS)
# In the last sentence of a command that a signal has ended: while it ran, or before that.
ASKED = ("as asked", "interrupted")
TRACEBACK = "Traceback (most recent call last)"
TAIL = 2**16  # bytes of a log that are looked at, from its end


@dataclass(frozen=True)
class RunStatus:
    """One run as it is now.

    Attributes
    ----------
    name : tuple of str
        Paper, sweep and point; or the path of a run of one's own.
    path : str
        Of its result.
    state : str
        One of `STATES`.
    why : str
        Why it is in that state, where there is something to say.
    doing : str
        ``start`` while it makes its first configuration, ``run`` after that; nothing if unknown.
    step, steps : int or None
        Done, and in all.
    beads : int or None
    rate : float or None
        Steps per second, of the last minute; of a run that is done, of the whole.
    measured : Measured
    measured_step : int or None
        The step up to which that was sampled.
    seen : float or None
        When ``step`` was true, as `time.time` has it.
    process, host, since : int, str, str, or None
        Of the process that is at work.
    work : float
        Bead-steps that it still has to do; NaN if unknown.
    """

    name: tuple[str, ...]
    path: str
    state: str = WAITS
    why: str = ""
    doing: str = ""
    step: int | None = None
    steps: int | None = None
    beads: int | None = None
    rate: float | None = None
    measured: Measured = NOTHING
    measured_step: int | None = None
    seen: float | None = None
    process: int | None = None
    host: str | None = None
    since: str | None = None
    work: float = np.nan

    @property
    def seconds_left(self) -> float | None:
        """Of wall clock from ``seen``, at its own rate; None if that is not known."""
        if self.state != AT_WORK or not self.rate or self.step is None or self.steps is None:
            return None
        return max(self.steps - self.step, 0) / self.rate


def look_at(
    name: tuple[str, ...], path: str | Path, scene: Scene | None = None,
    log: str | Path | None = None, open_logs: Collection[str] = (),
) -> RunStatus:  # fmt: skip
    """The status of a run.

    Parameters
    ----------
    name : tuple of str
    path : path
        Of its result, which need not be there.
    scene : Scene or None
        What is to run; None for whatever has been run under that name.
    log : path or None
        What its command said, if that is kept.
    open_logs : collection of str
        Logs that a process writes to, see `dpd.pipeline.jobs.open_logs`.

    Returns
    -------
    RunStatus
    """
    run = RunStatus(name, str(path))
    if scene is not None:
        run = replace(run, steps=sum(scene.steps), beads=scene.beads, work=float(scene.work))
    try:
        worker, in_the_way = worker_on(path), ""
    except UserError as problem:
        worker, in_the_way = None, str(problem)
    if worker is not None and worker.alive:
        return _at_work(run, worker, sight_of(checkpoint_path(path)))
    if log is not None and os.path.abspath(log) in open_logs:
        return replace(run, state=AT_WORK, why="it begins, or waits for another run")
    made = _made(run, scene)
    if made.state == DONE:
        return made
    if in_the_way:
        return replace(run, state=FAILS, why=in_the_way)
    error = last_error(log) if log is not None else ""
    if error and not any(words in error for words in ASKED):
        return replace(run, state=FAILS, why=error)
    sight = sight_of(checkpoint_path(path))
    if sight is not None or worker is not None or error:
        return _stopped(run, scene, worker, sight)
    return made


def _at_work(run, worker, sight):
    """A run whose process is there."""
    run = replace(run, state=AT_WORK, process=worker.process, host=worker.host, since=worker.since)
    if told := told_by(worker.told):
        run = replace(
            run, doing=told.doing, step=told.step, steps=told.steps, rate=told.rate or None,
            seen=told.time,
        )  # fmt: skip
    if isinstance(sight, str) or sight is None or run.doing == START:
        return run
    is_newer = run.seen is None or sight.seen > run.seen
    if not is_newer and sight.step > run.step:  # left by a former run, and of no use to this one
        return run
    run = replace(run, measured=sight.measured, measured_step=sight.step)
    if is_newer:
        run = replace(run, step=sight.step, seen=sight.seen)
    return _with_work(run, sight)


def _with_work(run, sight):
    """A run with its size, by the scene in its checkpoint, and the work that is left."""
    if sight.scene is not None:
        run = replace(run, steps=sum(sight.scene.steps), beads=sight.scene.beads)
    if run.beads and run.steps:
        run = replace(run, work=float(run.beads * (run.steps - run.step)))
    return run


def _made(run, scene):
    """A run with its result, if there is one; it waits if the result is of no use."""
    try:
        there = os.stat(run.path)
    except FileNotFoundError:
        return run
    except OSError as problem:
        return replace(run, why=f"{run.path}: cannot be read ({reason(problem)})")
    try:
        found = _attributes(run.path, there.st_mtime_ns, there.st_size)
    except UserError as problem:
        return replace(run, why=str(problem))
    if "scene_digest" not in found or "steps" not in found:
        return replace(run, why=f"{run.path}: not the result of a run")
    run = replace(run, rate=_rate(found))
    if scene is not None:
        if found["scene_digest"] != scene.digest:
            return replace(run, why="its scene was edited since its result was made")
        if found.get("sources") != run_sources(scene):
            return replace(run, why="its result was made by other sources")
        missing = [p for p in scene.files_beside(run.path).values() if not p.is_file()]
        if missing:
            return replace(run, why=f"{missing[0]}: is missing")
    steps, lost = int(found["steps"]), int(found.get("lost_step", -1))
    return replace(
        run, state=DONE, step=steps if lost < 0 else lost, steps=steps, beads=int(found["beads"]),
        why="" if lost < 0 else f"it blew up at step {lost}, as its scene allows",
        work=0.0, seen=there.st_mtime,
    )  # fmt: skip


def _rate(found):
    """Steps per second of a run that has ended; None if its file does not say."""
    beads, rate = found.get("beads"), found.get("bead_steps_per_second")
    return float(rate) / int(beads) if beads and rate else None


def _stopped(run, scene, worker, sight):
    """A run that was begun, and is not at work."""
    why = "it was stopped"
    if worker is not None:
        why = f"it was killed: process {worker.process} on {worker.host} is gone"
    if sight is None:
        return replace(run, state=STOPPED, why=f"{why}; it left no checkpoint and begins anew")
    if isinstance(sight, str):
        return replace(run, state=STOPPED, why=f"{why}; {sight}, so it begins anew")
    if scene is not None and not _fits(sight, scene):
        other = "its checkpoint is of another scene or other sources"
        return replace(run, state=STOPPED, why=f"{why}; {other}, so it begins anew")
    run = replace(
        run, state=STOPPED, why=f"{why}; it goes on from step {sight.step}", step=sight.step,
        measured=sight.measured, measured_step=sight.step, seen=sight.seen,
    )  # fmt: skip
    return _with_work(run, sight)


def _fits(sight, scene):
    """Whether a run of a scene, with the sources as they are, goes on from a checkpoint."""
    return sight.scene_digest == scene.digest and sight.sources == run_sources(scene)


@lru_cache(RECENT)
def _attributes(path, changed, size):
    """Attributes of a result, read once unless the file changes."""
    return files.attributes(path)


def last_error(log: str | Path) -> str:
    """What the last try of a job ended with, from its log; nothing if it did not fail.

    Parameters
    ----------
    log : path
        It need not be there.

    Returns
    -------
    str
        The sentence of a command that failed, or the last line of a traceback.
    """
    lines = tail_of(log)
    sentences = [line for line in lines if line.startswith(FAILED)]
    if sentences:
        return sentences[-1].removeprefix(FAILED)
    if any(line.startswith(TRACEBACK) for line in lines):
        return lines[-1]
    return ""


def tail_of(log: str | Path) -> list[str]:
    """The last lines of a log that hold something; none where it cannot be read."""
    if not os.path.isfile(log):
        return []
    try:
        with open(log, "rb") as file:
            file.seek(max(os.fstat(file.fileno()).st_size - TAIL, 0))
            text = file.read().decode(errors="replace")
    except OSError:
        return []
    return [line.rstrip() for line in text.splitlines() if line.strip()]
