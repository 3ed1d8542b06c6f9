"""How many neighbours of which species beads have."""

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


def neighbour_pairs(
    position: np.ndarray, species: np.ndarray, box: Sequence[float], farthest: float, count: int
) -> np.ndarray:
    """Count pairs of beads that are near each other, by their species.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    species : (n,) uint8 array
    box : tuple
        Edges in r_c.
    farthest : float
        Largest distance, at most half the smallest edge.
    count : int
        Number of species.

    Returns
    -------
    (count, count) array
        Pairs at their nearest images: symmetric, each counted once on the diagonal and once on
        either side of it.
    """
    space = space_of(box)
    counts = _count(rows_of(position), species, space, grid(space, farthest), farthest, count)
    return counts + counts.T - np.diag(np.diag(counts))


@kernel()
def _count(position, species, space, grid, farthest, count):
    beads = Beads(position, position, None, np.empty(len(position), np.uint32), species, None)
    ordered, search = sorted_beads(beads, space, grid)
    pairs = search.pairs
    counts = np.zeros((count, count))
    at = first_place()
    while at.slot < len(position):
        at, n = next_pairs(at, len(position), ordered.position, search, farthest)
        for p in range(n):
            counts[ordered.species[pairs.i[p]], ordered.species[pairs.j[p]]] += 1.0
    return counts
