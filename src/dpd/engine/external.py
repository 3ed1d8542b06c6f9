"""Forces on single beads from outside: walls and body forces. Each thread has its own beads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import uint32

from dpd.engine.moves import velocity_of_friction
from dpd.engine.threads.team import Share, meet
from dpd.jit import part
from dpd.physics.forces import curvature, drag, energy, force, random, weight
from dpd.physics.noise import gaussian_noise, uniform_noise

# The noise of a bead at a wall is that of a pair with a partner that no bead is: another one for
# each wall and axis. Partners above are those of a Langevin thermostat.
FIRST_PARTNER, PER_WALL = 0xFFFFFFFF - 3, 3
ENERGY, PUSH, DRAG = 0, 1, 2  # columns of what is measured of each wall, DRAG with one per axis
DEPTH, BEAD, STEP = 0, 1, 2  # what is noted of a bead behind a wall


class AtWalls(NamedTuple):
    """What is noted of beads at walls during a call.

    Attributes
    ----------
    sums : (walls, 2 + dimension) array
        Of one evaluation of the forces: the `ENERGY` of each wall; its `PUSH`, the sum of what it
        does to beads along its normal into the box; and from `DRAG` on the sum of the friction and
        noise on beads along each axis.
    deepest : (threads, 3) array
        Of each thread the bead that got deepest behind a plane: `DEPTH`, `BEAD` and `STEP`.
    """

    sums: np.ndarray
    deepest: np.ndarray


class Near(NamedTuple):
    """Beads within the range of a wall.

    Attributes
    ----------
    slot, identity : (n,) uint32 arrays
    z : (n,) array
        Distance from the plane, negative behind it.
    push : (n,) array
        Force of the wall along its normal into the box.
    drag : (dimension, n) array
        Friction and noise.
    partner, zeta : (n,) arrays
        Whom the noise is shared with, and the noise.
    """

    slot: np.ndarray
    identity: np.ndarray
    z: np.ndarray
    push: np.ndarray
    drag: np.ndarray
    partner: np.ndarray
    zeta: np.ndarray


@part()
def add_external(team, plan, beads, force, mine, at_walls, now):
    """Add body forces and the forces of walls; measure those of walls if asked.

    Parameters
    ----------
    team : Team
    plan : Plan
    beads : Beads
    force : array with a row for each bead
    mine : Share
        A thread's share of the beads.
    at_walls : AtWalls or None
    now : Evaluation
    """
    add_body_force(force, beads.position, beads.species, mine, plan.forces.body_force)
    if at_walls is not None:
        velocity, walls = velocity_of_friction(beads.velocity, beads.predicted), plan.forces.walls
        deepest = at_walls.deepest[team.rank]
        add_wall_forces(force, velocity, beads, mine, walls, plan.space, deepest, now)
        if now.measure:
            measure_walls(team, velocity, beads, walls, plan.space, at_walls.sums, now)


@part()
def add_body_force(total, position, species, mine, body):
    """Add the body force on a thread's share of the beads.

    Parameters
    ----------
    total, position : arrays with a row for each bead
        The force; in storage order.
    species : (n,) uint8 array or None
    mine : Share
    body : None or BodyForce
    """
    if body is None:
        return
    for s in range(mine.first, mine.end):
        strength = of_species(body.strength, species, s)
        total[s, body.axis] += force(body, strength, position[s, body.across])


@part()
def of_species(values, species, s):
    """The value for the species of bead s."""
    if species is None:
        return values[0]
    return values[species[s]]


@part()
def add_wall_forces(total, velocity, beads, mine, walls, space, deepest, now):
    """Add the forces of walls on a thread's share of the beads; note who is deepest behind them.

    Parameters
    ----------
    total, velocity : arrays with a row for each bead
        The force; the velocity that the friction sees.
    beads : Beads
    mine : Share
    walls : Walls
    space : Space
    deepest : (3,) array
        Of this thread, see `AtWalls`.
    now : Evaluation
    """
    near = near_buffers(mine.end - mine.first, space)
    for wall in range(len(walls.axis)):
        n = find_near(near, beads, mine, walls, wall)
        find_pushes(near, n, beads.species, walls)
        find_drag(near, n, velocity, walls, wall, walls.friction, space, now.keys)
        axis, inward = walls.axis[wall], walls.inward[wall]
        for c in range(n):
            s = near.slot[c]
            total[s, axis] += inward * near.push[c]
            add_drag(total, s, near, c, walls.friction, space)
            if -near.z[c] > deepest[DEPTH]:
                deepest[DEPTH], deepest[BEAD] = -near.z[c], near.identity[c]
                deepest[STEP] = now.step


@part()
def measure_walls(team, velocity, beads, walls, space, sums, now):
    """Add up what each wall does to all beads.

    One thread does, so that the order of the sums, and with it their bits, is always the same.
    The others wait for it before they change velocities.
    """
    if team.rank == 0:
        everybody = Share(np.uint64(0), np.uint64(len(beads.identity)))
        near = near_buffers(everybody.end, space)
        for wall in range(len(walls.axis)):
            n = find_near(near, beads, everybody, walls, wall)
            find_pushes(near, n, beads.species, walls)
            find_drag(near, n, velocity, walls, wall, walls.friction, space, now.keys)
            for c in range(n):
                a = of_species(walls.repulsion, beads.species, near.slot[c])
                sums[wall, ENERGY] += energy(walls, a, near.z[c])
                sums[wall, PUSH] += near.push[c]
                for k in range(len(space.edges)):
                    sums[wall, DRAG + k] += near.drag[k, c]
    meet(team)


@part()
def near_buffers(n, space):
    """Room for n beads."""
    return Near(
        np.empty(n, np.uint32), np.empty(n, np.uint32), np.empty(n), np.empty(n),
        np.zeros((len(space.edges), n)), np.empty(n, np.uint32), np.empty(n),
    )  # fmt: skip


@part()
def find_near(near, beads, mine, walls, wall):
    """Find which of some beads are within the range of a wall; return how many."""
    axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
    n = np.uint64(0)
    for s in range(mine.first, mine.end):
        z = inward * (beads.position[s, axis] - place)
        if z < 1.0:
            near.slot[n] = uint32(s)
            near.identity[n] = beads.identity[s]
            near.z[n] = z
            n += np.uint64(1)
    return n


@part()
def find_pushes(near, n, species, walls):
    """Fill ``near.push[:n]``."""
    for c in range(n):
        a = of_species(walls.repulsion, species, near.slot[c])
        near.push[c] = force(walls, a, near.z[c])


@part()
def find_drag(near, n, velocity, walls, wall, friction, space, keys):
    """Fill ``near.drag[:, :n]``, if the walls have friction."""
    if friction is None:
        return
    for k in range(len(space.edges)):
        for c in range(n):
            near.partner[c] = uint32(FIRST_PARTNER - PER_WALL * wall - k)
        if friction.gaussian:
            gaussian_noise(near.zeta, near.identity, near.partner, n, keys)
        else:
            uniform_noise(near.zeta, near.identity, near.partner, n, keys)
        for c in range(n):
            w = weight(walls, near.z[c])
            relative = velocity[near.slot[c], k] - walls.velocity[wall, k]
            near.drag[k, c] = random(friction, near.zeta[c], w) - drag(friction, relative, w)


@part()
def add_drag(total, s, near, c, friction, space):
    """Add friction and noise on bead c of those near a wall, if the walls have friction."""
    if friction is not None:
        for k in range(len(space.edges)):
            total[s, k] += near.drag[k, c]


@part()
def renew_wall_friction(total, beads, mine, walls, space):
    """Replace the friction in a force by that of the velocities now.

    Parameters
    ----------
    total : array with a row for each bead
        The force.
    beads : Beads
        With what velocities have lost since in the place of the predicted ones, see
        `dpd.engine.second_friction`.
    mine : Share
    walls : None or Walls
    space : Space
    """
    if walls is not None:
        renew_drag(total, beads, mine, walls, walls.friction, space)


@part()
def renew_drag(total, beads, mine, walls, friction, space):
    """The same of walls, if they have friction."""
    if friction is None:
        return
    for wall in range(len(walls.axis)):
        axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
        for s in range(mine.first, mine.end):
            w = weight(walls, inward * (beads.position[s, axis] - place))
            for k in range(len(space.edges)):
                total[s, k] += drag(friction, beads.predicted[s, k], w)


@part()
def add_wall_curvature(total, position, species, walls):
    """Add the forces of walls on all beads; return their part in the Laplacian of the potential."""
    if walls is None:
        return 0.0
    laplacian = 0.0
    for wall in range(len(walls.axis)):
        axis, place, inward = walls.axis[wall], walls.place[wall], walls.inward[wall]
        for s in range(len(position)):
            z = inward * (position[s, axis] - place)
            a = of_species(walls.repulsion, species, s)
            total[s, axis] += inward * force(walls, a, z)
            laplacian += curvature(walls, a, z)
    return laplacian
