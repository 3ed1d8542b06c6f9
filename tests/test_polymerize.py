"""Chains grown in two dimensions: exactly those asked for, and no two of their bonds cross."""

import numpy as np
import pytest

from dpd import files
from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.start import start_work
from dpd.start.common import polymerization as module
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import make_start, make_start_and_record
from dpd.start.common.polymerization import (
    CROSSED,
    FAR,
    FREE,
    MADE,
    TRIED,
    Chains,
    Growth,
    Rule,
    grow,
)
from tests.engine.exact import crossings_by_looking
from tests.systems import assert_same_state

RELAX = {"relax": {"steps": 500, "dt": 0.002}}
STIFF = {"core": {"radius": 0.15, "force": 100}, "bond": {"stiffness": 300, "length": 0.25}}
SCENE = {
    "dimension": 2,
    "box": 15,
    "molecules": [{"architecture": "A 10", "density": 2}],
    "repulsion": {"A A": 25},
    "integrator": {"scheme": "gw-vv", "lambda": 0.65, "dt": 0.002},
    "start": {"method": "polymerize"} | RELAX,
    "steps": {"equilibrate": 0, "sample": 10},
} | STIFF


def distance(position, first, second, box):
    """Distances of some beads from others at their nearest images."""
    apart = position.T[first] - position.T[second]
    return np.linalg.norm(apart - np.array(box) * np.round(apart / np.array(box)), axis=1)


def assert_whole(scene, state, record):
    """Every chain is there, its bonds are short, and none crosses another.

    Springs of 300, at rest at 0.25, are 0.36 long on average and 0.60 at most in 20 melts;
    at 0.8 they would hold 45 kT. Beads of different chains are up to half the box apart.
    """
    assert state.position.shape == state.velocity.shape == (2, scene.beads)
    assert (state.position >= 0).all()
    assert (state.position < np.array(scene.box)[:, None]).all()
    np.testing.assert_array_equal(state.identity, np.arange(scene.beads))
    assert state.step == 0
    assert distance(state.position, *scene.bonded.T, scene.box).max() < 0.8
    assert crossings_by_looking(state.position, scene.bonded, scene.box) == set()
    assert record["conversion"][-1] == 1


@pytest.fixture(scope="module")
def melt():
    """The scene, its start, how it came about, and what progress was told."""
    scene, told = Scene(SCENE), []
    return scene, *make_start_and_record(scene, told.append), told


def test_the_melt_is_what_the_scene_asks_for(melt):
    """45 chains of 10, density 2, at rest as a whole, and without a crossing; all work is told."""
    scene, state, record, told = melt
    assert (scene.beads, len(scene.bonded), state.species) == (450, 45 * 9, None)
    assert_whole(scene, state, record)
    np.testing.assert_allclose(state.velocity.sum(axis=1), 0, atol=1e-10)
    assert np.mean(state.velocity**2) == pytest.approx(1, abs=5 * np.sqrt(2 / 900))
    assert told[-1] == start_work(scene) == 450 + 500


def test_the_same_seed_gives_the_same_bits(melt):
    """Of the state and of the record; another seed gives others, start.seed goes first."""
    scene, state, record, _ = melt
    start = SCENE["start"] | {"seed": scene.data["seed"]}
    again, recorded = make_start_and_record(Scene(SCENE | {"seed": 2, "start": start}))
    np.testing.assert_array_equal(again.position, state.position)
    np.testing.assert_array_equal(again.velocity, state.velocity)
    for name, values in record.items():
        np.testing.assert_array_equal(recorded[name], values, err_msg=name)
    other = make_start(Scene(SCENE | {"seed": 2}))
    assert not np.isin(other.position, state.position).any()


SMALL = SCENE | {"box": [7.5, 6.0]}


