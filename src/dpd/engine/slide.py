"""Images that slide: the boundary conditions of steady shear (Lees and Edwards 1972).

Let x be the axis of the flow and y that of its gradient. The image above the box moves with the
flow that is there, and the image below moves the other way. In a time they slide by g L_y times
that time, with the rate g. At any moment the images form a lattice whose vector along the gradient
is tilted, (s L_y, L_y). The *tilt* s lies between -1/2 and 1/2 of L_x / L_y, because a lattice that
has slid by a whole edge is the same as before.

A separation is brought to its nearest image in coordinates along the lattice, in which the box is
upright: x' = x - s y. Cells are those of x' too, so that neighbours stay neighbours. Along the flow
they are longer by sqrt(1 + s^2) at the largest tilt: two beads at a distance of 1 may differ by so
much in x'.

The slide is a whole number of 2^-64 of an edge for each step, so the tilt is an exact function of
the number of the step: no error adds up, and a resumed run has the same bits. A run that begins
with the end of another one begins with the slide of that.

Beads are kept with positions in the upright box and velocities about the flow, which no boundary
changes; see `dpd.physics.shear`.
"""

from __future__ import annotations

from fractions import Fraction
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.jit import exact_part, part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.engine.space import Space
    from dpd.physics.shear import Shear

TURN = 2**64  # parts of an edge


class Slide(NamedTuple):
    """How images slide.

    Attributes
    ----------
    flow, gradient : int
        Axes.
    rate : float
        Of the shear, in 1 / tau.
    parts : uint64
        Parts of an edge by which images slide in a step, 2^64 to an edge.
    begun : uint64
        Parts by which they had slid at step 0.
    ratio : float
        Edge along the flow over that along the gradient.
    tilt : (1,) array
        At the present step. All threads write the same number (`slide_to`).
    """

    flow: int
    gradient: int
    rate: float
    parts: np.uint64
    begun: np.uint64
    ratio: float
    tilt: np.ndarray


class TiltedBox(tuple[float, ...]):
    """Edges of a box whose images have slid; whoever takes the edges of a box takes this too.

    Attributes
    ----------
    slide : Slide
    """

    slide: Slide

    @property
    def tilt(self) -> float:
        """Displacement along the flow of an image, over that along the gradient."""
        return float(self.slide.tilt[0])

    @property
    def slid(self) -> int:
        """Parts of an edge by which images have slid, 2^64 to an edge."""
        return round(Fraction(self.tilt) / Fraction(self.slide.ratio) * TURN) % TURN


def parts_of(shear: Shear, box: Sequence[float], dt: float) -> int:
    """Parts of an edge by which images slide in a step, 2^64 to an edge."""
    edges = Fraction(box[shear.gradient]) / Fraction(box[shear.flow])
    return round(Fraction(shear.rate) * Fraction(dt) * edges * TURN) % TURN


