"""Bonds that pass through each other are those that the roots of a cubic say, each pair once."""

from itertools import pairwise, product
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from dpd.engine.crossings import passed_bonds
from dpd.engine.loop import run
from dpd.engine.space import wrapped
from dpd.scene.scene import Scene
from tests.systems import assert_pairs, begun, by_identity, chains, values_of
from tests.test_extend import PAGES

MARGIN = 1e-7  # of a time and of a place along a bond, within which nothing is decided


def moving_chains(box, count, length, bond, move, seed):
    """Places before and after, and members: chains in any direction, numbered in no order."""
    rng = np.random.default_rng(seed)

    def vectors(*shape):
        found = rng.normal(size=(3, *shape))
        return found * rng.uniform(0.4, 1, shape) / np.sqrt((found**2).sum(axis=0))

    first = rng.random((3, count, 1)) * np.array(box)[:, None, None]
    flights = np.concatenate([first, bond * vectors(count, length - 1)], axis=2).cumsum(axis=2)
    number = rng.permutation(count * length)
    before, after = np.empty((2, 3, len(number)))
    before[:, number] = flights.reshape(3, -1)
    after[:, number] = before[:, number] + move * vectors(len(number))
    members = number[chains(count, length)].astype(np.uint32)
    return wrapped(before, box)[0], wrapped(after, box)[0], members


def planes(one, other):
    """Whether two bonds meet inside both at each time they lie in one plane; None if unclear.

    A bond is ((A, A after), (B, B after)). The times are roots of w . (u x v), a cubic; there
    w + p u - q v = 0.
    """
    # Each end moves in a straight line in a unit of time: three polynomials.
    a, b, c, d = ([Polynomial([x, y - x]) for x, y in zip(*end)] for end in (*one, *other))
    u, v, w = ([y - x for x, y in zip(*ends)] for ends in ((a, b), (c, d), (c, a)))
    triple = sum(
        w[i] * (u[j] * v[k] - u[k] * v[j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    )
    inside = []
    for root in np.roots(triple.coef[::-1]):
        if root.imag or not -MARGIN < root.real < 1 + MARGIN:
            continue
        now_u, now_v, now_w = (np.array([x(root.real) for x in line]) for line in (u, v, w))
        places = np.linalg.lstsq(np.stack([now_u, -now_v], axis=1), -now_w, rcond=None)[0]
        if np.abs([root.real, 1 - root.real, *places, *(1 - places)]).min() < MARGIN:
            return None
        inside.append(bool(((places > 0) & (places < 1)).all()))
    return inside


def passes_by_looking(before, after, members, box):
    """Pairs of bonds without a common bead that meet an odd number of times, and unclear ones.

    Every pair at every image whose bounds overlap is looked at. Unclear are those within
    `MARGIN` of touching an end or of a pass just at the beginning or the end, and those that
    lie in one plane several times, inside both bonds at some of them but not at all.
    """
    edges = np.array(box)[:, None]
    start = before[:, members[:, 0]]
    bond = before[:, members[:, 1]] - start
    ends = np.stack([start, start + bond - edges * np.round(bond / edges)])
    move = np.stack([(after - before)[:, members[:, end]] for end in (0, 1)])
    track = np.stack([ends, ends + move - edges * np.round(move / edges)], axis=1)
    low, high = track.min(axis=(0, 1)), track.max(axis=(0, 1))
    track = track.transpose(3, 0, 1, 2)  # bond, end, time, axis
    found, unclear = set(), set()
    for image in product((-1, 0, 1), repeat=3):
        shift = np.array(image) * np.array(box)
        aside = (low + shift[:, None])[:, None] > high[:, :, None]
        aside |= low[:, :, None] > (high + shift[:, None])[:, None]
        for i, j in np.argwhere(np.triu(~aside.any(axis=0), 1)):
            if set(members[i]) & set(members[j]):
                continue
            inside = planes(track[i], track[j] + shift)
            if inside is None or 0 < sum(inside) < len(inside):
                unclear.add((int(i), int(j)))
            elif sum(inside) % 2:
                found.add((int(i), int(j)))
    return found, unclear


# Box, chains, beads in each, longest bond, farthest move. A bond and twice the move are less
# than half the box. Two cells an axis and three, many, and moves as long as bonds.
CASES = [
    ((2.0, 2.0, 2.0), 200, 2, 0.7, 0.14),
    ((2.2, 3.1, 2.6), 250, 2, 0.8, 0.15),
    ((3.1, 2.2, 2.2), 60, 6, 0.6, 0.12),
    ((5.1, 2.2, 3.7), 60, 10, 0.5, 0.1),
    ((2.2, 2.6, 3.1), 500, 2, 0.3, 0.1),
    ((6.0, 6.0, 6.0), 60, 10, 0.9, 0.2),
    ((3.1, 3.1, 3.1), 250, 2, 0.5, 0.5),
]


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("case", CASES, ids=str)
def test_random_bonds_pass_as_the_roots_say(case, seed):
    """The same pairs but for unclear ones, of which there are few unless moves are long."""
    box = case[0]
    before, after, members = moving_chains(*case, seed)
    found = assert_pairs(passed_bonds(before, after, members, box))
    expected, unclear = passes_by_looking(before, after, members, box)
    assert len(expected) > 5
    assert len(unclear) < len(expected) / 3
    assert found - unclear == expected - unclear


PHANTOM = {
    "dimension": 3,
    "box": [3.0, 3.5, 4.0],
    "molecules": [{"architecture": "A 6", "count": 15}, {"architecture": "A", "count": 20}],
    "repulsion": {"A A": 1},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 30, "sample": 400},
    "pages": [PAGES["passes"]],
    "observe": [{"passes": {"every": 4}}],
}


def test_passes_of_a_run_are_those_between_its_samples():
    """None at the first sample; many in all, of chains that hardly repel each other."""
    scene, places = Scene(PHANTOM), []
    simulation, (observer, *_), steps = begun(PHANTOM)
    watch = SimpleNamespace(
        every=4, arrays={}, sample=lambda now: places.append(by_identity(now, "position"))
    )
    run(simulation, steps, [observer, watch])
    expected = [0] + [
        passed_bonds(*two, scene.bonded, scene.box).shape[1] for two in pairwise(places)
    ]
    found = values_of(observer)
    assert len(places) == 100 and sum(expected) > 20
    np.testing.assert_array_equal(found["passes"], expected)
    np.testing.assert_allclose(found["pass_time"], 0.08 * np.arange(1, 101), rtol=1e-12)
