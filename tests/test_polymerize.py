"""Chains grown in two dimensions: exactly those asked for, and no two of their bonds cross."""

import numpy as np
import pytest

from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.start import start_work
from dpd.start.common import growth as module
from dpd.start.common.files import read_start, write_start
from dpd.start.common.growth import FREE, Growth, grow
from dpd.start.common.make import make_start
from dpd.start.polymerize import Growth as Settings
from tests.engine.test_crossings import crossings_by_looking
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
    apart = position[:, first] - position[:, second].reshape(2, -1)
    return np.linalg.norm(nearest(apart, box), axis=0)


def assert_whole(scene, state):
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


def test_the_melt_is_what_the_scene_asks_for():
    """45 chains of 10, density 2, at rest as a whole, without a crossing; the same bits again."""
    scene, told = Scene(SCENE), []
    state = make_start(scene, told.append)
    assert (scene.beads, len(scene.bonded), state.species) == (450, 45 * 9, None)
    assert_whole(scene, state)
    np.testing.assert_allclose(state.velocity.sum(axis=1), 0, atol=1e-10)
    assert np.mean(state.velocity**2) == pytest.approx(1, abs=5 * np.sqrt(2 / 900))
    assert told[-1] == start_work(scene) == 450 + 500
    start = SCENE["start"] | {"seed": scene.data["seed"]}  # which goes first
    assert_same_state(make_start(Scene(SCENE | {"seed": 2, "start": start})), state)
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
    state = make_start(scene)
    assert_whole(scene, state)
    length = distance(state.position, *scene.bonded.T, scene.box)
    means = [length[scene.joined[2][1] == law].mean() for law in range(3)]
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
    state = make_start(scene)
    assert_whole(scene, state)
    path = tmp_path / "start.nc"
    write_start(scene, path)
    assert_same_state(read_start(scene, path), state)
    np.testing.assert_array_equal(state.position, make_start(Scene(SMALL)).position)
    other = Scene(SMALL | {"start": SCENE["start"] | {"polymerize": {"radius": 0.9}}})
    with pytest.raises(UserError, match="start_digest"):
        read_start(other, path)


# Growth in configurations made by hand.

BOX = (6.0, 5.0)


@pytest.mark.parametrize("box", [(5.0, 4.5), (2.5, 3.2), (2.2, 2.1)], ids=str)
def test_ends_stop_only_where_every_monomer_is_behind_a_bond(box):
    """Monomers at rest in a box of one cell or more, rounds until none makes a bond.

    Then no two bonds cross, none is longer than the radius, and each monomer that an end
    could reach is refused because its bond would cross, all by exact arithmetic.
    """
    radius, rng = 0.9, np.random.default_rng(0)
    n, ends = round(8 * np.prod(box)), 8
    position = rng.random((2, n)) * np.array(box)[:, None]
    chain, length = np.full(n, FREE), np.ones(ends, np.int64)
    beads, wanted = np.zeros((ends, n), np.int64), np.zeros((ends, n), np.int64)
    beads[:, 0] = first = rng.choice(n, ends, replace=False)
    chain[first] = np.arange(ends)
    shape = tuple(int(edge / radius) for edge in box)
    given = radius, False, np.zeros(n, np.uint8), wanted, chain, beads, length
    while grow(position, box, shape, *given, rng.permutation(ends), rng):
        pass
    assert length.sum() > 3 * ends
    bonds = [pair for c in range(ends) for pair in zip(beads[c], beads[c, 1 : length[c]])]
    members = np.array(bonds, np.uint32)
    assert distance(position, *members.T, box).max() <= radius
    assert crossings_by_looking(position, members, box) == set()
    free = np.flatnonzero(chain == FREE)
    for end in beads[np.arange(ends), length - 1]:
        for monomer in free[distance(position, free, end, box) <= radius]:
            tried = np.array([*bonds, (end, monomer)], np.uint32)
            assert crossings_by_looking(position, tried, box)


@pytest.mark.parametrize("younger", [0, 1])
def test_of_two_bonds_that_cross_the_younger_is_undone(younger):
    """With all that grew after it; its beads are free again, those before it stay.

    The younger chain began earlier and was finished later, so its age is that of the bond.
    """
    molecules = [{"architecture": "A 4", "count": 2}]
    scene = Scene(SCENE | {"box": list(BOX), "molecules": molecules})
    growth = Growth(scene, Settings(spare=0, initiators=1), np.random.default_rng(0))
    growth.beads[:] = np.arange(8).reshape(2, 4)
    growth.length[:] = 4
    growth.chain[:] = np.repeat([0, 1], 4)
    growth.born[:] = [0, 4, 5, 6]
    growth.born[younger] = [0, 1, 8, 9]
    # In a box of 6 by 5: the second bonds of both cross, no others.
    level = [(1.2, 2.0), (1.8, 2.0), (2.4, 2.0), (3.0, 2.0)]
    upright = [(2.2, 1.2), (2.2, 1.8), (2.0, 2.4), (2.0, 3.0)]
    position = np.array([*level, *upright]).T
    assert crossings_by_looking(position, growth.bonds()[0], BOX) == {(1, 4)}
    assert growth.undo_crossed(position, BOX) == 2
    assert growth.length.tolist() == [2 if c == younger else 4 for c in (0, 1)]
    freed = [4 * younger + 2, 4 * younger + 3]
    np.testing.assert_array_equal(np.flatnonzero(growth.chain == FREE), freed)
    assert growth.undo_crossed(position, BOX) == 0
