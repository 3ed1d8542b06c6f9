"""What the search for bonds that cross and for bonds that pass through each other shares."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError
from dpd.jit import inlined

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
ROOM = 1024  # pairs found, at first


def refuse_longer(longest: float, box: Sequence[float], what: str) -> None:
    """Refuse a bond longer than half the smallest edge: its nearest image is not its own."""
    if longest > 0.5 * min(box):
        raise UserError(
            f"a bond of {longest:.3g} r_c is longer than half the box ({min(box):g} r_c): "
            f"{what} cannot be told; take a larger box or stiffer bonds"
        )


@inlined()
def share_a_bead(members, a, b):
    """Whether two bonds have an end in common."""
    first, second = members[a, 0], members[a, 1]
    if first == members[b, 0] or first == members[b, 1]:
        return True
    return second == members[b, 0] or second == members[b, 1]


def all_found(search: Callable[..., int], *arguments: Any) -> np.ndarray:
    """(2, n) uint32 array: all pairs of bonds that a kernel finds.

    It fills a (2, size) array as far as there is room, and returns how many pairs there are.
    """
    found = np.empty((2, ROOM), np.uint32)
    while (total := search(found, *arguments)) > found.shape[1]:
        found = np.empty((2, total), np.uint32)
    return found[:, :total].copy()


@inlined()
def note_pair(found, total, a, b):
    """Note a pair after ``total`` others, if there is room; return how many there are then."""
    if total < found.shape[1]:
        found[0, total], found[1, total] = min(a, b), max(a, b)
    return total + 1
