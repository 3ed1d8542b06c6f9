"""Forces of bonds and of the angles between them, in batches that threads share.

A batch holds whole molecules, and so all beads of their angles: the thread that works on its bonds
goes on with its angles, and no other thread pushes these beads meanwhile.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import uint32, uint64

from dpd.engine.pair import CLOSEST
from dpd.engine.rows import nearest_images, push_apart
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_BONDS
from dpd.jit import inlined
from dpd.physics.common.forces import curvature, energy, force, force_over_r, law_of

if TYPE_CHECKING:
    from dpd.engine.state import System

BONDS_AT_ONCE = 512  # in a batch, or a few more: their buffers stay in cache


class Bonded(NamedTuple):
    """The bonds of a system, or its angles, in the same batches."""

    law: Any  # what acts in each
    members: np.ndarray  # (n, 2 or 3) uint32: identities, that in the middle of an angle as second
    batch: np.ndarray  # (batches + 1,) int64: where each begins, and the end


class Arms(NamedTuple):
    """Buffers for some bonds, or for one side of some angles."""

    # (size,) uint32: slots of the two beads
    i: np.ndarray
    j: np.ndarray
    apart: np.ndarray  # (dimension, size): r_i - r_j at the nearest image
    scale: np.ndarray  # (size,): F / r of a bond
    push: np.ndarray  # (dimension, size): what an angle does to bead i


class Opening(NamedTuple):
    """The shape of an angle i-j-k, as its forces need it."""

    theta: float
    cosine: float
    sine: float
    # one over the lengths of the two bonds; 0 for a bond without a length
    over_i: float
    over_k: float


def bonds_of(system: System) -> Bonded | None:
    """Bonds, cut into batches between molecules that are numbered one after the other."""
    if system.bond is None:
        return None
    members = np.ascontiguousarray(system.members, dtype=np.uint32)
    highest = np.maximum.accumulate(members.max(axis=1))
    lowest = np.minimum.accumulate(members.min(axis=1)[::-1])[::-1]
    cuts = 1 + np.flatnonzero(highest[:-1] < lowest[1:])
    batch = [0]  # type: list[int | np.integer]
    for cut in cuts:
        if cut - batch[-1] >= BONDS_AT_ONCE:
            batch.append(cut)
    batch.append(len(members))
    return Bonded(_as_compiled(system.bond), members, np.array(batch, np.int64))


def angles_of(system: System, bonds: Bonded | None) -> Bonded | None:
    """Angles, cut into the batches of the bonds between them."""
    if system.angle is None or bonds is None:
        return None
    members = np.ascontiguousarray(system.angle_members, dtype=np.uint32)
    # Batches are cut between molecules, where all numbers of beads go up.
    lowest = np.minimum.reduceat(bonds.members.min(axis=1), bonds.batch[:-1])
    of_batch = np.searchsorted(lowest, members.min(axis=1), side="right") - 1
    order = np.argsort(of_batch, kind="stable")
    batch = np.searchsorted(of_batch[order], np.arange(len(lowest) + 1)).astype(np.int64)
    law = _as_compiled(system.angle)
    if law.number is not None:
        law = law._replace(number=law.number[order])
    return Bonded(law, members[order], batch)


def _as_compiled(law):
    """A law or a table with the types that kernels are compiled for."""
    *values, number = law
    if number is None:
        return type(law)(*map(float, values), None)
    columns = (np.ascontiguousarray(value, dtype=np.float64) for value in values)
    return type(law)(*columns, np.ascontiguousarray(number, dtype=np.uint16))


def buffers_of(dimension: int, *bonded: Bonded | None) -> Arms | None:
    """Room for the largest batch of some bonds or angles."""
    there = [each for each in bonded if each is not None]
    if not there:
        return None
    size = max(int(np.diff(each.batch).max()) for each in there)
    return Arms(
        np.empty(size, np.uint32), np.empty(size, np.uint32), np.empty((dimension, size)),
        np.empty(size), np.empty((dimension, size)),
    )  # fmt: skip


@inlined(given="slot")
def find_slots(slot, identity, mine):
    """Slots of a thread's share of the beads by identity, if there are bonds."""
    for s in range(mine.first, mine.end):
        slot[identity[s]] = uint32(s)


@inlined()
def gather(arms, bonded, task, x, slot, outer, edges, slide):
    """Fill the arms of a batch, from members 1 to those in column ``outer`` or, of bonds, back.

    Return the first of the batch, and how many there are.
    """
    i, j, apart, members = arms.i, arms.j, arms.apart, bonded.members
    begin, n = uint64(bonded.batch[task]), uint64(bonded.batch[task + 1] - bonded.batch[task])
    for b in range(n):
        i[b] = slot[members[begin + b, outer]]
        j[b] = slot[members[begin + b, 1]]
    for b in range(n):
        for k in range(len(edges)):
            apart[k, b] = x[i[b], k] - x[j[b], k]
    nearest_images(apart, n, edges, slide)
    return begin, n


@inlined()
def length(apart, b, edges):
    """Length of column ``b``, at least such that one may divide by it."""
    r2 = CLOSEST
    for k in range(len(edges)):
        r2 += apart[k, b] * apart[k, b]
    return np.sqrt(r2)