def tilted(
    box: Sequence[float], shear: Shear | None, dt: float, step: int, begun: int = 0
) -> tuple[float, ...]:
    """The box with its images where they are at a step.

    Parameters
    ----------
    box : tuple of float
        Edges in r_c.
    shear : Shear or None
        Without shear the box stays as it is.
    dt : float
    step : int
    begun : int
        Parts of an edge by which they had slid at step 0.

    Returns
    -------
    tuple of float
        A `TiltedBox` with shear.
    """
    if shear is None:
        return tuple(box)
    found = TiltedBox(map(float, box))
    parts, ratio = parts_of(shear, found, dt), found[shear.flow] / found[shear.gradient]
    slid = (parts * step + begun) % TURN
    tilt = float(slid - TURN if slid >= TURN // 2 else slid) / TURN * ratio
    found.slide = Slide(
        shear.flow, shear.gradient, float(shear.rate), np.uint64(parts), np.uint64(begun), ratio,
        np.array([tilt]),
    )  # fmt: skip
    return found


def longest_cutoffs(space: Space, cutoff: float) -> list[float]:
    """The most that a distance of one cutoff can be along each axis of the lattice, at any tilt."""
    cutoffs = [cutoff] * len(space.edges)
    if space.slide is not None:
        cutoffs[space.slide.flow] *= hypot(1.0, 0.5 * space.slide.ratio)
    return cutoffs


@part()
def tilt_at(slide, step):
    """The tilt at a step."""
    slid = np.int64(np.uint64(slide.parts * np.uint64(step) + slide.begun))
    return slid / 2.0**64 * slide.ratio


@part()
def slide_to(slide, step):
    """Put the images where they are at a step.

    Every thread does, before it moves its beads: nobody needs the former tilt any more.
    """
    if slide is not None:
        slide.tilt[0] = tilt_at(slide, step)


@part()
def turn_images(image, identity, mine, slide, step, dt):
    """Count, in a thread's share, the whole edges by which the tilt falls back at a step.

    A bead that is images above is as many times those edges further along the flow.
    """
    if slide is None:
        return
    ahead = tilt_at(slide, step - 1) + slide.rate * dt - tilt_at(slide, step)
    edges = np.int32(np.rint(ahead / slide.ratio))
    if edges != 0:
        for i in range(mine.first, mine.end):
            bead = identity[i]
            image[bead, slide.flow] += edges * image[bead, slide.gradient]


@part()
def drift_with_flow(beads, force, mine, time, half_square, slide):
    """Do to a thread's share of the beads what the flow does to the drift that follows.

    The drift takes ``time`` and adds half_square f. A bead keeps its velocity v, so that about the
    flow changes with the way along the gradient, and x grows by time v. Its way by itself is what
    remains when the flow has carried it as at the middle of that way.
    """
    if slide is None:
        return
    x, y = slide.flow, slide.gradient
    for i in range(mine.first, mine.end):
        across = time * beads.velocity[i, y] + half_square * force[i, y]
        beads.position[i, x] += time * slide.rate * (beads.position[i, y] + across)
        beads.velocity[i, x] -= slide.rate * across
        along = time * beads.velocity[i, x] + half_square * force[i, x]
        beads.peculiar[i] += along + 0.5 * time * slide.rate * across


@part()
def put_inside_sliding(position, image, identity, mine, space, slide):
    """Move beads to their image in the upright box, and count boxes along the tilted lattice."""
    x, y, tilt = slide.flow, slide.gradient, slide.tilt[0]
    height = space.edges[y]
    for i in range(mine.first, mine.end):
        up = np.floor(position[i, y] / height)
        inside = position[i, y] - height * up
        if inside >= height:  # by rounding: it is the lower end of the next image
            inside = 0.0
            up += 1.0
        position[i, y] = max(inside, 0.0)
        position[i, x] -= up * tilt * height
        count_box(image, identity, i, y, up)
        for k in range(len(space.edges)):
            if k != y:
                edge = space.edges[k]
                boxes = np.floor(position[i, k] / edge)
                inside = position[i, k] - edge * boxes
                position[i, k] = max(inside, 0.0) if inside < edge else 0.0
                count_box(image, identity, i, k, boxes if inside < edge else boxes + 1.0)


@part()
def count_box(image, identity, i, k, boxes):
    """Count the boxes that bead i has crossed along an axis: few do in any step."""
    if boxes != 0.0:
        image[identity[i], k] += np.int32(boxes)


@exact_part()
def boxes_beside(position, i, space, slide):
    """Boxes along the flow between bead i and its image in the tilted cell, 0 <= x' < L_x.

    Sorting asks, and the search asks again, so it is rounded as written.
    """
    x = position[i, slide.flow] - slide.tilt[0] * position[i, slide.gradient]
    return np.floor(x / space.edges[slide.flow])


@exact_part()
def along_lattice(position, i, k, space, slide):
    """Place of bead i along axis k of the lattice, in the box."""
    if slide is None:
        return position[i, k]
    if k != slide.flow:
        return position[i, k]
    x = position[i, k] - slide.tilt[0] * position[i, slide.gradient]
    return x - space.edges[k] * boxes_beside(position, i, space, slide)


@part()
def put_on_lattice(target, place, position, i, shift, m, space, slide):
    """Complete a column that is bead i plus row m of ``shift``, which counts in whole edges."""
    if slide is not None:
        beside = space.edges[slide.flow] * boxes_beside(position, i, space, slide)
        target[slide.flow, place] += slide.tilt[0] * shift[m, slide.gradient] - beside


@part()
def slide_level(position, first, n, axis, move, slide):
    """Complete columns that were moved by whole edges along an axis."""
    if slide is not None:
        beside = slide.tilt[0] * move if axis == slide.gradient else 0.0
        for t in range(n):
            position[slide.flow, first + t] += beside


@part()
def add_tilt(apart, n, times, slide):
    """Add so many times the tilt to separations: once to lattice coordinates, minus once to ours.

    Parameters
    ----------
    apart : (dimension, size) array
    n : int
        The first so many.
    times : float
    slide : Slide or None
    """
    if slide is not None:
        for p in range(n):
            apart[slide.flow, p] += times * slide.tilt[0] * apart[slide.gradient, p]


@part()
def add_flow_between(pairs, n, slide):
    """Add to ``pairs.approach[:n]`` what the flow adds to r_ij . v_ij."""
    if slide is not None:
        x, y = slide.flow, slide.gradient
        for p in range(n):
            flow = slide.rate * pairs.separation[x, p] * pairs.separation[y, p]
            pairs.approach[p] += flow
