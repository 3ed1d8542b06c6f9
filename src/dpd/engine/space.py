"""The periodic box, whose images may slide: edges, nearest images, and the boxes that beads cross.

Here in NumPy, for who looks at beads between steps; for kernels in `dpd.engine.rows`.

Steady shear has the boundary conditions of Lees and Edwards (1972). Let x be the axis of the flow
and y that of its gradient. The image above the box moves with the flow that is there, and the image
below moves the other way. In a time they slide by g L_y times that time, with the rate g. At any
moment the images form a lattice whose vector along the gradient is tilted, (s L_y, L_y). The
*tilt* s lies between -1/2 and 1/2 of L_x / L_y, because a lattice that has slid by a whole edge is
the same as before.

A separation is brought to its nearest image in coordinates along the lattice, in which the box is
upright: x' = x - s y. Cells are those of x' too. Along the flow they are longer by sqrt(1 + s^2) at
the largest tilt: two beads at a distance of 1 may differ by so much in x'.

The slide is a whole number of 2^-64 of an edge for each step, so the tilt is an exact function of
the number of the step. Positions are kept in the upright box.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.physics.shear import Shear

TURN = 2**64  # parts of an edge


class Slide(NamedTuple):
    """How images slide."""

    # axes
    flow: int
    gradient: int
    rate: float  # of the shear, in 1 / tau
    parts: np.uint64  # parts of an edge by which images slide in a step, 2^64 to an edge
    begun: np.uint64  # parts by which they had slid at step 0
    ratio: float  # edge along the flow over that along the gradient
    tilt: np.ndarray  # (1,): at the present step; all threads write the same number


class TiltedBox(tuple[float, ...]):
    """Edges of a box whose images have slid; whoever takes the edges of a box takes this too."""

    slide: Slide

    @property
    def tilt(self) -> float:
        """Displacement along the flow of an image, over that along the gradient."""
        return float(self.slide.tilt[0])

    @property
    def slid(self) -> int:
        """Parts of an edge by which images have slid, 2^64 to an edge."""
        return round(Fraction(self.tilt) / Fraction(self.slide.ratio) * TURN) % TURN


def tilted(
    box: Sequence[float], shear: Shear | None, dt: float, step: int, begun: int = 0
) -> tuple[float, ...]:
    """The box with its images where they are at a step, a `TiltedBox`; without shear as it is.

    ``begun`` is in parts of an edge, 2^64 of them, by which they had slid at step 0.
    """
    if shear is None:
        return tuple(box)
    found = TiltedBox(map(float, box))
    ratio = found[shear.flow] / found[shear.gradient]
    edges = Fraction(found[shear.gradient]) / Fraction(found[shear.flow])
    parts = round(Fraction(shear.rate) * Fraction(dt) * edges * TURN) % TURN
    slid = (parts * step + begun) % TURN
    tilt = float(slid - TURN if slid >= TURN // 2 else slid) / TURN * ratio
    found.slide = Slide(
        shear.flow, shear.gradient, float(shear.rate), np.uint64(parts), np.uint64(begun), ratio,
        np.array([tilt]),
    )  # fmt: skip
    return found


def edges_of(box: Sequence[float]) -> tuple[float, ...]:
    """The edges alone, as kernels take them."""
    return tuple(map(float, box))


def slide_of(box: Sequence[float]) -> Slide | None:
    """How the images of a box slide; None where they stay."""
    return getattr(box, "slide", None)


def nearest(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations, a (dimension, ...) array, at their nearest image."""
    edges, slide = _columns(apart, box), slide_of(box)
    if slide is None:
        far = apart / edges
        np.rint(far, out=far)
        far *= edges
        return apart - far
    far = edges * np.rint(along_axes(apart, box) / edges)  # in lattice coordinates
    far[slide.flow] += slide.tilt[0] * far[slide.gradient]
    return apart - far


def wrapped(position: np.ndarray, box: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions moved into the box, 0 <= x < edge, and the boxes by which they were outside."""
    edges, slide = _columns(position, box), slide_of(box)
    if slide is not None:
        height, y = box[slide.gradient], position[slide.gradient]
        up = np.floor(y / height)
        up += y - height * up >= height  # by rounding
        position = np.array(position)
        position[slide.flow] -= slide.tilt[0] * up * height
    boxes = np.floor(position / edges)
    inside = position - edges * boxes
    over = inside >= edges  # rounding may reach the edge, or fall short of 0
    return np.where(over, 0.0, np.maximum(inside, 0.0)), (boxes + over).astype(np.int32)


def unfolded(position: np.ndarray, image: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Positions, (dimension, ...), that go on where beads leave the box, by the boxes passed."""
    further, slide = _columns(position, box) * image, slide_of(box)
    if slide is not None:
        further[slide.flow] += slide.tilt[0] * further[slide.gradient]
    return position + further


def along_axes(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations, (dimension, ...), along the vectors of the lattice of images."""
    slide = slide_of(box)
    if slide is None:
        return apart
    found = np.array(apart)
    found[slide.flow] -= slide.tilt[0] * apart[slide.gradient]
    return found


def _columns(array, box):
    """Edges of the box along the first axis of an array."""
    return np.array(box).reshape(-1, *[1] * (np.ndim(array) - 1))
