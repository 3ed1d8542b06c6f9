"""The compiled loop with a pair list, for small time steps.

Where beads hardly move in a step, pairs within the cutoff and a skin are listed once and
the list serves until some bead has moved half the skin. Between rebuilds the beads stay in
the order of the last sort, and the list follows from the positions at that time (the
reference), so a resumed run has the same list in the same order.
"""

import numpy as np
from numba import uint64

from dpd.engine.advance import cells_in, count_cells, drift, like, sort_by_cell
from dpd.engine.bath import add_bath_forces
from dpd.engine.bonds import add_bond_forces, bonded_slots
from dpd.engine.cells import pair_buffers, row_buffers, row_pairs
from dpd.engine.forces import add_pair_forces, measure_pairs
from dpd.engine.friction import keep_pairs, kept_buffers, renew_friction
from dpd.engine.jit import kernel, part
from dpd.engine.noise import step_keys

CHUNK = 1024  # pairs whose forces are worked out together: their buffers stay in cache


@part()
def list_pairs(position, start, box, shape, ahead, reach, fullest):
    """All pairs within ``reach`` of beads that are sorted by cell, as an (2, n) array."""
    pairs = row_buffers(start, box, shape, ahead, fullest)
    listed = np.empty((2, 8 * position.shape[1]), np.uint32)
    total = 0
    for row in range((len(start) - 1) // shape[len(box) - 1]):
        n = np.int64(row_pairs(row, position, start, box, shape, ahead, reach, fullest, pairs))
        if total + n > listed.shape[1]:
            larger = np.empty((2, 2 * (total + n)), np.uint32)
            larger[:, :total] = listed[:, :total]
            listed = larger
        listed[0, total : total + n] = pairs.i[:n]
        listed[1, total : total + n] = pairs.j[:n]
        total += n
    return listed[:, :total].copy()


@part()
def moved_too_far(position, reference, box, limit):
    """Whether some bead is further than ``limit`` from where the list was made."""
    farthest = 0.0
    for i in range(position.shape[1]):
        r2 = 0.0
        for k in range(len(box)):
            d = position[k, i] - reference[k, i]
            d -= box[k] * np.rint(d / box[k])
            r2 += d * d
        farthest = max(farthest, r2)
    return farthest > limit * limit


@part()
def list_force(beads, force, listed, slots, pairs, fields, box, keys, measure, sums, kept):
    """Evaluate all forces; pairs in the skin have w = 0 and feel none. Return the pairs."""
    position, _, predicted, identity, species = beads
    virial, energy = sums
    bonds, core = fields[3], fields[4]
    force[:] = 0.0
    total = uint64(listed.shape[1])
    for first in range(uint64(0), total, uint64(CHUNK)):
        n = min(uint64(CHUNK), uint64(total - first))
        for p in range(n):
            pairs.i[p] = listed[0, first + p]
            pairs.j[p] = listed[1, first + p]
        for k in range(len(box)):
            edge = box[k]
            for p in range(n):
                d = position[k, pairs.i[p]] - position[k, pairs.j[p]]
                pairs.separation[k, p] = d - edge * np.rint(d / edge)
        add_pair_forces(force, pairs, n, predicted, identity, species, box, fields, keys)
        kept = keep_pairs(kept, np.int64(first), pairs, n, fields[1][0], box)
        if measure:
            measure_pairs(virial, energy, pairs, n, box, core)
    add_bond_forces(force, position, slots, bonds, box, measure, sums)
    add_bath_forces(force, predicted, identity, fields[5], fields[2], box, keys)
    return kept


@kernel()
def advance_with_list(
    beads, reference, force, fields, box, shape, ahead, skin, dt, scheme, seed, step, steps, measure
):
    """Advance by ``steps`` steps like `dpd.engine.advance.advance`, with a pair list.

    Parameters
    ----------
    reference : (dimension, n) array
        Where the beads were at the last sort, in today's order; ignored for 0 steps,
        which sort and list afresh.
    shape : tuple
        Cells along each axis, with edges of at least 1 + ``skin``.
    skin : float
        Distance beyond the cutoff within which pairs are listed.

    Returns
    -------
    beads, reference, force, sums, lost
        As there.
    """
    position, velocity, identity, species = beads
    source = (position, velocity, velocity.copy(), identity, species)
    target = (
        np.empty_like(position), np.empty_like(position), np.empty_like(position),
        np.empty_like(identity), like(species),
    )  # fmt: skip
    start = np.empty(cells_in(shape) + 1, np.uint32)
    pairs = pair_buffers(len(box), CHUNK)
    sums = (np.zeros((2, len(box), len(box))), np.zeros(2))
    correction = scheme[2]
    kept = kept_buffers(scheme[3], len(box), 4 * position.shape[1])
    lost = (-1, step, 0.0)
    if steps == 0:
        fullest = sort_by_cell(source, target, box, shape, start)
        source, target = target, source
        reference = source[0].copy()
    else:
        fullest = count_cells(reference, box, shape, start)
    listed = list_pairs(reference, start, box, shape, ahead, 1.0 + skin, fullest)
    slots = bonded_slots(fields[3], source[3])
    for s in range(max(steps, 1)):
        if steps > 0:
            step += 1
            bead, distance = drift(source[0], source[1], source[2], force, box, dt, scheme)
            if bead >= 0:
                lost = (np.int64(source[3][bead]), step, distance)
                break
            if moved_too_far(source[0], reference, box, 0.5 * skin):
                fullest = sort_by_cell(source, target, box, shape, start)
                source, target = target, source
                reference = source[0].copy()
                listed = list_pairs(reference, start, box, shape, ahead, 1.0 + skin, fullest)
                slots = bonded_slots(fields[3], source[3])
        keys = step_keys(seed, step)
        last = measure and s + 1 >= steps
        kept = list_force(source, force, listed, slots, pairs, fields, box, keys, last, sums, kept)
        if steps > 0 and correction > 0.0:
            source[1][:] += (correction * dt) * force
            renew_friction(force, kept, listed.shape[1], source[1], source[2], fields[5], box)
    return (source[0], source[1], source[3], source[4]), reference, force, sums, lost
