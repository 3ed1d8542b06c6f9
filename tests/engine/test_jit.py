"""Parts are linked once into kernels; where Numba is another one, they are compiled as it does."""

import numpy as np
import pytest
from numba import njit
from numba.core.options import DefaultOptions
from numba.extending import register_jitable

from dpd import jit
from dpd.jit import INLINED, OPTIONS


def test_numba_has_what_parts_are_linked_with():
    """A version that has it not: see what took its place, or keep the pinned one."""
    assert jit.lacking() == [], "kernels compile more slowly with this Numba"


def test_another_numba_compiles_as_it_does(monkeypatch):
    """What is missing is named, and no option of ours is left."""
    monkeypatch.setitem(jit.RELIED_ON, DefaultOptions, ("_gone",))
    assert jit.lacking() == ["_gone"]
    assert jit.compilers() == [{}, {}]


@pytest.mark.parametrize("ours", [True, False])
def test_parts_of_parts(ours):
    """A part that two others call, and the kernel too: linked once, the same numbers either way."""
    of_kernels, of_parts = jit.compilers() if ours else [{}, {}]
    of_numba = {key: INLINED[key] for key in INLINED if key not in ("pipeline_class", "_nrt")}
    options = of_numba | of_parts

    @register_jitable(**options)
    def square(x):
        return x * x

    @register_jitable(**options)
    def length(x):
        return np.sqrt(square(x[0]) + square(x[1]))

    @njit(**of_kernels, **OPTIONS)
    def summed(rows):
        total = 0.0
        for k in range(len(rows)):
            total += length(rows[k]) + square(rows[k, 0])
        return total

    assert summed(np.array([[3.0, 4.0], [6.0, 8.0]])) == pytest.approx(5 + 9 + 10 + 36)
