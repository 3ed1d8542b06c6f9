"""What the search for bonds that cross and for bonds that pass through each other shares."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.rows import columns
from dpd.errors import UserError
from dpd.jit import inlined

if TYPE_CHECKING:
    from collections.abc import Sequence

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
ROOM = 16  # pairs found, at first


def longest_bond(bond: np.ndarray, box: Sequence[float], what: str) -> float:
    """Length of the longest bond.

    Parameters
    ----------
    bond : (dimension, bonds) array
        End to end, at nearest images.
    box : tuple
    what : str
        What is looked for, for the message.

    Raises
    ------
    UserError
        If it is longer than half the smallest edge: its nearest image is not its own.
    """
    longest = float(np.sqrt((bond**2).sum(axis=0).max())) if bond.shape[1] else 0.0
    if longest > 0.5 * min(box):
        raise UserError(
            f"a bond of {longest:.3g} r_c is longer than half the box ({min(box):g} r_c): "
            f"{what} cannot be told; take a larger box or stiffer bonds"
        )
    return longest


@inlined()
def share_a_bead(members, a, b):
    """Whether two bonds have an end in common."""
    first, second = members[a, 0], members[a, 1]
    if first == members[b, 0] or first == members[b, 1]:
        return True
    return second == members[b, 0] or second == members[b, 1]


@inlined()
def with_pair(found, total, a, b):
    """The (2, n) pairs found with one more, after ``total`` others; larger if it is full."""
    if total == found.shape[1]:
        found = columns(found, total, 2 * total)
    found[0, total], found[1, total] = min(a, b), max(a, b)
    return found
