"""A list of pairs that serves for several steps."""

import numpy as np

from dpd.engine.arrays import columns
from dpd.engine.cells import find_cells
from dpd.engine.jit import part
from dpd.engine.search import next_pairs, search_buffers

CHUNK = 1024  # pairs whose forces are worked out together: their buffers stay in cache


@part()
def list_pairs(position, cells, box, grid, reach):
    """All pairs within ``reach`` of beads that are sorted by cell, as an (2, n) array."""
    line, pairs = search_buffers(cells.start, box, grid)
    listed = np.empty((2, 8 * position.shape[1]), np.uint32)
    total = 0
    at = (0, -1)
    while at[0] < position.shape[1]:
        at, found = next_pairs(at, position, cells, box, grid, reach, line, pairs)
        n = np.int64(found)
        if total + n > listed.shape[1]:
            listed = columns(listed, total, 2 * (total + n))
        for p in range(n):
            listed[0, total + p] = pairs.i[p]
            listed[1, total + p] = pairs.j[p]
        total += n
    return columns(listed, total, total)


@part()
def no_list(reference):
    """A list yet to be made; None where pairs are found by cells."""
    if reference is None:
        return None
    return np.empty((2, 0), np.uint32)


@part()
def listing(reference, position, sorted_now, first, listed, cells, box, grid, skin):
    """Reference and list after a sort, or for the first step of a call; else as they were.

    A call begins with the list that was made at its reference. (Numba drops the branch on
    None only of an argument that is never assigned to.)
    """
    if reference is None:
        return None, None
    made_at, pairs = reference, listed
    if sorted_now:
        made_at = position.copy()
    elif first:
        find_cells(made_at, box, grid, cells)
    if sorted_now or first:
        pairs = list_pairs(made_at, cells, box, grid, 1.0 + skin)
    return made_at, pairs


@part()
def moved_too_far(position, reference, box, limit):
    """Whether some bead is further than ``limit`` from where the list was made, if it was."""
    if reference is None:
        return True
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
def listed_pairs(first, position, listed, box, pairs):
    """Fill the pairs with up to `CHUNK` of the list from ``first`` on; return how many."""
    n = np.uint64(min(CHUNK, listed.shape[1] - first))
    start = np.uint64(first)
    for p in range(n):
        pairs.i[p] = listed[0, start + p]
        pairs.j[p] = listed[1, start + p]
    for k in range(len(box)):
        edge = box[k]
        for p in range(n):
            d = position[k, pairs.i[p]] - position[k, pairs.j[p]]
            pairs.separation[k, p] = d - edge * np.rint(d / edge)
    return n
