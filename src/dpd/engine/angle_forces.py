"""Forces of angles between bonds, batch by batch with the bonds themselves.

A batch of bonds holds whole molecules, and so all beads of their angles: the thread that works on
the bonds of a batch goes on with its angles, and no other thread pushes these beads meanwhile.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.pair_forces import CLOSEST
from dpd.engine.space import nearest_images
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_BONDS
from dpd.engine.vectors.rows import push_apart
from dpd.jit import part
from dpd.physics.angle import Angle, AngleTable
from dpd.physics.forces import curvature, energy, force


class Angles(NamedTuple):
    """The angles of a system.

    Attributes
    ----------
    law : Angle or AngleTable
        What acts in each.
    members : (n, 3) uint32 array
        Identities of the three beads, the middle one in between.
    batch : (batches + 1,) int64 array
        Where batches of angles begin and end: those of the molecules of each batch of bonds.
    """

    law: Angle | AngleTable
    members: np.ndarray
    batch: np.ndarray


class Opening(NamedTuple):
    """The shape of an angle i-j-k, as its forces need it.

    Attributes
    ----------
    theta, cosine, sine : float
    over_i, over_k : float
        One over the lengths of the two bonds; 0 for a bond without a length.
    """

    theta: float
    cosine: float
    sine: float
    over_i: float
    over_k: float


@part()
def over_length(bond, b, dimension):
    """One over the length of column ``b``; 0 for no length, where there is no direction."""
    r2 = 0.0
    for k in range(dimension):
        r2 += bond[k, b] * bond[k, b]
    return np.sqrt(r2) / (r2 + CLOSEST)


@part()
def opening(to_i, to_k, b, dimension):
    """The angle between columns ``b`` of two (dimension, n) arrays.

    The sine is taken from the part of one bond across the other: of the cosine near a straight
    angle it would be the root of a rounding error.
    """
    over_i, over_k = over_length(to_i, b, dimension), over_length(to_k, b, dimension)
    cosine = 0.0
    for k in range(dimension):
        cosine += to_i[k, b] * over_i * (to_k[k, b] * over_k)
    across = 0.0
    for k in range(dimension):
        part_across = to_k[k, b] * over_k - cosine * (to_i[k, b] * over_i)
        across += part_across * part_across
    sine = np.sqrt(across)
    return Opening(np.arctan2(sine, cosine), cosine, sine, over_i, over_k)


@part()
def gather_angles(to_i, to_k, slots, position, slot, angles, begin, space):
    """Fill slots of the three beads, and the bonds from the middle bead to the other two."""
    n = np.uint64(slots.shape[1])
    for a in range(n):
        for m in range(3):
            slots[m, a] = slot[angles.members[begin + a, m]]
    for a in range(n):
        i, j, k = slots[0, a], slots[1, a], slots[2, a]
        for axis in range(len(space.edges)):
            to_i[axis, a] = position[i, axis] - position[j, axis]
            to_k[axis, a] = position[k, axis] - position[j, axis]
    nearest_images(to_i, n, space)
    nearest_images(to_k, n, space)


@part()
def add_angle_forces(total, position, slot, angles, batch, space, sums, measure):
    """Add the forces of the angles of a batch, and their virial and energy if asked.

    Parameters
    ----------
    total, position : arrays with a row for each bead
        The force; in storage order.
    slot : (n,) array
        From `dpd.engine.bond_forces.find_slots`.
    angles : None or Angles
    batch : int
    space : Space
    sums : Sums
    measure : bool

    Notes
    -----
    With e_i and e_k along the bonds from the middle bead, r_i and r_k their lengths, and F the
    derivative -du/dtheta, bead i feels -F (e_k - cos(theta) e_i) / (r_i sin(theta)), bead k the
    same with i and k exchanged, and the middle bead the opposite of both. In a straight angle no
    direction is across, and where F is not 0 there either, the force is 0.
    """
    if angles is None:
        return
    dimension, begin = len(space.edges), np.uint64(angles.batch[batch])
    n = np.uint64(angles.batch[batch + 1]) - begin
    slots = np.empty((3, n), np.uint32)
    to_i, to_k = np.empty((dimension, n)), np.empty((dimension, n))
    push_i, push_k = np.empty((dimension, n)), np.empty((dimension, n))
    gather_angles(to_i, to_k, slots, position, slot, angles, begin, space)
    for a in range(n):
        at = opening(to_i, to_k, a, dimension)
        across = -force(angles.law, at.theta, begin + a) * at.sine / (at.sine * at.sine + CLOSEST)
        for k in range(dimension):
            e_i, e_k = to_i[k, a] * at.over_i, to_k[k, a] * at.over_k
            push_i[k, a] = across * at.over_i * (e_k - at.cosine * e_i)
            push_k[k, a] = across * at.over_k * (e_i - at.cosine * e_k)
        if measure:
            sums.energy[OF_BONDS] += energy(angles.law, at.theta, begin + a)
    for a in range(n):
        push_apart(total, slots[0, a], slots[1, a], 1.0, push_i, a, space)
        push_apart(total, slots[2, a], slots[1, a], 1.0, push_k, a, space)
    if measure:
        for a in range(n):
            for k in range(dimension):
                for m in range(dimension):
                    moment = to_i[k, a] * push_i[m, a] + to_k[k, a] * push_k[m, a]
                    sums.virial[CONSERVATIVE, k, m] += moment
                    sums.virial[ALL_FORCES, k, m] += moment


@part()
def angle_curvature(position, slot, angles, space):
    """The part of angles in the Laplacian of the potential, summed over their three beads.

    With c and s the cosine and sine of theta, d the dimension, and beads as above, the squared
    gradients of theta add up to 2 / r_i^2 + 2 / r_k^2 - 2 c / (r_i r_k), and its Laplacians to
    2 (d - 2) (c (1 / r_i^2 + 1 / r_k^2) - 1 / (r_i r_k)) / s.
    """
    if angles is None:
        return 0.0
    dimension, n, total = len(space.edges), np.uint64(len(angles.members)), 0.0
    slots = np.empty((3, n), np.uint32)
    to_i, to_k = np.empty((dimension, n)), np.empty((dimension, n))
    gather_angles(to_i, to_k, slots, position, slot, angles, np.uint64(0), space)
    for a in range(n):
        at = opening(to_i, to_k, a, dimension)
        over_s = at.sine / (at.sine * at.sine + CLOSEST)
        squares = at.over_i * at.over_i + at.over_k * at.over_k
        product = at.over_i * at.over_k
        total += curvature(angles.law, at.theta, a) * 2.0 * (squares - at.cosine * product)
        bend = 2.0 * (dimension - 2) * over_s * (at.cosine * squares - product)
        total -= force(angles.law, at.theta, a) * bend
    return total
