"""Pairs for measurements: the same search as for forces, with a cutoff of its own."""

import numpy as np

from dpd.engine.advance import cells_in, sort_by_cell
from dpd.engine.cells import forward_rows, grid_shape, row_buffers, row_pairs
from dpd.engine.jit import kernel

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory


def pair_histogram(position, box, farthest, bins):
    """Count pairs by distance.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    box : tuple
        Edges in r_c.
    farthest : float
        Largest distance, at most half the smallest edge.
    bins : int
        Equal bins from 0 to ``farthest``.

    Returns
    -------
    (bins,) array
        Pairs at their nearest images, each counted once.
    """
    shape = grid_shape(box, max(farthest, SMALLEST_CELL))
    return _histogram(position, box, shape, forward_rows(len(box)), farthest, bins)


@kernel()
def _histogram(position, box, shape, ahead, farthest, bins):
    cells = cells_in(shape)
    start = np.empty(cells + 1, np.uint32)
    identity = np.empty(position.shape[1], np.uint32)
    source = (position, position, position, identity, None)
    ordered = np.empty_like(position)
    spare = np.empty_like(position)
    fullest = sort_by_cell(
        source, (ordered, spare, spare, np.empty_like(identity), None), box, shape, start
    )
    pairs = row_buffers(start, box, shape, ahead, fullest)
    counts = np.zeros(bins)
    scale = bins / farthest
    for row in range(cells // shape[len(box) - 1]):
        n = row_pairs(row, ordered, start, box, shape, ahead, farthest, fullest, pairs)
        for p in range(n):
            r2 = 0.0
            for k in range(len(box)):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            counts[min(int(np.sqrt(r2) * scale), bins - 1)] += 1.0
    return counts
