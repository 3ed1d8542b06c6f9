"""Pairs of beads closer than a cutoff, found row by row of cells.

A row of cells and the rows ahead of it are merged into one line of memory, level by level,
the row's own beads first in each level. The partners of a bead are then in one stretch, from
the level before its own to the one after. One long loop over distances and one over hits
take the place of many short ones with lengths that no processor can foresee.
"""

from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.neighbours.cells import SPARE
from dpd.engine.vectors.bits import LANES, lowest, near, popcount
from dpd.engine.vectors.rows import sum_to_column
from dpd.jit import part

U0, U1, U2 = np.uint64(0), np.uint64(1), np.uint64(2)
ENOUGH = np.uint64(512)  # pairs that are worked on together: their buffers stay in cache
WORD = np.uint64(64)  # candidates that leave their bits in one word
AT_ONCE = np.uint64(4)  # bits that are read off without a look whether there are more
FAR = 1e6  # r_c; where the fillers at the end of a line are
HALF, LOW = np.uint64(32), np.uint64(0xFFFFFFFF)


class Pairs(NamedTuple):
    """Buffers for some pairs.

    ``separation[:, p]`` is r_i - r_j of pair p at its nearest image. What follows is scratch of
    the forces: a_ij, r_ij . v_ij, noise, force / r, and the sorted identities. (Rows of one
    array they must not be: the compiler would take them to overlap, and not vectorise.)
    """

    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray
    strength: np.ndarray
    approach: np.ndarray
    theta: np.ndarray
    over_r: np.ndarray
    low: np.ndarray
    high: np.ndarray


class Line(NamedTuple):
    """A row of cells merged with those ahead of it.

    Attributes
    ----------
    position : (dimension, size) array
    slot : (size,) uint32 array
        Where each bead is stored.
    first : (lanes + 3,) int64 array, where lanes are levels rounded up to whole vectors
        Place of the first bead of each level, from -1 (the last one, a box before) to the
        number of levels (the first one, a box further); and where that ends.
    ahead : (levels + 1,) int64 array
        Place of the first bead that is not the row's own, from level -1 on.
    to : (rows, lanes) int64 array
        What leads from slots to places, for each of the rows and each level.
    hit : (widest + `ENOUGH` + `AT_ONCE`,) uint64 array
        Places of both beads of each pair found, in one word.
    """

    position: np.ndarray
    slot: np.ndarray
    first: np.ndarray
    ahead: np.ndarray
    to: np.ndarray
    hit: np.ndarray


@part()
def pair_buffers(dimension, size):
    """Buffers for ``size`` pairs."""
    return Pairs(
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
        np.empty((dimension, size)),
        np.empty(size),
        np.empty(size),
        np.empty(size),
        np.empty(size),
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
    )


@part()
def search_buffers(cells, box, grid):
    """A `Line` for the fullest rows, and `Pairs` for all that one call of `next_pairs` finds."""
    in_cell, in_row = cells.most
    dimension, levels = len(box), grid.shape[len(box) - 1]
    rows = grid.base.shape[1]
    size = rows * (in_row + 2 * in_cell) + LANES
    lanes = (levels + SPARE - 1) // SPARE * SPARE
    widest = 3 * rows * in_cell + LANES
    line = Line(
        np.empty((dimension, size)),
        np.empty(size, np.uint32),
        np.empty(lanes + 3, np.int64),
        np.empty(levels + 1, np.int64),
        np.empty((rows, lanes), np.int64),
        np.empty(widest + int64(ENOUGH + AT_ONCE), np.uint64),
    )
    return line, pair_buffers(dimension, widest + int64(ENOUGH))


@part()
def merge_rows(row, position, cells, box, grid, line):
    """Fill a line with a row and those ahead of it."""
    start, level = cells.start, cells.level
    levels, rows = grid.shape[len(box) - 1], grid.base.shape[1]
    make_room(row, start, levels, grid, line)
    for r in range(rows):
        base = grid.base[row, r]
        for s in range(uint64(start[base]), uint64(start[base + levels])):
            place = uint64(line.to[r, level[s]]) + s
            sum_to_column(line.position, place, position, s, grid.shift, row * rows + r, box)
            line.slot[place] = uint32(s)
    join_ends(line, box, levels)


