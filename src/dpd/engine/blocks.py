"""Blocks of cells whose pairs different threads may work on at the same time."""

from typing import NamedTuple

import numpy as np

PHASES = 6  # at most; threads count the tasks of each
FEWEST = 4  # rows in a block, if it is not a whole layer


class Blocks(NamedTuple):
    """Blocks of the rows of a grid, in the order in which they are worked on.

    Attributes
    ----------
    row : (blocks, 2) int64 array
        First row of each and the one after its last.
    phase : (phases + 1,) int64 array
        Where each phase begins, and the last ends. No two blocks of a phase push the same bead.
    """

    row: np.ndarray
    phase: np.ndarray


def make_blocks(layers, rows):
    """`Blocks` of so many layers of cells along the first axis, with so many rows in each.

    Pairs of a row push beads of that row and the next in its layer, and of those and the one
    before in the next layer. So blocks touch only neighbours in their layer and in the layers
    on both sides. A phase takes every second layer, and of a layer every second block; of an
    odd number of layers the last, which touches the first, comes alone in the end.

    A layer is cut into as many as four blocks, for threads to have about as much to do whatever
    the number of layers; not into more, as the neighbours of a block are fetched along with it.
    """
    pieces = 4 if rows >= 4 * FEWEST else 2 if rows >= 2 * FEWEST else 1
    cuts = rows * np.arange(pieces + 1) // pieces
    paired = layers // 2 * 2
    row, phase = [], [0]
    for turn in (range(0, paired, 2), range(1, paired, 2), range(paired, layers)):
        for side in (0, 1):
            own = [(z * rows + cuts[p : p + 2]) for z in turn for p in range(side, pieces, 2)]
            if own:
                row += own
                phase.append(len(row))
    return Blocks(np.array(row, np.int64), np.array(phase, np.int64))
