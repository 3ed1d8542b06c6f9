"""Blocks of cells whose pairs different threads may work on at the same time."""

from itertools import product
from typing import NamedTuple

import numpy as np

PHASES = 6  # at most; threads count the tasks of each
FEWEST = 4  # rows in a piece of a layer, if it is not a whole one
ENOUGH_BLOCKS = 64  # for threads to share; with more to come, blocks get deeper instead


class Blocks(NamedTuple):
    """Blocks of the rows of a grid, in the order in which they are worked on.

    Attributes
    ----------
    rows : (pieces, 2) int64 array
        First row of each piece of a layer and the one after its last.
    piece : (blocks + 1,) int64 array
        Where the pieces of each block begin, and those of the last end.
    phase : (phases + 1,) int64 array
        Where each phase begins, and the last ends. No two blocks of a phase push the same bead.
    """

    rows: np.ndarray
    piece: np.ndarray
    phase: np.ndarray


def make_blocks(layers: int, rows: int) -> Blocks:
    """`Blocks` of so many layers of cells along the first axis, with so many rows in each.

    Pairs of a row push beads of that row and the next in its layer, and of those and the one
    before in the next layer. So blocks touch only neighbours in their layers and in the layers
    on both sides. A phase takes every second slab of layers, and of a slab every second block; of
    an odd number of slabs the last, which touches the first, comes alone in the end.

    A layer is cut into as many as four pieces, for threads to have about as much to do whatever
    the number of layers; not into more, as the neighbours of a piece are fetched along with it.
    A slab is one layer until there are blocks enough. Of a large system it is more, and a bead
    that comes as a neighbour comes as one of the next layer while it is still in cache.
    """
    pieces = 4 if rows >= 4 * FEWEST else 2 if rows >= 2 * FEWEST else 1
    deep = max(1, layers * pieces // ENOUGH_BLOCKS)
    slabs = layers if deep == 1 else layers // deep // 2 * 2
    across, along = (n * np.arange(m + 1) // m for n, m in ((layers, slabs), (rows, pieces)))
    paired = slabs // 2 * 2
    found, piece, phase = [], [0], [0]
    for turn in (range(0, paired, 2), range(1, paired, 2), range(paired, slabs)):
        for side in (0, 1):
            for slab, p in product(turn, range(side, pieces, 2)):
                found += [z * rows + along[p : p + 2] for z in range(*across[slab : slab + 2])]
                piece.append(len(found))
            if len(piece) - 1 > phase[-1]:
                phase.append(len(piece) - 1)
    return Blocks(*(np.array(numbers, np.int64) for numbers in (found, piece, phase)))
