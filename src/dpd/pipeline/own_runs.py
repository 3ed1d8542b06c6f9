"""Runs of one's own, as they are now: one by its path, or all that lie in a folder."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

from dpd.errors import UserError, reason
from dpd.pipeline.lock import lock_of
from dpd.pipeline.run_status import DONE, RunStatus, look_at
from dpd.pipeline.sight import measured_in
from dpd.pipeline.simulate import checkpoint_path
from dpd.pipeline.status import Status, left_of

SUFFIX, LOCK, CHECKPOINT = ".nc", ".lock", ".checkpoint"  # of a result and what lies beside it
ALLOWED = (
    "allowed: the folder of a study's results, as results/quick; the result of a run, as run.nc, "
    "also while it is at work; a folder with such results"
)


@dataclass(frozen=True)
class OwnRuns:
    """Runs of one's own that are looked at again and again.

    Attributes
    ----------
    path : Path
        Of the result of a run, or a folder with some.
    """

    path: Path

    def look(self) -> Status:
        """The runs as they are now.

        Raises
        ------
        UserError
            If there is no run, or what is there cannot be read.
        """
        paths = runs_in(self.path) if self.path.is_dir() else [self.path]
        runs = [self._look_at(path) for path in paths]
        return Status(str(self.path), "", time.time(), runs, [], left_of(runs))

    def _look_at(self, path: Path) -> RunStatus:
        """One run, with what it has measured if it is done."""
        run = look_at((str(path),), path)
        if run.state == DONE:
            return replace(run, measured=measured_in(path), measured_step=run.step)
        if not is_begun(path):
            raise UserError(run.why or f"{path}: there is no such run; {ALLOWED}")
        return run


def runs_in(folder: Path) -> list[Path]:
    """Results of all runs that lie in a folder, done or begun.

    Raises
    ------
    UserError
        If the folder cannot be read.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as problem:
        raise UserError(f"{folder}: cannot be read ({reason(problem)})") from None
    found: set[Path] = set()
    for name in names:
        for ending in (SUFFIX + LOCK, CHECKPOINT):
            if name.endswith(ending):
                found.add(folder / f"{name.removesuffix(ending)}{SUFFIX}")
        path = folder / name
        if path.suffix.lower() == SUFFIX and look_at((name,), path).state == DONE:
            found.add(path)
    return sorted(found)


def is_begun(path: Path) -> bool:
    """Whether a run has left something beside the place of its result."""
    return any(map(os.path.lexists, (lock_of(path), checkpoint_path(path))))


def result_of(path: Path) -> Path:
    """The result that a path is about: its own, or that of a lock or of a checkpoint."""
    if path.suffix == LOCK:
        return path.with_suffix("")
    return path.with_suffix(SUFFIX) if path.suffix == CHECKPOINT else path
