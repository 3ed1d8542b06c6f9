"""Bonds that cross in two dimensions, or pass through each other in three."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from dpd.engine.measure import SMALLEST_CELL, sorted_beads
from dpd.engine.neighbours import first_place, near_pairs
from dpd.engine.rows import rows_of
from dpd.engine.space import edges_of, nearest, nearest_image, wrapped
from dpd.errors import UserError
from dpd.jit import inlined, kernel

ROOM = 1024  # pairs found, at first
SLACK = 1e-9  # in r_c and relative, so that bonds which only touch end to end are looked at
HALVINGS = 30  # of the time at which two bonds lie in one plane
PIECE = 0.6  # r_c at most: bonds are looked for by such pieces; whole ones take six times as long
# Columns of what is known of a piece: where its bond's first end is, relative to the middle of the
# piece half way, and the second end, relative to that; how both change; and its farthest point.
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
        at, n = near_pairs(at, bonds, middles.ordered, search, reach)
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
    bond = nearest(before[:, members[:, 1]] - before[:, members[:, 0]], box)
    length = np.sqrt((bond**2).sum(axis=0))
    refuse_longer(float(length.max()), box, "passes")
    pieces = np.maximum(np.ceil(length / PIECE), 1).astype(int)
    owner, half = (np.repeat(each, pieces) for each in (np.arange(len(pieces)), 0.5 / pieces))
    number = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = (2 * number + 1) * half
    middle, known = np.empty((3, len(owner))), np.empty((len(owner), RADIUS + 1))
    _follow(middle, known, before, after, members[owner], share, half, edges_of(box))
    radius = known[:, RADIUS].copy()
    reach = min(2 * float(radius.max()), 0.5 * min(box))
    middles = sorted_beads(middle, box, max(reach, SMALLEST_CELL))
    found = all_found(_passed, middles, known, radius[middles.bead], members, owner, reach)
    return np.unique(found, axis=1)  # a pass where two pieces end is found by both


@kernel()
def _follow(middle, known, before, after, members, share, half, edges):
    """Find how pieces of bonds move: from ``share - half`` to ``share + half`` of each bond.

    Where the middle of a piece is half way, in the box, decides which image of another one is near.
    """
    for b in range(len(members)):
        far = 0.0, 0.0, 0.0, 0.0  # squared, of both ends of the piece, at the begin and at the end
        for k in range(len(edges)):
            edge, here = edges[k], before[k, members[b, 0]]
            there = before[k, members[b, 1]]
            bond = nearest_image(there - here, edge)
            move = nearest_image(after[k, members[b, 0]] - here, edge)
            turn = nearest_image(after[k, members[b, 1]] - there, edge) - move
            centre = share[b] * bond + 0.5 * (move + share[b] * turn)
            place = here + centre
            place -= edge * np.floor(place / edge)
            middle[k, b] = place if place < edge else 0.0
            known[b, END + k], known[b, MOVE + k] = -centre, move
            known[b, BOND + k], known[b, TURN + k] = bond, turn
            low, high = share[b] - half[b], share[b] + half[b]
            far = (
                far[0] + (low * bond - centre) ** 2,
                far[1] + (high * bond - centre) ** 2,
                far[2] + (low * (bond + turn) + move - centre) ** 2,
                far[3] + (high * (bond + turn) + move - centre) ** 2,
            )
        known[b, RADIUS] = np.sqrt(max(far))


@inlined()
def line_up(x, known, i, j, t):
    """`Met` of the bonds of pieces i and j at time t; ``x`` is from middle j to middle i."""
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
    return known[i, BOND + k] + t * known[i, TURN + k]


@kernel()
def _passed(found, middles, known, radius, members, owner, reach):
    search = middles.search
    pairs, pieces, total = search.pairs, len(middles.bead), 0
    at = first_place()
    while at.slot < pieces:
        at, n = near_pairs(at, pieces, middles.ordered, search, reach)
        for s in range(n):
            i, j, apart = pairs.i[s], pairs.j[s], pairs.separation
            x = apart[0, s], apart[1, s], apart[2, s]
            # The search takes all pieces for as large as the largest one.
            both = radius[i] + radius[j]
            if x[0] * x[0] + x[1] * x[1] + x[2] * x[2] > both * both:
                continue
            i, j = middles.bead[i], middles.bead[j]
            low_sign = line_up(x, known, i, j, 0.0).triple
            if low_sign * line_up(x, known, i, j, 1.0).triple >= 0.0:
                continue
            one, other = owner[i], owner[j]
            if share_a_bead(members, one, other):
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
                total = note_pair(found, total, one, other)
    return total
