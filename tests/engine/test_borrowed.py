"""Records whose arrays a kernel does not count."""

import sys
from typing import NamedTuple

import numpy as np
from numba import njit

from dpd.engine.threads.borrowed import borrowed
from dpd.jit import KERNEL, part


class Inner(NamedTuple):
    weight: np.ndarray
    nothing: None
    flag: bool


class Outer(NamedTuple):
    inner: Inner
    rows: np.ndarray
    scale: float


@part()
def double(record):
    for i in range(record.rows.shape[0]):
        record.rows[i, 0] *= record.scale
    return record.inner.weight.sum()


@njit(**KERNEL)
def through_borrowed(record):
    mine = borrowed(record)
    total = double(mine)
    return total, mine.inner.nothing is None, mine.inner.flag, mine.rows[1:, 0].sum()


@njit(**KERNEL)
def references(record):
    return len(borrowed(record).rows)


def example():
    return Outer(Inner(np.arange(3.0), None, True), np.ones((4, 2)), 2.0)


def test_a_borrowed_record_is_the_same():
    """Its fields, those of records in it, and what is written into its arrays."""
    record = example()
    assert through_borrowed(record) == (3.0, True, True, 6.0)
    assert np.array_equal(record.rows, [[2.0, 1.0]] * 4)


def test_an_array_and_none():
    @njit(**KERNEL)
    def total(array, nothing):
        return borrowed(array).sum(), borrowed(nothing) is None

    assert total(np.arange(4.0), None) == (6.0, True)


def test_the_owner_is_not_touched():
    """However often it is lent, and after the last time the array is let go."""
    record = example()
    before = sys.getrefcount(record.rows)
    for _ in range(5):
        references(record)
    after = sys.getrefcount(record.rows)  # not in the assertion, which holds it once more
    assert after == before
