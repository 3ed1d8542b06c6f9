"""Which bonds cross, by the side on which ends lie of a line, for every pair at every image."""

from itertools import product

import numpy as np


def side(a, b, c):
    """1, 0 or -1: c lies left of the line from a to b, on it, or right of it."""
    return np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


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


def crossings_by_looking(position, members, box):
    """Pairs of bonds with a point but no bead in common, as a set of (smaller, larger).

    For bonds shorter than half the smallest edge, none of which touches another within rounding.
    """
    edges = np.array(box)[:, None]
    one = position[:, members[:, 0]]
    along = position[:, members[:, 1]] - one
    other = one + along - edges * np.round(along / edges)
    a, b, cross = one[:, :, None], other[:, :, None], False
    for image in product((-1, 0, 1), repeat=2):
        c, d = ((end + np.array(image)[:, None] * edges)[:, None] for end in (one, other))
        cross |= (side(a, b, c) != side(a, b, d)) & (side(c, d, a) != side(c, d, b))
    cross &= (members[:, None, :, None] != members[:, None]).all(axis=(2, 3))
    return {(int(i), int(j)) for i, j in np.argwhere(np.triu(cross, 1))}
