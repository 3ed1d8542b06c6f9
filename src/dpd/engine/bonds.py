"""Harmonic bonds: a pull of C (r - length) along each (Groot and Warren 1997, Eq. 25)."""

import numpy as np

from dpd.engine.forces import CLOSEST
from dpd.engine.jit import part


@part()
def bonded_slots(bonds, identity):
    """(2, n) storage slots of the ends of each bond, for as long as the order lasts."""
    if bonds is None:
        return None
    members = bonds[0]
    slot = np.empty(len(identity), np.uint32)
    for s in range(len(identity)):
        slot[identity[s]] = s
    slots = np.empty((2, len(members)), np.uint32)
    for b in range(len(members)):
        slots[0, b] = slot[members[b, 0]]
        slots[1, b] = slot[members[b, 1]]
    return slots


@part()
def add_bond_forces(force, position, slots, bonds, box, measure, sums):
    """Add the forces of all bonds, and their virial and energy if asked.

    Parameters
    ----------
    force, position : (dimension, n) arrays
        In storage order.
    slots : None or (2, n) array
        From `bonded_slots`.
    bonds : None or (members, stiffness, length)
        ``members`` is an (n, 2) array of identities.
    """
    if bonds is None:
        return
    virial, energy = sums
    _, stiffness, length = bonds
    dimension, n = len(box), slots.shape[1]
    apart = np.empty((dimension, n))
    over_r = np.empty(n)
    for k in range(dimension):
        edge = box[k]
        for b in range(n):
            d = position[k, slots[0, b]] - position[k, slots[1, b]]
            apart[k, b] = d - edge * np.rint(d / edge)
    for b in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += apart[k, b] * apart[k, b]
        over_r[b] = -stiffness * (1.0 - length / np.sqrt(r2))
    for b in range(n):
        i, j = slots[0, b], slots[1, b]
        for k in range(dimension):
            pull = over_r[b] * apart[k, b]
            force[k, i] += pull
            force[k, j] -= pull
    if measure:
        for b in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += apart[k, b] * apart[k, b]
                for m in range(dimension):
                    moment = over_r[b] * apart[k, b] * apart[m, b]
                    virial[0, k, m] += moment
                    virial[1, k, m] += moment
            energy[1] += 0.5 * stiffness * (np.sqrt(r2) - length) ** 2
