"""The periodic box: its edges, its images, and the nearest image of a separation.

Nobody else writes a modulo. `Space` is what kernels take; `nearest` and `wrapped` do the same in
NumPy, for what looks at beads between steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.slide import Slide, add_tilt, count_box, put_inside_sliding
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
    slide : Slide or None
        How images slide under shear; None where they stay.
    """

    edges: tuple
    slide: Slide | None = None


def space_of(box: Sequence[float]) -> Space:
    """The `Space` of a box that is given by its edges, or of a `dpd.engine.slide.TiltedBox`."""
    return Space(tuple(map(float, box)), getattr(box, "slide", None))


@part()
def nearest_image(apart, edge):
    """A separation along an axis at its nearest image."""
    return apart - edge * np.rint(apart / edge)


@part()
def nearest_images(apart, n, space):
    """Put the first ``n`` separations of a (dimension, size) array at their nearest image."""
    add_tilt(apart, n, -1.0, space.slide)
    for k in range(len(space.edges)):
        edge = space.edges[k]
        for p in range(n):
            apart[k, p] = nearest_image(apart[k, p], edge)
    add_tilt(apart, n, 1.0, space.slide)


@part()
def squared_distance(one, i, other, j, space):
    """Squared distance of row i of one array from row j of another, at nearest images.

    Not under shear: whoever asks for it is refused there.
    """
    r2 = 0.0
    for k in range(len(space.edges)):
        d = nearest_image(one[i, k] - other[j, k], space.edges[k])
        r2 += d * d
    return r2


@part()
def row_edges(space):
    """Edges of the box and their inverses as rows have them, over and over; 1 for padding.

    With room for the boxes by which entries are outside.
    """
    width = row_width(len(space.edges))
    edges = np.ones((3, STRETCH))
    for first in range(0, STRETCH, width):
        for k in range(len(space.edges)):
            edges[0, first + k] = space.edges[k]
            edges[1, first + k] = 1.0 / space.edges[k]
    return edges


@part()
def put_inside(position, image, identity, mine, edges, space, slide):
    """Move beads to their image in the box, and count the boxes by which they are moved.

    Parameters
    ----------
    position : array with a row for each bead
    image : (n, dimension) int32 array
        Of each identity.
    identity : (n,) uint32 array
    mine : (int, int)
        First bead, and the one after the last.
    edges : (3, `STRETCH`) array
        From `row_edges`.
    space : Space
    slide : Slide or None
        Of the space.
    """
    if slide is not None:
        put_inside_sliding(position, image, identity, mine, space, slide)
        return
    x = position.ravel()
    begin, end = entries(mine, position)
    for first in range(begin, end, np.uint64(STRETCH)):
        size = min(np.uint64(STRETCH), np.uint64(end - first))
        outside = 0.0
        for t in range(size):
            edge = edges[0, t]
            boxes = np.floor(x[first + t] * edges[1, t])
            inside = x[first + t] - edge * boxes
            x[first + t] = inside if inside < edge else 0.0
            edges[2, t] = boxes if inside < edge else boxes + 1.0
            outside += abs(edges[2, t])
        if outside > 0.0:
            count_boxes(image, identity, edges, first, size, space)


@part()
def count_boxes(image, identity, edges, first, size, space):
    """Count the boxes by which some entries of rows were outside."""
    width = np.uint64(row_width(len(space.edges)))
    i = np.uint64(first // width)
    for t in range(np.uint64(0), size, width):
        for k in range(len(space.edges)):
            count_box(image, identity, i, k, edges[2, t + np.uint64(k)])
        i += np.uint64(1)


def nearest(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations at their nearest image, in NumPy.

    Parameters
    ----------
    apart : (dimension, ...) array
    box : tuple
        Edges in r_c, or a `dpd.engine.slide.TiltedBox`.
    """
    edges = _edges(apart, box)
    slide = getattr(box, "slide", None)
    if slide is None:
        return apart - edges * np.rint(apart / edges)
    far = edges * np.rint(along_axes(apart, box) / edges)  # in lattice coordinates
    far[slide.flow] += slide.tilt[0] * far[slide.gradient]
    return apart - far


def wrapped(position: np.ndarray, box: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions moved into the box, 0 <= x < edge, and the boxes by which they were outside.

    In NumPy; `unfolded` is the way back.
    """
    edges = _edges(position, box)
    slide = getattr(box, "slide", None)
    if slide is not None:
        height, y = box[slide.gradient], position[slide.gradient]
        up = np.floor(y / height)
        up += y - height * up >= height  # by rounding
        position = np.array(position)
        position[slide.flow] -= slide.tilt[0] * up * height
    boxes = np.floor(position / edges)
    inside = position - edges * boxes
    over = inside >= edges  # rounding may reach the edge
    return np.where(over, 0.0, inside), (boxes + over).astype(np.int32)


def unfolded(position: np.ndarray, image: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Positions that go on where beads leave the box: with the vectors of the box that they passed.

    Parameters
    ----------
    position : (dimension, ...) array
    image : (dimension, ...) array
        Boxes by which beads are further, see `dpd.engine.state.State`.
    box : tuple
        Edges in r_c, or a `dpd.engine.slide.TiltedBox`.
    """
    further = _edges(position, box) * image
    slide = getattr(box, "slide", None)
    if slide is not None:
        further[slide.flow] += slide.tilt[0] * further[slide.gradient]
    return position + further


def along_axes(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations along the vectors of the lattice of images: as they are, unless images slide.

    Parameters
    ----------
    apart : (dimension, ...) array
    box : tuple
        Edges in r_c, or a `dpd.engine.slide.TiltedBox`.
    """
    slide = getattr(box, "slide", None)
    if slide is None:
        return apart
    found = np.array(apart)
    found[slide.flow] -= slide.tilt[0] * apart[slide.gradient]
    return found


def _edges(array, box):
    return np.array(box).reshape(-1, *[1] * (np.ndim(array) - 1))