@inlined(given="arms")
def add_bonds(f, x, slot, bonds, task, arms, virial, sums, measure, edges, slide):
    """Add the forces of a batch of bonds, if there are any; if asked, their virial and energy."""
    first, n = gather(arms, bonds, task, x, slot, 0, edges, slide)
    apart, over_r = arms.apart, arms.scale
    for b in range(n):
        over_r[b] = force_over_r(law_of(bonds.law, first + b), length(apart, b, edges))
    for b in range(n):
        push_apart(f, arms.i[b], arms.j[b], over_r[b], apart, b, edges)
    if measure:
        for b in range(n):
            sums[OF_BONDS] += energy(law_of(bonds.law, first + b), length(apart, b, edges))
            for k in range(len(edges)):
                add_moment(virial, k, over_r[b] * apart[k, b], apart, b, edges)


@inlined()
def add_moment(virial, k, push, apart, b, edges):
    """Add to both virials what a push along axis k does at a separation."""
    for m in range(len(edges)):
        virial[CONSERVATIVE, m, k] += apart[m, b] * push
        virial[ALL_FORCES, m, k] += apart[m, b] * push


@inlined()
def over_length(apart, b, edges):
    """One over the length of column ``b``; 0 for no length, where there is no direction."""
    r2 = 0.0
    for k in range(len(edges)):
        r2 += apart[k, b] * apart[k, b]
    return np.sqrt(r2) / (r2 + CLOSEST)


@inlined()
def opening(to_i, to_k, b, edges):
    """The angle between columns ``b`` of two (dimension, n) arrays.

    The sine is taken from the part of one bond across the other: of the cosine near a straight
    angle it would be the root of a rounding error.
    """
    over_i, over_k = over_length(to_i, b, edges), over_length(to_k, b, edges)
    cosine, across = 0.0, 0.0
    for k in range(len(edges)):
        cosine += to_i[k, b] * over_i * (to_k[k, b] * over_k)
    for k in range(len(edges)):
        aside = to_k[k, b] * over_k - cosine * (to_i[k, b] * over_i)
        across += aside * aside
    sine = np.sqrt(across)
    return Opening(np.arctan2(sine, cosine), cosine, sine, over_i, over_k)


@inlined(given="angles")
def add_angles(f, x, slot, angles, task, arms, others, virial, sums, measure, edges, slide):
    """Add the forces of a batch of angles, if there are any; if asked, their virial and energy.

    With e_i and e_k along the bonds from the middle bead, r_i and r_k their lengths, and F the
    derivative -du/dtheta, bead i feels -F (e_k - cos(theta) e_i) / (r_i sin(theta)), bead k the
    same with i and k exchanged, and the middle bead the opposite of both. In a straight angle no
    direction is across, and where F is not 0 there either, the force is 0.
    """
    gather(arms, angles, task, x, slot, 0, edges, slide)
    first, n = gather(others, angles, task, x, slot, 2, edges, slide)
    law, to_i, to_k, push_i, push_k = angles.law, arms.apart, others.apart, arms.push, others.push
    for a in range(n):
        at = opening(to_i, to_k, a, edges)
        across = -force(law_of(law, first + a), at.theta) * at.sine / (at.sine * at.sine + CLOSEST)
        for k in range(len(edges)):
            e_i, e_k = to_i[k, a] * at.over_i, to_k[k, a] * at.over_k
            push_i[k, a] = across * at.over_i * (e_k - at.cosine * e_i)
            push_k[k, a] = across * at.over_k * (e_i - at.cosine * e_k)
        if measure:
            sums[OF_BONDS] += energy(law_of(law, first + a), at.theta)
    for a in range(n):
        push_apart(f, arms.i[a], arms.j[a], 1.0, push_i, a, edges)
        push_apart(f, others.i[a], others.j[a], 1.0, push_k, a, edges)
    if measure:
        for a in range(n):
            for k in range(len(edges)):
                add_moment(virial, k, push_i[k, a], to_i, a, edges)
                add_moment(virial, k, push_k[k, a], to_k, a, edges)


@inlined()
def bond_curvature(x, slot, bonds, arms, edges):
    """The part of bonds in the Laplacian of the potential: u'' + (d - 1) u' / r at both ends."""
    if bonds is None:
        return 0.0
    total, (_, n) = 0.0, gather(arms, bonds, 0, x, slot, 0, edges, None)
    for b in range(n):
        r = length(arms.apart, b, edges)
        law = law_of(bonds.law, b)
        over_r = force_over_r(law, r)
        total += 2.0 * (curvature(law, r) - (len(edges) - 1) * over_r)
    return total


@inlined()
def angle_curvature(x, slot, angles, arms, others, edges):
    """The part of angles in the Laplacian of the potential, summed over their three beads.

    With c and s the cosine and sine of theta, d the dimension, and beads as above, the squared
    gradients of theta add up to 2 / r_i^2 + 2 / r_k^2 - 2 c / (r_i r_k), and its Laplacians to
    2 (d - 2) (c (1 / r_i^2 + 1 / r_k^2) - 1 / (r_i r_k)) / s.
    """
    if angles is None:
        return 0.0
    gather(arms, angles, 0, x, slot, 0, edges, None)
    total, (_, n) = 0.0, gather(others, angles, 0, x, slot, 2, edges, None)
    for a in range(n):
        at = opening(arms.apart, others.apart, a, edges)
        over_s = at.sine / (at.sine * at.sine + CLOSEST)
        squares = at.over_i * at.over_i + at.over_k * at.over_k
        product = at.over_i * at.over_k
        law = law_of(angles.law, a)
        total += curvature(law, at.theta) * 2.0 * (squares - at.cosine * product)
        bend = 2.0 * (len(edges) - 2) * over_s * (at.cosine * squares - product)
        total -= force(law, at.theta) * bend
    return total
