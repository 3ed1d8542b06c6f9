"""Friction evaluated once more, with the velocities at the end of the step.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold,
Vattulainen, Karttunen and Polson 2000) takes it with the predicted velocities during the
step and replaces it by that of the final ones before the next, while conservative and
random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.arrays import columns
from dpd.engine.jit import part


class Kept(NamedTuple):
    """Pairs of one evaluation.

    ``ends`` are their (2, n) slots, ``drag`` is sqrt(gamma) w e, whose square is their friction.
    """

    ends: np.ndarray
    drag: np.ndarray


@part()
def kept_buffers(again, exchange, dimension, size):
    """Buffers for ``size`` pairs; None for a scheme that needs them once."""
    if again is None:  # noqa: SIM102  Numba drops branches on None one by one
        if exchange is None:
            return None
    return Kept(np.empty((2, size), np.uint32), np.empty((dimension, size)))


@part()
def keep_pairs(kept, count, pairs, n, friction, box):
    """Append those of ``n`` pairs that are within the cutoff after ``count`` others.

    ``pairs.scratch[2]`` holds w / r.

    Returns
    -------
    None or Kept, int
        The pairs, and how many they are now.
    """
    if kept is None:
        return None, 0
    ends, drag = kept
    if count + np.int64(n) >= ends.shape[1]:
        size = 2 * (count + np.int64(n))
        ends, drag = columns(ends, count, size), columns(drag, count, size)
    root, weight = np.sqrt(friction), pairs.scratch[2]
    end = np.uint64(count)
    for p in range(n):
        ends[0, end] = pairs.i[p]
        ends[1, end] = pairs.j[p]
        for k in range(len(box)):
            drag[k, end] = root * weight[p] * pairs.separation[k, p]
        end += np.uint64(weight[p] > 0.0)
    return Kept(ends, drag), np.int64(end)


@part()
def renew_friction(force, kept, count, velocity, predicted, bath, box, again):
    """Replace the friction in a force by that of the velocities now.

    Parameters
    ----------
    force : (dimension, n) array
        With the friction of ``predicted``.
    kept : None or Kept
        Pairs of that evaluation, ``count`` of them.
    velocity, predicted : (dimension, n) arrays
        ``predicted`` is lost: it is made the velocity's change.
    bath : None or (gamma, sigma / sqrt(dt))
    again : None or True
        None for schemes that leave it.
    """
    if again is None:
        return
    change = predicted
    for k in range(len(box)):
        for i in range(velocity.shape[1]):
            change[k, i] -= velocity[k, i]
    for p in range(np.uint64(count)):
        i, j = kept.ends[0, p], kept.ends[1, p]
        pull = 0.0
        for k in range(len(box)):
            pull += kept.drag[k, p] * (change[k, i] - change[k, j])
        for k in range(len(box)):
            push = pull * kept.drag[k, p]
            force[k, i] += push
            force[k, j] -= push
    if bath is not None:
        for k in range(len(box)):
            for i in range(velocity.shape[1]):
                force[k, i] += bath[0] * change[k, i]
