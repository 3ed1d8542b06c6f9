"""Pairs of beads closer than a cutoff, found row by row of cells.

A row of cells and the rows ahead of it are merged into one line of memory, level by level, the
row's own beads first in each level. The partners of a bead are then together, from the level before
its own to the one after. One long loop over distances and one over hits take the place of many
short ones with lengths that no processor can foresee.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.rows import LANES, lowest, near, nearest_images, popcount, sum_to_column
from dpd.engine.space import IN_CELL, IN_ROW, SPARE, Cells, Grid, Slide, boxes_along
from dpd.engine.threads import BLOCKS, next_task
from dpd.jit import inlined

U0, U1, U2, U3 = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(3)
PAIRS_AT_ONCE = np.uint64(256)  # pairs that are worked on together: their buffers stay in cache
WORD = np.uint64(64)  # candidates that leave their bits in one word
AT_ONCE = np.uint64(4)  # bits that are read off without a look whether there are more
FAR = 1e6  # r_c; where the fillers at the end of a line are
HALF, LOW = np.uint64(32), np.uint64(0xFFFFFFFF)


class Pairs(NamedTuple):
    """Buffers for some pairs: not rows of one array, which the compiler would take to overlap."""

    # (size,) uint32: slots of the two beads
    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray  # (dimension, size): r_i - r_j at the nearest image
    # (size,): what the forces need, and find
    repulsion: np.ndarray  # a_ij
    approach: np.ndarray  # r_ij . v_ij
    theta: np.ndarray  # a random number
    crowd: np.ndarray  # sum of both local densities; before, what the pair adds to each
    force_over_r: np.ndarray
    conservative_over_r: np.ndarray  # where it is measured
    weight_over_r: np.ndarray
    # (size,) uint32: the smaller and the larger of the two identities
    low: np.ndarray
    high: np.ndarray


class Line(NamedTuple):
    """A row of cells merged with those ahead of it."""

    position: np.ndarray  # (dimension, size)
    slot: np.ndarray  # (size,) uint32: where each bead is stored
    # (lanes + 3,) int64, lanes being levels rounded up to whole vectors: place of the first bead of
    # each level, from -1 (the last one, a box before) to one more than there are; and the end
    first: np.ndarray
    # (levels + 1,) int64: place of the first bead that is not the row's own, from level -1 on
    ahead: np.ndarray
    # (rows, lanes) int64: what leads from slots to places, for each of the rows and each level
    to: np.ndarray
    # (`PAIRS_AT_ONCE` + `WORD` + `AT_ONCE`,) uint64: places of both beads of each pair found, in
    # one word
    hit: np.ndarray


class Place(NamedTuple):
    """How far a search has come: the next bead's slot, its row of cells, its next candidate."""

    slot: int
    row: int
    candidate: int


class Search(NamedTuple):
    """What a search for pairs works with."""

    cells: Cells  # filled by a sort
    grid: Grid  # with edges not below the cutoff of the search
    line: Line  # left alone between calls of `next_pairs`
    pairs: Pairs  # those found last
    edges: tuple
    slide: Slide | None = None


def pair_buffers(dimension: int) -> Pairs:
    size = int(PAIRS_AT_ONCE + WORD)
    slots = {name: np.empty(size, np.uint32) for name in ("i", "j", "low", "high")}
    numbers = {name: np.empty(size) for name in Pairs._fields if name not in slots}
    return Pairs(**numbers | slots | {"separation": np.empty((dimension, size))})


def line_buffers(grid: Grid, size: int) -> Line:
    dimension, levels, rows = len(grid.shape), grid.shape[-1], grid.base.shape[1]
    lanes = (levels + SPARE - 1) // SPARE * SPARE
    return Line(
        np.empty((dimension, size)),
        np.empty(size, np.uint32),
        np.empty(lanes + 3, np.int64),
        np.empty(levels + 1, np.int64),
        np.empty((rows, lanes), np.int64),
        np.empty(int(PAIRS_AT_ONCE + WORD + AT_ONCE), np.uint64),
    )


@inlined()
def longest_line(most, base):
    """Beads on a line at most, after a sort."""
    return base.shape[1] * (most[IN_ROW] + 2 * most[IN_CELL]) + LANES


