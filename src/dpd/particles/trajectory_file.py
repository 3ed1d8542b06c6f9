"""A trajectory that grows while a run goes on: the same bits, however often the run is killed."""

from __future__ import annotations

import hashlib
import os
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import gsd.fl
import gsd.hoomd
import gsd.pygsd
import numpy as np

from dpd.errors import UserError, reason, remedy
from dpd.files import check_output, draft_of, unfinished
from dpd.particles.gsd_files import APPLICATION, SCHEMA, trajectory_to_read

if TYPE_CHECKING:
    from collections.abc import Iterator

DIGEST = 8  # bytes, of each frame
MAGIC = 0x65DF65DF65DF65DF  # with which a GSD file begins
PATIENCE = 1.0  # s between frames that can be seen: to flush takes hundredths of a second
PER_BEAD = 24  # bytes of position and image in single precision,
OF_VELOCITY = 12  # and of the velocity
PER_BOND, PER_ANGLE = 12, 16  # bytes, once
PER_FRAME = 512  # bytes of the index, which doubles when it is full


def bytes_of(frames: int, beads: int, bonds: int, angles: int, velocities: bool) -> int:
    """Bytes that a trajectory takes on the disk in the end, when it is there twice."""
    once = PER_BOND * bonds + PER_ANGLE * angles
    each = PER_BEAD + OF_VELOCITY * velocities
    return 2 * frames * (PER_FRAME + each * beads) + 2 * once


