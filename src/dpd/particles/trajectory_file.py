"""A trajectory that grows while a run goes on: the same bits, however often the run is killed."""

from __future__ import annotations

import hashlib
import os
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import gsd.fl
import gsd.hoomd
import gsd.pygsd
import numpy as np

from dpd.drafts import draft_of
from dpd.errors import UserError, reason, remedy
from dpd.files import check_output
from dpd.particles.gsd_files import APPLICATION, SCHEMA, frame_of, trajectory_to_read
from dpd.scene.beside import unfinished

if TYPE_CHECKING:
    from collections.abc import Iterator

    from dpd.particles.particles import Particles

DIGEST = 32  # bytes
MAGIC = 0x65DF65DF65DF65DF  # with which a GSD file begins
PATIENCE = 1.0  # s between frames that can be seen: to flush takes hundredths of a second
PER_BEAD = 36  # bytes of position, velocity and image in single precision
PER_BOND, PER_ANGLE = 12, 16  # bytes, once
PER_FRAME = 256  # bytes of the index, which doubles when it is full


def bytes_of(frames: int, beads: int, bonds: int, angles: int = 0) -> int:
    """Bytes that a trajectory takes on the disk in the end, when it is there twice."""
    once = PER_BOND * bonds + PER_ANGLE * angles
    return 2 * frames * (PER_FRAME + PER_BEAD * beads) + 2 * once


