"""Images that slide: the lattice, its nearest images, and the pairs that are found in it."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from dpd.engine import images
from dpd.engine.images import nearest_images, put_inside
from dpd.engine.queries.pairs import pair_histogram
from dpd.engine.rows import axes_of, rows_of
from dpd.engine.space import (
    TURN,
    along_axes,
    edges_of,
    nearest,
    slide_of,
    tilted,
    unfolded,
    wrapped,
)
from dpd.engine.threads import Share
from dpd.jit import kernel
from dpd.physics.shear import Shear
from tests.engine.test_pairs import pairs_by_cells

DOUBTFUL = 1e-9  # r_c: a distance this near to the cutoff may be rounded to either side
AXES = {2: [(0, 1)], 3: [(0, 1), (0, 2), (1, 2)]}


@kernel()
def tilt_at(slide, step):
    """The tilt that a kernel sees."""
    return images.tilt_at(slide, step)


@kernel()
def nearest_in_kernel(apart, edges, slide):
    nearest_images(apart, apart.shape[1], edges, slide)


@kernel()
def inside_in_kernel(position, image, identity, wrap, edges, slide):
    mine = Share(np.uint64(0), np.uint64(len(position)))
    put_inside(position, image, identity, mine, wrap, edges, slide)


def box_with(edges, shear, turns):
    """A box whose images have slid by some share of an edge."""
    return tilted(edges, shear, 0.04, 0, round(turns * TURN) % TURN)


@st.composite
def tilted_boxes(draw):
    """A box of two dimensions or three, at any tilt: upright, half an edge, and between."""
    dimension = draw(st.sampled_from([2, 3]))
    flow, gradient = draw(st.sampled_from(AXES[dimension]))
    box = draw(st.lists(st.floats(2.0, 7.0), min_size=dimension, max_size=dimension))
    turns = draw(st.one_of(st.sampled_from([-0.5, 0.0, 0.25, 0.4999999]), st.floats(-0.5, 0.5)))
    tall = box[gradient]
    box[flow] = max(box[flow], 2 / np.sqrt(1 - 1 / max(tall, 2.0) ** 2) + 1e-9)
    return box_with(box, Shear(0.1, flow, gradient), turns)


def lattice(box, reach=2):
    """(images, dimension) vectors of the lattice of images up to some edges away."""
    slide = box.slide
    vectors = np.diag(np.array(box))
    vectors[slide.gradient, slide.flow] = box.tilt * box[slide.gradient]
    counts = [range(-reach, reach + 1)] * len(box)
    counts[slide.flow] = range(-reach - 3, reach + 4)
    return np.array(list(product(*counts))) @ vectors


@st.composite
def sheared_beads(draw, most=40):
    """Beads in such a box; beads on its faces, in its middle, in clusters and at one place."""
    box = draw(tilted_boxes())
    count = draw(st.one_of(st.sampled_from([1, 2]), st.integers(3, most)))
    special = st.sampled_from([0.0, 0.5, np.nextafter(1.0, 0.0)])
    anywhere = st.one_of(st.floats(0.0, 1.0, exclude_max=True), special)
    fraction = draw(arrays.arrays(float, (len(box), count), elements=anywhere))
    spread = draw(st.sampled_from([1.0, 0.2, 0.0]))
    corner = draw(arrays.arrays(float, (len(box), 1), elements=anywhere))
    if spread < 1.0:
        fraction = (corner + spread * fraction) % 1.0
    edges = np.array(box)[:, None]
    return np.minimum(fraction * edges, np.nextafter(edges, 0.0)), box


def pairs_by_looking(position, box, cutoff):
    """Identities i < j of all pairs, their separation at the nearest of all images, distance."""
    i, j = np.triu_indices(position.shape[1], 1)
    apart = (position[:, i] - position[:, j])[:, :, None] + lattice(box).T[:, None, :]
    square = (apart**2).sum(axis=0)
    best = square.argmin(axis=1)
    return i, j, apart[:, np.arange(len(i)), best], np.sqrt(square.min(axis=1))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(sheared_beads())
def test_cells_find_every_pair_once(case):
    """The pairs within the cutoff among all images, each once, with its separation."""
    position, box = case
    found = pairs_by_cells(position, box, 1.0)
    i, j, apart, distance = pairs_by_looking(position, box, 1.0)
    expected = {(a, b): s for a, b, s in zip(i, j, apart.T)}
    sure = {pair for pair, r in zip(zip(i, j), distance) if r < 1.0 - DOUBTFUL}
    seen = []
    for a, b, separation in found:
        pair, sign = ((a, b), 1) if a < b else ((b, a), -1)
        r = np.linalg.norm(separation)
        assert r < 1.0 + DOUBTFUL
        if r < 1.0 - DOUBTFUL:
            seen.append(pair)
            np.testing.assert_allclose(sign * separation, expected[pair], rtol=0, atol=1e-13)
    assert len(seen) == len(set(seen))
    assert set(seen) == sure


@settings(max_examples=100, deadline=None, derandomize=True)
@given(sheared_beads(), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_images_are_images(case, more, less):
    """NumPy and kernels: what is wrapped lies in the box, an image away; what is nearest too, at
    the nearest of all images if that is within the cutoff."""
    position, box = case
    edges = np.array(box)[:, None]
    away = position + edges * np.array([more, less, more][: len(box)])[:, None]
    for function in (lambda x: wrapped(x, box), lambda x: inside_by_kernel(x, box)):
        inside, image = function(away)
        assert (inside >= 0).all() and (inside < edges).all()
        np.testing.assert_allclose(unfolded(inside, image, box), away, rtol=0, atol=1e-11)
    apart = away[:, :1] - away
    for function in (lambda x: nearest(x, box), lambda x: nearest_by_kernel(x, box)):
        found = function(apart)
        assert_images(apart - found, box)
        others = np.sqrt(((found[:, :, None] + lattice(box).T[:, None, :]) ** 2).sum(axis=0))
        least, length = others.min(axis=1), np.sqrt((found**2).sum(axis=0))
        within = least < 1.0 - DOUBTFUL
        np.testing.assert_allclose(length[within], least[within], rtol=0, atol=1e-12)


def inside_by_kernel(position, box):
    rows, image = rows_of(position), np.zeros(position.T.shape, np.int32)
    identity = np.arange(len(rows)).astype(np.uint32)
    inside_in_kernel(rows, image, identity, np.zeros((2, 1)), edges_of(box), slide_of(box))
    return axes_of(rows, len(position)), image.T


def nearest_by_kernel(apart, box):
    found = np.ascontiguousarray(apart)
    nearest_in_kernel(found, edges_of(box), slide_of(box))
    return found


def assert_images(moved, box):
    """Moved by whole vectors of the lattice."""
    boxes = along_axes(moved, box) / np.array(box)[:, None]
    np.testing.assert_allclose(boxes, np.rint(boxes), rtol=0, atol=1e-11)


@pytest.mark.parametrize("turns", [-0.5, -0.2, 0.0, 0.31])
def test_histogram_counts_pairs_of_a_tilted_box(turns):
    box = box_with((5.0, 4.0, 4.4), Shear(0.1, 0, 1), turns)
    position = np.random.default_rng(4).random((3, 200)) * np.array(box)[:, None]
    counts = pair_histogram(position, box, 2.0, 40)
    distance = pairs_by_looking(position, box, 2.0)[3]
    np.testing.assert_array_equal(counts, np.histogram(distance, np.linspace(0, 2, 41))[0])
    species = np.repeat(np.array([0, 1], np.uint8), [60, 140])
    by_species = pair_histogram(position, box, 2.0, 40, species)
    np.testing.assert_array_equal(by_species[np.triu_indices(2)].sum(axis=0), counts)


@settings(max_examples=200, deadline=None, derandomize=True)
@example(10**12, 0.1, 0.04, (10.0, 10.0, 10.0))
@given(
    st.integers(0, 10**12), st.floats(-2.0, 2.0), st.floats(1e-6, 0.1),
    st.tuples(*[st.floats(2.0, 1000.0)] * 3),
)  # fmt: skip
def test_the_slide_is_exact_after_any_number_of_steps(step, rate, dt, box):
    """By fractions: the speed of the slide is rounded to 2^-65 of an edge, once; the kernel has
    the same bits as NumPy."""
    shear = Shear(rate, 0, 1)
    found = tilted(box, shear, dt, step)
    turns = Fraction(found.tilt) * Fraction(box[1]) / Fraction(box[0])
    exact = Fraction(rate) * Fraction(dt) * step * Fraction(box[1]) / Fraction(box[0])
    off = (turns - exact) % 1
    assert min(off, 1 - off) < Fraction(step, 2**65) + Fraction(1, 2**51)
    assert abs(turns) <= Fraction(1, 2) + Fraction(1, 2**51)
    assert tilt_at(tilted(box, shear, dt, 0).slide, step) == found.tilt
    later = tilted(box, shear, dt, step, begun=12345 * 2**50)
    assert tilt_at(later.slide, step) == later.tilt
    assert (later.slid - found.slid - 12345 * 2**50 + 2**13) % TURN < 2**14