def test_copolymers_and_solvent_have_the_species_asked_for():
    """Along each chain, molecule after molecule; bonds have the law of their pair of species."""
    kinds = [
        {"architecture": "C", "count": 11},
        {"architecture": "A 2 B 3 A 2", "count": 6},
        {"architecture": "B 4", "count": 3},
    ]
    pairs = {f"{a} {b}": 25 for a in "ABC" for b in "ABC"}
    start = SCENE["start"] | {"polymerize": {"partner": "nearest"}}
    bonds = {f"{a} {a}": {"stiffness": 300, "length": 0.2} for a in "AB"}
    bonds["B A"] = {"stiffness": 300, "length": 0.45}
    changes = {"molecules": kinds, "repulsion": pairs, "start": start, "bond": bonds}
    scene = Scene(SMALL | changes)
    state, record = make_start_and_record(scene)
    assert_whole(scene, state, record)
    length = distance(state.position, *scene.bonded.T, scene.box)
    means = [length[scene.joined[2].law == law].mean() for law in range(3)]
    assert means[2] > max(means[:2]) + 0.05
    np.testing.assert_array_equal(state.species, [2] * 11 + [0, 0, 1, 1, 1, 0, 0] * 6 + [1] * 12)
    assert state.species.dtype == np.uint8


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("stiffness", "named"),
    [(2, r"start\.polymerize: after .* no chain grows"), (8, r"start\.relax: .* bonds crossed")],
)
def test_forces_that_let_chains_cross_are_refused(stiffness, named, monkeypatch):
    """Without cores, long weak bonds cross faster than chains grow, shorter ones later."""
    monkeypatch.setattr(module, "STALL", 5.0)
    weak = {
        "molecules": [{"architecture": "A 3", "density": 2}],
        "core": {"radius": 0, "force": 100},
        "bond": {"stiffness": stiffness, "length": 0},
    }
    with pytest.raises(UserError, match=rf"my\.yaml: {named}"):
        make_start(Scene(SCENE | weak, "my.yaml"))


def test_start_forces_and_the_file_of_a_start(tmp_path):
    """The same start as where the run itself has these forces; read as it was made."""
    weak = {"core": {"radius": 0, "force": 100}, "bond": {"stiffness": 2, "length": 0}}
    scene = Scene(SMALL | weak | {"start": SCENE["start"] | {"forces": STIFF}})
    state, record = make_start_and_record(scene)
    assert_whole(scene, state, record)
    path = tmp_path / "start.nc"
    write_start(scene, path)
    assert_same_state(read_start(scene, path), state)
    variables, _ = files.read(path)
    for name, values in record.items():
        np.testing.assert_array_equal(variables[name], values, err_msg=name)
    np.testing.assert_array_equal(state.position, make_start(Scene(SMALL)).position)
    other = Scene(SMALL | {"start": SCENE["start"] | {"polymerize": {"radius": 0.9}}})
    with pytest.raises(UserError, match="start_digest"):
        read_start(other, path)


# One round of growth in configurations made by hand.

BOX = (6.0, 5.0)


def one_round(points, chains):
    """Let the ends of some chains try once within 1 r_c, each up to 4 beads.

    Other beads than those of ``chains`` are free. Returns counts that are not 0, by name, and
    chains afterwards.
    """
    position = np.array(points, float).T
    beads, length = np.zeros((len(chains), 4), np.int64), np.array([len(c) for c in chains])
    chain = np.full(len(points), FREE)
    for c, along in enumerate(chains):
        beads[c, : len(along)] = along
        chain[along] = c
    rule = Rule(1.0, True, np.zeros(len(points), np.uint8), np.zeros_like(beads))
    active, rng = np.flatnonzero(length < 4), np.random.default_rng(0)
    counts = grow(position, BOX, (3, 2), rule, Chains(chain, beads, length), active, rng)
    after = [beads[c, :n].tolist() for c, n in enumerate(length)]
    assert all((chain[along] == c).all() for c, along in enumerate(after))
    names = {"tried": TRIED, "crossed": CROSSED, "far": FAR, "made": MADE}
    return {name: int(counts[k]) for name, k in names.items() if counts[k]}, after


END, NEAR, BEYOND = (3.0, 3.0), (3.6, 3.0), (3.0, 1.99)
ACROSS = [(3.3, 2.7), (3.3, 3.2)]  # a bond between the end and a monomer at NEAR


def test_an_end_takes_what_it_reaches():
    """Within the radius, not behind a bond, nor behind one that it only touches."""
    assert one_round([END, NEAR, BEYOND], [[0]]) == ({"tried": 2, "far": 1, "made": 1}, [[0, 1]])
    assert one_round([END, BEYOND], [[0]]) == ({"tried": 1, "far": 1}, [[0]])
    whole = [[0], [2, 3, 4, 5]]
    points = [END, NEAR, *ACROSS, (1.0, 1.0), (1.5, 1.0)]
    assert one_round(points, whole) == ({"tried": 1, "crossed": 1}, whole)
    found = one_round([*points, (2.2, 3.0)], whole)
    assert found == ({"tried": 2, "crossed": 1, "made": 1}, [[0, 6], whole[1]])
    points[2:4] = [(3.25, 3.0), (3.25, 3.5)]
    assert one_round(points, whole) == ({"tried": 1, "crossed": 1}, whole)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("box", [(5.0, 4.5), (2.5, 3.2), (2.2, 2.1)], ids=str)