@part()
def make_room(row, start, levels, grid, line):
    """Find where levels begin on a line, and where beads of each row go."""
    rows, first = grid.base.shape[1], line.first
    for z in range(line.to.shape[1]):
        first[z + 2] = 0
    for r in range(rows):
        base = uint64(grid.base[row, r])
        for z in range(uint64(line.to.shape[1])):
            begin, end = int64(start[base + z]), int64(start[base + z + U1])
            line.to[r, z] = first[z + U2] - begin
            first[z + U2] += end - begin
    first[1] = first[levels + 1]  # room for the last level, a box before
    for z in range(levels):
        first[z + 2] += first[z + 1]
    for r in range(rows):
        for z in range(line.to.shape[1]):
            line.to[r, z] += first[z + 1]
    own = uint64(grid.base[row, 0])
    for z in range(uint64(levels)):
        line.ahead[z + U1] = first[z + U1] + int64(start[own + z + U1]) - int64(start[own + z])


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
        for t in range(uint64(LANES)):
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
    the cutoff. Each candidate leaves one bit. Bits are read off some at a time, whether there
    are as many or not: one branch for each would often be foreseen wrongly.
    """
    begin, same = uint64(line.ahead[level]), uint64(line.first[level + 1])
    end = uint64(line.first[level + 3])
    while begin < end:
        bits = U0
        for t in range(U0, min(WORD, uint64(end - begin)), uint64(LANES)):
            bits |= near(line.position, box, own, begin + t, limit) << t
        bits &= ~uint64(ones(own + U1, begin) & ~ones(same, begin))
        count = popcount(bits)
        at = hits
        while bits != U0:
            for t in range(AT_ONCE):
                line.hit[at + t] = uint64(own << HALF) | uint64(begin + lowest(bits))
                bits &= uint64(bits - U1)
            at += AT_ONCE
        hits += count
        begin += WORD
    return hits


@part()
def ones(end, begin):
    """A word with a bit for each place before ``end`` from ``begin`` on."""
    if end <= begin:
        return U0
    n = uint64(end - begin)
    return ~U0 if n >= WORD else uint64((U1 << n) - U1)


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
def pairs_of_piece(piece, cells, grid):
    """``at`` and ``end`` for `next_pairs` to find those of beads in one piece of a block."""
    first, end = grid.blocks.rows[piece, 0], grid.blocks.rows[piece, 1]
    levels = grid.shape[len(grid.shape) - 1]
    return (int64(cells.start[first * levels]), first - 1), int64(cells.start[end * levels])


@part()
def next_pairs(at, end, position, cells, box, grid, cutoff, line, pairs):
    """Find some more pairs closer than the cutoff.

    Parameters
    ----------
    at : (slot, row)
        Where to go on: (0, -1) at first, for all beads.
    end : int
        Slot to stop at: the number of beads, or the end of a row.
    position : array with a row for each bead
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
        All pairs are found when its slot is ``end``.
    n : uint64
        How many pairs were found: `ENOUGH` or a few more, or all that were left.
    """
    s, row = at
    levels = grid.shape[len(box) - 1]
    n = U0
    while n < ENOUGH and s < end:
        stop = int64(cells.start[(row + 1) * levels])  # of the row; for row -1, 0
        if s == stop:
            while s == stop:
                row += 1
                stop = int64(cells.start[(row + 1) * levels])
            merge_rows(row, position, cells, box, grid, line)
        hits = U0
        while s < stop and n + hits < ENOUGH:
            level = int64(cells.level[s])
            own = uint64(line.to[0, level] + s)
            hits = find_partners(own, level, cutoff * cutoff, box, line, hits)
            s += 1
        n = unpack_hits(hits, line, pairs, n, box)
    return (s, row), n
