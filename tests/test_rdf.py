"""The observable `rdf`, of all beads and of each pair of species."""

import numpy as np
import pytest

import dpd
from tests.test_own_pages import SCENE

PAIRS = ["A A", "A B", "B B"]
ONE = SCENE | {
    "molecules": [{"architecture": "A", "count": 191}, {"architecture": "B", "count": 1}]
}


def test_one_sample_is_what_looking_at_all_pairs_counts():
    """Over those of an ideal gas, N_A N_B v / V and N_A (N_A - 1) v / 2V."""
    settings = {"species": True, "range": 2, "bin": 0.25, "every": 60}
    observe = ["thermo", {"rdf": settings}, {"configuration": {"every": 60}}]
    run = dpd.run(SCENE | {"observe": observe}, progress=False)
    assert list(run.rdf_pair.values) == PAIRS and run.rdf_of_pair.dims == ("block", "rdf_pair", "r")
    position, species = run.position.values, np.repeat([0, 1], [128, 64])
    i, j = np.triu_indices(192, 1)
    apart = position[:, i] - position[:, j]
    distance = np.sqrt((np.square(apart - 4 * np.round(apart / 4))).sum(axis=0))
    edges = np.linspace(0, 2, 9)
    shells = np.diff(4 / 3 * np.pi * edges**3) / 64
    for kinds, pairs, name in (
        (0, 128 * 127 / 2, "A A"),
        (1, 128 * 64, "A B"),
        (2, 64 * 63 / 2, "B B"),
    ):
        counts, _ = np.histogram(distance[species[i] + species[j] == kinds], edges)
        found = run.rdf_of_pair.sel(rdf_pair=name).values[0]
        np.testing.assert_allclose(found, counts / (pairs * shells), rtol=1e-12)


@pytest.mark.parametrize("scene", [SCENE, ONE], ids=["many", "one"])
def test_the_weighted_sum_is_that_of_all_beads(scene):
    """Also where there is a single bead of a species, and so no pair of its own."""
    asked = {"species": True, "range": 2, "every": 10}
    run = dpd.run(scene | {"observe": ["thermo", {"rdf": asked}]}, progress=False)
    counts = {name: next(kind.get("count", kind.get("density", 0) * 64)
                         for kind in scene["molecules"] if kind["architecture"] == name)
              for name in "AB"}  # fmt: skip
    weights = {
        f"{a} {b}": counts[a] * counts[b] if a != b else counts[a] * (counts[a] - 1) / 2
        for a, b in map(str.split, run.rdf_pair.values)
    }
    assert set(PAIRS) - set(weights) == ({"B B"} if counts["B"] == 1 else set())
    total = sum(weight * run.rdf_of_pair.sel(rdf_pair=name) for name, weight in weights.items())
    np.testing.assert_allclose(total / sum(weights.values()), run.rdf, rtol=1e-12, atol=1e-12)
    plain = dpd.run(
        scene | {"observe": ["thermo", {"rdf": {"range": 2, "every": 10}}]}, progress=False
    )
    assert "rdf_of_pair" not in plain
    np.testing.assert_allclose(run.rdf, plain.rdf, rtol=1e-12)
