"""Forces on single beads: a bath, body forces and walls. Each thread has its own beads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import uint32

from dpd.engine.integrate import of_bead, of_bead_or_one
from dpd.engine.search import PAIRS_AT_ONCE
from dpd.engine.threads import Share, barrier
from dpd.jit import inlined
from dpd.physics.common.forces import curvature, drag, energy, force, random, weight
from dpd.physics.common.noise import gaussian_noise, uniform_noise

# The noise of a bead is that of a pair with a partner that no bead is: another one for each axis of
# a bath, and for each wall and axis.
OF_BATH, OF_WALLS, PER_WALL = 0xFFFFFFFF, 0xFFFFFFFF - 3, 3
ENERGY, PUSH, DRAG = 0, 1, 2  # columns of what is measured of each wall, DRAG with one per axis
DEPTH, BEAD, STEP = 0, 1, 2  # what is noted of a bead behind a wall


class Near(NamedTuple):
    """Buffers of one thread for some beads within the range of a wall, or in a bath."""

    # (size,) uint32: the bead, and whom it shares its noise with
    slot: np.ndarray
    identity: np.ndarray
    partner: np.ndarray
    z: np.ndarray  # (size,): distance from the plane, negative behind it
    push: np.ndarray  # (size,): force of the wall along its normal into the box
    drag: np.ndarray  # (dimension, size): friction and noise
    zeta: np.ndarray  # (size,): the noise


def near_buffers(dimension: int) -> Near:
    size = int(PAIRS_AT_ONCE)
    slot, identity, partner = (np.empty(size, np.uint32) for _ in range(3))
    z, push, zeta = (np.empty(size) for _ in range(3))
    return Near(slot, identity, partner, z, push, np.zeros((dimension, size)), zeta)


@inlined()
def draw(near, n, partner, gaussian, keys):
    for c in range(n):
        near.partner[c] = uint32(partner)
    if gaussian:
        gaussian_noise(near.zeta, near.identity, near.partner, n, keys)
    else:
        uniform_noise(near.zeta, near.identity, near.partner, n, keys)


@inlined(given="langevin")
def add_bath(f, v, beads, mine, langevin, near, keys, edges):
    """Add friction and noise on a thread's share of the beads, if there is a bath."""
    for first in range(mine.first, mine.end, PAIRS_AT_ONCE):
        n = min(PAIRS_AT_ONCE, mine.end - first)
        for c in range(n):
            near.identity[c] = beads.identity[first + c]
        for k in range(len(edges)):
            draw(near, n, OF_BATH - k, langevin.gaussian, keys)
            for c in range(n):
                s = first + c
                share = of_bead_or_one(langevin.shares, beads.species, s)
                noise = random(langevin, np.sqrt(share) * near.zeta[c], 1.0)
                f[s, k] += noise - drag(langevin, share * v[s, k], 1.0)


@inlined(given="langevin")
def renew_bath(f, excess, species, mine, langevin, edges):
    """Replace the friction in a force by that of the velocities now; see `change_since`."""
    for s in range(mine.first, mine.end):
        share = of_bead_or_one(langevin.shares, species, s)
        for k in range(len(edges)):
            f[s, k] += drag(langevin, share * excess[s, k], 1.0)


@inlined(given="body")
def add_body_force(f, x, species, mine, body):
    """Add the body force on a thread's share of the beads, if there is one."""
    for s in range(mine.first, mine.end):
        strength = of_bead(body.strength, species, s)
        f[s, body.axis] += force(body, strength, x[s, body.across])


