"""Bonds that cross in two dimensions, or pass through each other in three."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.queries.pairs import SMALLEST_CELL, sorted_beads
from dpd.engine.rows import nearest_image, rows_of
from dpd.engine.search import first_place, next_pairs
from dpd.engine.space import edges_of, nearest, wrapped
from dpd.errors import UserError
from dpd.jit import inlined, kernel

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

ROOM = 1024  # pairs found, at first
SLACK = 1e-9  # in r_c and relative, so that bonds which only touch end to end are looked at
HALVINGS = 30  # of the time at which two bonds lie in one plane
# Columns of what is known of a bond: where its first end is, relative to its middle half way, and
# its second one, relative to that; how both change; and the farthest that an end gets.
END, MOVE, BOND, TURN, RADIUS = 0, 3, 6, 9, 12


def crossing_bonds(position: np.ndarray, members: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """(2, crossings) uint32 array: numbers of the bonds in each pair that crosses.

    A bond is a closed segment between its beads' nearest images, so bonds that only touch
    cross; two that share a bead never do. Positions, (2, n), are in the order of identities,
    ``members``, (bonds, 2), those of the ends. A `UserError` refuses bonds longer than half the
    smallest edge, whose nearest image is not their own.
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
    search = middles.search
    pairs, number, bonds, total = search.pairs, middles.bead, len(middles.bead), 0
    at = first_place()
    while at.slot < bonds:
        at, n = next_pairs(at, bonds, middles.ordered, search, reach)
        for p in range(n):
            i, j = number[pairs.i[p]], number[pairs.j[p]]
            x, y = pairs.separation[0, p], pairs.separation[1, p]
            ix, iy, jx, jy = halves[i, 0], halves[i, 1], halves[j, 0], halves[j, 1]
            if segments_meet(x, y, ix, iy, jx, jy) and not share_a_bead(members, i, j):
                total = note_pair(found, total, i, j)
    return total


@inlined()
def segments_meet(x, y, ix, iy, jx, jy):
    """Whether two closed segments have a point in common, by their halves and middles x, y apart.

    They do unless a line along one of them has the other on one side: as Liu et al. 2008, Eqs. 6
    to 9, have it.
    """
    turn = abs(ix * jy - iy * jx)
    if abs(ix * y - iy * x) > turn or abs(jx * y - jy * x) > turn:
        return False
    # On one line, or a bond of no length: apart along an axis, they are apart.
    return turn != 0.0 or (abs(x) <= abs(ix) + abs(jx) and abs(y) <= abs(iy) + abs(jy))


def refuse_longer(longest: float, box: Sequence[float], what: str) -> None:
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
    """(2, n) uint32: all pairs of a kernel that fills a (2, size) array, and returns how many."""
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


class Met(NamedTuple):
    """How two bonds lie at some time."""

    triple: float  # product, zero where they lie in one plane
    # the nearest points of their lines, in units of the bonds, which count only there
    on_one: float
    on_other: float


def passed_bonds(
    before: np.ndarray, after: np.ndarray, members: np.ndarray, box: Sequence[float]
) -> np.ndarray:
    """(2, passes) uint32 array: bonds that went through each other on straight lines of beads.

    Two bonds AB and CD lie in one plane where (C - A) . (AB x CD) = 0. They pass through
    each other if that changes its sign while the nearest points of the two lines lie inside
    both bonds. A pass and a return in the same interval is none; nor is a pass of two bonds
    that lie in one plane twice in it, which happens where beads move half a bond or more.
    Positions, (3, n), are in the order of identities, each bead moves to the nearest image, and
    bonds that share a bead are not looked at. Bonds are refused as in `crossing_bonds`.
    """
    if not len(members):
        return np.empty((2, 0), np.uint32)
    middle, known = np.empty((3, len(members))), np.empty((len(members), RADIUS + 1))
    longest = _follow(middle, known, before, after, members, edges_of(box))
    refuse_longer(longest, box, "passes")
    reach = min(2 * float(known[:, RADIUS].max()), 0.5 * min(box))
    middles = sorted_beads(middle, box, max(reach, SMALLEST_CELL))
    return all_found(_passed, middles, known[middles.bead], members, reach)


