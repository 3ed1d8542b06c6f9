"""Cells: sort beads so that neighbours in space are neighbours in memory.

Cells are numbered with the last axis fastest, so a row of cells along that axis is one
stretch of memory. The place of a cell in its row is called its level.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.slide import along_lattice, longest_cutoffs
from dpd.engine.threads.blocks import Blocks, make_blocks
from dpd.engine.threads.team import Share
from dpd.engine.vectors.arrays import rows_of
from dpd.engine.vectors.rows import copy_row
from dpd.jit import exact_part, part

if TYPE_CHECKING:
    from dpd.engine.space import Space

SPARE = 8  # so that loops over the cells of a row may go on to a whole number of vectors


class Grid(NamedTuple):
    """Cells of a box, and which rows touch which.

    Attributes
    ----------
    shape : tuple of int
        Cells along each axis.
    base : (rows, ahead) int64 array
        First cell of each row itself and of half of those around it, the ones ahead: one in
        two dimensions, four in three.
    shift : (rows * ahead, width) array
        What brings beads of that row to the near side of a periodic boundary.
    blocks : Blocks
        Of rows, for threads to share.
    """

    shape: tuple
    base: np.ndarray
    shift: np.ndarray
    blocks: Blocks


class Cells(NamedTuple):
    """Where beads lie, before and after a sort.

    Attributes
    ----------
    start : (cells + 1 + `SPARE`,) uint32 array
        First slot of each cell, and the end of the last; what follows may be read, not used.
    level : (n,) uint32 array
        Level of each bead, sorted.
    cell, along : (n,) uint32 arrays
        Cell and level of each bead before the sort.
    free : (threads, cells) uint32 array
        Where each thread puts its next bead of a cell.
    most : (2,) int64 array
        Most beads in a cell, and in a row.
    """

    start: np.ndarray
    level: np.ndarray
    cell: np.ndarray
    along: np.ndarray
    free: np.ndarray
    most: np.ndarray


def grid(space: Space, cutoff: float) -> Grid:
    """The `Grid` with as many cells as fit with edges not below the cutoff."""
    box = space.edges
    cutoffs = longest_cutoffs(space, cutoff)
    shape = tuple(max(1, int(edge / longest)) for edge, longest in zip(box, cutoffs))
    across, edges = np.array(shape[:-1]), np.array(box[:-1])
    here = np.array(list(product(*map(range, across))))
    around = list(product((-1, 0, 1), repeat=len(across)))
    there = here[:, None] + np.array([offset for offset in around if offset >= (0,) * len(across)])
    shift = np.zeros((*there.shape[:2], len(box)))
    shift[..., :-1] = edges * np.floor_divide(there, across)
    row = np.ravel_multi_index(tuple(np.moveaxis(there % across, -1, 0)), tuple(across))
    blocks = make_blocks(shape[0], len(row) // shape[0])
    shift = rows_of(shift.reshape(-1, len(box)).T)
    return Grid(shape, row.astype(np.int64) * shape[-1], shift, blocks)


@part()
def cell_buffers(grid, beads, threads):
    """`Cells` to be filled by a sort."""
    cells = 1
    for k in range(len(grid.shape)):
        cells *= grid.shape[k]
    return Cells(
        np.empty(cells + 1 + SPARE, np.uint32),
        np.empty(beads, np.uint32),
        np.empty(beads, np.uint32),
        np.empty(beads, np.uint32),
        np.empty((threads, cells), np.uint32),
        np.empty(2, np.int64),
    )


@exact_part()
def cell_of(position, i, space, shape):
    """Number of the cell that holds bead i, and its level.

    Sorting asks, and a resumed list asks again, so it is rounded as written: left free, two
    copies of the code put a bead on a boundary in two cells.
    """
    cell, along = 0, 0
    for k in range(len(space.edges)):
        if space.slide is None:  # asked here, else the compiler does not unroll the loop
            place = position[i, k]
        else:
            place = along_lattice(position, i, k, space, space.slide)
        along = min(int(place * (shape[k] / space.edges[k])), shape[k] - 1)
        cell = cell * shape[k] + along
    return cell, along


@part()
def count_cells(position, mine, space, grid, cells, rank):
    """Find the cells of a thread's share of the beads, and count them."""
    free = cells.free[rank]
    for c in range(free.shape[0]):
        free[c] = np.uint32(0)
    for i in range(mine.first, mine.end):
        cell, along = cell_of(position, i, space, grid.shape)
        cells.cell[i] = uint32(cell)
        cells.along[i] = uint32(along)
    for i in range(mine.first, mine.end):
        free[cells.cell[i]] += np.uint32(1)


@part()
def share_cells(cells, grid):
    """Turn each thread's counts into where its beads go: after those of threads before it."""
    start, free = cells.start, cells.free
    total = uint32(0)
    for c in range(free.shape[1]):
        start[c] = total
        for rank in range(free.shape[0]):
            count = free[rank, c]
            free[rank, c] = total
            total = uint32(total + count)
    start[free.shape[1]] = total
    cells.most[0] = fullest(start, free.shape[1], 1)
    cells.most[1] = fullest(start, free.shape[1], grid.shape[len(grid.shape) - 1])


@part()
def move_to_cells(source, target, mine, space, cells, rank):
    """Copy a thread's share of the beads to their places.

    The sort is stable, so the order of storage follows from the state alone, and a resumed run
    adds up its forces in the same order as an uninterrupted one.

    Parameters
    ----------
    source, target : Beads
    """
    free = cells.free[rank]
    for i in range(mine.first, mine.end):
        cell = cells.cell[i]
        s = free[cell]
        free[cell] = uint32(s + uint32(1))
        cells.level[s] = cells.along[i]
        copy_row(target.position, s, source.position, i, space)
        copy_row(target.velocity, s, source.velocity, i, space)
        target.identity[s] = source.identity[i]
        copy_predicted(target.predicted, s, source.predicted, i, space)
        copy_number(target.species, s, source.species, i)
        copy_number(target.peculiar, s, source.peculiar, i)


@part()
def sort_by_cell(source, target, space, grid, cells):
    """Copy beads sorted by cell, and fill ``cells``; all by one thread."""
    mine = Share(uint64(0), uint64(len(source.identity)))
    count_cells(source.position, mine, space, grid, cells, 0)
    share_cells(cells, grid)
    move_to_cells(source, target, mine, space, cells, 0)


@part()
def copy_predicted(target, s, source, i, space):
    """Copy one bead's predicted velocity, where it is kept."""
    if source is not None:
        copy_row(target, s, source, i, space)


@part()
def copy_number(target, s, source, i):
    """Copy one bead's species where there are several, its way by itself where there is a flow."""
    if source is not None:
        target[s] = source[i]


@part()
def fullest(start, cells, cells_together):
    """Most beads in any stretch of so many cells, counted from the first."""
    most = 0
    for first in range(0, cells, cells_together):
        most = max(most, int64(start[first + cells_together]) - int64(start[first]))
    return most
