"""Drifts and kicks of beads, each thread its own, and the look for beads that got lost."""

from typing import NamedTuple

import numpy as np

from dpd.engine.slide import drift_with_flow
from dpd.engine.space import put_inside
from dpd.engine.threads.team import Share
from dpd.engine.vectors.rows import add_rows, entries
from dpd.jit import part

IN_CACHE = np.uint64(4096)  # beads that stay there from one loop over them to the next
FARTHEST = 1.0  # a bead that moves a cutoff along an axis in one step has lost its way
SLOT, DISTANCE = 0, 1  # what is noted of such a bead


class Lost(NamedTuple):
    """A bead that moved too far: its identity, or -1; the step; how far along an axis."""

    bead: int
    step: int
    distance: float


@part()
def drift(beads, force, image, mine, edges, plan, waiting, lost):
    """Move a thread's share of the beads, predict velocities; note one that moved too far.

    First comes the kick that is still ``waiting``, a time. On return ``velocity`` holds
    v + dt (1 - b) f, ``predicted`` holds v + lambda dt f, and the force is zero, for the next to
    be added up. A scheme with its force in the middle of a step drifts for half of it.
    """
    lost[SLOT] = -1.0
    for first in range(mine.first, mine.end, IN_CACHE):
        some = Share(first, min(mine.end, first + IN_CACHE))
        if waiting > 0.0:
            add_rows(beads.velocity, force, waiting, some)
        drift_some(beads, force, image, some, edges, plan, lost)


@part()
def drift_some(beads, force, image, mine, edges, plan, lost):
    """The same for so few beads that from loop to loop they stay in cache."""
    scheme, dt, space = plan.scheme, plan.dt, plan.space
    time = dt if scheme.middle is None else 0.5 * dt
    half_square = scheme.acceleration * dt * dt
    drift_with_flow(beads, force, mine, time, half_square, space.slide)
    x, v, f = beads.position.ravel(), beads.velocity.ravel(), force.ravel()
    far, (begin, end) = 0, entries(mine, beads.position)
    for q in range(begin, end):
        far += not abs(time * v[q] + half_square * f[q]) <= FARTHEST  # also true for NaN
    if far > 0:
        find_lost(beads.velocity, force, mine, time, half_square, lost)
    predict(beads.predicted, beads.velocity, force, mine, scheme.prediction, dt)
    for q in range(begin, end):
        x[q] += time * v[q] + half_square * f[q]
        v[q] += (1.0 - scheme.correction) * dt * f[q]
        f[q] = 0.0
    put_inside(beads.position, image, beads.identity, mine, edges, space, space.slide)


@part()
def find_lost(velocity, force, mine, time, half_square, lost):
    """Note the first bead that moves too far, and how far along the first such axis."""
    for i in range(mine.first, mine.end):
        for k in range(velocity.shape[1]):
            move = time * velocity[i, k] + half_square * force[i, k]
            if not abs(move) <= FARTHEST and lost[SLOT] < 0.0:
                lost[SLOT], lost[DISTANCE] = i, abs(move)


@part()
def predict(predicted, velocity, force, mine, prediction, dt):
    """Predict velocities, where the prediction is not the velocity itself."""
    if predicted is not None:
        p, v, f = predicted.ravel(), velocity.ravel(), force.ravel()
        begin, end = entries(mine, velocity)
        for q in range(begin, end):
            p[q] = v[q] + prediction * dt * f[q]


@part()
def velocity_of_friction(velocity, predicted):
    """The velocity that the friction sees."""
    if predicted is None:
        return velocity
    return predicted


@part()
def first_lost(shared, identity, step):
    """The first bead that moved too far, if one did."""
    for rank in range(shared.lost.shape[0]):
        slot = np.int64(shared.lost[rank, SLOT])
        if slot >= 0:
            return Lost(np.int64(identity[slot]), step, shared.lost[rank, DISTANCE])
    return Lost(np.int64(-1), step, 0.0)
