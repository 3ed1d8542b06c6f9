"""Pairs of beads closer than a cutoff, found row by row of cells.

A row of cells and the rows ahead of it are merged into one line of memory, level by level,
the row's own beads first in each level. The partners of a bead are then in one stretch, from
the level before its own to the one after. One long loop over distances and one over hits
take the place of many short ones with lengths that no processor can foresee.
"""

from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.cells import fullest
from dpd.engine.jit import part

U0, U1 = np.uint64(0), np.uint64(1)
ENOUGH = np.uint64(512)  # pairs that are worked on together: their buffers stay in cache
LANES = np.uint64(8)  # candidates are looked at in multiples of this
FAR = 1e6  # r_c; where the fillers at the end of a line are
HALF, LOW = np.uint64(32), np.uint64(0xFFFFFFFF)


class Pairs(NamedTuple):
    """Buffers for some pairs.

    ``separation[:, p]`` is r_i - r_j of pair p at its nearest image, ``scratch`` holds
    four numbers a pair, ``low`` and ``high`` the sorted identities.
    """

    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray
    scratch: np.ndarray
    low: np.ndarray
    high: np.ndarray


class Line(NamedTuple):
    """A row of cells merged with those ahead of it.

    Attributes
    ----------
    position : (dimension, size) array
    slot : (size,) uint32 array
        Where each bead is stored.
    first : (levels + 3,) int64 array
        Place of the first bead of each level, from -1 (the last one, a box before) to the
        number of levels (the first one, a box further); and where that ends.
    ahead : (levels + 1,) int64 array
        Place of the first bead that is not the row's own, from level -1 on.
    to : (rows, levels) int64 array
        What leads from slots to places, for each of the rows and each level.
    square : (widest,) array
        Squared distances from one bead.
    hit : (widest + `ENOUGH`,) uint64 array
        Places of both beads of each pair found, in one word.
    """

    position: np.ndarray
    slot: np.ndarray
    first: np.ndarray
    ahead: np.ndarray
    to: np.ndarray
    square: np.ndarray
    hit: np.ndarray


@part()
def pair_buffers(dimension, size):
    """Buffers for ``size`` pairs."""
    return Pairs(
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
        np.empty((dimension, size)),
        np.empty((4, size)),
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
    )


@part()
def search_buffers(start, box, grid):
    """A `Line` for the fullest rows, and `Pairs` for all that one call of `next_pairs` finds."""
    dimension, levels = len(box), grid.shape[len(box) - 1]
    rows = grid.base.shape[1]
    size = rows * (fullest(start, levels) + 2 * fullest(start, 1)) + int64(LANES)
    widest = 3 * rows * fullest(start, 1) + int64(LANES)
    line = Line(
        np.empty((dimension, size)),
        np.empty(size, np.uint32),
        np.empty(levels + 3, np.int64),
        np.empty(levels + 1, np.int64),
        np.empty((rows, levels), np.int64),
        np.empty(widest),
        np.empty(widest + int64(ENOUGH), np.uint64),
    )
    return line, pair_buffers(dimension, widest + int64(ENOUGH))


@part()
def merge_rows(row, position, cells, box, grid, line):
    """Fill a line with a row and those ahead of it."""
    start, level = cells
    last, levels = len(box) - 1, grid.shape[len(box) - 1]
    rows = grid.base.shape[1]
    place = 0
    for r in range(rows):  # room for the last level, a box before
        cell = grid.base[row, r] + levels - 1
        place += int64(start[cell + 1]) - int64(start[cell])
    for z in range(levels):
        line.first[z + 1] = place
        for r in range(rows):
            cell = grid.base[row, r] + z
            begin, end = int64(start[cell]), int64(start[cell + 1])
            line.to[r, z] = place - begin
            place += end - begin
            if r == 0:
                line.ahead[z + 1] = place
    line.first[levels + 1] = place
    for r in range(rows):
        base = grid.base[row, r]
        for s in range(uint64(start[base]), uint64(start[base + levels])):
            place = uint64(line.to[r, level[s]] + int64(s))
            for k in range(last):
                line.position[k, place] = position[k, s] + grid.shift[row, r, k]
            line.position[last, place] = position[last, s]
            line.slot[place] = uint32(s)
    join_ends(line, box, levels)


