"""Images that may slide, and the search that finds the pairs that looking at all of them finds."""

import itertools
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.spatial import cKDTree

from dpd.engine import integrate, space
from dpd.engine.measure import pair_histogram, sorted_beads
from dpd.engine.neighbours import first_place, near_pairs
from dpd.engine.rows import axes_of, rows_of
from dpd.engine.space import edges_of, nearest, wrapped
from dpd.engine.threads import Share
from dpd.jit import FEATURES, kernel
from dpd.physics.shear import Shear
from tests.systems import BOX_2D, BOX_3D, make_simulation, make_system, random_beads

DOUBTFUL = 1e-9  # r_c: a distance this near to the cutoff may be rounded to either side
AXES = {2: [(0, 1)], 3: [(0, 1), (0, 2), (1, 2)]}
EXAMPLES = settings(max_examples=200, deadline=None, derandomize=True)


@kernel()
def tilt_at(slide, step):
    return integrate.tilt_at(slide, step)


@kernel()
def nearest_in_kernel(apart, edges, slide):
    space.nearest_images(apart, apart.shape[1], edges, slide)


@kernel()
def inside_in_kernel(position, image, identity, wrap, edges, slide):
    mine = Share(np.uint64(0), np.uint64(len(position)))
    integrate.put_inside(position, image, identity, mine, wrap, edges, slide)


@kernel()
def fill_pairs(one, other, apart, beads, cutoff):
    total, pairs = 0, beads.search.pairs
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = near_pairs(at, len(beads.bead), beads.ordered, beads.search, cutoff)
        for p in range(n):
            one[total], other[total] = beads.bead[pairs.i[p]], beads.bead[pairs.j[p]]
            for k in range(len(beads.search.edges)):
                apart[total, k] = pairs.separation[k, p]
            total += 1
    return total


def lattice(box):
    """(images, dimension) vectors of the lattice of images around a box."""
    vectors, counts, slide = np.diag(np.array(box)), [range(-2, 3)] * len(box), space.slide_of(box)
    if slide is not None:
        vectors[slide.gradient, slide.flow] = box.tilt * box[slide.gradient]
        counts[slide.flow] = range(-5, 6)
    return np.array(list(itertools.product(*counts))) @ vectors


def pairs_by_looking(position, box):
    """Identities i < j of all pairs, their separation at the nearest of all images, distance."""
    i, j = np.triu_indices(position.shape[1], 1)
    apart = (position[:, i] - position[:, j])[:, :, None] + lattice(box).T[:, None, :]
    square = (apart**2).sum(axis=0)
    best = square.argmin(axis=1)
    return i, j, apart[:, np.arange(len(i)), best], np.sqrt(square.min(axis=1))


def box_with(edges, shear, turns):
    """A box whose images have slid by some share of an edge."""
    return space.tilted(edges, shear, 0.04, 0, round(turns * space.TURN) % space.TURN)


@st.composite
def boxes(draw, slides):
    """A box of two dimensions or three, with images that slide at any tilt or not."""
    dimension = draw(st.sampled_from([2, 3]))
    box = draw(st.lists(st.floats(2.0, 7.0), min_size=dimension, max_size=dimension))
    if not slides:
        return tuple(box)
    flow, gradient = draw(st.sampled_from(AXES[dimension]))
    turns = draw(st.one_of(st.sampled_from([-0.5, 0.0, 0.25, 0.4999999]), st.floats(-0.5, 0.5)))
    tall = box[gradient]
    box[flow] = max(box[flow], 2 / np.sqrt(1 - 1 / max(tall, 2.0) ** 2) + 1e-9)
    return box_with(box, Shear(0.1, flow, gradient), turns)


@st.composite
def beads_in_boxes(draw, slides, most=40):
    """Beads in such a box, on its faces, in clusters and at one place; and a cutoff."""
    box = draw(boxes(slides))
    count = draw(st.one_of(st.sampled_from([1, 2]), st.integers(3, most)))
    special = st.sampled_from([0.0, 0.5, np.nextafter(1.0, 0.0)])
    anywhere = st.one_of(st.floats(0.0, 1.0, exclude_max=True), special)
    fraction = draw(arrays.arrays(float, (len(box), count), elements=anywhere))
    spread = draw(st.sampled_from([1.0, 0.2, 0.0]))
    corner = draw(arrays.arrays(float, (len(box), 1), elements=anywhere))
    if spread < 1.0:
        fraction = (corner + spread * fraction) % 1.0
    edges, half = np.array(box)[:, None], min(box) / 2
    cutoff = draw(st.one_of(st.just(1.0), st.just(half), st.floats(0.3, half)))
    return np.minimum(fraction * edges, np.nextafter(edges, 0.0)), box, 1.0 if slides else cutoff


