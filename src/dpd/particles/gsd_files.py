"""Configurations and growing trajectories in GSD files, with the schema of HOOMD-blue.

https://gsd.readthedocs.io/en/stable/schema-hoomd.html. The box is centred at 0. In two dimensions
the file says so, its box is 2 thick, and all beads are at z = 0.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from zlib import crc32

import gsd.fl
import gsd.hoomd
import gsd.pygsd
import numpy as np

from dpd.errors import UserError
from dpd.files import draft_of, reading, unfinished, writing
from dpd.particles.particles import FLAT, Particles, box_of_file, centre, frame_number, tilt_factors

APPLICATION = "dpd-papers"  # in the header of the files that this program writes
SCHEMA = [2, 0]  # version of HOOMD's schema
THICKNESS = 2.0  # of a box of two dimensions along z
# What the format can hold beside what `Particles` has, with the values that mean nothing.
OTHERS = {"charge": 0, "angmom": 0, "orientation": [1, 0, 0, 0]}
MORE_BONDS = ("dihedrals", "impropers", "constraints", "pairs")


def read_gsd(path: Path, frame: int = -1) -> Particles:
    """One frame, counted from 0, or from the last with negative numbers; `UserError` if bad."""
    with trajectory_to_read(path) as trajectory:
        found = trajectory[frame_number(frame, len(trajectory), path)]
    configuration, beads = found.configuration, found.particles
    d = int(configuration.dimensions)
    box = np.array([_decimal(edge) for edge in configuration.box])
    if d == 2 and (np.abs(beads.position[:, 2]) > FLAT).any():
        raise UserError(
            f"{path}: two dimensions, and beads that are not at z = 0; mend one of both"
        )
    edges, moves = box_of_file(box[:d], box[3:], path), beads.velocity.any()  # 0 if not in the file
    return Particles(
        box=edges,
        position=beads.position[:, :d].T.astype(float) + centre(edges),
        image=beads.image[:, :d].T,
        velocity=beads.velocity[:, :d].T if moves else None,
        species=beads.typeid.astype(np.int64),
        names=tuple(beads.types),
        bonds=found.bonds.group.astype(np.int64),
        angles=found.angles.group.astype(np.int64),
        step=int(configuration.step),
        left_out=tuple(_left_out(found)),
        masses=_masses(beads),
        types={
            tuple(group): table.types[kind]
            for table in (found.bonds, found.angles)
            if table.types not in (None, ["bond"], ["angle"])
            for group, kind in zip(table.group.tolist(), table.typeid)
        },
    ).checked(path)


@contextmanager
def trajectory_to_read(path: Path) -> Iterator[gsd.hoomd.HOOMDTrajectory]:
    """A GSD file, read by the library's Python code: its C code can die of a damaged file."""
    with reading(path), open(path, "rb") as file:
        found = gsd.pygsd.GSDFile(file)
        if found.schema != "hoomd":
            raise UserError(f"{path}: a GSD file with the schema {found.schema!r}; allowed: hoomd")
        yield gsd.hoomd.HOOMDTrajectory(found)


def _decimal(number):
    """The shortest decimal that single precision, of all boxes, rounds to: 6.3, not 6.3000002."""
    return float(str(np.float32(number)))


def _masses(beads):
    """(types,) array of masses by type; None where all are 1, or where beads of a type differ."""
    of_type = [np.unique(beads.mass[beads.typeid == k]) for k in range(len(beads.types))]
    if (beads.mass == 1).all() or any(len(masses) > 1 for masses in of_type):
        return None
    return np.array([_decimal(masses[0]) if len(masses) else 1.0 for masses in of_type])


def _left_out(frame):
    """What a frame has that is lost, a sentence each."""
    beads = frame.particles
    for name, nothing in OTHERS.items():
        if (getattr(beads, name) != nothing).any():
            yield f"{name} is left out: beads have none here"
    if _masses(beads) is None and not (beads.mass == 1).all():
        yield "mass is left out: beads of one type differ in it, here they do not"
    for name in MORE_BONDS:
        if count := getattr(frame, name).N:
            yield f"{count} {name} are left out: there are none here"


