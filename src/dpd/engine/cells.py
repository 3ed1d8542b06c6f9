"""Cells: sort beads so that neighbours in space are neighbours in memory.

Cells are numbered with the last axis fastest, so a row of cells along that axis is one
stretch of memory. The place of a cell in its row is called its level.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from numba import int64, uint32

from dpd.engine.jit import exact_part, part


class Grid(NamedTuple):
    """Cells of a box, and which rows touch which.

    Attributes
    ----------
    shape : tuple of int
        Cells along each axis.
    base : (rows, ahead) int64 array
        First cell of each row itself and of half of those around it, the ones ahead: one in
        two dimensions, four in three.
    shift : (rows, ahead, dimension - 1) array
        What brings beads of that row to the near side of a periodic boundary.
    """

    shape: tuple
    base: np.ndarray
    shift: np.ndarray


class Cells(NamedTuple):
    """Where sorted beads lie: first slot of each cell, one more at the end; level of each bead."""

    start: np.ndarray
    level: np.ndarray


def grid(box, cutoff):
    """The `Grid` with as many cells as fit with edges not below the cutoff."""
    shape = tuple(max(1, int(edge / cutoff)) for edge in box)
    across, edges = np.array(shape[:-1]), np.array(box[:-1])
    here = np.array(list(product(*map(range, across))))
    around = list(product((-1, 0, 1), repeat=len(across)))
    there = here[:, None] + np.array([offset for offset in around if offset >= (0,) * len(across)])
    shift = edges * np.floor_divide(there, across)
    row = np.ravel_multi_index(tuple(np.moveaxis(there % across, -1, 0)), tuple(across))
    return Grid(shape, row.astype(np.int64) * shape[-1], shift)


@part()
def cell_buffers(grid, beads):
    """`Cells` to be filled by a sort."""
    cells = 1
    for k in range(len(grid.shape)):
        cells *= grid.shape[k]
    return Cells(np.empty(cells + 1, np.uint32), np.empty(beads, np.uint32))


@exact_part()
def cell_of(position, i, box, shape):
    """Number of the cell that holds bead i, and its level.

    Counting and sorting both ask, and a resumed list asks again, so it is rounded as
    written: left free, two copies of the code put a bead on a boundary in two cells.
    """
    cell, along = 0, 0
    for k in range(len(box)):
        along = min(int(position[k, i] * (shape[k] / box[k])), shape[k] - 1)
        cell = cell * shape[k] + along
    return cell, along


@part()
def find_cells(position, box, grid, cells):
    """Fill ``cells`` for beads that lie sorted; for others, only ``start`` is right."""
    start, level = cells
    start[:] = 0
    for i in range(position.shape[1]):
        cell, along = cell_of(position, i, box, grid.shape)
        start[cell + 1] += np.uint32(1)
        level[i] = uint32(along)
    for c in range(1, len(start)):
        start[c] += start[c - 1]


@part()
def sort_by_cell(source, target, box, grid, cells):
    """Copy (position, velocity, predicted, identity, species) sorted by cell; fill ``cells``.

    The sort is stable, so the order of storage follows from the state alone and a
    resumed run adds up its forces in the same order as an uninterrupted one.
    """
    position, velocity, predicted, identity, species = source
    find_cells(position, box, grid, cells)
    free = cells.start.copy()
    for i in range(position.shape[1]):
        cell, along = cell_of(position, i, box, grid.shape)
        s = free[cell]
        free[cell] += np.uint32(1)
        cells.level[s] = uint32(along)
        for k in range(len(box)):
            target[0][k, s] = position[k, i]
            target[1][k, s] = velocity[k, i]
            target[2][k, s] = predicted[k, i]
        target[3][s] = identity[i]
        copy_species(target[4], s, species, i)


@part()
def copy_species(target, s, source, i):
    """Copy one bead's species, where there are several."""
    if source is not None:
        target[s] = source[i]


@part()
def like(array):
    """An empty array like another; None for None."""
    if array is None:
        return None
    return np.empty_like(array)


@part()
def empty_like(beads):
    """Buffers to sort beads into."""
    position, velocity, predicted, identity, species = beads
    return (
        np.empty_like(position),
        np.empty_like(velocity),
        np.empty_like(predicted),
        np.empty_like(identity),
        like(species),
    )


@part()
def fullest(start, cells_together):
    """Most beads in any stretch of so many cells, counted from the first."""
    most = 0
    for first in range(0, len(start) - 1, cells_together):
        most = max(most, int64(start[first + cells_together]) - int64(start[first]))
    return most
