"""Friction evaluated once more, with the velocities at the end of the step.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold,
Vattulainen, Karttunen and Polson 2000) takes it with the predicted velocities during the
step and replaces it by that of the final ones before the next, while conservative and
random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.forces import CLOSEST
from dpd.engine.jit import part


class Kept(NamedTuple):
    """Pairs of one evaluation: slots, separation, gamma w^2 / r^2, and r_ij . v_ij then."""

    i: np.ndarray
    j: np.ndarray
    separation: np.ndarray
    drag: np.ndarray
    approach: np.ndarray


@part()
def kept_buffers(again, dimension, size):
    """Buffers for ``size`` pairs; None for a scheme that evaluates friction once."""
    if again is None:
        return None
    return Kept(
        np.empty(size, np.uint32),
        np.empty(size, np.uint32),
        np.empty((dimension, size)),
        np.empty(size),
        np.empty(size),
    )


@part()
def larger(kept, count, size):
    """The first ``count`` pairs in buffers for ``size``."""
    more = kept_buffers(True, kept.separation.shape[0], size)
    more.i[:count] = kept.i[:count]
    more.j[:count] = kept.j[:count]
    more.separation[:, :count] = kept.separation[:, :count]
    more.drag[:count] = kept.drag[:count]
    more.approach[:count] = kept.approach[:count]
    return more


@part()
def keep_pairs(kept, count, pairs, n, friction, box):
    """Append ``n`` pairs, whose approach is in scratch[1], after ``count`` others."""
    if kept is None:
        return None
    n = np.int64(n)
    if count + n > len(kept.i):
        kept = larger(kept, count, 2 * (count + n))
    end = count + n
    kept.i[count:end] = pairs.i[:n]
    kept.j[count:end] = pairs.j[:n]
    kept.approach[count:end] = pairs.scratch[1, :n]
    drag = kept.drag[count:end]
    for k in range(len(box)):
        kept.separation[k, count:end] = pairs.separation[k, :n]
    for p in range(np.uint64(n)):
        r2 = CLOSEST
        for k in range(len(box)):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        w = max(0.0, 1.0 - np.sqrt(r2))
        drag[p] = friction * w * w / r2
    return kept


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
    bath : None or (gamma, sigma / sqrt(dt))
    """
    if kept is None:
        return
    for p in range(np.uint64(count)):
        i, j = kept.i[p], kept.j[p]
        approach = 0.0
        for k in range(len(box)):
            approach += kept.separation[k, p] * (velocity[k, i] - velocity[k, j])
        change = kept.drag[p] * (kept.approach[p] - approach)
        for k in range(len(box)):
            push = change * kept.separation[k, p]
            force[k, i] += push
            force[k, j] -= push
    if bath is not None:
        for k in range(len(box)):
            for i in range(velocity.shape[1]):
                force[k, i] += bath[0] * (predicted[k, i] - velocity[k, i])
