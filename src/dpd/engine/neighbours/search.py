"""Pairs of beads closer than a cutoff, found row by row of cells.

A row of cells and the rows ahead of it are merged into one line of memory, level by level,
the row's own beads first in each level. The partners of a bead are then in one stretch, from
the level before its own to the one after. One long loop over distances and one over hits
take the place of many short ones with lengths that no processor can foresee.
"""

from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.neighbours.cells import SPARE, Cells, Grid
from dpd.engine.slide import put_on_lattice, slide_level
from dpd.engine.space import Space
from dpd.engine.vectors.bits import LANES, lowest, near, popcount
from dpd.engine.vectors.rows import sum_to_column
from dpd.jit import part

U0, U1, U2 = np.uint64(0), np.uint64(1), np.uint64(2)
PAIRS_AT_ONCE = np.uint64(512)  # pairs that are worked on together: their buffers stay in cache
WORD = np.uint64(64)  # candidates that leave their bits in one word
AT_ONCE = np.uint64(4)  # bits that are read off without a look whether there are more
FAR = 1e6  # r_c; where the fillers at the end of a line are
HALF, LOW = np.uint64(32), np.uint64(0xFFFFFFFF)


class Pairs(NamedTuple):
    """Buffers for some pairs of beads.

    They are arrays of their own, and not rows of one: the compiler would take rows to overlap, and
    would not vectorise.

    Attributes
    ----------
    i, j : (size,) uint32 arrays
        Slots of the two beads.
    separation : (dimension, size) array
        r_i - r_j at the nearest image.
    repulsion, approach : (size,) arrays
        What the forces need of each pair: a_ij and r_ij . v_ij.
    theta : (size,) array
        A random number of each pair. The loop that uses it up leaves w / r in its place: with an
        array more, forces between several species are not rounded as they have always been.
    force_over_r : (size,) array
        What the forces find: F / r.
    low, high : (size,) uint32 arrays
        The smaller and the larger of the two identities.
    """

    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray
    repulsion: np.ndarray
    approach: np.ndarray
    theta: np.ndarray
    force_over_r: np.ndarray
    low: np.ndarray
    high: np.ndarray


class Place(NamedTuple):
    """How far a search has come: the next bead's slot, and its row of cells."""

    slot: int
    row: int


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
    hit : (widest + `PAIRS_AT_ONCE` + `AT_ONCE`,) uint64 array
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


class Search(NamedTuple):
    """What a search for pairs works with.

    Attributes
    ----------
    cells : Cells
        Filled by a sort.
    space : Space
    grid : Grid
        With edges not below the cutoff of the search.
    line : Line
        Left alone between calls of `next_pairs`.
    pairs : Pairs
        Those found last.
    """

    cells: Cells
    space: Space
    grid: Grid
    line: Line
    pairs: Pairs


@part()
def new_search(cells, space, grid):
    """A `Search` with buffers for the fullest rows, and for all that one call finds."""
    in_cell, in_row = cells.most
    dimension, levels = len(space.edges), grid.shape[len(space.edges) - 1]
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
        np.empty(widest + int64(PAIRS_AT_ONCE + AT_ONCE), np.uint64),
    )
    pairs = pair_buffers(dimension, widest + int64(PAIRS_AT_ONCE))
    return Search(cells, space, grid, line, pairs)


@part()
def merge_rows(row, position, search):
    """Fill the line with a row and those ahead of it."""
    start, level = search.cells.start, search.cells.level
    base, shift, to = search.grid.base, search.grid.shift, search.line.to
    levels, rows = search.grid.shape[len(search.space.edges) - 1], base.shape[1]
    make_room(row, start, levels, search.grid, search.line)
    target, slot = search.line.position, search.line.slot
    for r in range(rows):
        first = base[row, r]
        for s in range(uint64(start[first]), uint64(start[first + levels])):
            place = uint64(to[r, level[s]]) + s
            move = row * rows + r
            sum_to_column(target, place, position, s, shift, move, search.space)
            put_on_lattice(
                target, place, position, s, shift, move, search.space, search.space.slide
            )
            slot[place] = uint32(s)
    join_ends(search.line, search.space, levels)


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
    itself = uint64(grid.base[row, 0])
    for z in range(uint64(levels)):
        begin, end = int64(start[itself + z]), int64(start[itself + z + U1])
        line.ahead[z + U1] = first[z + U1] + end - begin


