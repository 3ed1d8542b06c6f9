"""What every query begins with: positions sorted by cell, and a search through them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.bonded import angles_of, bonds_of, buffers_of
from dpd.engine.cells import (
    cell_buffers,
    count_cells,
    find_places,
    grid_of,
    move_rows,
    share_cells,
)
from dpd.engine.pair import add_densities
from dpd.engine.rows import empty_rows, rows_of
from dpd.engine.search import (
    Search,
    first_place,
    line_buffers,
    longest_line,
    next_pairs,
    pair_buffers,
)
from dpd.engine.space import edges_of, slide_of
from dpd.engine.threads import Share
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.engine.state import System


class Sorted(NamedTuple):
    """Positions as they were given and sorted by cell, the bead in each slot, and a search."""

    x: np.ndarray
    ordered: np.ndarray
    bead: np.ndarray
    search: Search


def sorted_beads(position: np.ndarray, box: Sequence[float], cutoff: float) -> Sorted:
    """Positions inside the box, to be searched for pairs nearer than a cutoff in r_c."""
    x, edges, grid = rows_of(position), edges_of(box), grid_of(box, cutoff)
    ordered, bead, slide = empty_rows(*x.shape), np.empty(len(x), np.uint32), slide_of(box)
    cells = cell_buffers(grid, len(x), 1)
    _sort(x, ordered, bead, *cells, grid.shape, edges, slide)
    line = line_buffers(grid, int(longest_line(cells.most, grid.base)))
    return Sorted(
        x, ordered, bead, Search(cells, grid, line, pair_buffers(len(edges)), edges, slide)
    )


@kernel()
def _sort(x, ordered, bead, start, level, cell, along, place, free, most, shape, edges, slide):
    """Sort positions by cell; fill ``ordered``, ``bead`` and the arrays of `Cells`."""
    mine = Share(np.uint64(0), np.uint64(len(bead)))
    count_cells(x, mine, cell, along, free[0], edges, shape, slide)
    share_cells(start, free, most, shape[len(edges) - 1])
    find_places(place, level, mine, cell, along, free[0])
    move_rows(x, ordered, mine, place, edges)
    for i in range(mine.first, mine.end):
        bead[place[i]] = np.uint32(i)


def terms_of(system: System, beads: Sorted) -> tuple[Any, ...]:
    """What kernels need of many-body forces, bonds and angles; each None where there are none.

    Returns
    -------
    density : (n,) array
        About the bead in each slot.
    bonds, angles : Bonds, Angles
    slot : (n,) uint32 array
        Room for the slots of beads by identity.
    arms, others : Arms
        Room for all bonds and angles.
    """
    density, bonds, d = None, bonds_of(system), system.dimension
    if system.many_body is not None:
        density = np.zeros(len(beads.bead))
        _add_densities(density, beads, system.many_body)
    angles = angles_of(system, bonds)
    slot = None if bonds is None else np.empty(len(beads.bead), np.uint32)
    arms = buffers_of(d, bonds, angles, whole=True), buffers_of(d, angles, whole=True)
    return density, bonds, angles, slot, *arms


@kernel()
def _add_densities(density, beads, law):
    search = beads.search
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, law.range)
        add_densities(density, search.pairs, n, law, search.edges)
