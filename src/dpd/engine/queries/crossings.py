"""Bonds that cross in two dimensions, and what else looks for pairs of bonds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.engine.queries.sorting import sorted_beads
from dpd.engine.rows import rows_of
from dpd.engine.search import first_place, next_pairs
from dpd.engine.space import nearest, wrapped
from dpd.errors import UserError
from dpd.jit import inlined, kernel

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
ROOM = 1024  # pairs found, at first
SLACK = 1e-9  # in r_c and relative, so that bonds which only touch end to end are looked at


def crossing_bonds(position: np.ndarray, members: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """(2, crossings) uint32 array: numbers of the bonds in each pair that crosses.

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

    Raises
    ------
    UserError
        If a bond is longer than half the smallest edge: its nearest image is not its own.
    """
    end = position[:, members[:, 0]]
    bond = nearest(position[:, members[:, 1]] - end, box)
    half = 0.5 * bond
    middle, _ = wrapped(end + half, box)
    longest = float(np.sqrt((bond**2).sum(axis=0).max(initial=0.0)))
    refuse_longer(longest, box, "crossings")
    reach = longest * (1.0 + SLACK) + SLACK
    middles = sorted_beads(middle, box, max(reach, SMALLEST_CELL))
    return all_found(_crossing, middles, rows_of(half), members, reach)


@kernel()
def _crossing(found, middles, halves, members, reach):
    """Two segments meet unless a line along one of them has the other on one side."""
    search = middles.search
    pairs, number, bonds, total = search.pairs, middles.bead, len(middles.bead), 0
    at = first_place()
    while at.slot < bonds:
        at, n = next_pairs(at, bonds, middles.ordered, search, reach)
        for p in range(n):
            i, j = number[pairs.i[p]], number[pairs.j[p]]
            x, y = pairs.separation[0, p], pairs.separation[1, p]
            ix, iy, jx, jy = halves[i, 0], halves[i, 1], halves[j, 0], halves[j, 1]
            turn = abs(ix * jy - iy * jx)
            off_i, off_j = abs(ix * y - iy * x), abs(jx * y - jy * x)
            if off_i > turn or off_j > turn:
                continue
            # On one line, or a bond of no length: apart along an axis, they are apart.
            if turn == 0.0 and (abs(x) > abs(ix) + abs(jx) or abs(y) > abs(iy) + abs(jy)):
                continue
            if not share_a_bead(members, i, j):
                total = note_pair(found, total, i, j)
    return total


def refuse_longer(longest: float, box: Sequence[float], what: str) -> None:
    """Refuse a bond longer than half the smallest edge: its nearest image is not its own."""
    if longest > 0.5 * min(box):
        raise UserError(
            f"a bond of {longest:.3g} r_c is longer than half the box ({min(box):g} r_c): "
            f"{what} cannot be told; take a larger box or stiffer bonds"
        )


@inlined()
def share_a_bead(members, a, b):
    """Whether two bonds have an end in common."""
    first, second = members[a, 0], members[a, 1]
    if first == members[b, 0] or first == members[b, 1]:
        return True
    return second == members[b, 0] or second == members[b, 1]


def all_found(search: Callable[..., int], *arguments: Any) -> np.ndarray:
    """(2, n) uint32 array: all pairs of bonds that a kernel finds.

    It fills a (2, size) array as far as there is room, and returns how many pairs there are.
    """
    found = np.empty((2, ROOM), np.uint32)
    while (total := search(found, *arguments)) > found.shape[1]:
        found = np.empty((2, total), np.uint32)
    return found[:, :total].copy()


@inlined()
def note_pair(found, total, a, b):
    """Note a pair after ``total`` others, if there is room; return how many there are then."""
    if total < found.shape[1]:
        found[0, total], found[1, total] = min(a, b), max(a, b)
    return total + 1
