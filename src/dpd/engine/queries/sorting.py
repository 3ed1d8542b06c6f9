"""What every query begins with: positions sorted by cell, and a search through them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.cells import count_cells, find_places, grid_of, move_rows, share_cells
from dpd.engine.rows import empty_rows, rows_of
from dpd.engine.search import Search, new_search, sized
from dpd.engine.space import edges_of
from dpd.engine.threads import Share
from dpd.jit import inlined

if TYPE_CHECKING:
    from collections.abc import Sequence


class Unsorted(NamedTuple):
    """Positions, and room for them in order.

    Attributes
    ----------
    x : array with a row for each bead
        Inside the box.
    ordered : array with a row for each bead
        To be filled: the same, sorted by cell.
    bead : (n,) uint32 array
        To be filled: the number of the bead in each slot.
    search : Search
    """

    x: np.ndarray
    ordered: np.ndarray
    bead: np.ndarray
    search: Search


def unsorted(position: np.ndarray, box: Sequence[float], cutoff: float) -> Unsorted:
    """Positions to be searched for pairs nearer than a cutoff.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    box : tuple
        Edges in r_c.
    cutoff : float
    """
    x, beads = rows_of(position), position.shape[1]
    search = new_search(grid_of(box, cutoff), beads, edges_of(box))
    return Unsorted(x, empty_rows(*x.shape), np.empty(beads, np.uint32), search)


@inlined()
def sort(given):
    """Sort `Unsorted` positions, and return the search through them."""
    cells, grid, line, pairs, edges, _ = given.search
    start, level, cell, along, place, free, most = cells
    mine = Share(np.uint64(0), np.uint64(len(given.bead)))
    count_cells(given.x, mine, cell, along, free[0], edges, grid.shape, None)
    share_cells(start, free, most, grid.shape[len(edges) - 1])
    find_places(place, level, mine, cell, along, free[0])
    move_rows(given.x, given.ordered, mine, place, edges)
    for i in range(mine.first, mine.end):
        given.bead[place[i]] = np.uint32(i)
    return Search(cells, grid, sized(line, most, grid.base.shape[1]), pairs, edges, None)
