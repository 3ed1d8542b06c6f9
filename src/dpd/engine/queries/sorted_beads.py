"""What every query begins with: the beads sorted by cell, and a search through them."""

import numpy as np

from dpd.engine.neighbours.cells import cell_buffers, sort_by_cell
from dpd.engine.neighbours.search import new_search
from dpd.engine.state import Beads
from dpd.jit import part


@part()
def sorted_beads(beads, space, grid):
    """A copy of some beads sorted by cell, and a search for pairs of them.

    Parameters
    ----------
    beads : Beads
        Without predicted velocities; whatever has a row for each bead may stand for the velocity.
    space : Space
    grid : Grid

    Returns
    -------
    Beads, Search
    """
    ordered = Beads(
        np.empty_like(beads.position),
        np.empty_like(beads.velocity),
        None,
        np.empty_like(beads.identity),
        like(beads.species),
        None,
    )
    cells = cell_buffers(grid, len(beads.identity), 1)
    sort_by_cell(beads, ordered, space, grid, cells)
    return ordered, new_search(cells, space, grid)


@part()
def like(array):
    """An empty array like another; None for None."""
    if array is None:
        return None
    return np.empty_like(array)
