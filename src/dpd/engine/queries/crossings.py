"""Bonds that cross in two dimensions."""

import numpy as np

from dpd.engine.neighbours.cells import cell_buffers, empty_like, grid, sort_by_cell
from dpd.engine.neighbours.search import next_pairs, search_buffers
from dpd.engine.periodic import nearest, wrapped
from dpd.engine.queries.bond_pairs import SMALLEST_CELL, longest_bond, share_a_bead, with_pair
from dpd.engine.vectors.arrays import columns, rows_of
from dpd.jit import kernel

SLACK = 1e-9  # in r_c and relative, so that bonds which only touch end to end are looked at


def crossing_bonds(position, members, box):
    """Pairs of bonds that cross.

    A bond is a closed segment between its beads' nearest images, so bonds that only touch
    cross; two that share a bead never do.

    Parameters
    ----------
    position : (2, n) array
        In the order of identities.
    members : (bonds, 2) uint32 array
        Identities of the two ends.
    box : tuple
        Edges in r_c.

    Returns
    -------
    (2, crossings) uint32 array
        Numbers of the bonds in each pair.

    Raises
    ------
    UserError
        If a bond is longer than half the smallest edge: its nearest image is not its own.
    """
    end = position[:, members[:, 0]]
    bond = nearest(position[:, members[:, 1]] - end, box)
    half = 0.5 * bond
    middle = wrapped(end + half, box)
    reach = longest_bond(bond, box, "crossings") * (1.0 + SLACK) + SLACK
    cells = grid(box, max(reach, SMALLEST_CELL))
    return _crossing(rows_of(middle), rows_of(half), members, box, cells, reach)


@kernel()
def _crossing(middle, half, members, box, grid, reach):
    """Two segments meet unless a line along one of them has the other on one side."""
    bonds = len(middle)
    source = (middle, half, None, np.arange(bonds).astype(np.uint32), None)
    ordered = empty_like(source)
    cells = cell_buffers(grid, bonds, 1)
    sort_by_cell(source, ordered, box, grid, cells)
    middles, halves, _, numbers, _ = ordered
    line, pairs = search_buffers(cells, box, grid)
    found = np.empty((2, 16), np.uint32)
    total = 0
    at = (0, -1)
    while at[0] < bonds:
        at, n = next_pairs(at, bonds, middles, cells, box, grid, reach, line, pairs)
        for p in range(n):
            i, j = pairs.i[p], pairs.j[p]
            x, y = pairs.separation[0, p], pairs.separation[1, p]
            ix, iy, jx, jy = halves[i, 0], halves[i, 1], halves[j, 0], halves[j, 1]
            turn = abs(ix * jy - iy * jx)
            off_i, off_j = abs(ix * y - iy * x), abs(jx * y - jy * x)
            if off_i > turn or off_j > turn:
                continue
            # On one line, or a bond of no length: apart along an axis, they are apart.
            if turn == 0.0 and (abs(x) > abs(ix) + abs(jx) or abs(y) > abs(iy) + abs(jy)):
                continue
            a, b = numbers[i], numbers[j]
            if not share_a_bead(members, a, b):
                found = with_pair(found, total, a, b)
                total += 1
    return columns(found, total, total)
