"""Scenes and studies: what they mean, and what they refuse."""

import numpy as np
import pytest

from dpd.digest import PACKAGE
from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.pipeline.paper import read_paper
from dpd.pipeline.study import read_study
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge, read_yaml
from dpd.start import start_digest
from dpd.start.common.make import make_start
from dpd.start.random import FLIGHT

GOOD = {
    "dimension": 3,
    "box": 4,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 10},
}
CHAINS = GOOD | {"molecules": [{"architecture": "A 4", "density": 3}], "bond": {"stiffness": 20}}

# What is changed in GOOD, and what the message has to name: key, value, what is allowed.
BAD = [
    ({"boxx": 4}, ["boxx", "did you mean 'box'"]),
    ({"charge": 1}, ["unknown key 'charge'; allowed: ", "unstable, keep_state, seed"]),
    ({"integrator": {"scheme": "gw-vv", "dt": 0.04, "lamda": 1}}, ["lamda", "lambda"]),
    ({"molecules": [{"architecture": "A", "density": -3}]}, ["molecules.0.density", "-3", "> 0"]),
    ({"molecules": [{"architecture": "A"}]}, ["molecules.0", "density", "count"]),
    ({"molecules": [{"architecture": "A", "density": 0.001}]}, ["0.001", "one molecule"]),
    ({"integrator": {"scheme": "leapfrog", "dt": 0.1}}, ["integrator.scheme", "leapfrog", "euler"]),
    ({"box": 1.9}, ["box", "1.9", ">= 2"]),
    ({"box": [4, 4]}, ["box", "2 edges"]),
    ({"molecules": [{"architecture": "A", "density": 1}, {"architecture": "B", "density": 1}]},
     ["repulsion", "'A B'"]),
    ({"repulsion": {"A A": 25, "A C": 3}}, ["repulsion.A C", "'C'", "allowed: A"]),
    ({"repulsion": {"A A": float("nan")}}, ["repulsion.A A", "nan", "finite"]),
    ({"box": 1e4, "molecules": [{"architecture": "A", "count": 9}]}, ["1e+12", "too large"]),
    ({"bond": {"stiffness": 2}}, ["bond", "single bead"]),
    ({"molecules": [{"architecture": "A 2", "density": 3}]}, ["bond", "several beads"]),
    ({"observe": ["thermo", "bonds"]}, ["observe", "single bead"]),
    ({"observe": ["viscosity"]}, ["observe", "viscosity", "thermo"]),
    ({"observe": [{"rdf": {"range": 3}}]}, ["observe.rdf.range", "3", "<= 2"]),
    ({"observe": [{"thermo": {"every": 100}}]}, ["observe.thermo.every", "100", "1 to 10"]),
    ({"steps": {}}, ["steps.sample", "nothing to sample"]),
    ({"core": {"radius": 0.6, "force": 100}}, ["core.radius", "0.6", "< 0.5"]),
    ({"box": 2.2, "pairs": {"search": "list"}}, ["pairs.skin", "2.3", "search: cells"]),
]  # fmt: skip


@pytest.mark.parametrize(("change", "named"), BAD, ids=lambda part: str(part)[:40])
def test_bad_scenes_are_refused(change, named):
    """One sentence with file, key, value and what is allowed."""
    with pytest.raises(UserError) as refusal:
        Scene(GOOD | change, "my.yaml")
    message = str(refusal.value)
    assert message.startswith("my.yaml: ")
    for part in named:
        assert part in message, message


def test_two_values_for_a_pair_are_refused():
    """A B and B A are one pair."""
    kinds = [{"architecture": "A", "density": 1}, {"architecture": "B", "density": 1}]
    table = {"A A": 25, "B B": 25, "A B": 30, "B A": 31}
    with pytest.raises(UserError, match="30, but 31 in the other order"):
        Scene(GOOD | {"molecules": kinds, "repulsion": table})


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


@pytest.mark.parametrize("path", sorted((PACKAGE / "scenes").glob("*.yaml")))
def test_example_scenes_are_scenes(path):
    """What the README shows can be run."""
    assert Scene.read(path).beads > 0


def test_the_longer_of_steps_and_duration_counts():
    """duration / dt against steps."""
    steps = {
        "steps": {"sample": 10, "equilibrate": 50},
        "duration": {"sample": 1, "equilibrate": 1},
    }
    assert Scene(GOOD | steps).steps == (50, 25)


def test_digest_follows_the_content():
    """Written-out defaults change nothing, a changed value does."""
    plain = Scene(GOOD).digest
    assert Scene(GOOD | {"seed": 1, "thermostat": {"gamma": 4.5}}).digest == plain
    assert Scene(GOOD | {"seed": 2}).digest != plain


MELT = {
    "box": 8,
    "molecules": [{"architecture": "A 16", "count": 32}],
    "repulsion": {"A A": 200},
    "bond": {"stiffness": 400, "length": 0.95},
}


def bond_lengths(scene, state):
    """Of every bond, at its nearest image."""
    i, j = scene.bonded.T
    return np.linalg.norm(nearest(state.position[:, i] - state.position[:, j], scene.box), axis=0)