@inlined()
def make_room(row, start, base, first, ahead, to):
    """Find where levels begin on a line, and where beads of each row go; arrays of `Line`."""
    levels, rows = ahead.shape[0] - 1, base.shape[1]
    for z in range(to.shape[1]):
        first[z + 2] = 0
    for r in range(rows):
        cell = uint64(base[row, r])
        for z in range(uint64(to.shape[1])):
            begin, end = int64(start[cell + z]), int64(start[cell + z + U1])
            to[r, z] = first[z + U2] - begin
            first[z + U2] += end - begin
    first[1] = first[levels + 1]  # room for the last level, a box before
    for z in range(levels):
        first[z + 2] += first[z + 1]
    for r in range(rows):
        for z in range(to.shape[1]):
            to[r, z] += first[z + 1]
    cell = uint64(base[row, 0])
    for z in range(uint64(levels)):
        begin, end = int64(start[cell + z]), int64(start[cell + z + U1])
        ahead[z + U1] = first[z + U1] + end - begin


@inlined()
def merge_rows(row, x, start, level, base, shift, line, edges, slide):
    position, slot, first, ahead, to, _ = line
    make_room(row, start, base, first, ahead, to)
    levels, rows = ahead.shape[0] - 1, base.shape[1]
    for r in range(rows):
        cell, move = base[row, r], row * rows + r
        for s in range(uint64(start[cell]), uint64(start[cell + levels])):
            place = uint64(to[r, level[s]]) + s
            sum_to_column(position, place, x, s, shift, move, edges)
            if slide is not None:  # the row of ``shift`` counts in whole edges
                aside = edges[slide.flow] * boxes_along(x, s, edges, slide)
                position[slide.flow, place] += slide.tilt[0] * shift[move, slide.gradient] - aside
            slot[place] = uint32(s)
    # The last level once more before the first, the first after the last, and fillers.
    first[0] = 0
    ahead[0] = ahead[levels] - first[levels]
    first[levels + 2] = first[levels + 1] + first[2] - first[1]
    copy_level(position, slot, first[levels], first[levels + 1], 0, -1.0, edges, slide)
    copy_level(position, slot, first[1], first[2], first[levels + 1], 1.0, edges, slide)
    end = uint64(first[levels + 2])
    for k in range(len(edges)):
        for t in range(uint64(LANES)):
            position[k, end + t] = FAR


@inlined()
def copy_level(position, slot, first, end, to, boxes, edges, slide):
    """Copy places ``first`` to ``end`` of a line, moved by so many boxes along the row."""
    last, n = len(edges) - 1, uint64(end - first)
    source, target = uint64(first), uint64(to)
    move = boxes * edges[last]
    for k in range(last):
        for t in range(n):
            position[k, target + t] = position[k, source + t]
    for t in range(n):
        position[last, target + t] = position[last, source + t] + move
        slot[target + t] = slot[source + t]
    if slide is not None:
        aside = slide.tilt[0] * move if last == slide.gradient else 0.0
        for t in range(n):
            position[slide.flow, target + t] += aside


@inlined()
def find_partners(bead, begin, same, end, limit, position, hit, hits, edges):
    """Append pairs of the row's own bead at place ``bead`` with a word of candidates.

    Candidates are from ``begin`` on. Own beads of the level before have found this one, and so have
    those before it in its own level, which begins at ``same``. What lies beyond ``end`` is two
    levels away, further than the cutoff. Each candidate leaves one bit; bits are read off some at a
    time, as one branch for each would often be foreseen wrongly.
    """
    bits = U0
    for t in range(U0, min(WORD, uint64(end - begin)), uint64(LANES)):
        bits |= near(position, edges, bead, begin + t, limit) << t
    bits &= ~uint64(ones(bead + U1, begin) & ~ones(same, begin))
    at, count = hits, popcount(bits)
    while bits != U0:
        for t in range(AT_ONCE):
            hit[at + t] = uint64(bead << HALF) | uint64(begin + lowest(bits))
            bits &= uint64(bits - U1)
        at += AT_ONCE
    return hits + count


@inlined()
def ones(end, begin):
    """A word with a bit for each place before ``end`` from ``begin`` on."""
    if end <= begin:
        return U0
    n = uint64(end - begin)
    return ~U0 if n >= WORD else uint64((U1 << n) - U1)


@inlined()
def first_place():
    return Place(int64(0), int64(-1), U0)


@inlined()
def place_of_piece(piece, pieces, start, levels):
    """Where a search through one piece of a block begins, and the slot at which it ends."""
    first, end = pieces[piece, 0], pieces[piece, 1]
    return Place(int64(start[first * levels]), first - 1, U0), int64(start[end * levels])


