"""Pairs for measurements: the same search as for forces, with a cutoff of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.neighbours.cells import grid
from dpd.engine.neighbours.search import first_place, next_pairs
from dpd.engine.queries.sorted_beads import sorted_beads
from dpd.engine.space import space_of
from dpd.engine.state import Beads
from dpd.engine.vectors.arrays import rows_of
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory


def pair_histogram(
    position: np.ndarray, box: Sequence[float], farthest: float, bins: int
) -> np.ndarray:
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
    space = space_of(box)
    cells = grid(space, max(farthest, SMALLEST_CELL))
    return _histogram(rows_of(position), space, cells, farthest, bins)


@kernel()
def _histogram(position, space, grid, farthest, bins):
    beads = Beads(position, position, None, np.empty(len(position), np.uint32), None, None)
    ordered, search = sorted_beads(beads, space, grid)
    separation = search.pairs.separation
    counts = np.zeros(bins)
    scale = bins / farthest
    at = first_place()
    while at.slot < len(position):
        at, n = next_pairs(at, len(position), ordered.position, search, farthest)
        for p in range(n):
            r2 = 0.0
            for k in range(len(space.edges)):
                r2 += separation[k, p] * separation[k, p]
            counts[min(int(np.sqrt(r2) * scale), bins - 1)] += 1.0
    return counts