@inlined(given="walls")
def add_walls(team, f, v, beads, mine, walls, near, shared, now, edges):
    """Add the forces of walls; note who is deepest behind them."""
    deepest = shared.deepest[team.rank]
    for wall in range(len(walls.axis)):
        axis, inward = walls.axis[wall], walls.inward[wall]
        first = mine.first
        while first < mine.end:
            first, n = find_near(near, beads, first, mine.end, walls, wall)
            find_pushes(near, n, beads.species, walls)
            find_drag(near, n, v, walls, wall, walls.friction, now.keys, edges)
            for c in range(n):
                s = near.slot[c]
                f[s, axis] += inward * near.push[c]
                for k in range(len(edges)):
                    f[s, k] += near.drag[k, c]
                if -near.z[c] > deepest[DEPTH]:
                    deepest[DEPTH], deepest[BEAD] = -near.z[c], near.identity[c]
                    deepest[STEP] = now.step
    if now.measure:
        # One thread does, so that the order of the sums is always the same. The others wait for it
        # before they change velocities.
        if team.rank == 0:
            measure_walls(shared.at_walls, v, beads, walls, near, now.keys, edges)
        barrier(team)


@inlined()
def measure_walls(sums, v, beads, walls, near, keys, edges):
    """Add up what each wall does to all beads; see `add_walls`."""
    everybody = Share(np.uint64(0), np.uint64(len(beads.identity)))
    for wall in range(len(walls.axis)):
        first = everybody.first
        while first < everybody.end:
            first, n = find_near(near, beads, first, everybody.end, walls, wall)
            find_pushes(near, n, beads.species, walls)
            find_drag(near, n, v, walls, wall, walls.friction, keys, edges)
            for c in range(n):
                a = of_bead(walls.repulsion, beads.species, near.slot[c])
                sums[wall, ENERGY] += energy(walls, a, near.z[c])
                sums[wall, PUSH] += near.push[c]
                for k in range(len(edges)):
                    sums[wall, DRAG + k] += near.drag[k, c]


@inlined()
def find_near(near, beads, first, end, walls, wall):
    """Find some beads within the range of a wall; return where to go on, and how many."""
    axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
    n, s = np.uint64(0), first
    while s < end and n < PAIRS_AT_ONCE:
        z = inward * (beads.position[s, axis] - place)
        if z < 1.0:
            near.slot[n] = uint32(s)
            near.identity[n] = beads.identity[s]
            near.z[n] = z
            n += np.uint64(1)
        s += np.uint64(1)
    return s, n


@inlined()
def find_pushes(near, n, species, walls):
    for c in range(n):
        a = of_bead(walls.repulsion, species, near.slot[c])
        near.push[c] = force(walls, a, near.z[c])


@inlined(given="friction")
def find_drag(near, n, v, walls, wall, friction, keys, edges):
    """Find the drag on ``n`` beads near a wall, if it has friction; else it stays zero."""
    for k in range(len(edges)):
        draw(near, n, OF_WALLS - PER_WALL * wall - k, friction.gaussian, keys)
        for c in range(n):
            w = weight(walls, near.z[c])
            relative = v[near.slot[c], k] - walls.velocity[wall, k]
            near.drag[k, c] = random(friction, near.zeta[c], w) - drag(friction, relative, w)


@inlined(given="walls")
def renew_wall_friction(f, excess, x, mine, walls, edges):
    """Replace the friction in a force by that of the velocities now."""
    renew_drag(f, excess, x, mine, walls, walls.friction, edges)


@inlined(given="friction")
def renew_drag(f, excess, x, mine, walls, friction, edges):
    for wall in range(len(walls.axis)):
        axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
        for s in range(mine.first, mine.end):
            w = weight(walls, inward * (x[s, axis] - place))
            for k in range(len(edges)):
                f[s, k] += drag(friction, excess[s, k], w)


@inlined()
def add_wall_curvature(f, x, species, walls):
    """Add the forces of walls; return their part in the Laplacian of the potential."""
    if walls is None:
        return 0.0
    laplacian = 0.0
    for wall in range(len(walls.axis)):
        axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
        for s in range(len(x)):
            z = inward * (x[s, axis] - place)
            a = of_bead(walls.repulsion, species, s)
            f[s, axis] += inward * force(walls, a, z)
            laplacian += curvature(walls, a, z)
    return laplacian
