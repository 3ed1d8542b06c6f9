"""The periodic box, whose images may slide, and the cells that sort its beads.

Steady shear has the boundary conditions of Lees and Edwards (1972). Let x be the axis of the flow
and y that of its gradient. The image above the box moves with the flow that is there, and the image
below moves the other way. In a time they slide by g L_y times that time, with the rate g. At any
moment the images form a lattice whose vector along the gradient is tilted, (s L_y, L_y). The *tilt*
s lies between -1/2 and 1/2 of L_x / L_y, because a lattice that has slid by a whole edge is the
same as before.

A separation is brought to its nearest image in coordinates along the lattice, in which the box is
upright: x' = x - s y. Cells are those of x' too. Along the flow they are longer by sqrt(1 + s^2) at
the largest tilt: two beads at a distance of 1 may differ by so much in x'.

The slide is a whole number of 2^-64 of an edge for each step, so the tilt is an exact function of
the number of the step. Positions are kept in the upright box.

Cells sort beads so that neighbours in space are neighbours in memory. The last axis is the fastest:
a row of cells along it is one piece of memory. The place of a cell in its row is called its level.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.lanes import LANES
from dpd.engine.rows import copy_row, rows_of
from dpd.errors import UserError
from dpd.jit import inlined, inlined_exactly

if TYPE_CHECKING:
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
    return getattr(box, "slide", None)


def nearest(apart: np.ndarray, box: Sequence[float]) -> np.ndarray:
    """Separations, a (dimension, ...) array, at their nearest image."""
    edges, slide = _columns(apart, box), slide_of(box)
    far = along_axes(apart, box) / edges  # in lattice coordinates
    np.rint(far, out=far)
    far *= edges
    if slide is not None:
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


PHASES = 6  # of blocks, at most; threads count the tasks of each
FEWEST = 4  # rows in a piece of a layer, if it is not a whole one
ENOUGH_BLOCKS = 64  # for threads to share; with more to come, blocks get deeper instead
IMAGE = 27  # bits of a slot; the image of a bead stands above them


class Blocks(NamedTuple):
    """Blocks of the rows of a grid, in order; no two blocks of a phase push the same bead."""

    rows: np.ndarray  # (pieces, 2) int64: first row of each piece of a layer, and its end
    piece: np.ndarray  # (blocks + 1,) int64: where the pieces of each block begin
    phase: np.ndarray  # (phases + 1,) int64: where each phase begins, and the last ends


class Grid(NamedTuple):
    """Cells of a box, and which rows touch which."""

    shape: tuple  # cells along each axis
    # (rows, ahead) int64: first cell of each row itself and of half of those around it, the ones
    # ahead: one in two dimensions, four in three
    base: np.ndarray
    image: np.ndarray  # (rows, ahead) int64: which image of each is near, a row of `move`
    # (3^dimension, width): what brings beads to an image: -1, 0 or 1 box along each axis, the last
    # the fastest
    move: np.ndarray
    blocks: Blocks  # of rows, for threads to share


class Cells(NamedTuple):
    """Where beads lie, before and after a sort."""

    start: np.ndarray  # (cells + 1,) uint32: first slot of each cell, and the end of the last
    single: np.ndarray  # (dimension, n + LANES) float32: positions, sorted; in the tilted cell
    # (n,) uint32: of each bead before the sort: its cell, and the slot that it goes to
    cell: np.ndarray
    place: np.ndarray
    free: np.ndarray  # (threads, cells) uint32: where each thread puts its next bead of a cell
    most: np.ndarray  # (1,) int64: most beads in a cell


def grid_of(box: Sequence[float], cutoff: float) -> Grid:
    """The `Grid` with as many cells as fit with edges not below the cutoff, at any tilt."""
    least, slide = [cutoff] * len(box), slide_of(box)
    if slide is not None:
        least[slide.flow] *= hypot(1.0, 0.5 * slide.ratio)
    shape = tuple(max(1, int(edge / length)) for edge, length in zip(box, least))
    return _grid(edges_of(box), shape)


@lru_cache(maxsize=8)
def _grid(box, shape):
    """The same, of so many cells; cached, as observables ask for it again and again."""
    across = np.array(shape[:-1])
    here = np.array(list(product(*map(range, across))))
    around = list(product((-1, 0, 1), repeat=len(across)))
    there = here[:, None] + np.array([offset for offset in around if offset >= (0,) * len(across)])
    boxes = np.floor_divide(there, across) + 1
    image = boxes @ 3 ** np.arange(len(across), 0, -1) + 1
    move = rows_of((np.array(list(product((-1, 0, 1), repeat=len(box)))) * box).T)
    row = np.ravel_multi_index(tuple(np.moveaxis(there % across, -1, 0)), tuple(across))
    blocks = make_blocks(shape[0], len(row) // shape[0])
    return Grid(shape, row.astype(np.int64) * shape[-1], image, move, blocks)


def make_blocks(layers: int, rows: int) -> Blocks:
    """`Blocks` of so many layers of cells along the first axis, with so many rows in each.

    Pairs of a row push beads of neighbouring rows, in its layer and the next. So a phase takes
    every second slab of layers, and of a slab every second block; of an odd number of slabs the
    last, which touches the first, comes alone in the end.

    A layer is cut into as many as four pieces, for threads to have about as much to do; not into
    more, as the neighbours of a piece are fetched along with it. Of a large system a slab is more
    than one layer: a neighbour comes again as a bead of the next while it is still in cache.
    """
    pieces = 4 if rows >= 4 * FEWEST else 2 if rows >= 2 * FEWEST else 1
    deep = max(1, layers * pieces // ENOUGH_BLOCKS)
    slabs = layers if deep == 1 else layers // deep // 2 * 2
    across, along = (n * np.arange(m + 1) // m for n, m in ((layers, slabs), (rows, pieces)))
    paired = slabs // 2 * 2
    found, piece, phase = [], [0], [0]
    for turn in (range(0, paired, 2), range(1, paired, 2), range(paired, slabs)):
        for side in (0, 1):
            for slab, p in product(turn, range(side, pieces, 2)):
                found += [z * rows + along[p : p + 2] for z in range(*across[slab : slab + 2])]
                piece.append(len(found))
            if len(piece) - 1 > phase[-1]:
                phase.append(len(piece) - 1)
    return Blocks(*(np.array(numbers, np.int64) for numbers in (found, piece, phase)))


def cell_buffers(grid: Grid, beads: int, threads: int) -> Cells:
    if beads > 1 << IMAGE:
        raise UserError(f"{beads} beads: at most {1 << IMAGE} can be sorted into cells")
    cells = int(np.prod(grid.shape))
    single = np.zeros((len(grid.shape), beads + LANES), np.float32)
    sizes = cells + 1, beads, beads, (threads, cells)
    start, cell, place, free = (np.empty(size, np.uint32) for size in sizes)
    return Cells(start, single, cell, place, free, np.empty(1, np.int64))


@inlined()
def nearest_image(apart, edge):
    """A separation along an axis at its nearest image."""
    return apart - edge * np.rint(apart / edge)


@inlined(given="slide")
def nearest_images(apart, n, edges, slide):
    """Put the first ``n`` separations of a (dimension, size) array at their nearest image."""
    for p in range(n):  # in coordinates along the lattice
        apart[slide.flow, p] -= slide.tilt[0] * apart[slide.gradient, p]
    for k in range(len(edges)):
        for p in range(n):
            apart[k, p] = nearest_image(apart[k, p], edges[k])
    for p in range(n):
        apart[slide.flow, p] += slide.tilt[0] * apart[slide.gradient, p]


@inlined_exactly()
def boxes_along(x, i, edges, slide):
    """Boxes along the flow between bead i and its image in the tilted cell, 0 <= x' < L_x."""
    along = x[i, slide.flow] - slide.tilt[0] * x[i, slide.gradient]
    return np.floor(along / edges[slide.flow])


