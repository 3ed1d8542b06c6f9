"""The one place that says how kernels are compiled.

`kernel` is for what Python calls, `part` for what kernels call. Parts are inlined by
LLVM: a function kept apart is optimised differently when it is compiled afresh and when
it is read from Numba's disk cache, and a resumed run would differ in its last bits.
"""

from functools import partial

from numba import njit

# NumPy's rules for division (no exceptions) and freedom to reorder sums let LLVM
# vectorise; NaN and infinity keep their meaning, the blow-up check needs them.
kernel = partial(
    njit,
    cache=True,
    nogil=True,
    error_model="numpy",
    fastmath={"contract", "reassoc", "nsz", "arcp"},
)
part = partial(kernel, forceinline=True)
# For what two places must agree on to the last bit: rounded as written.
exact_part = partial(part, fastmath=False)