def frame_of(particles: Particles, precision: type = np.float64) -> gsd.hoomd.Frame:
    """Particles as a frame of the library, positions and velocities with some precision."""
    frame = gsd.hoomd.Frame()
    configuration, beads = frame.configuration, frame.particles
    dimension = particles.dimension
    configuration.step, configuration.dimensions = particles.step, dimension
    configuration.box = [*particles.box, *[THICKNESS] * (3 - dimension)]
    configuration.box += tilt_factors(particles.box)
    beads.N = particles.beads
    beads.types = list(particles.names)
    beads.typeid = particles.species.astype(np.uint32)
    position, image = particles.in_tilted_box()
    beads.position = _columns(position - centre(particles.box), precision)
    beads.image = _columns(image, np.int32)
    if particles.velocity is not None:
        beads.velocity = _columns(particles.velocity, precision)
    if particles.masses is not None:
        beads.mass = particles.masses[particles.species].astype(np.float32)
    for kind in ("bond", "angle"):
        members, table = getattr(particles, f"{kind}s"), getattr(frame, f"{kind}s")
        if len(members):
            table.N, table.group = len(members), members
            table.types, numbers = particles.numbered(kind)
            table.typeid = numbers.astype(np.uint32)
    return frame


def _columns(array, kind):
    """(n, 3) array of a (dimension, n) one; 0 along the axis that is not there."""
    return np.pad(array, ((0, 3 - len(array)), (0, 0))).T.astype(kind, order="C")


def write_gsd(particles: Particles, path: Path) -> None:
    """Write one configuration in double precision."""
    with gsd.hoomd.HOOMDTrajectory(_new_file(path), precision="double") as trajectory:
        trajectory.append(frame_of(particles))


def _new_file(path):
    return gsd.fl.open(str(path), "w", APPLICATION, "hoomd", SCHEMA)


class TrajectoryFile:
    """A trajectory ``run.gsd`` while a run goes on: the same frames, however often that is killed.

    Until the end it grows as ``run.unfinished.gsd``. Digests of frames tell whether a file holds
    those that a checkpoint counts. `UserError` if it cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.unfinished = unfinished(self.path)
        self._trajectory: gsd.hoomd.HOOMDTrajectory | None = None
        self._before: tuple[Path, int, np.ndarray] | None = None  # see `_copy`
        self._is_longer = False  # than what is in its place, of which it has all frames

    def cut(self, frames: int, digests: np.ndarray) -> str:
        """Go on after the first frames of what a former process left; return why that cannot be."""
        source = self.unfinished if self.unfinished.exists() else self.path
        with self._begun() as trajectory:
            if problem := _copy(trajectory, source, frames, digests):
                return problem
            trajectory.flush()
        self._trajectory, self._before = trajectory, None
        return ""

    def go_on_after(self, source: Path, frames: int, digests: np.ndarray) -> None:
        """Begin with frames of a shorter run, read with the first own one; `cut` says more."""
        self._before = source, frames, digests.copy()
        self._is_longer = source == self.path

    def append(self, frame: gsd.hoomd.Frame) -> int:
        """Append a frame in single precision; return its digest."""
        with writing(self.unfinished):
            self._opened().append(frame)
        return _digest(frame)

    def flush(self) -> None:
        """See to it that all frames are on the disk."""
        if self._trajectory is None and self._before is None:
            return  # there is no frame, or the trajectory is in its place already
        with writing(self.unfinished):
            self._opened().flush()

    def finish(self, result: Path) -> None:
        """Put the trajectory in its place, once the run is done.

        The ``result`` of another run goes first: it must not stand beside one that is not its own.
        """
        with writing(self.path):
            self._opened().close()
            self._trajectory = None
            if not self._is_longer:
                result.unlink(missing_ok=True)
            self.unfinished.replace(self.path)

    def _opened(self):
        """The file to append to; a new one at the beginning."""
        if self._trajectory is None:
            with self._begun() as trajectory:
                if self._before and (problem := _copy(trajectory, *self._before)):
                    raise UserError(
                        f"{problem}; the run cannot be made longer without them: put the "
                        "trajectory back that was made with it"
                    )
                trajectory.flush()
            self._trajectory, self._before = trajectory, None
        return self._trajectory

    @contextmanager
    def _begun(self):
        """A new trajectory to write to, which then takes the place of an unfinished one."""
        with writing(self.unfinished), draft_of(self.unfinished) as draft:
            yield gsd.hoomd.HOOMDTrajectory(_new_file(draft))


def _copy(trajectory, source, frames, digests):
    """Append frames from another file, up to the first that is not meant; return what is wrong."""
    if not frames:
        return ""
    try:
        with trajectory_to_read(source) as found:
            for number in range(frames):
                frame = found[number]
                if _digest(frame) != digests[number]:
                    return (
                        f"{source}: its frames from {number} on, of {frames}, are not those that "
                        "the run has counted"
                    )
                trajectory.append(frame)
    except UserError as problem:
        return str(problem)
    return ""


def _digest(frame):
    """A checksum of a frame's positions."""
    return crc32(np.ascontiguousarray(frame.particles.position))
