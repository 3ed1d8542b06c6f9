"""Scenes and studies: what they mean, and what they refuse."""

import numpy as np
import pytest

from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.pipeline.paper import read_paper
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge
from dpd.start import start_digest
from dpd.start.common.make import make_start
from tests.test_bad_input import FLUID as GOOD

CHAINS = GOOD | {"molecules": [{"architecture": "A 4", "density": 3}], "bond": {"stiffness": 20}}


def test_a_scene_knows_its_system():
    """Beads, species, bonds and table follow from molecules and repulsion."""
    kinds = [{"architecture": "B 2 A", "count": 3}, {"architecture": "A", "density": 1}]
    table = {"A A": 25, "B A": 30, "B B": 20}
    scene = Scene(GOOD | {"molecules": kinds, "repulsion": table, "bond": {"stiffness": 20}})
    assert scene.beads == 3 * 3 + 64
    assert scene.species == ("A", "B")
    np.testing.assert_array_equal(scene.repulsion, [[25, 30], [30, 20]])
    np.testing.assert_array_equal(scene.bonded, [[0, 1], [1, 2], [3, 4], [4, 5], [6, 7], [7, 8]])
    state = make_start(scene)
    assert state.position.shape == (3, 73)
    np.testing.assert_array_equal(state.species[:6], [1, 1, 0, 1, 1, 0])


def test_steps_and_digest_follow_the_content():
    """The longer of steps and duration counts; defaults change nothing, a changed value does."""
    steps = {"sample": 10, "equilibrate": 50}
    times = {"steps": steps, "duration": {"sample": 1, "equilibrate": 1}}
    assert Scene(GOOD | times).steps == (50, 25)
    plain = Scene(GOOD).digest
    assert Scene(GOOD | {"seed": 1, "thermostat": {"gamma": 4.5}}).digest == plain
    assert Scene(GOOD | {"seed": 2}).digest != plain
    assert Scene(GOOD | {"observe": [{"thermo": {"pressure": True}}]}).digest == plain
    assert Scene(GOOD | {"observe": [{"thermo": {"pressure": False}}]}).digest != plain


@pytest.mark.parametrize(
    ("density", "dt", "skin"), [(3, 0.04, 0), (3, 0.005, 0.12), (1, 0.02, 0.35), (1, 0.04, 0)]
)
def test_pairs_are_listed_where_beads_move_little_of_the_skin(density, dt, skin):
    """Not where the box changes; as asked, where a scene says how."""
    fluid = {
        "molecules": [{"architecture": "A", "density": density}],
        "integrator": {"scheme": "gw-vv", "dt": dt},
    }
    assert Scene(GOOD | fluid).skin == skin
    assert Scene(GOOD | fluid | {"pressure": {"target": 20}}).skin == 0
    assert Scene(GOOD | fluid | {"pairs": {"search": "cells"}}).skin == 0
    assert Scene(GOOD | fluid | {"pairs": {"search": "list", "skin": 0.3}}).skin == 0.3


MELT = {
    "box": 8,
    "molecules": [{"architecture": "A 16", "count": 32}],
    "repulsion": {"A A": 200},
    "bond": {"stiffness": 400, "length": 0.95},
}


def test_chains_start_as_random_flights_of_their_bonds():
    """Steps across the box's faces; <R^2> = (N - 1) l^2 within 4 errors."""
    scene = Scene(GOOD | MELT | {"molecules": [{"architecture": "A 16", "count": 2000}]})
    state, (i, j) = make_start(scene), scene.bonded.T
    bond = nearest(state.position[:, j] - state.position[:, i], scene.box)
    square = (bond.reshape(3, 2000, 15).sum(axis=2) ** 2).sum(axis=0)
    assert abs(square.mean() - 15 * 0.95**2) < 4 * square.std() / np.sqrt(2000)


def test_the_push_off_keeps_bonds_whole():
    """The hardest beads of Nikunen's sets, from overlaps: no bond beyond 1.3 r_c is left."""
    scene = Scene(GOOD | MELT | {"start": {"relax": {"steps": 2000, "dt": 0.005}}})
    state, (i, j) = make_start(scene), scene.bonded.T
    bond = nearest(state.position[:, j] - state.position[:, i], scene.box)
    length = np.linalg.norm(bond, axis=0)
    assert length.max() < 1.3
    assert length.mean() == pytest.approx(0.966, abs=0.02)  # 0.976(3): not yet at rest


def test_slabs_are_apart():
    """The first molecules fill the first part of the longest axis."""
    kinds = [{"architecture": "A 3", "density": 1.5}, {"architecture": "B 3", "density": 1.5}]
    slabs = {"box": [4, 4, 10], "molecules": kinds, "start": {"method": "slabs"}}
    state = make_start(Scene(CHAINS | slabs | {"repulsion": {"A A": 25, "B B": 25, "A B": 40}}))
    z, species = state.position[2], state.species
    assert z[species == 0].max() < 5 <= z[species == 1].min()
    assert (state.position >= 0).all() and (state.position < [[4], [4], [10]]).all()


def test_sweeps_share_a_melt():
    """Points that differ in nothing that the start sees have one start; others their own."""
    sweeps = read_paper("liu_2008", "paper").sweeps
    starts = {
        name: {start_digest(point.scene) for point in sweeps[name].points}
        for name in ("rigidity", "stability", "sets", "melts", "langevin")
    }
    assert [len(found) for found in starts.values()] == [1, 1, 1, 4, 3]


def test_a_start_knows_its_forces():
    """A polymerized start depends on the forces it grows with, and on nothing of the run."""
    point = read_paper("liu_2008", "paper", only=["rigidity"]).sweeps["rigidity"].points[0]
    data = point.scene.data
    changed = Scene(merge(data, {"start": {"forces": {"bond": {"length": 0.2}}}}))
    assert start_digest(changed) != start_digest(point.scene)
    longer = Scene(merge(data, {"integrator": {"dt": 0.004}, "duration": {"sample": 9}}))
    assert start_digest(longer) == start_digest(point.scene)


def test_merge_keeps_what_is_not_named():
    """Dicts key by key, list items by number, all else replaced; nothing shared."""
    base = {"a": {"b": 1, "c": 2}, "list": [{"x": 1}, {"x": 2}]}
    merged = merge(base, {"a": {"b": 5}, "list": {"1": {"x": 9}}})
    assert merged == {"a": {"b": 5, "c": 2}, "list": [{"x": 1}, {"x": 9}]}
    assert base["list"][1]["x"] == 2
    assert merge(base, {"list": {1: {"x": 9}}}) == merge(base, {"list": {"1": {"x": 9}}})
    with pytest.raises(UserError, match="count from 0"):
        merge(base, {"list": {"2": {}}})
