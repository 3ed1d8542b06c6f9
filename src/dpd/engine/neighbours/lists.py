"""Lists of pairs that serve for several steps. Each thread keeps those of its own blocks."""

from typing import NamedTuple

import numpy as np

from dpd.engine.neighbours.cells import count_cells, share_cells
from dpd.engine.neighbours.search import next_pairs, pairs_of_piece, search_buffers
from dpd.engine.threads.team import BLOCKS, meet, take
from dpd.engine.vectors.arrays import columns
from dpd.engine.vectors.rows import copy_row
from dpd.jit import part

CHUNK = 1024  # pairs whose forces are worked out together: their buffers stay in cache


class Listed(NamedTuple):
    """Pairs of some blocks.

    Attributes
    ----------
    pairs : (2, n) uint32 array
        Slots.
    block : (blocks,) int64 array
        Numbers of the blocks.
    end : (blocks + 1,) int64 array
        ``end[q]`` pairs are listed before those of the q-th of them.
    phase : (phases + 1,) int64 array
        ``phase[f]`` of these blocks belong to phases before f.
    """

    pairs: np.ndarray
    block: np.ndarray
    end: np.ndarray
    phase: np.ndarray


@part()
def no_list(reference, grid, beads):
    """A list yet to be made; None where pairs are found by cells."""
    if reference is None:
        return None
    blocks = len(grid.blocks.piece) - 1
    pairs = np.empty((2, 8 * beads), np.uint32)
    return Listed(
        pairs,
        np.empty(blocks, np.int64),
        np.zeros(blocks + 1, np.int64),
        np.zeros_like(grid.blocks.phase),
    )


@part()
def list_pairs(team, position, cells, box, grid, reach, listed):
    """All pairs within ``reach`` of beads of the blocks that this thread gets hold of."""
    line, pairs = search_buffers(cells, box, grid)
    kept, count, total = listed.pairs, 0, 0
    begin, pieces = grid.blocks.phase, grid.blocks.piece
    for phase in range(len(begin) - 1):
        block = take(team, BLOCKS + phase, begin[phase], begin[phase + 1])
        while block < begin[phase + 1]:
            for piece in range(pieces[block], pieces[block + 1]):
                at, end = pairs_of_piece(piece, cells, grid)
                while at[0] < end:
                    at, found = next_pairs(at, end, position, cells, box, grid, reach, line, pairs)
                    n = np.int64(found)
                    if total + n > kept.shape[1]:
                        kept = columns(kept, total, 2 * (total + n))
                    for p in range(n):
                        kept[0, total + p] = pairs.i[p]
                        kept[1, total + p] = pairs.j[p]
                    total += n
            listed.block[count] = block
            count += 1
            listed.end[count] = total
            block = take(team, BLOCKS + phase, begin[phase], begin[phase + 1])
        listed.phase[phase + 1] = count
    return Listed(kept, listed.block, listed.end, listed.phase)


@part()
def listing(
    team, reference, position, own, sorted_now, first, listed, cells, box, grid, skin
):  # fmt: skip
    """The list after a sort, or for the first step of a call; else as it was.

    After a sort, the reference is where the beads are. A call begins with the list that was
    made at the reference it was given. (Numba drops the branch on None only of an argument
    that is never assigned to.)
    """
    if reference is None:
        return None
    if sorted_now:
        for i in range(own[0], own[1]):
            copy_row(reference, i, position, i, box)
    elif first:
        count_cells(reference, own, box, grid, cells, team.rank)
        meet(team)
        if team.rank == 0:
            share_cells(cells, grid)
        for i in range(own[0], own[1]):
            cells.level[i] = cells.along[i]
    if sorted_now or first:
        meet(team)
        return list_pairs(team, reference, cells, box, grid, 1.0 + skin, listed)
    return listed


@part()
def farthest_move(position, reference, own, box):
    """Largest squared distance of a bead from where the list was made; any without a list."""
    if reference is None:
        return np.inf
    farthest = 0.0
    for i in range(own[0], own[1]):
        r2 = 0.0
        for k in range(len(box)):
            d = position[i, k] - reference[i, k]
            d -= box[k] * np.rint(d / box[k])
            r2 += d * d
        farthest = max(farthest, r2)
    return farthest


@part()
def listed_pairs(first, end, position, listed, box, pairs):
    """Fill the pairs with up to `CHUNK` of the list from ``first`` to ``end``; return how many."""
    n = np.uint64(min(CHUNK, end - first))
    start = np.uint64(first)
    for p in range(n):
        pairs.i[p] = listed.pairs[0, start + p]
        pairs.j[p] = listed.pairs[1, start + p]
    for p in range(n):
        i, j = pairs.i[p], pairs.j[p]
        for k in range(len(box)):
            pairs.separation[k, p] = position[i, k] - position[j, k]
    for k in range(len(box)):
        edge = box[k]
        for p in range(n):
            pairs.separation[k, p] -= edge * np.rint(pairs.separation[k, p] / edge)
    return n
