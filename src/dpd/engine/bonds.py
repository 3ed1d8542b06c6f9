"""Harmonic bonds: a pull of C (r - length) along each (Groot and Warren 1997, Eq. 25)."""

from typing import NamedTuple

import numpy as np

from dpd.engine.vectors.rows import push_apart
from dpd.jit import part
from dpd.physics.pair import CLOSEST

ENOUGH = 512  # bonds in a batch, or a few more: their buffers stay in cache


class Bonds(NamedTuple):
    """Bonds of a system.

    Attributes
    ----------
    members : (n, 2) uint32 array
        Identities of the two ends.
    stiffness, length : float
        C in kT / r_c^2, rest length in r_c.
    batch : (batches + 1,) int64 array
        Where batches of bonds begin and end. No two batches have a bead in common, so
        threads may work on them at the same time.
    """

    members: np.ndarray
    stiffness: float
    length: float
    batch: np.ndarray


def make_bonds(members, stiffness, length):
    """`Bonds`, cut into batches between molecules that are numbered one after the other."""
    members = np.ascontiguousarray(members, dtype=np.uint32)
    highest = np.maximum.accumulate(members.max(axis=1))
    lowest = np.minimum.accumulate(members.min(axis=1)[::-1])[::-1]
    cuts = 1 + np.flatnonzero(highest[:-1] < lowest[1:])
    batch = [0]
    for cut in cuts:
        if cut - batch[-1] >= ENOUGH:
            batch.append(cut)
    batch.append(len(members))
    return Bonds(members, float(stiffness), float(length), np.array(batch, np.int64))


@part()
def no_slots(bonds, beads):
    """Where the slot of each identity will be, if there are bonds."""
    if bonds is None:
        return None
    return np.empty(beads, np.uint32)


@part()
def find_slots(slot, identity, own):
    """Slots of the beads from own[0] to own[1] by identity, if there are bonds."""
    if slot is not None:
        for s in range(own[0], own[1]):
            slot[identity[s]] = np.uint32(s)


@part()
def batches(bonds):
    """Number of batches."""
    if bonds is None:
        return 0
    return len(bonds.batch) - 1


@part()
def add_bond_forces(force, position, slot, bonds, batch, box, measure, virial, energy):
    """Add the forces of a batch of bonds, and their virial and energy if asked.

    Parameters
    ----------
    force, position : arrays with a row for each bead
        In storage order.
    slot : None or (n,) array
        From `find_slots`.
    bonds : None or Bonds
    virial : (2, dimension, dimension) array
    energy : (2,) array
    """
    if bonds is None:
        return
    dimension, begin = len(box), np.uint64(bonds.batch[batch])
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
    for k in range(dimension):
        edge = box[k]
        for b in range(n):
            apart[k, b] -= edge * np.rint(apart[k, b] / edge)
    for b in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += apart[k, b] * apart[k, b]
        over_r[b] = -bonds.stiffness * (1.0 - bonds.length / np.sqrt(r2))
    for b in range(n):
        push_apart(force, ends[0, b], ends[1, b], over_r[b], apart, b, box)
    if measure:
        for b in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += apart[k, b] * apart[k, b]
                for m in range(dimension):
                    moment = over_r[b] * apart[k, b] * apart[m, b]
                    virial[0, k, m] += moment
                    virial[1, k, m] += moment
            energy[1] += 0.5 * bonds.stiffness * (np.sqrt(r2) - bonds.length) ** 2
