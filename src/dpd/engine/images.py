"""Periodic images in kernels, as `dpd.engine.space` says; ``slide`` is None where they stay."""

import numpy as np

from dpd.engine.rows import flat
from dpd.jit import inlined, inlined_exactly

STRETCH = 256  # entries of rows whose edges are written out, for a loop without a look at the axis


def row_edges(edges: tuple[float, ...], width: int) -> np.ndarray:
    """(3, `STRETCH`) array: the edges as rows have them, over and over, and their inverses.

    Those of padding are 1. The last row is room for the boxes by which entries are outside.
    """
    padded = np.ones(width)
    padded[: len(edges)] = edges
    repeated = np.tile(padded, STRETCH // width)
    return np.stack([repeated, 1.0 / repeated, np.zeros(STRETCH)])


@inlined()
def nearest_image(apart, edge):
    """A separation along an axis at its nearest image."""
    return apart - edge * np.rint(apart / edge)


@inlined()
def nearest_images(apart, n, edges, slide):
    """Put the first ``n`` separations of a (dimension, size) array at their nearest image."""
    if slide is not None:
        add_tilt(apart, n, -slide.tilt[0], slide)
    for k in range(len(edges)):
        edge = edges[k]
        for p in range(n):
            apart[k, p] = nearest_image(apart[k, p], edge)
    if slide is not None:
        add_tilt(apart, n, slide.tilt[0], slide)


@inlined()
def add_tilt(apart, n, tilt, slide):
    """From coordinates along the lattice to those in the box; with minus the tilt, the way back."""
    for p in range(n):
        apart[slide.flow, p] += tilt * apart[slide.gradient, p]


@inlined()
def squared_distance(one, i, other, j, edges):
    """Squared distance of row i of one array from row j of another, at nearest images.

    Not under shear: scenes that ask for it are refused there.
    """
    r2 = 0.0
    for k in range(len(edges)):
        d = nearest_image(one[i, k] - other[j, k], edges[k])
        r2 += d * d
    return r2


@inlined()
def put_inside(x, image, identity, mine, wrap, edges, slide):
    """Move beads to their image in the box, and count the boxes by which they are moved."""
    if slide is not None:
        put_inside_sliding(x, image, identity, mine, edges, slide)
        return
    entries, width = flat(x), np.uint64(x.shape[1])
    begin, end = mine.first * width, mine.end * width
    for first in range(begin, end, np.uint64(STRETCH)):
        size = min(np.uint64(STRETCH), np.uint64(end - first))
        outside = 0.0
        for t in range(size):
            edge = wrap[0, t]
            boxes = np.floor(entries[first + t] * wrap[1, t])
            inside = entries[first + t] - edge * boxes
            entries[first + t] = max(inside, 0.0) if inside < edge else 0.0  # by rounding
            wrap[2, t] = boxes if inside < edge else boxes + 1.0
            outside += abs(wrap[2, t])
        if outside > 0.0:
            bead = np.uint64(first // width)
            for t in range(np.uint64(0), size, width):
                for k in range(len(edges)):
                    count_box(image, identity[bead], k, wrap[2, t + np.uint64(k)])
                bead += np.uint64(1)


@inlined()
def count_box(image, bead, k, boxes):
    """Count the boxes that a bead has crossed along an axis: few do in any step."""
    if boxes != 0.0:
        image[bead, k] += np.int32(boxes)


@inlined()
def put_inside_sliding(x, image, identity, mine, edges, slide):
    """The same in the upright box, with boxes counted along the tilted lattice."""
    flow, gradient, tilt = slide.flow, slide.gradient, slide.tilt[0]
    height = edges[gradient]
    for i in range(mine.first, mine.end):
        up = np.floor(x[i, gradient] / height)
        inside = x[i, gradient] - height * up
        if inside >= height:  # by rounding: it is the lower end of the next image
            inside = 0.0
            up += 1.0
        x[i, gradient] = max(inside, 0.0)
        x[i, flow] -= up * tilt * height
        count_box(image, identity[i], gradient, up)
        for k in range(len(edges)):
            if k != gradient:
                edge = edges[k]
                boxes = np.floor(x[i, k] / edge)
                inside = x[i, k] - edge * boxes
                x[i, k] = max(inside, 0.0) if inside < edge else 0.0
                count_box(image, identity[i], k, boxes if inside < edge else boxes + 1.0)


@inlined()
def tilt_at(slide, step):
    """The tilt at a step."""
    slid = np.int64(np.uint64(slide.parts * np.uint64(step) + slide.begun))
    return slid / 2.0**64 * slide.ratio


@inlined(given="slide")
def slide_to(step, image, identity, mine, dt, slide):
    """Put the images where they are at a step, and count whole edges by which the tilt falls back.

    Every thread does, before it moves its beads: nobody needs the former tilt any more. A bead that
    is images above is as many times those edges further along the flow.
    """
    slide.tilt[0] = tilt_at(slide, step)
    ahead = tilt_at(slide, step - 1) + slide.rate * dt - slide.tilt[0]
    boxes = np.int32(np.rint(ahead / slide.ratio))
    if boxes != 0:
        for i in range(mine.first, mine.end):
            bead = identity[i]
            image[bead, slide.flow] += boxes * image[bead, slide.gradient]


@inlined(given="slide")
def drift_with_flow(x, v, f, peculiar, mine, time, half_square, slide):
    """Do to a thread's share of the beads what the flow does to the drift that follows.

    The drift takes ``time`` and adds half_square f. A bead keeps its velocity v, so that about the
    flow changes with the way along the gradient, and x grows by time v. Its way by itself is what
    remains when the flow has carried it as at the middle of that way.
    """
    flow, gradient = slide.flow, slide.gradient
    for i in range(mine.first, mine.end):
        across = time * v[i, gradient] + half_square * f[i, gradient]
        x[i, flow] += time * slide.rate * (x[i, gradient] + across)
        v[i, flow] -= slide.rate * across
        along = time * v[i, flow] + half_square * f[i, flow]
        peculiar[i] += along + 0.5 * time * slide.rate * across


@inlined_exactly()
def boxes_beside(x, i, edges, slide):
    """Boxes along the flow between bead i and its image in the tilted cell, 0 <= x' < L_x.

    Sorting asks, and the search asks again, so it is rounded as written.
    """
    along = x[i, slide.flow] - slide.tilt[0] * x[i, slide.gradient]
    return np.floor(along / edges[slide.flow])


@inlined_exactly()
def along_lattice(x, i, k, edges, slide):
    """Place of bead i along axis k of the lattice, in the box."""
    if k != slide.flow:
        return x[i, k]
    along = x[i, k] - slide.tilt[0] * x[i, slide.gradient]
    return along - edges[k] * boxes_beside(x, i, edges, slide)