@pytest.mark.parametrize("slides", [False, True])
@EXAMPLES
@given(st.data())
def test_cells_find_every_pair_once(slides, data):
    """The pairs within the cutoff among all images, each once, with its separation."""
    position, box, cutoff = data.draw(beads_in_boxes(slides))
    beads, most = sorted_beads(position, box, cutoff), position.shape[1] ** 2
    one, other, vectors = np.empty(most, int), np.empty(most, int), np.empty((most, len(box)))
    n = fill_pairs(one, other, vectors, beads, cutoff)
    i, j, apart, distance = pairs_by_looking(position, box)
    expected = {(a, b): s for a, b, s in zip(i, j, apart.T)}
    sure = {pair for pair, r in zip(zip(i, j), distance) if r < cutoff - DOUBTFUL}
    seen = []
    for a, b, separation in zip(one[:n], other[:n], vectors[:n]):
        pair, sign = ((a, b), 1) if a < b else ((b, a), -1)
        r = np.linalg.norm(separation)
        assert r < cutoff + DOUBTFUL
        if r < cutoff - DOUBTFUL:
            seen.append(pair)
            np.testing.assert_allclose(sign * separation, expected[pair], rtol=0, atol=1e-13)
    assert len(seen) == len(set(seen))
    assert set(seen) == sure


@pytest.mark.parametrize(
    "box", [BOX_3D, BOX_2D, box_with((5.0, 4.0, 4.4), Shear(0.1, 0, 1), 0.31)], ids=str
)
def test_histogram_by_species(box):
    """Those of each two species are what looking at all pairs counts; together they are all."""
    position, _ = random_beads(box, 120, seed=8)
    species = np.repeat(np.array([2, 0, 1], np.uint8), [30, 89, 1])
    farthest, bins = min(box) / 2, 7
    found = pair_histogram(position, box, farthest, bins, species)
    i, j, _, distance = pairs_by_looking(position, box)
    for a, b in itertools.product(range(3), repeat=2):
        chosen = sorted((a, b)) == np.sort([species[i], species[j]], axis=0).T
        counts, _ = np.histogram(distance[chosen.all(axis=1)], bins, (0, farthest))
        np.testing.assert_array_equal(found[a, b], counts)
    upper = found[np.triu_indices(3)].sum(axis=0)
    np.testing.assert_array_equal(upper, pair_histogram(position, box, farthest, bins))


@pytest.mark.parametrize("box", [(20.2, 20.2, 20.2), (7.9, 33.2, 3.1), (33.2, 17.3, 3.1)])
def test_forces_where_layers_are_cut_into_blocks(box):
    """Large boxes: forces and virial of all pairs that a tree finds."""
    system = make_system(box, friction=0.0)
    position, velocity = random_beads(box, round(np.prod(box)), seed=5)
    simulation = make_simulation(system, position, velocity)
    i, j = cKDTree(position.T, boxsize=box).query_pairs(1.0, output_type="ndarray").T
    apart = nearest(position[:, i] - position[:, j], box)
    r = np.sqrt((apart**2).sum(axis=0))
    push = system.pair.repulsion[0, 0] * (1 - r) / r * apart
    expected = np.zeros_like(position)
    for force, component in zip(expected, push):
        np.add.at(force, i, component)
        np.add.at(force, j, -component)
    found = simulation.state.by_identity(simulation.state.force)
    np.testing.assert_allclose(found, expected, atol=1e-11)
    virial = np.trace(simulation.measure().of(-1).virial[0])
    np.testing.assert_allclose(virial, (push * apart).sum(), rtol=1e-12)


