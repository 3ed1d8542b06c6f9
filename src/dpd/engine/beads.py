"""What is done bead by bead: forces of a bath, body forces and walls, and sums that are sampled.

Each thread has its own beads.
"""

from typing import NamedTuple

import numpy as np
from numba import uint32

from dpd.engine.neighbours import PAIRS_AT_ONCE
from dpd.engine.rows import flat
from dpd.engine.state import System
from dpd.engine.threads import Share, barrier
from dpd.jit import inlined
from dpd.physics.common.forces import drag, energy, force, of_bead, random, weight
from dpd.physics.common.noise import fill_noise

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
    fill_noise(near.zeta, near.identity, near.partner, n, keys, gaussian)


@inlined(given="langevin")
def add_bath(f, v, beads, mine, langevin, near, keys, edges):
    for first in range(mine.first, mine.end, PAIRS_AT_ONCE):
        n = min(PAIRS_AT_ONCE, mine.end - first)
        for c in range(n):
            near.identity[c] = beads.identity[first + c]
        for k in range(len(edges)):
            draw(near, n, OF_BATH - k, langevin.gaussian, keys)
            for c in range(n):
                s = first + c
                share = of_bead(langevin.shares, beads.species, s)
                noise = random(langevin, np.sqrt(share) * near.zeta[c], 1.0)
                f[s, k] += noise - drag(langevin, share * v[s, k], 1.0)


@inlined(given="langevin")
def renew_bath(f, excess, species, mine, langevin, edges):
    """Replace the friction in a force by that of the velocities now; see `change_since`."""
    for s in range(mine.first, mine.end):
        share = of_bead(langevin.shares, species, s)
        for k in range(len(edges)):
            f[s, k] += drag(langevin, share * excess[s, k], 1.0)


@inlined(given="body")
def add_body_force(f, x, species, mine, body):
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
            first, n = find_near(near, v, beads, first, mine.end, walls, wall, now.keys, edges)
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
            first, n = find_near(near, v, beads, first, everybody.end, walls, wall, keys, edges)
            for c in range(n):
                a = of_bead(walls.repulsion, beads.species, near.slot[c])
                sums[wall, ENERGY] += energy(walls, a, near.z[c])
                sums[wall, PUSH] += near.push[c]
                for k in range(len(edges)):
                    sums[wall, DRAG + k] += near.drag[k, c]


@inlined()
def find_near(near, v, beads, first, end, walls, wall, keys, edges):
    """Find some beads within the range of a wall, its pushes and its drag on them.

    Return where to go on, and how many they are.
    """
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
    for c in range(n):
        a = of_bead(walls.repulsion, beads.species, near.slot[c])
        near.push[c] = force(walls, a, near.z[c])
    find_drag(near, n, v, walls, wall, walls.friction, keys, edges)
    return s, n


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
    renew_drag(f, excess, x, mine, walls, walls.friction, edges)


@inlined(given="friction")
def renew_drag(f, excess, x, mine, walls, friction, edges):
    for wall in range(len(walls.axis)):
        axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
        for s in range(mine.first, mine.end):
            w = weight(walls, inward * (x[s, axis] - place))
            for k in range(len(edges)):
                f[s, k] += drag(friction, excess[s, k], w)


PER_TASK = 1024  # beads that one thread adds up: the order of sums is the same for any team


class Across(NamedTuple):
    """Cells across a flow: layers along some axes."""

    axis: np.ndarray  # (axes,) int64
    low: np.ndarray  # (axes,): where the first layer begins
    per: np.ndarray  # (axes,): layers in 1 r_c
    layers: np.ndarray  # (axes,) int64: how many


def across_of(system: System) -> Across:
    """The cells across the flow of a system; one, without axes, in a fluid at rest."""
    found = [(axis, *system.layers(axis, thickness)) for axis, thickness in system.flow]
    axis, low, length, layers = np.array(found, float).reshape(-1, 4).T
    return Across(axis.astype(np.int64), low.copy(), layers / length, layers.astype(np.int64))