@kernel()
def _follow(middle, known, before, after, members, edges):
    """Find how bonds move, and the length of the longest.

    Where the middle of a bond is half way, in the box, decides which image of another one is near.
    """
    longest = 0.0
    for b in range(len(members)):
        length, one, other, one_after, other_after = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(len(edges)):
            edge, here = edges[k], before[k, members[b, 0]]
            there = before[k, members[b, 1]]
            bond = nearest_image(there - here, edge)
            first = nearest_image(after[k, members[b, 0]] - here, edge)
            second = nearest_image(after[k, members[b, 1]] - there, edge)
            half = 0.5 * bond + 0.25 * (first + second)
            place = here + half
            place -= edge * np.floor(place / edge)
            middle[k, b] = place if place < edge else 0.0
            known[b, END + k], known[b, MOVE + k] = -half, first
            known[b, BOND + k], known[b, TURN + k] = bond, second - first
            length += bond * bond
            one += half * half
            other += (bond - half) ** 2
            one_after += (first - half) ** 2
            other_after += (bond - half + second) ** 2
        known[b, RADIUS] = np.sqrt(max(one, other, one_after, other_after))
        longest = max(longest, length)
    return np.sqrt(longest)


@inlined()
def line_up(x, known, i, j, t):
    """`Met` of bonds in slots i and j at time t; ``x`` leads from the middle of j to that of i."""
    w0 = x[0] + place(known, i, 0, t) - place(known, j, 0, t)
    w1 = x[1] + place(known, i, 1, t) - place(known, j, 1, t)
    w2 = x[2] + place(known, i, 2, t) - place(known, j, 2, t)
    u0, u1, u2 = along(known, i, 0, t), along(known, i, 1, t), along(known, i, 2, t)
    v0, v1, v2 = along(known, j, 0, t), along(known, j, 1, t), along(known, j, 2, t)
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
def place(known, i, k, t):
    """Of the first end of a bond, along an axis, at time t."""
    return known[i, END + k] + t * known[i, MOVE + k]


@inlined()
def along(known, i, k, t):
    """A component of a bond at time t."""
    return known[i, BOND + k] + t * known[i, TURN + k]


@kernel()
def _passed(found, middles, known, members, reach):
    """Fill ``found``, as far as there is room, and return how many there are."""
    search = middles.search
    pairs, number, bonds, total = search.pairs, middles.bead, len(middles.bead), 0
    at = first_place()
    while at.slot < bonds:
        at, n = next_pairs(at, bonds, middles.ordered, search, reach)
        for s in range(n):
            i, j, apart = pairs.i[s], pairs.j[s], pairs.separation
            x = apart[0, s], apart[1, s], apart[2, s]
            # The search takes all bonds for as long as the longest one.
            both = known[i, RADIUS] + known[j, RADIUS]
            if x[0] * x[0] + x[1] * x[1] + x[2] * x[2] > both * both:
                continue
            low_sign = line_up(x, known, i, j, 0.0).triple
            if low_sign * line_up(x, known, i, j, 1.0).triple >= 0.0:
                continue
            if share_a_bead(members, number[i], number[j]):
                continue
            low, high = 0.0, 1.0
            for _ in range(HALVINGS):
                t = 0.5 * (low + high)
                if line_up(x, known, i, j, t).triple * low_sign > 0.0:
                    low = t
                else:
                    high = t
            met = line_up(x, known, i, j, 0.5 * (low + high))
            if 0.0 <= met.on_one <= 1.0 and 0.0 <= met.on_other <= 1.0:
                total = note_pair(found, total, number[i], number[j])
    return total
