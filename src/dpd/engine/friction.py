"""Friction evaluated once more, with the velocities at the end of the step.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold,
Vattulainen, Karttunen and Polson 2000) takes it with the predicted velocities during the
step and replaces it by that of the final ones before the next, while conservative and
random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.vectors.arrays import columns
from dpd.engine.vectors.rows import add_rows, difference_along, push_apart
from dpd.jit import part


class Kept(NamedTuple):
    """Pairs of one evaluation.

    ``ends`` are their (2, n) slots, ``drag`` is sqrt(gamma) w e, whose square is their friction;
    ``phase`` is how many of them were found before each phase of the blocks, and in all.
    """

    ends: np.ndarray
    drag: np.ndarray
    phase: np.ndarray


@part()
def kept_buffers(again, exchange, dimension, size, phases):
    """Buffers for ``size`` pairs of so many phases; None for a scheme that needs them once."""
    if again is None:  # noqa: SIM102  Numba drops branches on None one by one
        if exchange is None:
            return None
    return Kept(
        np.empty((2, size), np.uint32), np.empty((dimension, size)), np.zeros(phases + 1, np.int64)
    )


@part()
def keep_pairs(kept, count, pairs, n, friction, box):
    """Append those of ``n`` pairs that are within the cutoff after ``count`` others.

    ``pairs.theta`` holds w / r.

    Returns
    -------
    None or Kept, int
        The pairs, and how many they are now.
    """
    if kept is None:
        return None, 0
    ends, drag, phase = kept
    if count + np.int64(n) >= ends.shape[1]:
        size = 2 * (count + np.int64(n))
        ends, drag = columns(ends, count, size), columns(drag, count, size)
    root, weight = np.sqrt(friction), pairs.theta
    end = np.uint64(count)
    for p in range(n):
        ends[0, end] = pairs.i[p]
        ends[1, end] = pairs.j[p]
        for k in range(len(box)):
            drag[k, end] = root * weight[p] * pairs.separation[k, p]
        end += np.uint64(weight[p] > 0.0)
    return Kept(ends, drag, phase), np.int64(end)


@part()
def change_of(predicted, velocity, own):
    """Make the predicted velocity what it has to lose to be the velocity now."""
    add_rows(predicted, velocity, -1.0, own)


@part()
def close_phase(kept, phase, count):
    """Note how many pairs were kept up to the end of a phase."""
    if kept is not None:
        kept.phase[phase + 1] = count


@part()
def renew_friction(force, kept, phase, change, box):
    """Replace the friction in a force by that of the velocities now, for the pairs of a phase.

    Parameters
    ----------
    force : array with a row for each bead
    kept : Kept
    change : array with a row for each bead
        From `change_of`.
    """
    for p in range(np.uint64(kept.phase[phase]), np.uint64(kept.phase[phase + 1])):
        i, j = kept.ends[0, p], kept.ends[1, p]
        pull = difference_along(change, i, j, kept.drag, p, box)
        push_apart(force, i, j, pull, kept.drag, p, box)
