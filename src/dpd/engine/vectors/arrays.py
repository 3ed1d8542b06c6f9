"""Arrays that grow, and arrays with a row for each bead."""

import numpy as np

from dpd.jit import part

CACHE_LINE = 64  # bytes


@part()
def columns(array, count, size):
    """The first ``count`` columns of a (rows, n) array, in one with room for ``size``.

    Loops on purpose: what Numba makes of an assignment to a slice takes seconds to compile,
    for the sake of an error message.
    """
    kept = np.empty((array.shape[0], size), array.dtype)
    for k in range(array.shape[0]):
        for p in range(count):
            kept[k, p] = array[k, p]
    return kept


def rows_of(array: np.ndarray) -> np.ndarray:
    """A (dimension, n) array as kernels take it: a row for each bead.

    Pairs push beads that lie anywhere in memory. A row, padded with zeros to a width that
    processors load and store at once, is one access, where three arrays would be three.
    """
    dimension, beads = array.shape
    rows = empty_rows(beads, row_width(dimension))
    for k in range(dimension):  # twice as fast as all at once
        rows[:, k] = array[k]
    rows[:, dimension:] = 0.0
    return rows


def empty_rows(beads: int, width: int) -> np.ndarray:
    """An array of rows that begins where a line of the cache does: no row lies in two."""
    memory = np.empty(beads * width + CACHE_LINE // 8)
    first = -memory.ctypes.data % CACHE_LINE // 8
    return memory[first : first + beads * width].reshape(beads, width)


def axes_of(rows: np.ndarray, dimension: int) -> np.ndarray:
    """The (dimension, n) view of what `rows_of` made."""
    return rows[:, :dimension].T


@part()
def row_width(dimension):
    """Numbers in a row: a power of two."""
    return 2 if dimension < 3 else 4