@part()
def join_ends(line, box, levels):
    """Put the last level before the first, the first after the last, fillers at the end."""
    first = line.first
    first[0] = 0
    line.ahead[0] = line.ahead[levels] - first[levels]
    copy_level(line, first[levels], first[levels + 1], 0, -1.0, box)
    first[levels + 2] = first[levels + 1] + first[2] - first[1]
    copy_level(line, first[1], first[2], first[levels + 1], 1.0, box)
    end = uint64(first[levels + 2])
    for k in range(len(box)):
        for t in range(LANES):
            line.position[k, end + t] = FAR


@part()
def copy_level(line, first, end, to, boxes, box):
    """Copy places ``first`` to ``end``, moved by so many boxes along the row."""
    last, n = len(box) - 1, uint64(end - first)
    source, target = uint64(first), uint64(to)
    for k in range(last):
        for t in range(n):
            line.position[k, target + t] = line.position[k, source + t]
    move = boxes * box[last]
    for t in range(n):
        line.position[last, target + t] = line.position[last, source + t] + move
        line.slot[target + t] = line.slot[source + t]


@part()
def find_partners(own, level, limit, box, line, hits):
    """Append the pairs of the row's own bead at place ``own`` that are not yet found.

    Own beads of the level before have found this one, and so have those before it in its
    own level. The length is rounded up: what lies beyond is two levels away, further than
    the cutoff. Every candidate is written, and the next one over it unless it is a hit, so
    there is no branch to foresee.
    """
    begin, same = uint64(line.ahead[level]), uint64(line.first[level + 1])
    n = uint64((uint64(line.first[level + 3]) - begin + LANES - U1) & ~(LANES - U1))
    for t in range(n):
        s = 0.0
        for k in range(len(box)):
            d = line.position[k, own] - line.position[k, begin + t]
            s += d * d
        found = uint64(begin + t - same) <= uint64(own - same)
        line.square[t] = FAR if found else s
    for t in range(n):
        line.hit[hits] = uint64(own << HALF) | uint64(begin + t)
        hits += uint64(line.square[t] < limit)
    return hits


@part()
def unpack_hits(hits, line, pairs, n, box):
    """Append what was found to the pairs."""
    for h in range(hits):
        a, b = line.hit[h] >> HALF, line.hit[h] & LOW
        for k in range(len(box)):
            pairs.separation[k, n + h] = line.position[k, a] - line.position[k, b]
        pairs.i[n + h] = line.slot[a]
        pairs.j[n + h] = line.slot[b]
    return uint64(n + hits)


@part()
def next_pairs(at, position, cells, box, grid, cutoff, line, pairs):
    """Find some more pairs closer than the cutoff.

    Parameters
    ----------
    at : (slot, row)
        Where to go on: (0, -1) at first.
    position : (dimension, n) array
        Sorted by cell, inside the box.
    cells : Cells
    box : tuple of length dimension
    grid : Grid
        With edges not below the cutoff.
    cutoff : float
    line : Line
        Left alone between calls.
    pairs : Pairs
        Filled from 0.

    Returns
    -------
    at : (slot, row)
        All pairs are found when its slot is the number of beads.
    n : uint64
        How many pairs were found: `ENOUGH` or a few more, or all that were left.
    """
    s, row = at
    levels = grid.shape[len(box) - 1]
    beads = position.shape[1]
    n = U0
    while n < ENOUGH and s < beads:
        end = int64(cells.start[(row + 1) * levels])  # of the row; for row -1, 0
        if s == end:
            while s == end:
                row += 1
                end = int64(cells.start[(row + 1) * levels])
            merge_rows(row, position, cells, box, grid, line)
        hits = U0
        while s < end and n + hits < ENOUGH:
            level = int64(cells.level[s])
            own = uint64(line.to[0, level] + s)
            hits = find_partners(own, level, cutoff * cutoff, box, line, hits)
            s += 1
        n = unpack_hits(hits, line, pairs, n, box)
    return (s, row), n
