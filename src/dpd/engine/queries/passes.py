"""Bonds that pass through each other in three dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.images import nearest_image
from dpd.engine.queries.bond_pairs import (
    SMALLEST_CELL,
    all_found,
    note_pair,
    refuse_longer,
    share_a_bead,
)
from dpd.engine.queries.sorting import sorted_beads
from dpd.engine.search import first_place, next_pairs
from dpd.engine.space import edges_of
from dpd.jit import inlined, kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

HALVINGS = 30  # of the time at which two bonds lie in one plane


class Met(NamedTuple):
    """How two bonds lie at some time.

    Attributes
    ----------
    triple : float
        Their triple product, zero where they lie in one plane.
    on_one, on_other : float
        Nearest points of their lines, in units of the bonds: 0 and 1 are the ends. They count only
        where the triple product is zero.
    """

    triple: float
    on_one: float
    on_other: float


def passed_bonds(
    before: np.ndarray, after: np.ndarray, members: np.ndarray, box: Sequence[float]
) -> np.ndarray:
    """Pairs of bonds that went through each other while beads moved in straight lines.

    Two bonds AB and CD lie in one plane where (C - A) . (AB x CD) = 0. They pass through
    each other if that changes its sign while the nearest points of the two lines lie inside
    both bonds. A pass and a return in the same interval is none; nor is a pass of two bonds
    that lie in one plane twice in it, which happens where beads move half a bond or more.

    Parameters
    ----------
    before, after : (3, n) arrays
        Positions in the order of identities; each bead moves to the nearest image.
    members : (bonds, 2) uint32 array
        Identities of the two ends. Bonds that share a bead are not looked at.
    box : tuple
        Edges in r_c.

    Returns
    -------
    (2, passes) uint32 array
        Numbers of the bonds in each pair.

    Raises
    ------
    UserError
        If a bond is longer than half the smallest edge: its nearest image is not its own.
    """
    if not len(members):
        return np.empty((2, 0), np.uint32)
    middle, squares = np.empty((3, len(members))), np.zeros((5, len(members)))
    ends, move = np.empty((2, 2, 3, len(members)))
    _follow(middle, squares, ends, move, before, after, members, edges_of(box))
    radius, longest = np.sqrt(squares[:4].max(axis=0)), np.sqrt(squares[4].max())
    refuse_longer(float(longest), box, "passes")
    reach = min(2 * float(radius.max()), 0.5 * min(box))
    middles = sorted_beads(middle, box, max(reach, SMALLEST_CELL))
    return all_found(_passed, middles, radius, ends, move, members, reach)


@kernel()
def _follow(middle, squares, ends, move, before, after, members, edges):
    """Find how bonds move.

    Parameters
    ----------
    middle : (3, bonds) array
        Where the middle of each bond is half way, in the box: it decides which image of another
        bond is near.
    squares : (5, bonds) array
        Zeros, to add up squared distances from there: of both ends before and after, further than
        which the bond does not reach; and its squared length before.
    ends, move : (2, 3, bonds) arrays
        Of both ends: where they are before, relative to that middle, and how they move.
    before, after, members, edges
        See `passed_bonds`.
    """
    for k in range(len(edges)):
        edge = edges[k]
        for b in range(len(members)):
            one, other = before[k, members[b, 0]], before[k, members[b, 1]]
            bond = nearest_image(other - one, edge)
            first = nearest_image(after[k, members[b, 0]] - one, edge)
            second = nearest_image(after[k, members[b, 1]] - other, edge)
            half = 0.5 * bond + 0.25 * (first + second)
            place = one + half
            place -= edge * np.floor(place / edge)
            middle[k, b] = place if place < edge else 0.0
            ends[0, k, b], ends[1, k, b] = -half, bond - half
            move[0, k, b], move[1, k, b] = first, second
            squares[0, b] += half * half
            squares[1, b] += (bond - half) ** 2
            squares[2, b] += (first - half) ** 2
            squares[3, b] += (bond - half + second) ** 2
            squares[4, b] += bond * bond


@inlined()
def line_up(x, one, other, ends, move, t):
    """`Met` of two bonds at time t.

    The three numbers ``x`` lead from the middle of the other bond to that of the first.
    """
    u0, u1, u2 = (
        _axis(0, one, ends, move, t),
        _axis(1, one, ends, move, t),
        _axis(2, one, ends, move, t),
    )
    v0, v1, v2 = (
        _axis(0, other, ends, move, t),
        _axis(1, other, ends, move, t),
        _axis(2, other, ends, move, t),
    )
    w0 = x[0] + ends[0, 0, one] + t * move[0, 0, one] - ends[0, 0, other] - t * move[0, 0, other]
    w1 = x[1] + ends[0, 1, one] + t * move[0, 1, one] - ends[0, 1, other] - t * move[0, 1, other]
    w2 = x[2] + ends[0, 2, one] + t * move[0, 2, one] - ends[0, 2, other] - t * move[0, 2, other]
    c0, c1, c2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    square = c0 * c0 + c1 * c1 + c2 * c2
    triple = w0 * c0 + w1 * c1 + w2 * c2
    # w + p u = q v, crossed with v and with u.
    a0, a1, a2 = w1 * v2 - w2 * v1, w2 * v0 - w0 * v2, w0 * v1 - w1 * v0
    b0, b1, b2 = w1 * u2 - w2 * u1, w2 * u0 - w0 * u2, w0 * u1 - w1 * u0
    p = -(a0 * c0 + a1 * c1 + a2 * c2) / square
    q = -(b0 * c0 + b1 * c1 + b2 * c2) / square
    return Met(triple, p, q)


@inlined()
def _axis(k, bond, ends, move, t):
    """A component of a bond at time t."""
    return ends[1, k, bond] - ends[0, k, bond] + t * (move[1, k, bond] - move[0, k, bond])


@kernel()
def _passed(found, middles, radius, ends, move, members, reach):
    """Fill ``found``, as far as there is room, and return how many there are."""
    search = middles.search
    pairs, number, bonds, total = search.pairs, middles.bead, len(middles.bead), 0
    at = first_place()
    while at.slot < bonds:
        at, n = next_pairs(at, bonds, middles.ordered, search, reach)
        for s in range(n):
            one, other = number[pairs.i[s]], number[pairs.j[s]]
            x = pairs.separation[0, s], pairs.separation[1, s], pairs.separation[2, s]
            # The search takes all bonds for as long as the longest one.
            both = radius[one] + radius[other]
            if x[0] * x[0] + x[1] * x[1] + x[2] * x[2] > both * both:
                continue
            low_sign = line_up(x, one, other, ends, move, 0.0).triple
            if low_sign * line_up(x, one, other, ends, move, 1.0).triple >= 0.0:
                continue
            if share_a_bead(members, one, other):
                continue
            low, high = 0.0, 1.0
            for _ in range(HALVINGS):
                t = 0.5 * (low + high)
                if line_up(x, one, other, ends, move, t).triple * low_sign > 0.0:
                    low = t
                else:
                    high = t
            met = line_up(x, one, other, ends, move, 0.5 * (low + high))
            if 0.0 <= met.on_one <= 1.0 and 0.0 <= met.on_other <= 1.0:
                total = note_pair(found, total, one, other)
    return total
