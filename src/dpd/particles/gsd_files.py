"""Configurations in GSD files, with the schema of HOOMD-blue.

https://gsd.readthedocs.io/en/stable/schema-hoomd.html. The box is centred at 0. In two dimensions
the file says so, its box is 2 thick, and all beads are at z = 0.
"""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, BinaryIO

import gsd.fl
import gsd.hoomd
import gsd.pygsd
import numpy as np

from dpd.errors import UserError, reason
from dpd.particles.particles import (
    FLAT,
    Particles,
    box_of_file,
    centre,
    checked,
    in_tilted_box,
    tilt_factors,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

APPLICATION = "dpd-papers"  # in the header of the files that this program writes
SCHEMA = [2, 0]  # version of HOOMD's schema
THICKNESS = 2.0  # of a box of two dimensions along z
NO_BODY = -1
# What the format can hold beside what `Particles` has, with the values that mean nothing.
OTHERS = {"charge": 0, "body": NO_BODY, "angmom": 0, "orientation": [1, 0, 0, 0]}
MORE_BONDS = ("dihedrals", "impropers", "constraints", "pairs")


def read_gsd(path: Path, frame: int = -1) -> Particles:
    """Read one frame, counted from 0, or from the last with negative numbers.

    Raises
    ------
    UserError
        If the file cannot be read, has no such frame, or holds what no simulation can begin with.
    """
    with trajectory_to_read(path) as trajectory:
        frames = len(trajectory)
        if not -frames <= frame < frames:
            raise UserError(f"{path}: there is no frame {frame}; {frames_of(frames)}")
        place = frame % frames
        _check_counts(path, trajectory.file, place)
        found = trajectory[place]
        if trajectory.file.application == APPLICATION:
            found.particles.body = np.array(NO_BODY)  # molecules, which bonds tell as well
    return _particles_of(path, found)


def frames_of(count: int) -> str:
    """Which frames a file of so many has, in words."""
    if not count:
        return "the file has no frames: it was cut off before the first was written"
    return f"allowed: 0 to {count - 1}, or -1 for the last, to {-count}"


@contextmanager
def trajectory_to_read(
    path: Path, opened: BinaryIO | None = None
) -> Iterator[gsd.hoomd.HOOMDTrajectory]:
    """A GSD file, opened already or not, with a message for whatever is wrong with it.

    It is read by the library's Python code: its C code can end the process on a damaged file.
    """
    try:
        with nullcontext(opened) if opened else open(path, "rb") as file:
            found = gsd.pygsd.GSDFile(file)
            if found.schema != "hoomd":
                raise UserError(
                    f"{path}: a GSD file with the schema {found.schema!r}; allowed: 'hoomd'"
                )
            yield gsd.hoomd.HOOMDTrajectory(found)
    except UserError:
        raise
    except OSError as problem:
        if problem.errno:
            raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
        raise _damaged(path, "it ends too early") from None
    except Exception as problem:  # a dozen kinds, for numbers in it that cannot be
        raise _damaged(path, str(problem).replace(str(path), "the file")) from None


def _damaged(path, problem):
    return UserError(
        f"{path}: not a whole GSD file ({problem.splitlines()[0][:80] if problem else 'damaged'}); "
        "copy or write it again"
    )


def _check_counts(path, file, frame):
    """Refuse counts that do not fit to what is there: as much memory would be asked for."""
    for name, array in (("particles", "position"), ("bonds", "group"), ("angles", "group")):
        count = _chunk(file, frame, f"{name}/N")
        there = _chunk(file, frame, f"{name}/{array}")
        said, found = 0 if count is None else int(count[0]), 0 if there is None else len(there)
        at_centre = name == "particles" and there is None and said == 1  # not written: a default
        if said != found and not at_centre:
            raise UserError(
                f"{path}: frame {frame} says that it has {said} {name}, and has {array} for "
                f"{found}; the file is damaged or lacks them, write it again"
            )


def _chunk(file, frame, name):
    """An array of a frame or, as the schema has it, of the first frame; None if in neither."""
    for place in (frame, 0):
        if file.chunk_exists(place, name):
            return file.read_chunk(place, name)
    return None


def _particles_of(path, frame):
    configuration, beads = frame.configuration, frame.particles
    dimension = int(configuration.dimensions)
    if dimension not in (2, 3):
        raise UserError(f"{path}: {dimension} dimensions; allowed: 2 or 3")
    box = np.array([_decimal(edge) for edge in configuration.box])
    for name, columns in (("position", 3), ("velocity", 3), ("image", 3)):
        if np.shape(getattr(beads, name)) != (beads.N, columns):
            raise UserError(f"{path}: {name} is not 3 numbers for each of {beads.N} beads")
    if dimension == 2 and np.nanmax(np.abs(beads.position[:, 2])) > FLAT:
        bead = int(np.nanargmax(np.abs(beads.position[:, 2])))
        raise UserError(
            f"{path}: two dimensions, and bead {bead} is at z = {beads.position[bead, 2]:g}; "
            "allowed: 0"
        )
    edges = box_of_file(box[:dimension], box[3:], path)
    position = beads.position[:, :dimension].T.astype(float) + centre(edges)
    velocity = beads.velocity[:, :dimension].T.astype(float)
    return checked(
        Particles(
            box=edges,
            position=position,
            image=beads.image[:, :dimension].T,
            velocity=velocity if velocity.any() else None,  # 0 where a file has none
            species=beads.typeid.astype(np.int64),
            names=tuple(beads.types),
            bonds=frame.bonds.group.astype(np.int64).reshape(-1, 2),
            angles=frame.angles.group.astype(np.int64).reshape(-1, 3),
            step=int(configuration.step),
            left_out=tuple(_left_out(frame)),
            masses=_masses(beads),
        ),
        path,
    )


def _decimal(number):
    """The shortest decimal that single precision rounds to a number: 6.3, not 6.300000191.

    The library keeps boxes in single precision, whatever the precision of positions.
    """
    return float(str(np.float32(number)))


def _masses(beads):
    """(types,) array of masses by type; None where all are 1, or where beads of a type differ."""
    types, masses = np.asarray(beads.typeid), np.asarray(beads.mass, float)
    if masses.shape != types.shape or (masses == 1).all():
        return None
    table = np.ones(len(beads.types))
    known = types < len(table)
    table[types[known]] = masses[known]
    alike = known.all() and (table[types] == masses).all()
    return np.array([_decimal(mass) for mass in table]) if alike else None


def _left_out(frame):
    """What a frame has that is lost, a sentence each."""
    for name, nothing in OTHERS.items():
        values = getattr(frame.particles, name)
        if not np.array_equal(values, np.broadcast_to(nothing, np.shape(values))):
            yield f"{name} is left out: beads have none here"
    masses = np.asarray(frame.particles.mass)
    if _masses(frame.particles) is None and not (masses == 1).all():
        yield "mass is left out: beads of one type differ in it, here they do not"
    for name in MORE_BONDS:
        if getattr(frame, name).N:
            yield f"{getattr(frame, name).N} {name} are left out: there are none here"
    for name in ("bonds", "angles"):
        types = len(getattr(frame, name).types or ())
        if types > 1:
            yield f"{name} of {types} types become {name} of one type"


def frame_of(particles: Particles, precision: type = np.float64) -> gsd.hoomd.Frame:
    """Particles as a frame of the library, positions and velocities with some precision."""
    frame = gsd.hoomd.Frame()
    configuration, beads = frame.configuration, frame.particles
    dimension = particles.dimension
    configuration.step = particles.step
    configuration.dimensions = dimension
    configuration.box = [*particles.box, *[THICKNESS] * (3 - dimension)]
    configuration.box += tilt_factors(particles.box)
    beads.N = particles.beads
    beads.types = list(particles.names)
    beads.typeid = particles.species.astype(np.uint32)
    position, image = in_tilted_box(particles)
    beads.position = _columns(position - centre(particles.box), precision)
    beads.image = _columns(image, np.int32)
    if particles.velocity is not None:
        beads.velocity = _columns(particles.velocity, precision)
    if particles.masses is not None:
        beads.mass = particles.masses[particles.species].astype(np.float32)
    for kind in ("bond", "angle"):
        members, table = getattr(particles, f"{kind}s"), getattr(frame, f"{kind}s")
        if len(members):
            table.N, table.types, table.group = len(members), [kind], members
            table.typeid = np.zeros(len(members), np.uint32)
    return frame


def _columns(array, kind):
    """(n, 3) array of a (dimension, n) one; 0 along the axis that is not there."""
    found = np.zeros((array.shape[1], 3), kind)
    found[:, : len(array)] = array.T
    return found


def write_gsd(particles: Particles, path: Path) -> None:
    """Write one configuration in double precision."""
    path.touch()  # with the rights of any new file; the library would take some away
    opened = gsd.fl.open(str(path), "w", APPLICATION, "hoomd", SCHEMA)
    with gsd.hoomd.HOOMDTrajectory(opened, precision="double") as trajectory:
        trajectory.append(frame_of(particles))
