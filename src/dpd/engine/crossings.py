"""Bonds that cross in two dimensions."""

import numpy as np

from dpd.engine.advance import cells_in, sort_by_cell
from dpd.engine.cells import forward_rows, grid_shape, row_buffers, row_pairs
from dpd.engine.jit import kernel
from dpd.errors import UserError

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
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
    edges = np.array(box)[:, None]
    end = position[:, members[:, 0]]
    along = position[:, members[:, 1]] - end
    along -= edges * np.rint(along / edges)
    half = 0.5 * along
    middle = end + half
    middle -= edges * np.floor(middle / edges)
    middle = np.where(middle < edges, middle, 0.0)
    longest = float(np.sqrt((along**2).sum(axis=0).max())) if len(members) else 0.0
    if longest > 0.5 * min(box):
        raise UserError(
            f"a bond of {longest:.3g} r_c is longer than half the box ({min(box):g} r_c): "
            "crossings cannot be told; take a larger box or stiffer bonds"
        )
    reach = longest * (1.0 + SLACK) + SLACK
    shape = grid_shape(box, max(reach, SMALLEST_CELL))
    return _crossing(middle, half, members, box, shape, forward_rows(2), reach)


@kernel()
def _crossing(middle, half, members, box, shape, ahead, reach):
    """Two segments meet unless a line along one of them has the other on one side."""
    bonds = middle.shape[1]
    start = np.empty(cells_in(shape) + 1, np.uint32)
    number = np.arange(bonds).astype(np.uint32)
    source = (middle, half, half, number, None)
    ordered, halves, spare = np.empty_like(middle), np.empty_like(half), np.empty_like(half)
    numbers = np.empty_like(number)
    fullest = sort_by_cell(source, (ordered, halves, spare, numbers, None), box, shape, start)
    pairs = row_buffers(start, box, shape, ahead, fullest)
    found = np.empty((2, 16), np.uint32)
    total = 0
    for row in range((len(start) - 1) // shape[len(box) - 1]):
        n = row_pairs(row, ordered, start, box, shape, ahead, reach, fullest, pairs)
        for p in range(n):
            i, j = pairs.i[p], pairs.j[p]
            x, y = pairs.separation[0, p], pairs.separation[1, p]
            ix, iy, jx, jy = halves[0, i], halves[1, i], halves[0, j], halves[1, j]
            turn = abs(ix * jy - iy * jx)
            off_i, off_j = abs(ix * y - iy * x), abs(jx * y - jy * x)
            if off_i > turn or off_j > turn:
                continue
            # On one line, or a bond of no length: apart along an axis, they are apart.
            if turn == 0.0 and (abs(x) > abs(ix) + abs(jx) or abs(y) > abs(iy) + abs(jy)):
                continue
            a, b = numbers[i], numbers[j]
            if members[a, 0] == members[b, 0] or members[a, 0] == members[b, 1]:
                continue
            if members[a, 1] == members[b, 0] or members[a, 1] == members[b, 1]:
                continue
            if total == found.shape[1]:
                larger = np.empty((2, 2 * total), np.uint32)
                larger[:, :total] = found
                found = larger
            found[0, total], found[1, total] = min(a, b), max(a, b)
            total += 1
    return found[:, :total].copy()
