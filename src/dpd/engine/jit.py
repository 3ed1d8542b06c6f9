"""The one place that says how kernels are compiled.

`kernel` is for what Python calls, `part` for what kernels call; in Python a part stays a plain
function. Parts are inlined by LLVM: a function kept apart is optimised differently when it is
compiled afresh and when it is read from Numba's disk cache, and a resumed run would differ in
its last bits. Nor is anything compiled for parts that only Python would need, a quarter of
the time that a kernel takes.
"""

import sys
from functools import partial
from importlib import import_module

from numba import njit
from numba.extending import register_jitable


def _without_blas():
    """Spare every process SciPy's linear algebra, which takes 0.2 s of the 0.7 to a first step.

    Numba looks for it once, when it loads the first kernel, and goes without where there is none.
    No kernel here needs it.
    """
    blas = "scipy.linalg.cython_blas"
    if blas not in sys.modules:
        sys.modules[blas] = None  # so that importing it fails
        try:
            import_module("numba.np.arraymath")  # where Numba looks
        finally:
            del sys.modules[blas]


_without_blas()

# NumPy's rules for division (no exceptions) and freedom to reorder sums let LLVM
# vectorise; NaN and infinity keep their meaning, the blow-up check needs them.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz", "arcp"}}
kernel = partial(njit, cache=True, nogil=True, **OPTIONS)
part = partial(register_jitable, forceinline=True, no_cfunc_wrapper=True, **OPTIONS)
# For what two places must agree on to the last bit: rounded as written.
exact_part = partial(part, fastmath=False)
