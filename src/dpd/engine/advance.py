"""The compiled loop over steps.

Pairs are found by cells in every step, or, where beads hardly move in a step, listed once
within the cutoff and a skin; the list serves until some bead has moved half the skin.
Between rebuilds the beads stay in the order of the last sort, and the list follows from the
positions at that time (the reference), so a resumed run has the same list in the same order.
"""

import numpy as np

from dpd.engine.bath import add_bath_forces
from dpd.engine.bonds import add_bond_forces, bonded_slots
from dpd.engine.cells import cell_buffers, empty_like, sort_by_cell
from dpd.engine.exchange import exchange_momentum
from dpd.engine.forces import add_pair_forces, measure_pairs
from dpd.engine.friction import keep_pairs, kept_buffers, renew_friction
from dpd.engine.jit import kernel, part
from dpd.engine.lists import CHUNK, listed_pairs, listing, moved_too_far, no_list
from dpd.engine.noise import step_keys
from dpd.engine.search import next_pairs, pair_buffers, search_buffers

FARTHEST = 1.0  # a bead that moves a cutoff along an axis in one step has lost its way


@part()
def put_inside(x, edge):
    """The image of a coordinate that lies in the box."""
    x -= edge * np.floor(x / edge)
    return x if x < edge else 0.0


@part()
def finish(beads, force, kept, count, fields, exchange, box, dt, scheme, keys):
    """What a step does after the force: the rest of the kick, and of the friction."""
    position, velocity, predicted, identity, _ = beads
    correction, middle = scheme[2], scheme[5]
    if middle is None:
        if correction > 0.0:
            correct(velocity, force, correction * dt)
            renew_friction(force, kept, count, velocity, predicted, fields[5], box, scheme[3])
        exchange_momentum(velocity, identity, kept, count, exchange, fields[2], dt, keys, box)
    else:
        correct(velocity, force, 0.5 * dt)
        exchange_momentum(velocity, identity, kept, count, exchange, fields[2], dt, keys, box)
        correct(velocity, force, 0.5 * dt)
        for k in range(len(box)):
            for i in range(velocity.shape[1]):
                position[k, i] = put_inside(position[k, i] + 0.5 * dt * velocity[k, i], box[k])


@part()
def drift(position, velocity, predicted, force, box, dt, scheme):
    """Move beads, predict velocities; return a bead that moved too far, or -1.

    On return ``velocity`` holds v + dt (1 - b) f, ``predicted`` holds v + lambda dt f. A
    scheme with its force in the middle of a step drifts for half of it.
    """
    acceleration, prediction, correction, _, _, middle = scheme
    time = dt if middle is None else 0.5 * dt
    lost, distance = -1, 0.0
    for k in range(len(box)):
        edge = box[k]
        for i in range(position.shape[1]):
            f, v = force[k, i], velocity[k, i]
            move = time * v + acceleration * dt * dt * f
            if lost < 0 and not abs(move) <= FARTHEST:  # also true for NaN
                lost, distance = i, abs(move)
            position[k, i] = put_inside(position[k, i] + move, edge)
            predicted[k, i] = v + prediction * dt * f
            velocity[k, i] = v + (1.0 - correction) * dt * f
    return lost, distance


@part()
def correct(velocity, force, share):
    """Add that share of the force to the velocity."""
    for k in range(velocity.shape[0]):
        for i in range(velocity.shape[1]):
            velocity[k, i] += share * force[k, i]


@part()
def friction_of(fields, exchange):
    """gamma of the pairs that are kept."""
    if exchange is None:
        return fields[1][0]
    return exchange[1]


@part()
def pair_forces(
    beads, force, pairs, n, fields, exchange, box, keys, measure, sums, kept, count
):  # fmt: skip
    """Add the forces of ``n`` pairs; keep them after ``count`` others, add up if asked."""
    _, _, predicted, identity, species = beads
    virial, energy = sums
    add_pair_forces(force, pairs, n, predicted, identity, species, box, fields, keys)
    if measure:
        measure_pairs(virial, energy, pairs, n, box, fields[4])
    return keep_pairs(kept, count, pairs, n, friction_of(fields, exchange), box)


