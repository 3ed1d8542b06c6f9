"""Cells: sort beads so that neighbours in space are neighbours in memory; find pairs.

Cells are numbered with the last axis fastest, so the three cells z-1, z, z+1 of a row
are one stretch of memory. A bead's partners are looked for in the forward half of the
rows around it, each pair is found once.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from numba import int64, uint32, uint64

from dpd.engine.jit import exact_part, part

U0, U1 = np.uint64(0), np.uint64(1)


class Pairs(NamedTuple):
    """Buffers for some pairs.

    ``separation[:, p]`` is r_i - r_j of pair p at its nearest image, ``scratch`` holds
    four numbers a pair, ``low`` and ``high`` the sorted identities.
    """

    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray
    scratch: np.ndarray
    low: np.ndarray
    high: np.ndarray


def grid_shape(box, cutoff):
    """Cells along each axis: as many as fit with edges not below the cutoff."""
    return tuple(max(1, int(edge / cutoff)) for edge in box)


def forward_rows(dimension):
    """Offsets to the rows ahead of a row: 1 in two dimensions, 4 in three."""
    here = (0,) * (dimension - 1)
    return np.array([o for o in product((-1, 0, 1), repeat=dimension - 1) if o > here])


@exact_part()
def cell_of(position, i, box, shape):
    """Number of the cell that holds bead i.

    Counting and sorting both ask, and a resumed list asks again, so it is rounded as
    written: left free, two copies of the code put a bead on a boundary in two cells.
    """
    cell = 0
    for k in range(len(box)):
        along = int(position[k, i] * (shape[k] / box[k]))
        cell = cell * shape[k] + min(along, shape[k] - 1)
    return cell


@part()
def starts_from_counts(start):
    """Turn counts, kept one place up, into first slots; return the fullest cell's count."""
    fullest = uint32(0)
    for c in range(1, len(start)):
        fullest = max(fullest, start[c])
        start[c] += start[c - 1]
    return int64(fullest)


@part()
def pair_buffers(dimension, size):
    """Buffers for ``size`` pairs."""
    return Pairs(
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
        np.empty((dimension, size)),
        np.empty((4, size)),
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
    )


@part()
def fullest_row(start, cells_in_row):
    """Largest number of beads in a row of cells."""
    most = 0
    for first in range(0, len(start) - 1, cells_in_row):
        most = max(most, int64(start[first + cells_in_row]) - int64(start[first]))
    return most


@part()
def row_buffers(start, box, shape, ahead, fullest):
    """Buffers large enough for all pairs of any row of cells."""
    beads = fullest_row(start, shape[len(box) - 1])
    return pair_buffers(len(box), beads * (3 * len(ahead) + 2) * fullest)


@part()
def append(candidate, slot, m, position, first, last, shift, box):
    """Append beads ``first`` to ``last``, moved by ``shift``, to the candidates."""
    n = uint64(last - first)
    for k in range(len(box)):
        move = shift[k]
        for t in range(n):
            candidate[k, m + t] = position[k, first + t] + move
    for t in range(n):
        slot[m + t] = uint32(first + t)
    return uint64(m + n)


@part()
def gather_candidates(z, row, base, shift, position, start, box, shape, candidate, slot):
    """Copy what a bead of cell z may touch to one stretch: own cell first, then ahead.

    Beads across a periodic boundary are copied moved by the box, so the loop over
    candidates needs no minimum image. ``base`` and ``shift`` describe the rows: own row
    last.
    """
    last_axis = len(box) - 1
    nz, length = shape[last_axis], box[last_axis]
    own = len(base) - 1
    first, edge = base[own] + z, base[own] + nz
    ahead = min(first + 2, edge)
    m = append(candidate, slot, U0, position, start[first], start[ahead], shift[own], box)
    if first + 1 == edge:
        b = base[own]
        shift[own, last_axis] = length
        m = append(candidate, slot, m, position, start[b], start[b + 1], shift[own], box)
        shift[own, last_axis] = 0.0
    for t in range(own):
        b = base[t]
        if z == 0:
            shift[t, last_axis] = -length
            m = append(
                candidate, slot, m, position, start[b + nz - 1], start[b + nz], shift[t], box
            )
            shift[t, last_axis] = 0.0
        lo, hi = max(z - 1, 0), min(z + 2, nz)
        m = append(candidate, slot, m, position, start[b + lo], start[b + hi], shift[t], box)
        if z == nz - 1:
            shift[t, last_axis] = length
            m = append(candidate, slot, m, position, start[b], start[b + 1], shift[t], box)
            shift[t, last_axis] = 0.0
    return m


@part()
def row_pairs(row, position, start, box, shape, ahead, cutoff, fullest, pairs):
    """Find all pairs closer than the cutoff whose first bead lies in one row of cells.

    Parameters
    ----------
    row : int
        Number of the row, counted over all axes but the last.
    position : (dimension, n) array
        Sorted by cell, inside the box.
    start : (cells + 1,) uint32 array
        First slot of each cell.
    box, shape : tuples of length dimension
        Edges, and cells along each.
    ahead : (rows, dimension - 1) array
        From `forward_rows`.
    fullest : int
        Most beads in any cell.
    pairs : Pairs
        Filled from 0.

    Returns
    -------
    uint64
        How many pairs were found.
    """
    dimension = len(box)
    nz = shape[dimension - 1]
    here = np.empty(dimension, np.int64)
    left = row
    for k in range(dimension - 2, -1, -1):
        here[k] = left % shape[k]
        left //= shape[k]
    base = np.empty(len(ahead) + 1, np.int64)
    shift = np.zeros((len(ahead) + 1, dimension))
    base[len(ahead)] = row * nz
    for t in range(len(ahead)):
        there = 0
        for k in range(dimension - 1):
            along = here[k] + ahead[t, k]
            if along < 0:
                along += shape[k]
                shift[t, k] = -box[k]
            if along >= shape[k]:
                along -= shape[k]
                shift[t, k] = box[k]
            there = there * shape[k] + along
        base[t] = there * nz
    most = (3 * len(ahead) + 2) * fullest
    candidate = np.empty((dimension, most))
    slot = np.empty(most, np.uint32)
    square = np.empty(most)
    limit = cutoff * cutoff
    n = U0
    for z in range(nz):
        first = uint64(start[row * nz + z])
        last = uint64(start[row * nz + z + 1])
        if first == last:
            continue
        m = gather_candidates(z, row, base, shift, position, start, box, shape, candidate, slot)
        for own in range(uint64(last - first)):
            for b in range(m):
                s = 0.0
                for k in range(dimension):
                    d = candidate[k, own] - candidate[k, b]
                    s += d * d
                square[b] = s
            # Branchless compaction: always write, advance only when within the cutoff.
            found = n
            for b in range(uint64(own + U1), m):
                pairs.j[n] = uint32(b)
                n += uint64(square[b] < limit)
            for p in range(found, n):
                b = pairs.j[p]
                for k in range(dimension):
                    pairs.separation[k, p] = candidate[k, own] - candidate[k, b]
                pairs.j[p] = slot[b]
                pairs.i[p] = uint32(first + own)
    return n
