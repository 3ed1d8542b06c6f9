"""How rows of beads lie in memory, and how kernels are linked."""

import numpy as np
import pytest
from numba import njit
from numba.extending import register_jitable

from dpd.engine.rows import CACHE_LINE, axes_of, rows_of
from dpd.jit import INLINED, KERNEL


@pytest.mark.parametrize("dimension", [2, 3])
def test_rows_and_back(dimension):
    """Padded with zeros, and no row in two lines of the cache."""
    beads = np.random.default_rng(3).normal(size=(dimension, 50))
    made = rows_of(beads)
    np.testing.assert_array_equal(axes_of(made, len(beads)), beads)
    np.testing.assert_array_equal(made[:, len(beads) :], 0.0)
    assert made.ctypes.data % CACHE_LINE == 0
    assert CACHE_LINE % made.strides[0] == 0


@pytest.mark.parametrize("ours", [True, False])
def test_parts_of_parts(ours):
    """A part that two others call, and the kernel too: linked once, the same by Numba's own way."""
    private = () if ours else ("pipeline_class", "_nrt")
    options, of_kernel = (
        {k: given[k] for k in given if k not in private} for given in (INLINED, KERNEL)
    )

    @register_jitable(**options)
    def square(x):
        return x * x

    @register_jitable(**options)
    def length(x):
        return np.sqrt(square(x[0]) + square(x[1]))

    @njit(**of_kernel)
    def summed(rows):
        total = 0.0
        for k in range(len(rows)):
            total += length(rows[k]) + square(rows[k, 0])
        return total

    assert summed(np.array([[3.0, 4.0], [6.0, 8.0]])) == pytest.approx(5 + 9 + 10 + 36)
