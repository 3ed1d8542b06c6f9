"""Forces of bonds and of the angles between them, in batches that threads share."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.angle_forces import Angles, add_angle_forces, angle_curvature
from dpd.engine.pair_forces import CLOSEST
from dpd.engine.space import nearest_images, squared_distance
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_BONDS
from dpd.engine.vectors.rows import push_apart
from dpd.jit import part
from dpd.physics.angle import Angle, AngleTable
from dpd.physics.bond import Bond, BondTable
from dpd.physics.forces import curvature, energy, force_over_r

if TYPE_CHECKING:
    from dpd.engine.state import System

BONDS_AT_ONCE = 512  # in a batch, or a few more: their buffers stay in cache


class Bonded(NamedTuple):
    """The bonds of a system, and the angles between them.

    Attributes
    ----------
    law : Bond or BondTable
        What acts along each.
    members : (n, 2) uint32 array
        Identities of the two ends.
    batch : (batches + 1,) int64 array
        Where batches of bonds begin and end. No two batches have a bead in common, so
        threads may work on them at the same time.
    angles : None or Angles
    """

    law: Bond | BondTable
    members: np.ndarray
    batch: np.ndarray
    angles: Angles | None = None


def bonded_of(system: System) -> Bonded | None:
    """Bonds and angles of a system as kernels take them; None for a system without bonds."""
    bonds = in_batches(system.bond, system.members)
    if bonds is None:
        return None
    return bonds._replace(angles=_angles(system, bonds))


def _angles(system, bonds):
    """`Angles`, cut into the batches of the bonds between them."""
    if system.angle is None:
        return None
    members = np.ascontiguousarray(system.angle_members, dtype=np.uint32)
    # Batches are cut between molecules, where all numbers of beads go up.
    lowest = np.minimum.reduceat(bonds.members.min(axis=1), bonds.batch[:-1])
    of_batch = np.searchsorted(lowest, members.min(axis=1), side="right") - 1
    order = np.argsort(of_batch, kind="stable")
    batch = np.searchsorted(of_batch[order], np.arange(len(lowest) + 1)).astype(np.int64)
    law = _as_compiled(system.angle)
    if isinstance(law, AngleTable):
        law = law._replace(number=law.number[order])
    return Angles(law, members[order], batch)


def _as_compiled(law):
    """A law or a table with the types that kernels are compiled for."""
    if isinstance(law, Bond | Angle):
        return type(law)(*map(float, law))
    *values, number = law
    columns = (np.ascontiguousarray(value, dtype=np.float64) for value in values)
    return type(law)(*columns, np.ascontiguousarray(number, dtype=np.uint16))


def in_batches(bond: Bond | BondTable | None, members: np.ndarray | None) -> Bonded | None:
    """`Bonded`, cut into batches between molecules that are numbered one after the other.

    None for a system without bonds.
    """
    if bond is None:
        return None
    members = np.ascontiguousarray(members, dtype=np.uint32)
    highest = np.maximum.accumulate(members.max(axis=1))
    lowest = np.minimum.accumulate(members.min(axis=1)[::-1])[::-1]
    cuts = 1 + np.flatnonzero(highest[:-1] < lowest[1:])
    batch = [0]  # type: list[int | np.integer]
    for cut in cuts:
        if cut - batch[-1] >= BONDS_AT_ONCE:
            batch.append(cut)
    batch.append(len(members))
    return Bonded(_as_compiled(bond), members, np.array(batch, np.int64))


@part()
def empty_slots(bonds, beads):
    """Where the slot of each identity will be, if there are bonds."""
    if bonds is None:
        return None
    return np.empty(beads, np.uint32)


@part()
def find_slots(slot, identity, mine):
    """Slots of a thread's share of the beads by identity, if there are bonds."""
    if slot is not None:
        for s in range(mine.first, mine.end):
            slot[identity[s]] = np.uint32(s)


@part()
def batches(bonds):
    """Number of batches."""
    if bonds is None:
        return 0
    return len(bonds.batch) - 1


@part()
def add_bond_forces(total, position, slot, bonds, batch, space, sums, measure):
    """Add the forces of a batch of bonds and of the angles between them.

    If asked, their virial and energy are added up.

    Parameters
    ----------
    total, position : arrays with a row for each bead
        The force; in storage order.
    slot : None or (n,) array
        From `find_slots`.
    bonds : None or Bonded
    batch : int
    space : Space
    sums : Sums
    measure : bool
    """
    if bonds is None:
        return
    dimension, begin = len(space.edges), np.uint64(bonds.batch[batch])
    n = np.uint64(bonds.batch[batch + 1]) - begin
    ends = np.empty((2, n), np.uint32)
    apart = np.empty((dimension, n))
    over_r = np.empty(n)
    for b in range(n):
        ends[0, b] = slot[bonds.members[begin + b, 0]]
        ends[1, b] = slot[bonds.members[begin + b, 1]]
    for b in range(n):
        i, j = ends[0, b], ends[1, b]
        for k in range(dimension):
            apart[k, b] = position[i, k] - position[j, k]
    nearest_images(apart, n, space)
    for b in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += apart[k, b] * apart[k, b]
        over_r[b] = force_over_r(bonds.law, np.sqrt(r2), begin + b)
    for b in range(n):
        push_apart(total, ends[0, b], ends[1, b], over_r[b], apart, b, space)
    if measure:
        for b in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += apart[k, b] * apart[k, b]
                for m in range(dimension):
                    moment = over_r[b] * apart[k, b] * apart[m, b]
                    sums.virial[CONSERVATIVE, k, m] += moment
                    sums.virial[ALL_FORCES, k, m] += moment
            sums.energy[OF_BONDS] += energy(bonds.law, np.sqrt(r2), begin + b)
    add_angle_forces(total, position, slot, bonds.angles, batch, space, sums, measure)


@part()
def bond_curvature(position, slot, bonds, space):
    """The part of bonds and angles in the Laplacian of the potential.

    Of a bond, that is u'' + (d - 1) u' / r at both ends.
    """
    if bonds is None:
        return 0.0
    dimension, total = len(space.edges), 0.0
    for b in range(len(bonds.members)):
        i, j = slot[bonds.members[b, 0]], slot[bonds.members[b, 1]]
        r = np.sqrt(CLOSEST + squared_distance(position, i, position, j, space))
        over_r = force_over_r(bonds.law, r, b)
        total += 2.0 * (curvature(bonds.law, r, b) - (dimension - 1) * over_r)
    return total + angle_curvature(position, slot, bonds.angles, space)
