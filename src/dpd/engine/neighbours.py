"""Pairs of beads closer than a cutoff, found stretch by stretch of a row of cells.

A stretch is some cells of a row that hold about five beads. They and the cells ahead of them are
copied into one line, each at the image that is near, and each bead of the stretch is compared with
what follows it there: many at a time, in single precision, as far as the cutoff and what rounding
may take off. Separations are then taken from the positions themselves. What is found beyond the
cutoff so feels no force; observables have it left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine import lanes, rows
from dpd.engine.space import IMAGE, Cells, Grid, Slide, boxes_along
from dpd.engine.threads import BLOCKS, next_task
from dpd.jit import WIDE, inlined

U0, U1, FULL = np.uint64(0), np.uint64(1), np.uint64(lanes.LANES)
ALL, FOUR = np.uint64(2**64 - 1), np.uint64(rows.FOUR)
CUTOFF = 1.0  # of forces
PAIRS_AT_ONCE = np.uint64(256)  # pairs that are worked on together: their buffers stay in cache
CANDIDATES = np.uint64(256)  # of a bead that are looked at together: whole words
WORD = np.uint64(64)  # candidates that leave their bits in one word
TOGETHER = 5  # beads in a stretch, about, and cells, at most
GROUP = np.uint64(4)  # stretches that are lined up before any is searched: stores take their time
ENOUGH = np.uint64(1024)  # places on a line after which no stretch is added to it
ROUNDING = 1e-6  # of the largest edge and the cutoff: what single precision takes off a distance
FAR = np.float32(1e6)  # r_c; where the fillers at the end of a stretch are
NOWHERE = PAIRS_AT_ONCE + CANDIDATES + FULL  # a place behind all pairs, without a distance
OF_SLOT = np.uint32((1 << IMAGE) - 1)
FIRST, SLOT, AFTER, LAST = 0, 1, 2, 3  # see `Line`


class Pairs(NamedTuple):
    """Buffers for some pairs: not rows of one array, which the compiler would take to overlap."""

    # (size,) uint32: slots of the two beads
    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray  # (dimension, size): r_i - r_j at the nearest image; 0 at `NOWHERE`
    # (size,): what the forces need, and find
    repulsion: np.ndarray  # a_ij
    approach: np.ndarray  # r_ij . v_ij
    theta: np.ndarray  # a random number
    crowd: np.ndarray  # sum of both local densities; before, what the pair adds to each
    force_over_r: np.ndarray
    conservative_over_r: np.ndarray  # where it is measured
    weight_over_r: np.ndarray
    # (size,) uint32: the two identities; before, the image of j in `of_j`
    of_i: np.ndarray
    of_j: np.ndarray


class Line(NamedTuple):
    """Some stretches of a row, each with the cells ahead of it."""

    position: np.ndarray  # (dimension, size) float32
    slot: np.ndarray  # (size,) uint32: where each bead is stored, and above that its image
    # (`GROUP`, 4) uint64: place and slot of the first bead of each stretch, the slot after its last
    # one, and the place after all that is lined up with it
    stretch: np.ndarray


class Place(NamedTuple):
    """How far a search has come."""

    slot: int  # of the next bead
    candidate: int  # its next one, if it had some before
    cell: int  # that is lined up next
    # stretches that are done, and that are on the line
    done: int
    lined: int


class Search(NamedTuple):
    """What a search for pairs works with."""

    cells: Cells  # filled by a sort
    grid: Grid  # with edges not below the cutoff of the search
    line: Line  # left alone between calls of `next_pairs`
    pairs: Pairs  # those found last
    edges: tuple
    slide: Slide | None = None


def pair_buffers(dimension: int) -> Pairs:
    size = int(NOWHERE + FULL)
    slots = {name: rows.aligned((size,), np.uint32) for name in ("i", "j", "of_i", "of_j")}
    numbers = {name: rows.aligned((size,)) for name in Pairs._fields if name not in slots}
    separation = rows.aligned((dimension, size))
    separation[:] = 0.0
    return Pairs(**numbers | slots | {"separation": separation})


def line_buffers(grid: Grid, size: int) -> Line:
    return Line(
        rows.aligned((len(grid.shape), size), np.float32),
        rows.aligned((size,), np.uint32),
        np.empty((int(GROUP), 4), np.uint64),
    )


@inlined()
def longest_line(most, grid):
    """Places on a line at most, in whole vectors, with what is written beyond its end."""
    cells = grid.base.shape[1] * (min(TOGETHER, grid.shape[len(grid.shape) - 1]) + 2)
    return (cells * most[0] + int64(ENOUGH + FULL + FULL + FULL)) // int64(FULL) * int64(FULL)


@inlined()
def move_along(move, image, k, slide):
    """What brings a bead to an image along an axis."""
    if slide is None or k != slide.flow:
        return move[image, k]
    return move[image, k] + slide.tilt[0] * move[image, slide.gradient]


@inlined()
def append(begin, end, image, n, search):
    """Add slots ``begin`` to ``end``, at an image, to a line of ``n``; return how many it has."""
    line, first, last = search.line, uint64(begin), uint64(end)
    more, at = n + (last - first), n
    while True:  # mostly once
        for k in range(len(search.edges)):
            by = np.float32(move_along(search.grid.move, image, k, search.slide))
            lanes.copy_lanes(line.position[k], at, search.cells.single[k], first, by)
        lanes.count_lanes(line.slot, at, uint32(first | uint64(image) << uint64(IMAGE)), uint32(1))
        at += FULL
        first += FULL
        if first >= last:
            return more


@inlined()
def append_stretch(cell, row, level, width, n, search):
    """Add the beads of some cells, and those of the cells ahead; return how many the line has."""
    start, base, image = search.cells.start, search.grid.base, search.grid.image
    levels, ahead = search.grid.shape[len(search.edges) - 1], base.shape[1]
    low, high = max(level - 1, 0), min(level + width + 1, levels)
    n = append(start[cell], start[base[row, 0] + high], image[row, 0], n, search)
    for r in range(1, ahead):
        n = append(start[base[row, r] + low], start[base[row, r] + high], image[row, r], n, search)
    if level == 0:  # the last level once more before the first, but that of the row itself
        for r in range(1, ahead):
            end = base[row, r] + levels
            n = append(start[end - 1], start[end], image[row, r] - 1, n, search)
    if level + width == levels:  # the first after the last
        for r in range(ahead):
            first = base[row, r]
            n = append(start[first], start[first + 1], image[row, r] + 1, n, search)
    for t in range(FULL):
        search.line.position[0, n + t] = FAR
    return n


@inlined()
def line_up(slot, end, cell, search):
    """Fill the line from a cell on; return the next cell, and how many stretches there are."""
    start, grid, stretch = search.cells.start, search.grid, search.line.stretch
    levels = grid.shape[len(search.edges) - 1]
    mean = (search.cells.single.shape[1] - lanes.LANES) / (len(start) - 1)
    together = min(max(int64(TOGETHER / mean + 0.5), 1), TOGETHER)
    row, level, n, lined = cell // levels, cell % levels, U0, U0
    while lined < GROUP and n < ENOUGH and slot < end:
        width = min(together, levels - level)
        after = uint64(start[cell + width])
        if after > slot:
            stretch[lined, FIRST], stretch[lined, SLOT], stretch[lined, AFTER] = n, slot, after
            n = append_stretch(cell, row, level, width, n, search)
            stretch[lined, LAST] = n
            n = (n + FULL - U1) // FULL * FULL
            lined += U1
            slot = after
        cell += width
        level += width
        if level == levels:
            row, level = row + 1, 0
    return cell, lined


@inlined()
def find_partners(bead, begin, end, later, limit, line, found, n, edges):
    """Add those from ``begin`` to ``end`` of the line that are near to ``n`` found; return those.

    Of the first ones those whose bit in ``later`` is 0 are left out: the bead itself, and beads
    before it. Where there is no instruction to pack, each that is near leaves a bit; bits are read
    off four at a time, as one branch for each would often be foreseen wrongly.
    """
    position, slot = line.position, line.slot
    if WIDE:
        for t in range(begin, end, FULL):
            bits = lanes.near(position, edges, bead, t, limit) & later
            later = ALL
            lanes.pack(found, n, slot, t, bits)
            n += lanes.popcount(bits)
        return n
    for first in range(begin, end, WORD):
        bits = U0
        for t in range(U0, min(WORD, end - first), FULL):
            bits |= lanes.near(position, edges, bead, first + t, limit) << t
        bits &= later
        later = ALL
        at, count = n, lanes.popcount(bits)
        while bits != U0:
            for t in range(FOUR):
                found[at + t] = slot[first + lanes.lowest(bits)]
                bits &= uint64(bits - U1)
            at += FOUR
        n += count
    return n


@inlined()
def first_place():
    return Place(U0, U0, int64(0), U0, U0)


@inlined()
def place_of_piece(piece, pieces, start, levels):
    """Where a search through one piece of a block begins, and the slot at which it ends."""
    first, end = pieces[piece, 0] * levels, pieces[piece, 1] * levels
    return Place(uint64(start[first]), U0, int64(first), U0, U0), uint64(start[end])


@inlined()
def next_slots(at, end, search, cutoff):
    """Find some more pairs closer than the cutoff, or hardly further, up to the slot ``end``.

    There a row ends. Beads are sorted by cell, inside the box. Return where to go on, and how many
    were found: `PAIRS_AT_ONCE` or some more, or all that were left; j is left with its image.

    All beads of a stretch look at whole vectors from where it begins, as many each: how often a
    loop turns is then foreseen.
    """
    line, pairs, edges = search.line, search.pairs, search.edges
    largest = cutoff
    for k in range(len(edges)):
        largest = max(largest, edges[k])
    limit = np.float32((cutoff + ROUNDING * (largest + cutoff)) ** 2)
    slot, candidate, cell, done, lined = at
    n, stop = U0, uint64(end)
    while n < PAIRS_AT_ONCE and slot < stop:
        if done == lined:
            cell, lined = line_up(slot, stop, cell, search)
            done = U0
        first, after = line.stretch[done, SLOT], line.stretch[done, AFTER]
        place, last = line.stretch[done, FIRST], line.stretch[done, LAST]
        while n < PAIRS_AT_ONCE and slot < after:
            offset, before = slot - first, n
            begin, later = candidate, ALL
            if candidate == U0:
                begin, later = place + offset // FULL * FULL, ALL << (offset % FULL) << U1
            until = min(begin + CANDIDATES, last)
            n = find_partners(place + offset, begin, until, later, limit, line, pairs.j, n, edges)
            lanes.count_lanes(pairs.i, before, uint32(slot), uint32(0))
            for t in range(before + FULL, n, FULL):
                lanes.count_lanes(pairs.i, t, uint32(slot), uint32(0))
            candidate = until
            if until >= last:
                slot += U1
                candidate = U0
        if slot == after:
            done += U1
    return Place(slot, candidate, cell, done, lined), n


@inlined()
def next_pairs(at, end, x, search, cutoff):
    """The same, with slots of j and separations."""
    at, n = next_slots(at, end, search, cutoff)
    i, j, image, move = search.pairs.i, search.pairs.j, search.pairs.of_j, search.grid.move
    fill_up(i, j, n)
    for p in range(n + FOUR):
        image[p] = j[p] >> uint32(IMAGE)
        j[p] &= OF_SLOT
    for p in range(U0, n, FOUR):
        rows.apart_to_columns(
            search.pairs.separation, p, x, i, j, search.edges, search.slide, move, image
        )
    take_aside(search.pairs, n, x, move, search.edges, search.slide)
    return at, n


@inlined(given="slide")
def take_aside(pairs, n, x, move, edges, slide):
    """Move beads j along the flow to their images where these have slid."""
    for p in range(n):
        aside = slide.tilt[0] * move[pairs.of_j[p], slide.gradient] + edges[slide.flow] * (
            boxes_along(x, pairs.i[p], edges, slide) - boxes_along(x, pairs.j[p], edges, slide)
        )
        pairs.separation[slide.flow, p] -= aside


@inlined()
def fill_up(i, j, n):
    """Let what is read beyond ``n`` pairs be slots."""
    lanes.count_lanes(i, n, uint32(0), uint32(0))
    lanes.count_lanes(j, n, uint32(0), uint32(0))


@inlined()
def near_pairs(at, end, x, search, cutoff):
    """The same with those alone that are closer than the cutoff, as observables want them."""
    at, n = next_pairs(at, end, x, search, cutoff)
    return at, keep_near(search.pairs, n, cutoff * cutoff, search.edges)


@inlined()
def keep_near(pairs, n, limit, edges):
    """Keep those of ``n`` pairs whose squared distance is below a limit; return how many."""
    i, j, separation, kept = pairs.i, pairs.j, pairs.separation, U0
    for p in range(n, n + FULL):
        separation[0, p] = FAR
    for p in range(U0, n, FULL):
        bits = lanes.near(separation, edges, NOWHERE, p, limit)
        lanes.pack_columns(separation, kept, p, bits, edges)
        lanes.pack(i, kept, i, p, bits)
        lanes.pack(j, kept, j, p, bits)
        kept += lanes.popcount(bits)
    return kept


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
def list_pairs(team, search, reach, listed):
    """Count pairs within ``reach`` in blocks that this thread takes; list them if there is room."""
    pieces, piece, phases = search.grid.blocks
    start, levels = search.cells.start, search.grid.shape[len(search.edges) - 1]
    i, j = search.pairs.i, search.pairs.j
    pairs, count, total = listed.pairs, 0, 0
    for phase in range(len(phases) - 1):
        first, last = phases[phase], phases[phase + 1]
        block = next_task(team, BLOCKS + phase, first, last)
        while block < last:
            for q in range(piece[block], piece[block + 1]):
                at, end = place_of_piece(q, pieces, start, levels)
                while at.slot < end:
                    at, some = next_slots(at, end, search, reach)
                    n = np.int64(some)
                    if total + n <= pairs.shape[1]:
                        for p in range(n):
                            pairs[0, total + p] = i[p]
                            pairs[1, total + p] = j[p] & OF_SLOT
                    total += n
            listed.block[count] = block
            count += 1
            listed.end[count] = total
            block = next_task(team, BLOCKS + phase, first, last)
        listed.phase[phase + 1] = count
    return total


@inlined()
def listed_pairs(first, end, x, slots, search):
    """Fill the pairs with some of the list, without those in the skin.

    From ``first`` to ``end``; return where to go on, and how many there are.
    """
    n, start = np.uint64(min(np.int64(PAIRS_AT_ONCE), end - first)), np.uint64(first)
    i, j, separation = search.pairs.i, search.pairs.j, search.pairs.separation
    for p in range(n):
        i[p], j[p] = slots[0, start + p], slots[1, start + p]
    fill_up(i, j, n)
    for p in range(U0, n, FOUR):
        rows.apart_to_columns(separation, p, x, i, j, search.edges, search.slide, None, None)
    return first + np.int64(n), keep_near(search.pairs, n, CUTOFF * CUTOFF, search.edges)
