"""Pairs that a step needs again, and friction taken again with the velocities at its end.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold,
Vattulainen, Karttunen and Polson 2000) takes it with the predicted velocities during the
step and replaces it by that of the final ones before the next, while conservative and
random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.shares import share_weights, shares_of
from dpd.engine.vectors.arrays import columns
from dpd.engine.vectors.rows import add_rows, difference_along, push_apart
from dpd.jit import part


class Touching(NamedTuple):
    """Pairs within the cutoff, of one evaluation of the forces.

    Attributes
    ----------
    ends : (2, size) uint32 array
        Slots.
    drag : (dimension, size) array
        sqrt(gamma) w e of each, whose square is its friction.
    phase : (phases + 1,) int64 array
        How many were found before each phase of the blocks, and in all.
    count : int
        How many there are so far.
    """

    ends: np.ndarray
    drag: np.ndarray
    phase: np.ndarray
    count: int  # type: ignore[assignment]  # in place of tuple.count


@part()
def empty_touching(renewal, exchange, space, beads, phases):
    """Room for pairs; None for a scheme that needs them once."""
    if renewal is None:  # noqa: SIM102  Numba drops branches on None one by one
        if exchange is None:
            return None
    size = 4 * beads
    return Touching(
        np.empty((2, size), np.uint32),
        np.empty((len(space.edges), size)),
        np.zeros(phases + 1, np.int64),
        np.int64(0),
    )


@part()
def emptied(touching):
    """The same buffers for the pairs of another evaluation."""
    if touching is None:
        return None
    return Touching(touching.ends, touching.drag, touching.phase, np.int64(0))


@part()
def with_pairs(touching, pairs, n, species, forces, space):
    """Those of ``n`` pairs that are within the cutoff as well.

    ``pairs.theta`` holds w / r.
    """
    if touching is None:
        return None
    gamma = gamma_of(forces.friction, forces.exchange)
    share_weights(pairs, n, species, pair_shares(forces.friction, forces.exchange))
    ends, drag, phase, count = touching
    if count + np.int64(n) >= ends.shape[1]:
        size = 2 * (count + np.int64(n))
        ends, drag = columns(ends, count, size), columns(drag, count, size)
    root, weight = np.sqrt(gamma), pairs.theta
    end = np.uint64(count)
    for p in range(n):
        ends[0, end] = pairs.i[p]
        ends[1, end] = pairs.j[p]
        for k in range(len(space.edges)):
            drag[k, end] = root * weight[p] * pairs.separation[k, p]
        end += np.uint64(weight[p] > 0.0)
    return Touching(ends, drag, phase, np.int64(end))


@part()
def gamma_of(friction, exchange):
    """Friction of the pairs that are needed again."""
    if exchange is not None:
        return exchange.gamma
    if friction is not None:
        return friction.gamma
    return 0.0


@part()
def pair_shares(friction, exchange):
    """Shares of pairs of species in that friction; None where it is one for all."""
    if exchange is not None:
        return exchange.shares
    return shares_of(friction)


@part()
def close_phase(touching, phase):
    """Note how many pairs were found up to the end of a phase."""
    if touching is not None:
        touching.phase[phase + 1] = touching.count


@part()
def lose(predicted, velocity, mine):
    """Make the predicted velocity what it has to lose to be the velocity now."""
    add_rows(predicted, velocity, -1.0, mine)


@part()
def renew_friction(total, touching, phase, lost, space):
    """Replace the friction in a force by that of the velocities now, for the pairs of a phase.

    Parameters
    ----------
    total : array with a row for each bead
        The force.
    touching : Touching
    phase : int
    lost : array with a row for each bead
        From `lose`.
    """
    for p in range(np.uint64(touching.phase[phase]), np.uint64(touching.phase[phase + 1])):
        i, j = touching.ends[0, p], touching.ends[1, p]
        pull = difference_along(lost, i, j, touching.drag, p, space)
        push_apart(total, i, j, pull, touching.drag, p, space)