@part()
def total_force(
    beads, force, cells, listed, slots, fields, exchange, box, grid, keys, measure, sums, kept
):  # fmt: skip
    """Evaluate all forces on sorted beads; add virial and energy to ``sums`` if asked.

    Parameters
    ----------
    listed : None or (2, n) array
        None to find pairs by cells. Pairs in the skin have w = 0 and feel no force.

    Returns
    -------
    None or Kept, int
        The pairs, where the scheme needs them again, and their number.
    """
    position, _, predicted, identity, _ = beads
    force[:] = 0.0
    count = 0
    if listed is None:
        line, pairs = search_buffers(cells.start, box, grid)
        at = (0, -1)
        while at[0] < position.shape[1]:
            at, n = next_pairs(at, position, cells, box, grid, 1.0, line, pairs)
            kept, count = pair_forces(
                beads, force, pairs, n, fields, exchange, box, keys, measure, sums, kept, count
            )
    else:
        pairs = pair_buffers(len(box), CHUNK)
        for first in range(0, listed.shape[1], CHUNK):
            n = listed_pairs(first, position, listed, box, pairs)
            kept, count = pair_forces(
                beads, force, pairs, n, fields, exchange, box, keys, measure, sums, kept, count
            )
    add_bond_forces(force, position, slots, fields[3], box, measure, sums)
    add_bath_forces(force, predicted, identity, fields[5], fields[2], box, keys)
    return kept, count


@kernel()
def advance(
    beads, reference, force, fields, exchange, box, grid, skin, dt, scheme, seed, step, steps,
    measure,
):  # fmt: skip
    """Advance by ``steps`` steps, or for 0 steps evaluate the force where the beads are.

    Parameters
    ----------
    beads : (position, velocity, identity, species)
        (dimension, n) arrays, (n,) uint32 and (n,) uint8 or None.
    reference : None or (dimension, n) array
        None to find pairs by cells in every step. With a list, where the beads were at the
        last sort, in today's order; 0 steps sort and list afresh.
    force : (dimension, n) array
        The force on the beads as they are; ignored for 0 steps.
    fields : (repulsion, (gamma, sigma / sqrt(dt)), gaussian, bonds, core, bath)
        See `dpd.engine.forces`, `dpd.engine.bonds`, `dpd.engine.bath`.
    exchange : None or (kind, gamma, kT)
        See `dpd.engine.exchange`; the thermostat of a scheme that splits it off.
    grid : Grid
        Cells with edges of at least 1 + ``skin``.
    skin : float
        Distance beyond the cutoff within which pairs are listed.
    step : int
        Steps done so far: the key of the noise.
    measure : bool
        Whether the last evaluation adds up virial and energy.

    Returns
    -------
    beads, reference : as above, in the order of the last sort by cell
    force : (dimension, n) array
    sums : (virial, energy)
        (2, dimension, dimension) and (2,) arrays: conservative and full virial; pair and
        bond energy. Zero unless measured.
    lost : (bead, step, distance)
        Identity of a bead that moved too far, or -1.
    """
    position, velocity, identity, species = beads
    source = (position, velocity, velocity.copy(), identity, species)
    target = empty_like(source)
    cells = cell_buffers(grid, position.shape[1])
    sums = (np.zeros((2, len(box), len(box))), np.zeros(2))
    kept = kept_buffers(scheme[3], scheme[4], len(box), 4 * position.shape[1])
    lost = (-1, step, 0.0)
    listed = no_list(reference)
    slots = bonded_slots(fields[3], identity)
    for s in range(max(steps, 1)):
        if steps > 0:
            step += 1
            bead, distance = drift(source[0], source[1], source[2], force, box, dt, scheme)
            if bead >= 0:
                lost = (np.int64(source[3][bead]), step, distance)
                break
        sort_now = steps == 0 or moved_too_far(source[0], reference, box, 0.5 * skin)
        if sort_now:
            sort_by_cell(source, target, box, grid, cells)
            source, target = target, source
            slots = bonded_slots(fields[3], source[3])
        reference, listed = listing(
            reference, source[0], sort_now, s == 0, listed, cells, box, grid, skin
        )
        keys = step_keys(seed, step)
        last = measure and s + 1 >= steps
        kept, count = total_force(
            source, force, cells, listed, slots, fields, exchange, box, grid, keys, last, sums, kept
        )
        if steps > 0:
            finish(source, force, kept, count, fields, exchange, box, dt, scheme, keys)
    return (source[0], source[1], source[3], source[4]), reference, force, sums, lost
