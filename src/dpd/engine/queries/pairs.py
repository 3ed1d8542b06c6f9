"""Pairs for measurements: the same search as for forces, with a cutoff of its own."""

import numpy as np

from dpd.engine.neighbours.cells import cell_buffers, empty_like, grid, sort_by_cell
from dpd.engine.neighbours.search import next_pairs, search_buffers
from dpd.engine.vectors.arrays import rows_of
from dpd.jit import kernel

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
    cells = grid(box, max(farthest, SMALLEST_CELL))
    return _histogram(rows_of(position), box, cells, farthest, bins)


@kernel()
def _histogram(position, box, grid, farthest, bins):
    beads = len(position)
    source = (position, position, None, np.empty(beads, np.uint32), None)
    ordered = empty_like(source)
    cells = cell_buffers(grid, beads, 1)
    sort_by_cell(source, ordered, box, grid, cells)
    line, pairs = search_buffers(cells, box, grid)
    counts = np.zeros(bins)
    scale = bins / farthest
    at = (0, -1)
    while at[0] < beads:
        at, n = next_pairs(at, beads, ordered[0], cells, box, grid, farthest, line, pairs)
        for p in range(n):
            r2 = 0.0
            for k in range(len(box)):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            counts[min(int(np.sqrt(r2) * scale), bins - 1)] += 1.0
    return counts