class TrajectoryFile:
    """A trajectory of this program while it is written.

    It grows as ``run.unfinished.gsd``, so that one can look at it meanwhile. In the end its frames
    are written once more, in one go, as ``run.gsd``: where frames lie in a GSD file depends on when
    it was flushed, and so on when the run was stopped. Until then the trajectory of a former run
    stays there.

    A digest of all frames so far, in which each frame is digested together with the digest of
    those before it, tells whether a file holds the frames that a checkpoint counts.

    Parameters
    ----------
    path : path
        Of ``run.gsd``.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.unfinished = unfinished(self.path)
        self._trajectory: gsd.hoomd.HOOMDTrajectory | None = None
        self._before: _Before | None = None
        self._flushed = time.monotonic()

    def refuse_other_files(self) -> None:
        """Refuse to write where somebody else's file is.

        Raises
        ------
        UserError
            If one of the two names is taken by something that is no trajectory of this program.
        """
        refuse_other_trajectory(self.path)
        refuse_other_trajectory(self.unfinished)

    def cut(self, frames: int, digest: np.ndarray) -> str:
        """Go on after the first frames of what a former process has left.

        Parameters
        ----------
        frames : int
        digest : (`DIGEST`,) uint8 array
            Of these frames.

        Returns
        -------
        str
            Why that cannot be, or nothing.

        Raises
        ------
        UserError
            If it cannot be written.
        """
        source = self.unfinished if self.unfinished.exists() else self.path
        try:
            with self._replacing(self.unfinished) as trajectory:
                _copy(_Before(source, frames, digest), trajectory)
                trajectory.flush()
        except _Refused as problem:
            return str(problem)
        self._trajectory = trajectory
        return ""

    def go_on_after(self, source: Path, frames: int, digest: np.ndarray) -> None:
        """Begin with the frames of a shorter run, unless a checkpoint says more (`cut`).

        Parameters
        ----------
        source : Path
            The trajectory of that run. It is read when the first frame is appended.
        frames : int
        digest : (`DIGEST`,) uint8 array
            Of these frames.
        """
        self._before = _Before(source, frames, digest.copy())

    def append(self, particles: Particles, digest: np.ndarray) -> np.ndarray:
        """Append a frame.

        Parameters
        ----------
        particles : Particles
        digest : (`DIGEST`,) uint8 array
            Of the frames before it; zeros for none.

        Returns
        -------
        (`DIGEST`,) uint8 array
            Of all frames.

        Raises
        ------
        UserError
            If it cannot be written.
        """
        frame = frame_of(particles, np.float32)
        with self._writing():
            self._opened().append(frame)
        if time.monotonic() - self._flushed > PATIENCE:
            self.flush()
        return _digest(frame, digest)

    def flush(self) -> None:
        """See to it that all frames are on the disk.

        Raises
        ------
        UserError
            If they cannot be written.
        """
        if self._trajectory is None and self._before is None:
            return  # there is no frame, or the trajectory is in its place already
        with self._writing():
            self._opened().flush()
        self._flushed = time.monotonic()

    def finish(self) -> None:
        """Put the trajectory in its place, once the run is done.

        Raises
        ------
        UserError
            If it cannot be written.
        """
        trajectory = self._opened()
        self.flush()
        frames = len(trajectory)
        trajectory.close()
        self._trajectory = self._before = None
        with self._replacing(self.path) as trajectory:
            for frame in _first_frames(self.unfinished, frames):
                trajectory.append(frame)
            trajectory.close()
        self.unfinished.unlink(missing_ok=True)

    def _opened(self):
        """The file to append to; a new one at the beginning."""
        if self._trajectory is None:
            with self._replacing(self.unfinished) as trajectory:
                if self._before is not None:
                    self._copy_former(trajectory)
                self._trajectory = trajectory
        return self._trajectory

    def _copy_former(self, trajectory):
        try:
            _copy(self._before, trajectory)
        except _Refused as problem:
            raise UserError(
                f"{problem}; the run cannot be made longer without them: put the trajectory back "
                "that was made with it"
            ) from None

    @contextmanager
    def _replacing(self, path):
        """A new trajectory to write to, which then takes the place of what is there."""
        with self._writing(), draft_of(path) as draft:
            draft.touch()  # with the rights of any new file; the library would take some away
            opened = gsd.fl.open(str(draft), "w", APPLICATION, "hoomd", SCHEMA)
            yield gsd.hoomd.HOOMDTrajectory(opened)
            os.replace(draft, path)

    @contextmanager
    def _writing(self):
        try:
            yield
        except OSError as problem:
            raise UserError(
                f"{self.unfinished}: cannot be written ({reason(problem)}); "
                f"{remedy(problem, self.path.parent)}"
            ) from None


def refuse_other_trajectory(path: Path) -> None:
    """Refuse to let a trajectory take the place of somebody's file.

    Raises
    ------
    UserError
        If something is there that is neither a trajectory of this program, whole or damaged, nor
        empty.
    """
    check_output(path)
    if not os.path.lexists(path) or (os.path.isfile(path) and not os.path.getsize(path)):
        return
    if _application(path) != APPLICATION:
        raise UserError(
            f"{path}: the trajectory of this run would take its place, and this program did not "
            "write it; move it away, or choose another name for the result"
        )


class _Refused(Exception):
    """Frames that are not there, or are others."""


class _Before(NamedTuple):
    """Frames that a trajectory begins with: the first so many of a file, and their digest."""

    source: Path
    frames: int
    digest: np.ndarray


def _copy(before, trajectory):
    """Append frames from another file, if they are those that are meant."""
    found = np.zeros(DIGEST, np.uint8)
    for frame in _first_frames(before.source, before.frames):
        found = _digest(frame, found)
        trajectory.append(frame)
    if not np.array_equal(found, before.digest):
        raise _Refused(f"{before.source}: its frames are not those that the run has counted")


def _first_frames(path: Path, count: int) -> Iterator[gsd.hoomd.Frame]:
    """The first frames of a file."""
    if not count:
        return
    try:
        with trajectory_to_read(path) as trajectory:
            if len(trajectory) < count:
                raise _Refused(f"{path}: has {len(trajectory)} frames of {count}")
            for number in range(count):
                yield trajectory[number]
    except UserError as problem:
        raise _Refused(str(problem)) from None


def _digest(frame, before):
    """Digest of a frame together with that of those before it."""
    beads = frame.particles
    total = hashlib.sha256(before.tobytes())
    for array, kind in (
        (frame.configuration.step, np.uint64), (frame.configuration.box, np.float32),
        (beads.position, np.float32), (beads.velocity, np.float32), (beads.image, np.int32),
        (beads.typeid, np.uint32), (frame.bonds.group, np.uint32),
        (frame.angles.group, np.uint32),
    ):  # fmt: skip
        if array is not None:
            total.update(np.ascontiguousarray(array, kind).tobytes())
    return np.frombuffer(total.digest(), np.uint8)


def _application(path):
    """What wrote a GSD file, as its header says; None if it is none.

    The rest of the file may be damaged, where a run was killed.
    """
    header = gsd.pygsd.gsd_header_struct
    try:
        with open(path, "rb") as file:
            head = file.read(header.size)
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    if len(head) < header.size:
        return None
    found = gsd.pygsd.gsd_header._make(header.unpack(head))
    return (
        found.application.rstrip(b"\0").decode(errors="replace") if found.magic == MAGIC else None
    )
