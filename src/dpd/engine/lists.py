"""Lists of pairs that serve for several steps. Each thread keeps those of its own blocks."""

from typing import NamedTuple

import numpy as np

from dpd.engine.cells import Grid
from dpd.engine.images import nearest_images, squared_distance
from dpd.engine.search import PAIRS_AT_ONCE, next_pairs, place_of_piece
from dpd.engine.threads import BLOCKS, next_task
from dpd.jit import inlined


class Listed(NamedTuple):
    """Pairs of some blocks."""

    pairs: np.ndarray  # (2, n) uint32: slots
    block: np.ndarray  # (blocks,) int64: numbers of the blocks
    # (blocks + 1,) int64: ``end[q]`` pairs are listed before those of the q-th of them
    end: np.ndarray
    phase: np.ndarray  # (phases + 1,) int64: ``phase[f]`` of these blocks belong to phases before f


def list_buffers(grid: Grid, size: int) -> Listed:
    """A list yet to be made, with room for so many pairs."""
    blocks, phases = len(grid.blocks.piece) - 1, len(grid.blocks.phase) - 1
    return Listed(
        np.empty((2, size), np.uint32),
        np.empty(blocks, np.int64),
        np.zeros(blocks + 1, np.int64),
        np.zeros(phases + 1, np.int64),
    )


@inlined()
def list_pairs(team, x, search, reach, listed):
    """List pairs within ``reach`` of beads of the blocks that this thread gets hold of.

    Returns
    -------
    int
        How many there are. If there is no room for so many, the list is of no use.
    """
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
def farthest_move(x, reference, mine, edges):
    """Largest squared distance of a bead from where the list was made; infinity without a list."""
    if reference is None:
        return np.inf
    farthest = 0.0
    for i in range(mine.first, mine.end):
        farthest = max(farthest, squared_distance(x, i, reference, i, edges))
    return farthest


@inlined()
def listed_pairs(first, end, x, slots, pairs, edges, slide):
    """Fill the pairs with some of the list from ``first`` to ``end``; return how many."""
    n, start = np.uint64(min(np.int64(PAIRS_AT_ONCE), end - first)), np.uint64(first)
    i, j, separation = pairs.i, pairs.j, pairs.separation
    for p in range(n):
        i[p] = slots[0, start + p]
        j[p] = slots[1, start + p]
    for p in range(n):
        for k in range(len(edges)):
            separation[k, p] = x[i[p], k] - x[j[p], k]
    nearest_images(separation, n, edges, slide)
    return n
