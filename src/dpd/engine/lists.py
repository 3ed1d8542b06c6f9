"""A list of pairs that serves for several steps."""

import numpy as np

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
            larger = np.empty((2, 2 * (total + n)), np.uint32)
            larger[:, :total] = listed[:, :total]
            listed = larger
        listed[0, total : total + n] = pairs.i[:n]
        listed[1, total : total + n] = pairs.j[:n]
        total += n
    return listed[:, :total].copy()


@part()
def list_again(reference, steps, cells, box, grid, skin):
    """The list that was made at the reference; None where there is none.

    Before 0 steps, which sort and list afresh, it is empty.
    """
    if reference is None:
        return None
    if steps == 0:
        return np.empty((2, 0), np.uint32)
    find_cells(reference, box, grid, cells)
    return list_pairs(reference, cells, box, grid, 1.0 + skin)


@part()
def list_anew(reference, position, cells, box, grid, skin):
    """Reference and list of beads just sorted; None for both where there was none."""
    if reference is None:
        return None, None
    return position.copy(), list_pairs(position, cells, box, grid, 1.0 + skin)


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
