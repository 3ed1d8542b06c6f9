"""Lists of pairs that serve for several steps. Each thread keeps those of its own blocks."""

from typing import NamedTuple

import numpy as np

from dpd.engine.neighbours.cells import count_cells, share_cells
from dpd.engine.neighbours.search import new_search, next_pairs, place_of_piece
from dpd.engine.space import nearest_images, squared_distance
from dpd.engine.threads.team import BLOCKS, meet, next_task
from dpd.engine.vectors.arrays import columns
from dpd.engine.vectors.rows import copy_row
from dpd.jit import part

CHUNK = 1024  # pairs whose forces are worked out together: their buffers stay in cache


class Listed(NamedTuple):
    """Pairs of some blocks.

    Attributes
    ----------
    reference : array with a row for each bead
        Where the beads were when the list was made, in today's order.
    pairs : (2, n) uint32 array
        Slots.
    block : (blocks,) int64 array
        Numbers of the blocks.
    end : (blocks + 1,) int64 array
        ``end[q]`` pairs are listed before those of the q-th of them.
    phase : (phases + 1,) int64 array
        ``phase[f]`` of these blocks belong to phases before f.
    """

    reference: np.ndarray
    pairs: np.ndarray
    block: np.ndarray
    end: np.ndarray
    phase: np.ndarray


@part()
def empty_list(reference, grid, beads):
    """A list yet to be made; None where pairs are found by cells."""
    if reference is None:
        return None
    blocks = len(grid.blocks.piece) - 1
    return Listed(
        reference,
        np.empty((2, 8 * beads), np.uint32),
        np.empty(blocks, np.int64),
        np.zeros(blocks + 1, np.int64),
        np.zeros_like(grid.blocks.phase),
    )


@part()
def list_pairs(team, position, search, reach, listed):
    """All pairs within ``reach`` of beads of the blocks that this thread gets hold of."""
    blocks, found = search.grid.blocks, search.pairs
    pairs, count, total = listed.pairs, 0, 0
    for phase in range(len(blocks.phase) - 1):
        first, last = blocks.phase[phase], blocks.phase[phase + 1]
        block = next_task(team, BLOCKS + phase, first, last)
        while block < last:
            for piece in range(blocks.piece[block], blocks.piece[block + 1]):
                at, end = place_of_piece(piece, search.cells, search.grid)
                while at.slot < end:
                    at, some = next_pairs(at, end, position, search, reach)
                    n = np.int64(some)
                    if total + n > pairs.shape[1]:
                        pairs = columns(pairs, total, 2 * (total + n))
                    for p in range(n):
                        pairs[0, total + p] = found.i[p]
                        pairs[1, total + p] = found.j[p]
                    total += n
            listed.block[count] = block
            count += 1
            listed.end[count] = total
            block = next_task(team, BLOCKS + phase, first, last)
        listed.phase[phase + 1] = count
    return Listed(listed.reference, pairs, listed.block, listed.end, listed.phase)


@part()
def renewed_list(team, plan, position, mine, listed, cells, sorted_now, first):
    """The list after a sort, or for the first step of a call; else as it was.

    After a sort, the reference is where the beads are. A call begins with the list that was
    made at the reference it was given. (Numba drops the branch on None only of an argument
    that is never assigned to.)
    """
    if listed is None:
        return None
    if sorted_now:
        for i in range(mine.first, mine.end):
            copy_row(listed.reference, i, position, i, plan.space)
    elif first:
        count_cells(listed.reference, mine, plan.space, plan.grid, cells, team.rank)
        meet(team)
        if team.rank == 0:
            share_cells(cells, plan.grid)
        for i in range(mine.first, mine.end):
            cells.level[i] = cells.along[i]
    if sorted_now or first:
        meet(team)
        search = new_search(cells, plan.space, plan.grid)
        return list_pairs(team, listed.reference, search, 1.0 + plan.skin, listed)
    return listed


@part()
def farthest_move(position, listed, mine, space):
    """Largest squared distance of a bead from where the list was made; any without a list."""
    if listed is None:
        return np.inf
    farthest = 0.0
    for i in range(mine.first, mine.end):
        farthest = max(farthest, squared_distance(position, i, listed.reference, i, space))
    return farthest


@part()
def listed_pairs(first, end, position, listed, space, pairs):
    """Fill the pairs with up to `CHUNK` of the list from ``first`` to ``end``; return how many."""
    n = np.uint64(min(CHUNK, end - first))
    start = np.uint64(first)
    for p in range(n):
        pairs.i[p] = listed.pairs[0, start + p]
        pairs.j[p] = listed.pairs[1, start + p]
    for p in range(n):
        i, j = pairs.i[p], pairs.j[p]
        for k in range(len(space.edges)):
            pairs.separation[k, p] = position[i, k] - position[j, k]
    nearest_images(pairs.separation, n, space)
    return n