@inlined_exactly()
def along_lattice(x, i, k, edges, slide):
    """Place of bead i along axis k of the lattice, in the box."""
    if k != slide.flow:
        return x[i, k]
    along = x[i, k] - slide.tilt[0] * x[i, slide.gradient]
    return along - edges[k] * boxes_along(x, i, edges, slide)


@inlined_exactly()
def cell_of(x, i, edges, shape, slide):
    """Number of the cell that holds bead i.

    Rounded as written: left free, two copies of the code put a bead on a boundary in two cells.
    """
    cell = 0
    for k in range(len(edges)):
        if slide is None:  # asked here, else the compiler does not unroll the loop
            place = x[i, k]
        else:
            place = along_lattice(x, i, k, edges, slide)
        along = min(int(place * (shape[k] / edges[k])), shape[k] - 1)
        cell = cell * shape[k] + along
    return cell


@inlined()
def count_cells(x, mine, cell, count, edges, shape, slide):
    for c in range(count.shape[0]):
        count[c] = uint32(0)
    for i in range(mine.first, mine.end):
        cell[i] = uint32(cell_of(x, i, edges, shape, slide))
    for i in range(mine.first, mine.end):
        count[cell[i]] += uint32(1)


@inlined()
def share_cells(start, free, most):
    """Turn each thread's counts into where its beads go: after those of threads before it."""
    total, in_cell = uint32(0), uint32(0)
    for c in range(uint64(free.shape[1])):
        start[c] = total
        for rank in range(free.shape[0]):
            count = free[rank, c]
            free[rank, c] = total
            total = uint32(total + count)
        in_cell = max(in_cell, uint32(total - start[c]))
    start[free.shape[1]] = total
    most[0] = int64(in_cell)


@inlined()
def find_places(place, mine, cell, free):
    """Find where each of a thread's beads goes.

    The sort is stable, so the order of storage and of sums follows from the state alone.
    """
    for i in range(mine.first, mine.end):
        s = free[cell[i]]
        free[cell[i]] = uint32(s + uint32(1))
        place[i] = s


@inlined()
def copy_single(single, x, mine, edges, slide):
    for s in range(mine.first, mine.end):
        for k in range(len(edges)):
            single[k, s] = np.float32(x[s, k])
        if slide is not None:
            boxes = boxes_along(x, s, edges, slide)
            single[slide.flow, s] = np.float32(x[s, slide.flow] - edges[slide.flow] * boxes)


@inlined()
def move_beads(source, target, mine, place, edges):
    """Copy a thread's share of two `Beads` to their places."""
    move_rows(source.position, target.position, mine, place, edges)
    move_rows(source.velocity, target.velocity, mine, place, edges)
    move_rows(source.predicted, target.predicted, mine, place, edges)
    move_numbers(source.identity, target.identity, mine, place)
    move_numbers(source.species, target.species, mine, place)
    move_numbers(source.peculiar, target.peculiar, mine, place)
    move_rows(source.reference, target.reference, mine, place, edges)


@inlined(given="source")
def move_rows(source, target, mine, place, edges):
    for i in range(mine.first, mine.end):
        copy_row(target, place[i], source, i, edges)


@inlined(given="source")
def move_numbers(source, target, mine, place):
    for i in range(mine.first, mine.end):
        target[place[i]] = source[i]
