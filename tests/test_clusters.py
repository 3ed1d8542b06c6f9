"""The observable `clusters`: what touches is one cluster."""

from types import SimpleNamespace

import numpy as np
import pytest

import dpd
from dpd.engine.state import State
from dpd.observe.clusters import Clusters
from dpd.observe.common.snapshot import Snapshot
from dpd.scene.scene import Scene
from tests.conftest import SCENE as FLUID

SCENE = {
    "dimension": 3,
    "box": [6, 7, 8],
    "molecules": [{"architecture": "H T 2", "count": 40}, {"architecture": "W", "count": 60}],
    "repulsion": dict.fromkeys(("H H", "H T", "H W", "T T", "T W", "W W"), 25),
    "bond": {"stiffness": 4},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 100},
}

MONOMERS = {key: value for key, value in SCENE.items() if key != "bond"} | {
    "molecules": [{"architecture": "A", "count": 8}, {"architecture": "B", "count": 1}],
    "repulsion": {"A A": 25, "A B": 25, "B B": 25},
}


def measured(scene, position, **settings):
    """What the page says of beads at some places, in the order of the scene."""
    state = State(
        np.array(position, float).T, None, None, np.arange(len(position), dtype=np.uint32), None, 0
    )
    system = SimpleNamespace(shear=None, volume=float(np.prod(scene.box)))
    simulation = SimpleNamespace(state=state, system=system, box=scene.box)
    page = scene.observe["clusters"] if not settings else Clusters(**settings)
    return page.measure(Snapshot(scene, simulation))


def sizes_of(found, box=336.0):
    """Sizes of all clusters, from their densities."""
    count = np.rint(found["cluster_density"] * box).astype(int)
    return np.repeat(np.arange(1, len(count) + 1), count)


def test_clusters_made_by_hand():
    """Through faces of the box, in a row, and not by way of another species."""
    scene = Scene(MONOMERS)
    position = [
        (0.2, 3, 3), (5.6, 3, 3), (4.8, 3, 3),  # a row through the face at x = 0
        (3, 0.1, 0.2), (3, 6.8, 7.9),  # across an edge of the box
        (1, 5, 5), (2.6, 5, 5),  # apart, with a B between them
        (4.8, 3, 4.1),  # alone
        (1.8, 5, 5),
    ]  # fmt: skip
    found = measured(scene, position, of=["A"])
    np.testing.assert_array_equal(sizes_of(found), [1, 1, 1, 2, 3])
    assert (found["clusters"], found["cluster_largest"]) == (5, 3)
    assert found["cluster_mean"] == pytest.approx(8 / 5)
    assert found["cluster_weighted"] == pytest.approx((3 + 4 + 9) / 8)
    larger = measured(scene, position, of=["A"], least=2, largest=2)
    np.testing.assert_array_equal(sizes_of(larger), [1, 1, 1, 2])
    assert (larger["clusters"], larger["cluster_mean"]) == (2, 5 / 2)
    np.testing.assert_array_equal(sizes_of(measured(scene, position, of=["A", "B"])), [1, 2, 3, 3])
    none = measured(scene, position, of=["A"], least=4)
    assert (none["clusters"], none["cluster_mean"], none["cluster_weighted"]) == (0, 0, 0)


def by_brute_force(position, box, chosen, owner, within):
    """Sizes of clusters, in order: all pairs, and labels that spread until nothing changes."""
    apart = position[:, None] - position
    apart -= box * np.round(apart / np.where(box, box, 1))
    near = ((apart**2).sum(axis=2) <= within**2) & np.outer(chosen, chosen)
    label = owner.copy()
    while True:
        spread = np.where(near, label, owner.max() + 1).min(axis=1)
        spread = np.minimum(spread, label)
        least = np.array([spread[owner == own].min() for own in owner])
        if (least == label).all():
            return np.sort([len(np.unique(owner[(label == k) & chosen]))
                            for k in np.unique(label[chosen])])  # fmt: skip
        label = least


@pytest.mark.parametrize("walls", [False, True])
@pytest.mark.parametrize("count", ["molecules", "beads"])
def test_beads_anywhere(count, walls):
    """Molecules and beads, by two species of three; nothing is near through a wall."""
    scene = Scene(SCENE | ({"walls": {"axis": "z", "repulsion": 25}} if walls else {}))
    position = np.random.default_rng(3).random((scene.beads, 3)) * scene.box
    chosen = np.isin(np.array(scene.species)[scene.kinds], ["T", "W"])
    owner = np.repeat(np.arange(100), scene.lengths) if count == "molecules" else np.arange(180)
    edges = np.where([True, True, not walls], scene.box, 0.0)
    expected = by_brute_force(position, edges, chosen, owner, 0.8)
    found = measured(scene, position, of=["T", "W"], within=0.8, count=count)
    np.testing.assert_array_equal(sizes_of(found), expected)
    assert 3 < expected.max() == found["cluster_largest"] and expected.min() == 1


def test_in_a_run():
    """The series and the blocks agree, and the last sample with the last beads."""
    observe = ["thermo", {"clusters": {"of": ["A"], "within": 0.5, "every": 20}},
               {"configuration": {"every": 20}}]  # fmt: skip
    run = dpd.run(FLUID | {"observe": observe}, progress=False)
    assert run.clusters.dims == ("clusters_time",) and run.cluster_density.dims[0] == "block"
    position, box = run.position.values.T, np.full(3, 4.0)
    beads = np.arange(len(position))
    expected = by_brute_force(position, box, np.full(len(beads), True), beads, 0.5)
    assert run.cluster_largest[-1] == expected.max() and run.clusters[-1] == len(expected)
    assert run.cluster_mean[-1] == pytest.approx(expected.mean())
    total = (run.cluster_size * run.cluster_density.mean("block")).sum() * 64
    assert float(total) == pytest.approx(len(position))
    assert float(run.cluster_density.sum()) * 64 / run.sizes["block"] == pytest.approx(
        float(run.clusters.mean())
    )