@part()
def join_ends(line, space, levels):
    """Put the last level before the first, the first after the last, fillers at the end."""
    first = line.first
    first[0] = 0
    line.ahead[0] = line.ahead[levels] - first[levels]
    copy_level(line, first[levels], first[levels + 1], 0, -1.0, space)
    first[levels + 2] = first[levels + 1] + first[2] - first[1]
    copy_level(line, first[1], first[2], first[levels + 1], 1.0, space)
    end = uint64(first[levels + 2])
    for k in range(len(space.edges)):
        for t in range(uint64(LANES)):
            line.position[k, end + t] = FAR


@part()
def copy_level(line, first, end, to, boxes, space):
    """Copy places ``first`` to ``end``, moved by so many boxes along the row."""
    last, n = len(space.edges) - 1, uint64(end - first)
    source, target = uint64(first), uint64(to)
    for k in range(last):
        for t in range(n):
            line.position[k, target + t] = line.position[k, source + t]
    move = boxes * space.edges[last]
    for t in range(n):
        line.position[last, target + t] = line.position[last, source + t] + move
        line.slot[target + t] = line.slot[source + t]
    slide_level(line.position, target, n, last, move, space.slide)


@part()
def find_partners(bead, level, limit, space, line, hits):
    """Append the pairs of the row's own bead at place ``bead`` that are not yet found.

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
            bits |= near(line.position, space, bead, begin + t, limit) << t
        bits &= ~uint64(ones(bead + U1, begin) & ~ones(same, begin))
        count = popcount(bits)
        at = hits
        while bits != U0:
            for t in range(AT_ONCE):
                line.hit[at + t] = uint64(bead << HALF) | uint64(begin + lowest(bits))
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
def unpack_hits(hits, search, n):
    """Append what was found to the pairs."""
    line, pairs = search.line, search.pairs
    for h in range(hits):
        a, b = line.hit[h] >> HALF, line.hit[h] & LOW
        for k in range(len(search.space.edges)):
            pairs.separation[k, n + h] = line.position[k, a] - line.position[k, b]
        pairs.i[n + h] = line.slot[a]
        pairs.j[n + h] = line.slot[b]
    return uint64(n + hits)


@part()
def first_place():
    """Where a search through all beads begins."""
    return Place(int64(0), int64(-1))


@part()
def place_of_piece(piece, cells, grid):
    """Where a search through one piece of a block begins, and the slot at which it ends."""
    first, end = grid.blocks.rows[piece, 0], grid.blocks.rows[piece, 1]
    levels = grid.shape[len(grid.shape) - 1]
    return Place(int64(cells.start[first * levels]), first - 1), int64(cells.start[end * levels])


@part()
def next_pairs(at, end, position, search, cutoff):
    """Find some more pairs closer than the cutoff.

    Parameters
    ----------
    at : Place
        Where to go on.
    end : int
        Slot to stop at: the number of beads, or the end of a row.
    position : array with a row for each bead
        Sorted by cell, inside the box.
    search : Search
        Its pairs are filled from 0.
    cutoff : float

    Returns
    -------
    at : Place
        All pairs are found when its slot is ``end``.
    n : uint64
        How many pairs were found: `PAIRS_AT_ONCE` or a few more, or all that were left.
    """
    start, levels_of, to = search.cells.start, search.cells.level, search.line.to
    levels = search.grid.shape[len(search.space.edges) - 1]
    s, row = at
    n = U0
    while n < PAIRS_AT_ONCE and s < end:
        stop = int64(start[(row + 1) * levels])  # of the row; for row -1, 0
        if s == stop:
            while s == stop:
                row += 1
                stop = int64(start[(row + 1) * levels])
            merge_rows(row, position, search)
        hits = U0
        while s < stop and n + hits < PAIRS_AT_ONCE:
            level = int64(levels_of[s])
            bead = uint64(to[0, level] + s)
            hits = find_partners(bead, level, cutoff * cutoff, search.space, search.line, hits)
            s += 1
        n = unpack_hits(hits, search, n)
    return Place(s, row), n