class TrajectoryFile:
    """A trajectory ``run.gsd`` of this program while it is written.

    It grows as ``run.unfinished.gsd``, so that one can look at it meanwhile. In the end its frames
    are written once more, in one go, as ``run.gsd``: where frames lie in a GSD file depends on when
    it was flushed, and so on when the run was stopped. Until then the trajectory of a former run
    stays there.

    A digest of each frame tells whether a file holds the frames that a checkpoint counts, and the
    frames that were appended. While it grows it is kept open, so it may be removed or renamed.
    Digests are (n, `DIGEST`) uint8 arrays. What cannot be written is a `UserError`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.unfinished = unfinished(self.path)
        self._trajectory: gsd.hoomd.HOOMDTrajectory | None = None
        self._grown: BinaryIO  # to read what was written
        self._before: tuple[Path, int, np.ndarray] | None = None  # see `_copy`
        self._is_longer = False  # than what is in its place, of which it has all frames
        self._flushed = time.monotonic()

    def refuse_other_files(self) -> None:
        """Refuse if one of the two names is taken by what is no trajectory of this program."""
        refuse_other_trajectory(self.path)
        refuse_other_trajectory(self.unfinished)

    def cut(self, frames: int, digests: np.ndarray, is_over: bool) -> str:
        """Go on after the first frames of what a former process left; return why that cannot be.

        Where all was run, whole frames are taken, and `finish` says that the others are lost.
        """
        source = self.unfinished if self.unfinished.exists() else self.path
        return self._begin((source, frames, digests), is_over)

    def go_on_after(self, source: Path, frames: int, digests: np.ndarray) -> None:
        """Begin with frames of a shorter run's trajectory, unless a checkpoint says more (`cut`).

        It is read when the first frame is appended.
        """
        self._before = source, frames, digests.copy()
        self._is_longer = source == self.path

    def append(self, frame: gsd.hoomd.Frame) -> np.ndarray:
        """Append a frame in single precision; return its digest."""
        with self._writing():
            self._opened().append(frame)
        if time.monotonic() - self._flushed > PATIENCE:
            self.flush()
        return _digest(frame)

    def flush(self) -> None:
        """See to it that all frames are on the disk."""
        if self._trajectory is None and self._before is None:
            return  # there is no frame, or the trajectory is in its place already
        with self._writing():
            self._opened().flush()
        self._flushed = time.monotonic()

    def finish(self, frames: int, digests: np.ndarray, result: Path) -> str:
        """Put the trajectory in its place, once the run is done; return what was lost, if anything.

        A ``result`` of another run there, which would stand beside a trajectory that is not its own
        if we were killed before ours is written, is removed with its trajectory.
        """
        trajectory = self._opened()
        self.flush()
        trajectory.close()
        self._trajectory = None
        with self._replacing(self.path) as trajectory:
            problem = _copy(trajectory, self.unfinished, frames, digests, self._grown)
            trajectory.close()
            if not self._is_longer:
                result.unlink(missing_ok=True)
        self._grown.close()
        self.unfinished.unlink(missing_ok=True)
        return f"{self.path}: its last frames are lost: {problem}" if problem else ""

    def _opened(self):
        """The file to append to; a new one at the beginning."""
        if self._trajectory is None and (problem := self._begin(self._before)):
            raise UserError(
                f"{problem}; the run cannot be made longer without them: put the trajectory back "
                "that was made with it"
            )
        return self._trajectory

    def _begin(self, before, is_over=False):
        """Open the file with the frames of another one; return why it cannot go on from them."""
        try:
            with self._replacing(self.unfinished) as trajectory:
                if before and (problem := _copy(trajectory, *before)) and not is_over:
                    raise _Unreadable(problem)
                trajectory.flush()
        except _Unreadable as problem:
            return str(problem)
        self._trajectory, self._before = trajectory, None
        with self._writing():
            self._grown = open(self.unfinished, "rb")  # noqa: SIM115  # until it is finished
        return ""

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
    """Refuse to let a trajectory take the place of a file that is neither empty nor one of ours."""
    check_output(path)
    if not os.path.lexists(path) or (os.path.isfile(path) and not os.path.getsize(path)):
        return
    if _application(path) != APPLICATION:
        raise UserError(
            f"{path}: the trajectory of this run would take its place, and this program did not "
            "write it; move it away, or choose another name for the result"
        )


def _copy(trajectory, source, frames, digests, opened=None):
    """Append frames from another file, up to the first that is not meant; return what is wrong."""
    whole = 0
    try:
        for frame, digest in _first_frames(source, frames, opened):
            if not np.array_equal(digest, digests[whole]):
                return (
                    f"{source}: its frames from {whole} on, of {frames}, are not those that the "
                    "run has counted"
                )
            trajectory.append(frame)
            whole += 1
    except _Unreadable as problem:
        return str(problem)
    return "" if whole == frames else f"{source}: has {whole} frames of {frames}"


class _Unreadable(Exception):
    """Frames that cannot be read."""


def _first_frames(path: Path, count: int, opened: BinaryIO | None) -> Iterator[tuple]:
    """Up to so many of the first frames of a file, with their digests."""
    if not count:
        return
    try:
        with trajectory_to_read(path, opened) as trajectory:
            for number in range(min(count, len(trajectory))):
                frame = trajectory[number]
                yield frame, _digest(frame)
    except UserError as problem:
        raise _Unreadable(str(problem)) from None


def _digest(frame):
    """Digest of a frame; one that was read has defaults where nothing was written."""
    configuration, beads = frame.configuration, frame.particles
    names = [*(beads.types or ()), *(frame.bonds.types or ()), *(frame.angles.types or ())]
    total = hashlib.sha256(repr((int(configuration.step), names)).encode())
    for name, array, kind, nothing in (
        ("box", configuration.box, np.float32, 0), ("position", beads.position, np.float32, 0),
        ("velocity", beads.velocity, np.float32, 0), ("image", beads.image, np.int32, 0),
        ("typeid", beads.typeid, np.uint32, 0), ("mass", beads.mass, np.float32, 1),
        ("body", beads.body, np.int32, -1), ("bonds", frame.bonds.group, np.uint32, 0),
        ("angles", frame.angles.group, np.uint32, 0),
        *((name, value, np.float64, np.nan) for name, value in sorted(frame.log.items())),
    ):  # fmt: skip
        values = np.ascontiguousarray([] if array is None else array, kind)
        if (values != nothing).any():
            total.update(name.encode() + values.tobytes())
    return np.frombuffer(total.digest()[:DIGEST], np.uint8)


def _application(path):
    """What wrote a GSD file, as its header says; nothing if it is none. The rest may be damaged."""
    header = gsd.pygsd.gsd_header_struct
    try:
        with open(path, "rb") as file:
            head = file.read(header.size)
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    if len(head) < header.size:
        return ""
    found = gsd.pygsd.gsd_header._make(header.unpack(head))
    name = found.application.rstrip(b"\0").decode(errors="replace")
    return name if found.magic == MAGIC else ""