class Sampled(NamedTuple):
    """Sums of each sample, and those of beads that they are added up from."""

    # (samples, cells, q + 1, q): as `dpd.engine.state.Sums` has them, below each matrix the beads
    moments: np.ndarray
    virial: np.ndarray  # (samples, 2, dimension, dimension)
    energy: np.ndarray  # (samples, 2)
    walls: np.ndarray | None  # (samples, walls, 2 + dimension); None without walls
    place: np.ndarray  # (tasks, axes): where a bead is in its cell
    of_beads: np.ndarray  # (tasks, cells, q + 1, q): of `PER_TASK` beads each; 0 between samples


def sampled_buffers(
    samples: int, beads: int, across: Across, virial: np.ndarray, walls: np.ndarray | None
) -> Sampled:
    """Room for so many samples of what tasks add to a virial, and walls to their sums."""
    tasks, layers = -(-beads // PER_TASK), across.layers
    cells, q = int(np.prod(layers)), virial.shape[2] + 1 + len(layers)
    return Sampled(
        np.empty((samples, cells, q + 1, q)),
        np.empty((samples, *virial.shape[1:])),
        np.empty((samples, 2)),
        None if walls is None else np.empty((samples, *walls.shape)),
        np.zeros((tasks, len(layers))),
        np.zeros((tasks, cells, q + 1, q)),
    )


@inlined()
def add_moments(moments, place, beads, mass, across, some, edges):
    """Add the sums of m w w over some beads, cell by cell; below the matrix, their number.

    With w = (v, 1, s), s being the places of a bead along the axes of its cell, in layers from the
    middle.
    """
    x, v, axes, one = beads.position, beads.velocity, len(across.axis), len(edges)
    for s in range(some.first, some.end):
        m, cell = of_bead(mass, beads.species, s), np.int64(0)
        for a in range(axes):
            along = (x[s, across.axis[a]] - across.low[a]) * across.per[a]
            layer = np.int64(along)
            if layer >= across.layers[a]:
                layer = across.layers[a] - 1
            place[a] = along - layer - 0.5
            cell = cell * across.layers[a] + layer
        into = moments[cell]
        into[one + 1 + axes, 0] += 1.0
        into[one, one] += m
        for k in range(len(edges)):
            momentum = m * v[s, k]
            into[k, one] += momentum
            into[one, k] += momentum
            for q in range(len(edges)):
                into[k, q] += momentum * v[s, q]
            for a in range(axes):
                into[k, one + 1 + a] += momentum * place[a]
                into[one + 1 + a, k] += momentum * place[a]
        for a in range(axes):
            into[one, one + 1 + a] += m * place[a]
            into[one + 1 + a, one] += m * place[a]
            for b in range(axes):
                into[one + 1 + a, one + 1 + b] += m * place[a] * place[b]


@inlined(given="to")
def move_sums(to, k, parts):
    """Put the sums of all tasks in the place of sample k, and zero in theirs."""
    sums, found = flat(to), flat(parts)
    width = sums.shape[0] // to.shape[0]
    for q in range(width):
        total = 0.0
        for p in range(q, found.shape[0], width):
            total += found[p]
            found[p] = 0.0
        sums[k * width + q] = total


@inlined()
def take_sample(team, plan, beads, shared, k):
    barrier(team)  # all have come to the end of the step
    sampled = shared.sampled
    for task in range(team.rank, sampled.place.shape[0], team.size):
        first, end = task * PER_TASK, (task + 1) * PER_TASK
        if end > beads.position.shape[0]:
            end = beads.position.shape[0]
        some = Share(np.uint64(first), np.uint64(end))
        moments, place = sampled.of_beads[task], sampled.place[task]
        add_moments(moments, place, beads, plan.mass, plan.across, some, plan.edges)
    barrier(team)
    if team.rank == 0:
        move_sums(sampled.moments, k, sampled.of_beads)
        move_sums(sampled.virial, k, shared.virial)
        move_sums(sampled.energy, k, shared.energy)
        move_sums(sampled.walls, k, shared.at_walls)