def test_ends_stop_only_where_every_monomer_is_behind_a_bond(box, seed):
    """Monomers at rest in a box of one cell or more, rounds until none makes a bond.

    Then no two bonds cross, none is longer than the radius, and each monomer that an end
    could reach is refused because its bond would cross, all by exact arithmetic.
    """
    radius, rng = 0.9, np.random.default_rng(seed)
    n, ends = round(8 * np.prod(box)), 8
    position = rng.random((2, n)) * np.array(box)[:, None]
    chain, length = np.full(n, FREE), np.ones(ends, np.int64)
    beads, wanted = np.zeros((ends, n), np.int64), np.zeros((ends, n), np.int64)
    beads[:, 0] = chain_starts = rng.choice(n, ends, replace=False)
    chain[chain_starts] = np.arange(ends)
    shape = tuple(int(edge / radius) for edge in box)
    counts, made, crossed = None, 0, 0
    while counts is None or counts[MADE]:
        rule = Rule(radius, False, np.zeros(n, np.uint8), wanted)
        chains = Chains(chain, beads, length)
        counts = grow(
            position, tuple(map(float, box)), shape, rule, chains, rng.permutation(ends), rng
        )
        made += counts[MADE]
        crossed += counts[CROSSED]
        assert made == length.sum() - ends
    assert made > 2 * ends
    assert crossed > ends
    bonds = [pair for c in range(ends) for pair in zip(beads[c], beads[c, 1 : length[c]])]
    members = np.array(bonds, np.uint32)
    assert distance(position, *members.T, box).max() <= radius
    assert crossings_by_looking(position, members, box) == set()
    free, refused = np.flatnonzero(chain == FREE), 0
    for end in beads[np.arange(ends), length - 1]:
        within = free[distance(position, free, end, box) <= radius]
        refused += len(within)
        for monomer in within:
            tried = np.array([*bonds, (end, monomer)], np.uint32)
            assert crossings_by_looking(position, tried, box)
    assert counts[CROSSED] == refused
    assert counts[TRIED] == refused + counts[FAR]


# Chains made by hand whose bonds cross.


def two_chains(born):
    """Two chains of four in a box of 6 by 5: the second bonds of both cross, no others."""
    molecules = [{"architecture": "A 4", "count": 2}]
    scene = Scene(SCENE | {"box": list(BOX), "molecules": molecules})
    growth = Growth(scene, 0.0, 1.0, np.random.default_rng(0))
    growth.beads[:] = np.arange(8).reshape(2, 4)
    growth.length[:] = 4
    growth.chain[:] = np.repeat([0, 1], 4)
    growth.born[:] = born
    level = [(1.2, 2.0), (1.8, 2.0), (2.4, 2.0), (3.0, 2.0)]
    upright = [(2.2, 1.2), (2.2, 1.8), (2.0, 2.4), (2.0, 3.0)]
    return growth, np.array([*level, *upright]).T


@pytest.mark.parametrize("younger", [0, 1])
def test_of_two_bonds_that_cross_the_younger_is_undone(younger):
    """With all that grew after it; its beads are free again, those before it stay.

    The younger chain began earlier and was finished later, so its age is that of the bond.
    """
    born = np.array([[0, 4, 5, 6], [0, 4, 5, 6]])
    born[younger] = [0, 1, 8, 9]
    growth, position = two_chains(born)
    assert crossings_by_looking(position, growth.bonds()[0], BOX) == {(1, 4)}
    assert growth.undo_crossed(position, BOX) == 2
    assert growth.length.tolist() == [2 if c == younger else 4 for c in (0, 1)]
    freed = [4 * younger + 2, 4 * younger + 3]
    np.testing.assert_array_equal(np.flatnonzero(growth.chain == FREE), freed)
    assert sorted(np.bincount(growth.bonds()[1]).tolist()) == [1, 3]
    assert growth.undo_crossed(position, BOX) == 0