def test_a_list_lasts_longer_when_it_is_made_ahead_of_the_beads():
    """About twice as long, where nothing acts on beads as fast as the fastest are taken to be."""
    system = make_system((6.0,) * 3, repulsion=np.zeros((1, 1)), friction=1e-20, skin=0.4, dt=0.002)
    position, velocity = random_beads(system.box, 300, seed=5)
    velocity *= integrate.FAST / np.linalg.norm(velocity, axis=0)
    lists = []
    for ahead in (1.0, 0.0):
        simulation = make_simulation(system, position, velocity)
        simulation._plan = simulation._plan._replace(ahead=ahead * simulation._plan.ahead)
        seen = {simulation.state.reference[0, 0] for _ in range(400) if not simulation.advance(1)}
        lists.append(len(seen))
    assert 1.7 * lists[0] < lists[1]


@EXAMPLES
@given(beads_in_boxes(slides=True), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_images_are_images(case, more, less):
    """NumPy and kernels: what is wrapped lies in the box, an image away; what is nearest too, at
    the nearest of all images if that is within the cutoff."""
    position, box, _ = case
    edges = np.array(box)[:, None]
    away = position + edges * np.array([more, less, more][: len(box)])[:, None]
    for function in (lambda x: wrapped(x, box), lambda x: inside_by_kernel(x, box)):
        inside, image = function(away)
        assert (inside >= 0).all() and (inside < edges).all()
        np.testing.assert_allclose(space.unfolded(inside, image, box), away, rtol=0, atol=1e-11)
    apart = away[:, :1] - away
    for function in (lambda x: nearest(x, box), lambda x: nearest_by_kernel(x, box)):
        found = function(apart)
        boxes = space.along_axes(apart - found, box) / edges
        np.testing.assert_allclose(boxes, np.rint(boxes), rtol=0, atol=1e-11)
        others = np.sqrt(((found[:, :, None] + lattice(box).T[:, None, :]) ** 2).sum(axis=0))
        least, length = others.min(axis=1), np.sqrt((found**2).sum(axis=0))
        within = least < 1.0 - DOUBTFUL
        np.testing.assert_allclose(length[within], least[within], rtol=0, atol=1e-12)


def inside_by_kernel(position, box):
    rows, image = rows_of(position), np.zeros(position.T.shape, np.int32)
    identity = np.arange(len(rows)).astype(np.uint32)
    inside_in_kernel(rows, image, identity, np.zeros((2, 1)), edges_of(box), space.slide_of(box))
    return axes_of(rows, len(position)), image.T


def nearest_by_kernel(apart, box):
    found = np.ascontiguousarray(apart)
    nearest_in_kernel(found, edges_of(box), space.slide_of(box))
    return found


@EXAMPLES
@example(10**12, 0.1, 0.04, (10.0, 10.0, 10.0))
@given(
    st.integers(0, 10**12), st.floats(-2.0, 2.0), st.floats(1e-6, 0.1),
    st.tuples(*[st.floats(2.0, 1000.0)] * 3),
)  # fmt: skip
def test_the_slide_is_exact_after_any_number_of_steps(step, rate, dt, box):
    """By fractions: the speed of the slide is rounded to 2^-65 of an edge, once; the kernel has
    the same bits as NumPy."""
    shear = Shear(rate, 0, 1)
    found = space.tilted(box, shear, dt, step)
    turns = Fraction(found.tilt) * Fraction(box[1]) / Fraction(box[0])
    exact = Fraction(rate) * Fraction(dt) * step * Fraction(box[1]) / Fraction(box[0])
    off = (turns - exact) % 1
    assert min(off, 1 - off) < Fraction(step, 2**65) + Fraction(1, 2**51)
    assert abs(turns) <= Fraction(1, 2) + Fraction(1, 2**51)
    assert tilt_at(space.tilted(box, shear, dt, 0).slide, step) == found.tilt
    later = space.tilted(box, shear, dt, step, begun=12345 * 2**50)
    assert tilt_at(later.slide, step) == later.tilt
    assert (later.slid - found.slid - 12345 * 2**50 + 2**13) % space.TURN < 2**14


@pytest.mark.thorough
@pytest.mark.parametrize("missing", [("avx512",), ("avx", "fma", "f16c", "vaes", "vpclmul")])
def test_less_of_a_processor(missing, monkeypatch):
    """The same pairs where instructions are missing that these tests' own processor may have."""
    left = FEATURES
    for name in missing:
        left = left.replace(f"+{name}", f"-{name}")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", left)
    tests = [sys.executable, "-m", "pytest", "-m", "not thorough", __file__]
    subprocess.run(tests, check=True)
