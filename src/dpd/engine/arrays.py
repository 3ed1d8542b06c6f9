"""Arrays that grow.

Loops on purpose: what Numba makes of an assignment to a slice takes seconds to compile, for
the sake of an error message.
"""

import numpy as np

from dpd.engine.jit import part


@part()
def columns(array, count, size):
    """The first ``count`` columns of a (rows, n) array, in one with room for ``size``."""
    kept = np.empty((array.shape[0], size), array.dtype)
    for k in range(array.shape[0]):
        for p in range(count):
            kept[k, p] = array[k, p]
    return kept
