"""The search by cells finds the pairs that looking at all of them finds."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.spatial import cKDTree

from dpd.engine.queries.pairs import pair_histogram, sorted_beads
from dpd.engine.search import first_place, next_pairs
from dpd.jit import kernel
from tests.systems import BOX_2D, BOX_3D, make_simulation, make_system, random_beads

DOUBTFUL = 1e-9  # r_c: a distance this near to the cutoff may be rounded to either side


def pairs_by_cells(position, box, cutoff):
    """Identities and separations of all pairs, by the engine's sort and search."""
    beads, most = sorted_beads(position, box, cutoff), position.shape[1] ** 2
    one, other, apart = np.empty(most, int), np.empty(most, int), np.empty((most, len(box)))
    n = fill_pairs(one, other, apart, beads, cutoff)
    return list(zip(one[:n], other[:n], apart[:n]))


@kernel()
def fill_pairs(one, other, apart, beads, cutoff):
    total, pairs = 0, beads.search.pairs
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, beads.search, cutoff)
        for p in range(n):
            one[total], other[total] = beads.bead[pairs.i[p]], beads.bead[pairs.j[p]]
            for k in range(len(beads.search.edges)):
                apart[total, k] = pairs.separation[k, p]
            total += 1
    return total


def pairs_by_looking(position, box):
    """Identities i < j, separations at the nearest image, and distances of all pairs."""
    i, j = np.triu_indices(position.shape[1], 1)
    edges = np.array(box)[:, None]
    apart = position[:, i] - position[:, j]
    apart -= edges * np.round(apart / edges)
    return i, j, apart, np.sqrt((apart**2).sum(axis=0))


@st.composite
def boxes_of_beads(draw, most=60):
    """A box, beads in it and a cutoff; beads on the faces, in clusters and at one place."""
    dimension = draw(st.sampled_from([2, 3]))
    box = tuple(draw(st.lists(st.floats(2.0, 6.0), min_size=dimension, max_size=dimension)))
    count = draw(st.one_of(st.sampled_from([0, 1, 2]), st.integers(3, most)))
    anywhere = st.floats(0.0, 1.0, exclude_max=True)
    special = st.sampled_from([0.0, 0.5, np.nextafter(1.0, 0.0)])
    spread = draw(st.sampled_from([1.0, 0.2, 0.0]))
    fraction = draw(arrays.arrays(float, (dimension, count), elements=st.one_of(anywhere, special)))
    corner = draw(arrays.arrays(float, (dimension, 1), elements=anywhere))
    edges = np.array(box)[:, None]
    if spread < 1.0:
        fraction = (corner + spread * fraction) % 1.0
    position = np.minimum(fraction * edges, np.nextafter(edges, 0.0))
    half = min(box) / 2
    cutoff = draw(st.one_of(st.just(1.0), st.just(half), st.floats(0.3, half)))
    return position, box, cutoff


@settings(max_examples=200, deadline=None, derandomize=True)
@given(boxes_of_beads())
def test_cells_find_every_pair_once(case):
    """The pairs within the cutoff, each once, with r_i - r_j at the nearest image."""
    position, box, cutoff = case
    found = pairs_by_cells(position, box, cutoff)
    i, j, apart, distance = pairs_by_looking(position, box)
    expected = {(a, b): s for a, b, s in zip(i, j, apart.T)}
    sure = {pair for pair, r in zip(zip(i, j), distance) if r < cutoff - DOUBTFUL}
    seen = []
    for a, b, separation in found:
        pair, sign = ((a, b), 1) if a < b else ((b, a), -1)
        r = np.linalg.norm(separation)
        assert r < cutoff + DOUBTFUL
        if r < cutoff - DOUBTFUL:
            seen.append(pair)
            np.testing.assert_allclose(sign * separation, expected[pair], rtol=0, atol=1e-14)
    assert len(seen) == len(set(seen))
    assert set(seen) == sure


@settings(max_examples=100, deadline=None, derandomize=True)
@given(boxes_of_beads(), st.integers(1, 20))
def test_histogram_counts_every_pair(case, bins):
    """Below each edge of a bin lie as many pairs as looking at all of them counts."""
    position, box, farthest = case
    counts = pair_histogram(position, box, farthest, bins)
    distance = pairs_by_looking(position, box)[3]
    for k, edge in enumerate(np.linspace(0, farthest, bins + 1)):
        below = counts[:k].sum()
        assert (distance < edge - DOUBTFUL).sum() <= below
        assert below <= (distance < edge + DOUBTFUL).sum()


@pytest.mark.parametrize("box", [BOX_3D, BOX_2D])
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
    assert found[1, 1].sum() == 0
    upper = found[np.triu_indices(3)].sum(axis=0)
    np.testing.assert_array_equal(upper, pair_histogram(position, box, farthest, bins))


def test_crowded_cells():
    """A hundred beads to a cell, as when chains collapse: the buffers hold all their pairs."""
    position, _ = random_beads(BOX_3D, 3000)
    distance = pairs_by_looking(position, BOX_3D)[3]
    assert pair_histogram(position, BOX_3D, 1.0, 1)[0] == (distance < 1.0).sum()


@pytest.mark.parametrize(
    "box", [(20.2, 20.2, 20.2), (21.6, 17.3, 9.4), (7.9, 33.2, 3.1), (33.2, 17.3, 3.1)]
)
def test_forces_where_layers_are_cut_into_blocks(box):
    """Large boxes: forces and virial of all pairs that a tree finds."""
    system = make_system(box, friction=0.0)
    position, velocity = random_beads(box, round(np.prod(box)), seed=5)
    simulation = make_simulation(system, position, velocity)
    i, j = cKDTree(position.T, boxsize=box).query_pairs(1.0, output_type="ndarray").T
    edges = np.array(box)[:, None]
    apart = position[:, i] - position[:, j]
    apart -= edges * np.round(apart / edges)
    r = np.sqrt((apart**2).sum(axis=0))
    push = system.pair.repulsion[0, 0] * (1 - r) / r * apart
    expected = np.zeros_like(position)
    for force, component in zip(expected, push):
        np.add.at(force, i, component)
        np.add.at(force, j, -component)
    found = simulation.state.by_identity(simulation.state.force)
    np.testing.assert_allclose(found, expected, atol=1e-11)
    virial = np.trace(simulation.measure().virial[0])
    np.testing.assert_allclose(virial, (push * apart).sum(), rtol=1e-12)
