"""The periodic box: its edges, its images, and the nearest image of a separation.

Nobody else writes a modulo. `Space` is what kernels take; `nearest` and `wrapped` do the same in
NumPy, for what looks at beads between steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.vectors.arrays import row_width
from dpd.engine.vectors.rows import entries
from dpd.jit import part

if TYPE_CHECKING:
    from collections.abc import Sequence

STRETCH = 256  # entries of rows whose edges are written out, for a loop without a look at the axis


class Space(NamedTuple):
    """A periodic box.

    Attributes
    ----------
    edges : tuple of float
        One per axis, in r_c.
    """

    edges: tuple


def space_of(box: Sequence[float]) -> Space:
    """The `Space` of a box that is given by its edges."""
    return Space(tuple(map(float, box)))


@part()
def nearest_image(apart, edge):
    """A separation along an axis at its nearest image."""
    return apart - edge * np.rint(apart / edge)


@part()
def nearest_images(apart, n, space):
    """Put the first ``n`` separations of a (dimension, size) array at their nearest image."""
    for k in range(len(space.edges)):
        edge = space.edges[k]
        for p in range(n):
            apart[k, p] = nearest_image(apart[k, p], edge)


@part()
def squared_distance(one, i, other, j, space):
    """Squared distance of row i of one array from row j of another, at nearest images."""
    r2 = 0.0
    for k in range(len(space.edges)):
        d = nearest_image(one[i, k] - other[j, k], space.edges[k])
        r2 += d * d
    return r2


@part()
def row_edges(space):
    """Edges of the box and their inverses as rows have them, over and over; 1 for padding."""
    width = row_width(len(space.edges))
    edges = np.ones((2, STRETCH))
    for first in range(0, STRETCH, width):
        for k in range(len(space.edges)):
            edges[0, first + k] = space.edges[k]
            edges[1, first + k] = 1.0 / space.edges[k]
    return edges


@part()
def put_inside(position, mine, edges):
    """Move beads to their image in the box.

    Parameters
    ----------
    position : array with a row for each bead
    mine : (int, int)
        First bead, and the one after the last.
    edges : (2, `STRETCH`) array
        From `row_edges`.
    """
    x = position.ravel()
    begin, end = entries(mine, position)
    for first in range(begin, end, np.uint64(STRETCH)):
        for t in range(min(np.uint64(STRETCH), np.uint64(end - first))):
            edge = edges[0, t]
            inside = x[first + t] - edge * np.floor(x[first + t] * edges[1, t])
            x[first + t] = inside if inside < edge else 0.0


def nearest(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations at their nearest image, in NumPy.

    Parameters
    ----------
    apart : (dimension, ...) array
    box : tuple
        Edges in r_c.
    """
    edges = _edges(apart, box)
    return apart - edges * np.rint(apart / edges)


def wrapped(position: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Positions moved into the box, 0 <= x < edge, in NumPy."""
    edges = _edges(position, box)
    inside = position - edges * np.floor(position / edges)
    return np.where(inside < edges, inside, 0.0)  # rounding may reach the edge


def _edges(array, box):
    return np.array(box).reshape(-1, *[1] * (np.ndim(array) - 1))