@inlined()
def next_pairs(at, end, x, search, cutoff):
    """Find some more pairs closer than the cutoff, up to the slot ``end``, where a row ends.

    Positions are sorted by cell, inside the box. Return where to go on, and how many were found:
    `PAIRS_AT_ONCE` or a few more, or all that were left.
    """
    start, level, grid = search.cells.start, search.cells.level, search.grid
    line, edges = search.line, search.edges
    position, slot, first, ahead, to, hit = line
    i, j, separation = search.pairs.i, search.pairs.j, search.pairs.separation
    levels, limit = ahead.shape[0] - 1, cutoff * cutoff
    s, row, candidate = at
    n = U0
    while n < PAIRS_AT_ONCE and s < end:
        stop = int64(start[(row + 1) * levels])  # of the row; for row -1, 0
        if s == stop:
            while s == stop:
                row += 1
                stop = int64(start[(row + 1) * levels])
            merge_rows(row, x, start, level, grid.base, grid.shift, line, edges, search.slide)
        hits = U0
        while s < stop and n + hits < PAIRS_AT_ONCE:
            own = uint64(level[s])
            bead = uint64(to[0, own] + s)
            candidate = max(candidate, uint64(ahead[own]))
            last = uint64(first[own + U3])
            if candidate < last:
                same = uint64(first[own + U1])
                hits = find_partners(bead, candidate, same, last, limit, position, hit, hits, edges)
            candidate += WORD
            if candidate >= last:
                s += 1
                candidate = U0
        for h in range(hits):
            a, b = hit[h] >> HALF, hit[h] & LOW
            for k in range(len(edges)):
                separation[k, n + h] = position[k, a] - position[k, b]
            i[n + h] = slot[a]
            j[n + h] = slot[b]
        n = uint64(n + hits)
    return Place(s, row, candidate), n


class Listed(NamedTuple):
    """Pairs that serve for several steps, of the blocks of one thread."""

    pairs: np.ndarray  # (2, n) uint32: slots
    block: np.ndarray  # (blocks,) int64: numbers of the blocks
    # (blocks + 1,) int64: ``end[q]`` pairs are listed before those of the q-th of them
    end: np.ndarray
    phase: np.ndarray  # (phases + 1,) int64: ``phase[f]`` of these blocks belong to phases before f


def list_buffers(grid: Grid, size: int) -> Listed:
    blocks, phases = len(grid.blocks.piece) - 1, len(grid.blocks.phase) - 1
    return Listed(
        np.empty((2, size), np.uint32),
        np.empty(blocks, np.int64),
        np.zeros(blocks + 1, np.int64),
        np.zeros(phases + 1, np.int64),
    )


@inlined()
def list_pairs(team, x, search, reach, listed):
    """Count pairs within ``reach`` in blocks that this thread takes; list them if there is room."""
    rows, piece, phases = search.grid.blocks
    start, levels = search.cells.start, search.line.ahead.shape[0] - 1
    i, j = search.pairs.i, search.pairs.j
    pairs, count, total = listed.pairs, 0, 0
    for phase in range(len(phases) - 1):
        first, last = phases[phase], phases[phase + 1]
        block = next_task(team, BLOCKS + phase, first, last)
        while block < last:
            for q in range(piece[block], piece[block + 1]):
                at, end = place_of_piece(q, rows, start, levels)
                while at.slot < end:
                    at, some = next_pairs(at, end, x, search, reach)
                    n = np.int64(some)
                    if total + n <= pairs.shape[1]:
                        for p in range(n):
                            pairs[0, total + p] = i[p]
                            pairs[1, total + p] = j[p]
                    total += n
            listed.block[count] = block
            count += 1
            listed.end[count] = total
            block = next_task(team, BLOCKS + phase, first, last)
        listed.phase[phase + 1] = count
    return total


@inlined()
def listed_pairs(first, end, x, slots, search):
    """Fill the pairs with some of the list from ``first`` to ``end``; return how many."""
    n, start = np.uint64(min(np.int64(PAIRS_AT_ONCE), end - first)), np.uint64(first)
    i, j, separation = search.pairs.i, search.pairs.j, search.pairs.separation
    for p in range(n):
        i[p] = slots[0, start + p]
        j[p] = slots[1, start + p]
    for p in range(n):
        for k in range(len(search.edges)):
            separation[k, p] = x[i[p], k] - x[j[p], k]
    nearest_images(separation, n, search.edges, search.slide)
    return n
