"""Branched molecules: how they are written, measured, begun and kept in files."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dpd.engine.simulation import Snapshot
from dpd.engine.space import TURN, nearest, tilted, unfolded, wrapped
from dpd.engine.state import State
from dpd.observe.chains import ends_square, sizes
from dpd.observe.common.snapshot import Snapshot as Seen
from dpd.particles.particles import whole_images
from dpd.physics.shear import Shear
from dpd.scene.molecules import Molecule, graph_of
from dpd.scene.scene import Scene
from dpd.start import start_description
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE as FLUID
from tests.systems import look
from tests.test_bad_input import refusal


def molecule(architecture, count=1):
    return Molecule(*graph_of(architecture), count)


RUNS = st.builds("{} {}".format, st.sampled_from("ABC"), st.integers(1, 4))
WRITTEN = st.recursive(
    RUNS,
    lambda inner: st.one_of(
        st.lists(inner, min_size=1, max_size=3).map(" ".join),
        st.builds("({}) {}".format, inner, st.integers(1, 3)),
        st.builds("{} ({})".format, RUNS, inner),
    ),
    max_leaves=6,
)


def by_hand(text):
    """Beads and parents: groups are written out, and then bead after bead is hung on the last."""
    while found := re.search(r"\(([^()]*)\)( \d+)?", text):
        inside, times = found.groups()
        inside = " ".join([inside] * int(times)) if times else f"[{inside}]"
        text = text[: found.start()] + inside + text[found.end() :]
    beads, parents, last, branches = [], [], -1, []
    for word in re.findall(r"\[|\]|\w+(?: \d+)?", text):
        if word == "[":
            branches.append(last)
        elif word == "]":
            last = branches.pop()
        else:
            for _ in range(int(word[2:] or 1)):
                parents.append(last)
                last = len(beads)
                beads.append(word[0])
    return tuple(beads), tuple(parents), ()


@given(WRITTEN)
@settings(max_examples=100, deadline=None)
def test_architectures_are_trees(text):
    """A bracket without a number hangs on the bead before it; one with a number is repeated."""
    assert graph_of(text) == by_hand(text)


def test_names_and_blanks():
    """A species may hold digits; blanks stand between words alone."""
    beads = ("W1", "c3", "Na+", "C-3_b", "C-3_b")
    assert graph_of(" (W1 c3(Na+)C-3_b 2)1") == (beads, (-1, 0, 1, 1, 3), ())
    comb = [-1, 0, 1, 2, 3, 2, 5, 6, 7, 8, 2, 10, 11]
    assert graph_of(COMB) == (tuple("AAABBCCCCDAAA"), tuple(comb), ())


COMB = "A 3 (B 2) (C 4 (D)) A 3"


@given(WRITTEN)
@settings(max_examples=50, deadline=None)
def test_the_middle_is_as_far_from_both_ends(text):
    """By brute force over all pairs of beads."""
    found = molecule(text)
    n = len(found.beads)
    apart = np.full((n, n), n)
    np.fill_diagonal(apart, 0)
    apart[tuple(found.bonds.T)] = apart[tuple(found.bonds.T[::-1])] = 1
    for bead in range(n):
        apart = np.minimum(apart, apart[:, [bead]] + apart[[bead]])
    assert apart[list(found.middle)].max() == -(-apart.max() // 2) + (
        apart.max() % 2 == 0 and found.middle[0] != found.middle[1]
    )
    assert apart[found.middle] == apart.max() % 2


SCENE = FLUID | {
    "box": [5.0, 6.0, 7.0],
    "molecules": [
        {"architecture": COMB, "count": 4}, {"architecture": "A B A", "count": 3},
        {"architecture": "B (A) C", "count": 2}, {"architecture": "D", "count": 5},
    ],
    "repulsion": {f"{one} {other}": 25 for one in "ABCD" for other in "ABCD" if one <= other},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"sample": 40},
}  # fmt: skip
PAIRS = {
    "A A": {"stiffness": 50, "length": 0.5}, "B A": {"stiffness": 60},
    "B B": {"stiffness": 40, "length": 0.3}, "A C": {"stiffness": 55, "length": 0.7},
    "C C": {"stiffness": 65}, "D C": {"stiffness": 20, "length": 0.9}, "B C": {"stiffness": 30},
}  # fmt: skip


def only(architecture):
    """A change to nine molecules of A alone."""
    return {
        "molecules": [{"architecture": architecture, "count": 9}], "repulsion": {"A A": 25}
    }  # fmt: skip


def test_tables_give_each_bond_and_angle_its_law():
    """Whichever way round they are written; one angle for all is at each pair of bonds."""
    scene = Scene(SCENE | {"bond": PAIRS, "angle": {"A B A": {"stiffness": 3, "angle": 120}}})
    assert scene.data["bond"]["B A"] == {"stiffness": 60, "length": 0}
    system = system_of(scene)
    names = np.array(scene.species)[scene.kinds]
    for (one, other), number in zip(names[system.members], system.bond.number):
        law = PAIRS.get(f"{one} {other}") or PAIRS[f"{other} {one}"]
        assert system.bond.stiffness[number] == law["stiffness"]
        assert system.bond.length[number] == law.get("length", 0)
    assert ["".join(triple) for triple in names[system.angle_members]] == ["ABA"] * 3
    assert system.angle.angle[0] == pytest.approx(np.deg2rad(120))
    scene = Scene(SCENE | {"angle": {"stiffness": 3}})
    assert len(scene.joined[3][0]) == 4 * 14 + 3 + 2
    assert system_of(scene).angle == (3.0, np.pi, None)
    assert system_of(Scene(SCENE)).angle is None


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"bond": {k: v for k, v in PAIRS.items() if k != "D C"}}, ["bond", "'C D'", "no value"]),
        ({"bond": PAIRS | {"A B": {"stiffness": 1}}}, ["bond.A B", "other order"]),
        ({"bond": PAIRS | {"A D": {"stiffness": 1}}}, ["bond.A D", "bonded", "'A A'"]),
        ({"angle": {"D A D": {"stiffness": 3}}}, ["angle.D A D", "bonded", "'A A A'"]),
        ({"angle": {"stiffness": 3}} | only("A 2"), ["angle", "three beads"]),
        ({"observe": ["end_to_end"]} | only("A (A) (A) A"), ["observe", "'end_to_end'", "linear"]),
        ({"dimension": 2, "box": 9, "start": {"method": "polymerize"}} | only("A (A) (A) A"),
         ["start.method", "polymerize", "A (A) (A) A", "branches"]),
    ],
)  # fmt: skip
def test_what_does_not_fit_together(change, named):
    """One message with the key, the value, and what is allowed."""
    message = refusal(Scene, SCENE | change, "my.yaml")
    assert message.startswith("my.yaml: ") and "\n" not in message
    assert all(part in message for part in named), message


@pytest.mark.parametrize("method", ["random", "slabs"])
def test_first_places_are_flights_along_bonds(method):
    """Each bond has the length of its law, or that of a flight where it has none."""
    scene = Scene(SCENE | {"bond": PAIRS, "start": {"method": method}, "box": [5.0, 6.0, 30.0]})
    start, (one, other) = make_start(scene), scene.bonded.T
    apart = nearest(start.position[:, other] - start.position[:, one], scene.box)
    length, names = np.linalg.norm(apart, axis=0), np.array(scene.species)[scene.kinds]
    wanted = [
        (PAIRS.get(f"{a} {b}") or PAIRS[f"{b} {a}"]).get("length", 0) or 0.8
        for a, b in zip(names[one], names[other])
    ]
    assert (length < np.array(wanted) + 1e-12).all()  # a face of a slab folds some back
    assert np.isclose(length, wanted).mean() > (0.7 if method == "slabs" else 1 - 1e-9)
    assert start_description(scene)["flight"]["D C"] == 0.9


def test_trees_come_in_one_piece():
    """Across the boundary, bead by bead along bonds."""
    scene = Scene(SCENE)
    rng = np.random.default_rng(4)
    whole, place = [], []
    for kind in scene.molecules:
        steps = rng.normal(size=(3, kind.count, len(kind.beads))) * 0.4
        steps[:, :, 0] = rng.random((3, kind.count)) * 5
        x = kind.summed(steps)
        whole.append(x - x[:, :, :1])
        place.append(x.reshape(3, -1))
    position = np.concatenate(place, axis=1) % np.array(scene.box)[:, None]
    numbers = np.arange(scene.beads, dtype=np.uint32)
    state = State(position, np.zeros_like(position), None, numbers, None, 0)
    now = Seen(scene, Snapshot(system_of(scene), state))
    for found, expected in zip(now.in_one_piece, whole):
        np.testing.assert_allclose(found - found[:, :, :1], expected, atol=1e-12)
    place, (one, other) = np.concatenate(place, axis=1), scene.bonded.T
    for box in (scene.box, tilted(scene.box, Shear(0.1, 0, 1), 0.04, 0, TURN // 3)):
        inside, _ = wrapped(place, box)
        image = whole_images(scene.molecules, inside, np.zeros(inside.shape, np.int32), box)
        found = unfolded(inside, image, box)
        bonds = place[:, one] - place[:, other]
        np.testing.assert_allclose(found[:, one] - found[:, other], bonds, atol=1e-12)


def test_sizes_of_a_cross():
    """Four arms of length 1 about a centre: distances of ends 2 (two pairs) and sqrt 2 (four)."""
    cross = molecule("A (A) (A) (A) (A)")
    x = np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1.0]]).T[:, None]
    gyration, across = sizes(x, cross.ends)
    assert gyration == pytest.approx(4 / 5)
    assert across == pytest.approx(2)  # of the first and the last end
    assert ends_square(x[:, :, cross.ends]) == pytest.approx((2 * 4 + 4 * 2) / 6)


def test_distributions_have_the_area_one():
    """Of ends and of bonds; kinds of single beads have none; the share beyond is there."""
    scene, found = SCENE | {"bond": PAIRS}, {}
    still = make_start(Scene(scene)).position
    for asked in (
        {"end_points": {"every": 1, "range": 3, "bin": 0.07}},
        {"bond_lengths": {"every": 1, "range": 2, "bin": 0.03}},
    ):
        found |= look(scene, asked, *[still] * 40)
    area = found["end_density"].sum(axis=2) * 3 / 43 + found["end_beyond"]
    np.testing.assert_allclose(area[:, :3], 1, rtol=1e-12)
    assert np.isnan(area[:, 3]).all() and (found["end_beyond"][:, 0] > 0).all()
    assert found["bond_pair"].tolist() == ["A A", "A B", "A C", "B B", "B C", "C C", "C D"]
    np.testing.assert_allclose(found["pair_bond_density"].sum(axis=2) * 2 / 67, 1, rtol=1e-12)
    np.testing.assert_allclose(found["pair_bond_mean"][0], [0.5, 0.8, 0.7, 0.3, 0.8, 0.8, 0.9])