def test_chains_start_as_random_flights_of_their_bonds():
    """Steps of the rest length, across the box's faces; <R^2> = (N - 1) l^2 within 4 errors."""
    scene = Scene(GOOD | MELT | {"molecules": [{"architecture": "A 16", "count": 2000}]})
    state = make_start(scene)
    np.testing.assert_allclose(bond_lengths(scene, state), 0.95, rtol=1e-12)
    i, j = scene.bonded.T
    bond = nearest(state.position[:, j] - state.position[:, i], scene.box)
    square = (bond.reshape(3, 2000, 15).sum(axis=2) ** 2).sum(axis=0)
    assert abs(square.mean() - 15 * 0.95**2) < 4 * square.std() / np.sqrt(2000)
    bare = Scene(GOOD | MELT | {"bond": {"stiffness": 4, "length": 0}})
    np.testing.assert_allclose(bond_lengths(bare, make_start(bare)), FLIGHT, rtol=1e-12)


def test_the_push_off_keeps_bonds_whole():
    """The hardest beads of Nikunen's sets, from overlaps: no bond beyond 1.3 r_c is left."""
    relax = {"start": {"relax": {"steps": 2000, "dt": 0.005}}}
    scene = Scene(GOOD | MELT | relax)
    length = bond_lengths(scene, make_start(scene))
    assert length.max() < 1.3
    assert length.mean() == pytest.approx(0.966, abs=0.02)  # 0.976(3): not yet at rest


def test_slabs_are_apart():
    """The first molecules fill the first part of the longest axis; all are at rest as a whole."""
    kinds = [{"architecture": "A 3", "density": 1.5}, {"architecture": "B 3", "density": 1.5}]
    slabs = {"box": [4, 4, 10], "molecules": kinds, "start": {"method": "slabs"}}
    state = make_start(Scene(CHAINS | slabs | {"repulsion": {"A A": 25, "B B": 25, "A B": 40}}))
    z, species = state.position[2], state.species
    assert z[species == 0].max() < 5 <= z[species == 1].min()
    assert (state.position >= 0).all() and (state.position < [[4], [4], [10]]).all()
    assert np.abs(state.velocity.sum(axis=1)).max() < 1e-9
    assert abs((state.velocity**2).mean() - 1) < 5 * np.sqrt(2 / state.velocity.size)


@pytest.mark.parametrize("name", ["groot_warren_1997", "liu_2008", "nikunen_2007"])
@pytest.mark.parametrize("study", ["smoke", "paper"])
def test_every_study_unfolds(study, name):
    """Names and scenes of all points are distinct; figures name sweeps that exist."""
    assert read_study(study).description
    paper = read_paper(name, study)
    for sweep in paper.sweeps.values():
        names = [point.name for point in sweep.points]
        digests = [point.scene.digest for point in sweep.points]
        assert len(set(names)) == len(names)
        assert len(set(digests)) == len(digests)
        count = np.prod([len(axis.labels) for axis in sweep.axes])
        assert len(sweep.points) == count


def test_points_keep_their_scenes_when_others_come(monkeypatch):
    """An added density leaves the digests of the other points as they were."""

    def digests():
        points = read_paper("groot_warren_1997", "smoke").sweeps["equation_of_state_15"].points
        return {point.name: point.scene.digest for point in points}

    def edited(path):
        data = read_yaml(path)
        if path.stem == "groot_warren_1997":
            axes = data["sweeps"]["equation_of_state_15"]["axes"]
            axes["density"]["values"]["smoke"].append(4.25)
        return data

    before = digests()
    monkeypatch.setattr("dpd.pipeline.paper.read_yaml", edited)
    after = digests()
    assert set(after) - set(before) == {"repulsion=15,density=4.25,replica=0"}
    assert before.items() <= after.items()


def test_chain_lengths_are_numbers_on_an_axis():
    """An axis with a text puts its numbers into it: N becomes an architecture."""
    sweep = read_paper("liu_2008", "paper", only=["melts"]).sweeps["melts"]
    assert sweep.axes[0].labels == (20, 50, 100, 200)
    assert [len(point.scene.molecules[0].beads) for point in sweep.points] == [20, 50, 100, 200]
    assert all(point.scene.density == 2 for point in sweep.points)


def test_sweeps_share_a_melt():
    """Points that differ in nothing that the start sees have one start; others their own."""
    sweeps = read_paper("liu_2008", "paper").sweeps
    starts = {
        name: {start_digest(point.scene) for point in sweeps[name].points}
        for name in ("rigidity", "stability", "sets", "melts", "langevin")
    }
    assert [len(found) for found in starts.values()] == [1, 1, 1, 4, 3]


@pytest.mark.parametrize("key", ["radius", "length", "gamma"])
def test_a_start_knows_its_forces(key):
    """A polymerized start depends on the forces it grows with, and on nothing of the run."""
    point = read_paper("liu_2008", "paper", only=["rigidity"]).sweeps["rigidity"].points[0]
    data = point.scene.data
    part = {"radius": "core", "length": "bond"}.get(key)
    value = data["start"]["forces"][part][key] if part else data["start"]["forces"][key]
    change = {part: {key: 0.9 * value}} if part else {key: 0.9 * value}
    changed = Scene(merge(data, {"start": {"forces": change}}))
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
