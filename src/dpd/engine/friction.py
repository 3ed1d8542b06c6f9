"""Friction evaluated once more, with the velocities at the end of the step.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold,
Vattulainen, Karttunen and Polson 2000) takes it with the predicted velocities during the
step and replaces it by that of the final ones before the next, while conservative and
random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.jit import part


class Kept(NamedTuple):
    """Pairs of one evaluation: slots, and sqrt(gamma) w e, whose square is their friction."""

    i: np.ndarray
    j: np.ndarray
    drag: np.ndarray


@part()
def kept_buffers(again, dimension, size):
    """Buffers for ``size`` pairs; None for a scheme that evaluates friction once."""
    if again is None:
        return None
    return Kept(np.empty(size, np.uint32), np.empty(size, np.uint32), np.empty((dimension, size)))


@part()
def larger(kept, count, size):
    """The first ``count`` pairs in buffers for ``size``."""
    more = kept_buffers(True, kept.drag.shape[0], size)
    more.i[:count] = kept.i[:count]
    more.j[:count] = kept.j[:count]
    more.drag[:, :count] = kept.drag[:, :count]
    return more


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
    if count + np.int64(n) >= len(kept.i):
        kept = larger(kept, count, 2 * (count + np.int64(n)))
    root, weight = np.sqrt(friction), pairs.scratch[2]
    end = np.uint64(count)
    for p in range(n):
        kept.i[end] = pairs.i[p]
        kept.j[end] = pairs.j[p]
        for k in range(len(box)):
            kept.drag[k, end] = root * weight[p] * pairs.separation[k, p]
        end += np.uint64(weight[p] > 0.0)
    return kept, np.int64(end)


@part()
def renew_friction(force, kept, count, velocity, predicted, bath, box):
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
    """
    if kept is None:
        return
    change = predicted
    for k in range(len(box)):
        for i in range(velocity.shape[1]):
            change[k, i] -= velocity[k, i]
    for p in range(np.uint64(count)):
        i, j = kept.i[p], kept.j[p]
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
