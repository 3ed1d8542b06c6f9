"""Bonds that cross are those that exact arithmetic finds, each pair once."""

from contextlib import nullcontext
from itertools import product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from dpd.engine.crossings import crossing_bonds, segments_meet
from dpd.engine.space import wrapped
from dpd.errors import UserError
from tests.systems import assert_pairs

UNIT = 64  # ends lie on a grid of 1/64 r_c: floats hold them, and their products, exactly
TOO_LONG = r"a bond of 1.0\d r_c is longer than half the box"


def side(a, b, c):
    """1, 0 or -1: c lies left of the line from a to b, on it, or right of it."""
    return np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def meet(a, b, c, d):
    """Whether the closed segments AB and CD have a point in common, for exact numbers.

    They do if neither has both ends strictly on one side of the other; if all four ends lie
    on one line, if they overlap along both axes.
    """
    sides = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    if any(sides):
        return sides[0] * sides[1] <= 0 and sides[2] * sides[3] <= 0
    return all(
        max(min(a[k], b[k]), min(c[k], d[k])) <= min(max(a[k], b[k]), max(c[k], d[k]))
        for k in range(2)
    )


def crossings_by_looking(position, members, box):
    """Pairs of bonds with a point but no bead in common, as a set of (smaller, larger).

    For bonds shorter than half the smallest edge, none of which touches another within rounding.
    """
    edges = np.array(box)[:, None]
    one = position[:, members[:, 0]]
    along = position[:, members[:, 1]] - one
    other = one + along - edges * np.round(along / edges)
    a, b, cross = one[:, :, None], other[:, :, None], False
    for image in product((-1, 0, 1), repeat=2):
        c, d = ((end + np.array(image)[:, None] * edges)[:, None] for end in (one, other))
        cross |= (side(a, b, c) != side(a, b, d)) & (side(c, d, a) != side(c, d, b))
    cross &= (members[:, None, :, None] != members[:, None]).all(axis=(2, 3))
    return {(int(i), int(j)) for i, j in np.argwhere(np.triu(cross, 1))}


def separate(count):
    """Members of bonds that share no bead."""
    return np.arange(2 * count, dtype=np.uint32).reshape(count, 2)


def random_bonds(box, count, longest, seed):
    """Bonds anywhere in a box, up to a length, in any direction."""
    rng = np.random.default_rng(seed)
    edges = np.array(box)[:, None]
    first = rng.random((2, count)) * edges
    angle, length = rng.random((2, count)) * np.array([[2 * np.pi], [longest]])
    second = first + length * np.array([np.cos(angle), np.sin(angle)])
    position = np.stack([first, second], axis=2).reshape(2, -1)
    return wrapped(position, box)[0], separate(count)


# One cell, two, three by four, five by two, and more cells than bonds.
CASES = [
    ((2.0, 2.0), 0.99, 60),
    ((2.0, 2.0), 0.66, 60),
    ((2.2, 3.1), 0.7, 60),
    ((5.1, 2.2), 1.0, 120),
    ((6.0, 6.0), 0.5, 200),
]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("box", "longest", "count"), CASES, ids=str)
def test_random_bonds_cross_as_looking_at_all_pairs_says(box, longest, count, seed):
    """The same set of pairs as in exact arithmetic, some of them across the boundary.

    Random bonds come no nearer to touching than 1e-9, so rounding cannot tell differently.
    """
    position, members = random_bonds(box, count, longest, seed)
    apart = position[:, ::2] - position[:, 1::2]
    assert (np.abs(apart) > np.array(box)[:, None] / 2).any()
    expected = crossings_by_looking(position, members, box)
    assert len(expected) > 10
    assert assert_pairs(crossing_bonds(position, members, box)) == expected


# So few that ends are shared, lie on one line, on the other segment, or at one point.
POINT = st.tuples(*[st.integers(-2, 2)] * 2)


@settings(max_examples=2000, deadline=None, derandomize=True)
@given(st.tuples(*[POINT] * 4), st.tuples(*[st.integers(-500, 500)] * 2))
@example([(0, 0), (2, 3), (2, 3), (4, 6)], (0, 0))
@example([(0, 0), (0, 0), (0, 0), (0, 0)], (0, 0))
def test_segments_meet(ends, offset):
    """Every product and difference is exact here, so touching is told from all but touching."""
    a, b, c, d = (np.add(end, offset) / UNIT for end in ends)
    one, other = 0.5 * (b - a), 0.5 * (d - c)
    assert segments_meet(*(c + other - a - one), *one, *other) == meet(*ends)


def test_more_crossings_than_bonds():
    """Ten bonds each way make a hundred crossings: the list of them grows as it must."""
    at = np.arange(10) / 16 + 1
    low, high = np.full(10, 0.9), np.full(10, 1.7)
    upright = np.array([[at, at], [low, high]])
    level = upright[::-1]
    position = np.concatenate([upright, level], axis=2).transpose(0, 2, 1).reshape(2, -1)
    found = assert_pairs(crossing_bonds(position, separate(20), (3.0, 3.0)))
    assert found == {(i, 10 + j) for i in range(10) for j in range(10)}


@pytest.mark.parametrize("first", [0.5, 1.9])
@pytest.mark.parametrize(
    ("box", "along"),
    [((2.0, 5.0), (0.0, 0.99)), ((5.0, 2.0), (0.99, 0.0)), ((2.0, 2.0), (0.7, 0.7))],
    ids=str,
)
def test_a_bond_longer_than_half_the_box_is_refused(box, along, first):
    """Half the smaller edge, 1 here, whatever the direction, inside or across the boundary."""
    place, edges = np.array([[first], [first]]), np.array(box)[:, None]
    for factor, refused in ((1.0, nullcontext()), (1.03, pytest.raises(UserError, match=TOO_LONG))):
        with refused:
            position = np.hstack([place, place + factor * np.array(along)[:, None]]) % edges
            assert crossing_bonds(position, separate(1), box).shape == (2, 0)
