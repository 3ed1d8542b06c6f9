"""Which bonds cross, in exact arithmetic and by looking at every pair.

It shares nothing with the engine: ends are compared by the side on which they lie of a line,
in Python's integers, and every image of a bond is looked at instead of the nearest one.
"""

from fractions import Fraction
from itertools import product
from math import lcm

import numpy as np

SLACK = 1e-6  # r_c, thousands of times what the boxes around the bonds are rounded by


def side(a, b, c):
    """1, 0 or -1: c lies left of the line from a to b, on it, or right of it."""
    turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (turn > 0) - (turn < 0)


def meet(a, b, c, d):
    """Whether the closed segments AB and CD have a point in common, for exact numbers.

    They do if neither has both ends strictly on one side of the other; if all four ends lie
    on one line, if they overlap along both axes.
    """
    sides = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    if any(sides):
        return sides[0] * sides[1] <= 0 and sides[2] * sides[3] <= 0
    return all(
        max(min(a[k], b[k]), min(c[k], d[k])) <= min(max(a[k], b[k]), max(c[k], d[k]))
        for k in range(2)
    )


def whole_numbers(position, box):
    """Points and edges as whole numbers of one small unit, which every float is."""
    exact = [Fraction(float(x)) for x in (*np.ravel(position), *box)]
    unit = lcm(*(x.denominator for x in exact))
    whole = [int(x * unit) for x in exact]
    return list(zip(*np.reshape(np.array(whole[:-2], object), position.shape))), whole[-2:]


def crossings_by_looking(position, members, box):
    """Pairs of bonds with a point but no bead in common, as a set of (smaller, larger).

    For bonds shorter than half the smallest edge, between beads inside the box.
    """
    points, edges = whole_numbers(position, box)
    ends = []
    for first, second in members:
        a, b = points[first], points[second]
        ends.append((a, tuple(x - e * round(Fraction(x - y, e)) for x, y, e in zip(b, a, edges))))
    found = set()
    for image in product((-1, 0, 1), repeat=2):
        for i, j in overlapping(position, members, box, image):
            if set(map(int, members[i])) & set(map(int, members[j])):
                continue
            moved = [tuple(x + s * e for x, s, e in zip(p, image, edges)) for p in ends[j]]
            if meet(*ends[i], *moved):
                found.add((i, j))
    return found


def overlapping(position, members, box, image):
    """Pairs i < j of bonds that may meet once j is moved by whole edges.

    The boxes around the others are apart by more than any rounding: no more is decided in
    floats, and few pairs are left to compare exactly.
    """
    edges = np.array(box)[:, None]
    first = position[:, members[:, 0]]
    along = position[:, members[:, 1]] - first
    along -= edges * np.round(along / edges)
    low, high = np.minimum(first, first + along), np.maximum(first, first + along)
    move = np.array(image)[:, None] * edges
    near = (low[:, :, None] <= (high + move)[:, None] + SLACK) & (
        (low + move)[:, None] <= high[:, :, None] + SLACK
    )
    return [(int(i), int(j)) for i, j in np.argwhere(np.triu(near.all(axis=0), 1))]
