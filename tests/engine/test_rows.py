"""What is done with rows of beads as vectors is what NumPy does; and how kernels are linked."""

import numpy as np
import pytest
from numba import njit
from numba.extending import register_jitable

from dpd.engine import rows
from dpd.engine.integrate import put_inside, row_edges
from dpd.engine.rows import CACHE_LINE, axes_of, rows_of
from dpd.engine.threads import Share
from dpd.jit import INLINED, KERNEL

BEADS, PAIRS = 50, 200
BOXES = [(3.0, 5.5), (3.0, 5.5, 2.25)]


@pytest.fixture(params=BOXES, ids=["2D", "3D"])
def box(request):
    return request.param


@pytest.fixture
def beads(box):
    """Coordinates in and around the box, by axis."""
    rng = np.random.default_rng(3)
    return rng.uniform(-1.0, 2.0, (len(box), BEADS)) * np.array(box)[:, None]


@pytest.fixture
def pairs(box):
    """Slots of pairs, many of them of one bead in turn; a vector and a number for each."""
    rng = np.random.default_rng(4)
    i = np.sort(rng.integers(0, BEADS, PAIRS)).astype(np.uint32)
    j = (i + rng.integers(1, BEADS, PAIRS).astype(np.uint32)) % np.uint32(BEADS)
    return i, j, rng.normal(size=(len(box), PAIRS)), rng.normal(size=PAIRS)


def test_rows_and_back(beads):
    """Padded with zeros, and no row in two lines of the cache."""
    made = rows_of(beads)
    np.testing.assert_array_equal(axes_of(made, len(beads)), beads)
    np.testing.assert_array_equal(made[:, len(beads) :], 0.0)
    assert made.ctypes.data % CACHE_LINE == 0
    assert CACHE_LINE % made.strides[0] == 0


@njit(**KERNEL)
def all_at_once(force, source, reverse, shifted, shift, apart, i, j, scale, along, edges):
    for s in range(len(source)):
        rows.copy_row(reverse, len(source) - 1 - s, source, np.uint32(s), edges)
        rows.sum_to_column(shifted, s, source, s, shift, s % len(shift), edges)
    for p in range(len(i)):
        apart[p] = rows.difference_along(source, i[p], j[p], along, p, edges)
        rows.push_apart(force, i[p], j[p], scale[p], along, p, edges)


def test_rows_at_once_are_entry_by_entry(beads, pairs, box):
    """Copies, sums, and pushes, equal and opposite, bit by bit; scalar products to rounding."""
    i, j, along, scale = pairs
    force, reverse, shifted = rows_of(beads), rows_of(0 * beads), 0 * beads
    shift, apart = np.arange(2.0 * len(box)).reshape(len(box), 2), np.empty(PAIRS)
    all_at_once(
        force, rows_of(beads), reverse, shifted, rows_of(shift), apart, i, j, scale, along, box
    )
    np.testing.assert_array_equal(reverse, rows_of(beads[:, ::-1]))
    np.testing.assert_array_equal(shifted, beads + shift[:, np.arange(BEADS) % 2])
    products = ((beads[:, i] - beads[:, j]) * along).sum(axis=0)
    np.testing.assert_allclose(apart, products, rtol=0, atol=1e-14)
    expected = beads.copy()
    for a, b, change in zip(i, j, (scale * along).T, strict=True):
        expected[:, a] += change
        expected[:, b] -= change
    np.testing.assert_array_equal(force, rows_of(expected))


@pytest.mark.parametrize("share", [(0, BEADS), (7, 31)])
def test_images(beads, box, share):
    """Only a thread's own beads, and with more of them than edges are written out for."""
    position = rows_of(np.tile(beads, 10))
    inside, image = position.copy(), np.zeros((len(position), len(box)), np.int32)
    identity = np.random.default_rng(1).permutation(len(position)).astype(np.uint32)
    first, end = (10 * slot for slot in share)
    share = Share(np.uint64(first), np.uint64(end))
    njit(**KERNEL)(put_all_inside)(
        inside, image, identity, share, row_edges(box, position.shape[1]), box
    )
    moved = axes_of(inside, len(box))[:, first:end]
    edges = np.array(box)[:, None]
    assert (moved >= 0).all() and (moved < edges).all()
    boxes = (axes_of(position, len(box))[:, first:end] - moved) / edges
    image = image[identity]
    np.testing.assert_allclose(boxes, image[first:end].T, rtol=0, atol=1e-12)
    assert image[first:end].any()
    untouched = np.r_[0:first, end : len(position)]
    np.testing.assert_array_equal(inside[untouched], position[untouched])
    assert not image[untouched].any()


def put_all_inside(position, image, identity, share, wrap, edges):
    put_inside(position, image, identity, share, wrap, edges, None)


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
