"""The compiled loop over steps.

Pairs are found by cells in every step, or, where beads hardly move in a step, listed once
within the cutoff and a skin; the list serves until some bead has moved half the skin.
Between rebuilds the beads stay in the order of the last sort, and the list follows from the
positions at that time (the reference), so a resumed run has the same list in the same order.

Every thread of a team runs this loop. Drifts, kicks and sorts go by beads, each thread with
its own; forces go by batches of bonds and by blocks of cells, whoever is free taking the next.
Blocks come in phases, so that no two threads push the same bead at the same time, and the
order of all sums is that of one thread alone.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.bonds import add_bond_forces, batches, find_slots
from dpd.engine.friction import (
    change_of,
    close_phase,
    keep_pairs,
    kept_buffers,
    renew_friction,
)
from dpd.engine.neighbours.cells import Cells, count_cells, move_to_cells, share_cells
from dpd.engine.neighbours.lists import CHUNK, farthest_move, listed_pairs, listing, no_list
from dpd.engine.neighbours.search import next_pairs, pair_buffers, pairs_of_piece, search_buffers
from dpd.engine.threads.team import (
    BATCHES,
    BLOCKS,
    meet,
    new_round,
    share,
    take,
)
from dpd.engine.vectors.rows import add_rows, entries, put_inside, row_edges
from dpd.jit import kernel, part
from dpd.physics.exchange import exchange_momentum
from dpd.physics.langevin import add_bath_forces, renew_bath_friction
from dpd.physics.noise import step_keys
from dpd.physics.pair import add_pair_forces, measure_pairs

IN_CACHE = np.uint64(4096)  # beads that stay there from one loop over them to the next
FARTHEST = 1.0  # a bead that moves a cutoff along an axis in one step has lost its way


class Shared(NamedTuple):
    """What the threads of a team share.

    Attributes
    ----------
    cells : Cells
    slot : None or (n,) uint32 array
        Of each identity, for bonds.
    virial, energy : (tasks, 2, dimension, dimension) and (tasks, 2) arrays
        Of each batch of bonds, then of each block of cells.
    moved : (threads,) array
        Largest squared distance from the reference among each thread's beads.
    lost : (threads, 2) array
        Slot of a bead of each thread's that moved too far, or -1; and how far.
    """

    cells: Cells
    slot: np.ndarray | None
    virial: np.ndarray
    energy: np.ndarray
    moved: np.ndarray
    lost: np.ndarray


@part()
def seen(velocity, predicted):
    """The velocity that the friction sees."""
    if predicted is None:
        return velocity
    return predicted


@part()
def drift(beads, force, own, edges, dt, scheme, owed, lost):
    """Move the beads from own[0] to own[1], predict velocities; note one that moved too far.

    First comes the time for which the last force has yet to act, ``owed``. On return
    ``velocity`` holds v + dt (1 - b) f, ``predicted`` holds v + lambda dt f, and the force is
    zero, for the next to be added up. A scheme with its force in the middle of a step drifts for
    half of it.
    """
    lost[0] = -1.0
    for first in range(own[0], own[1], IN_CACHE):
        some = first, min(own[1], first + IN_CACHE)
        if owed > 0.0:
            add_rows(beads[1], force, owed, some)
        drift_some(beads, force, some, edges, dt, scheme, lost)


@part()
def drift_some(beads, force, own, edges, dt, scheme, lost):
    """The same for so few beads that from loop to loop they stay in cache."""
    position, velocity, predicted, _, _ = beads
    acceleration, prediction, correction, _, _, middle = scheme
    time = dt if middle is None else 0.5 * dt
    half_square = acceleration * dt * dt
    x, v, f = position.ravel(), velocity.ravel(), force.ravel()
    far, (begin, end) = 0, entries(own, position)
    for q in range(begin, end):
        far += not abs(time * v[q] + half_square * f[q]) <= FARTHEST  # also true for NaN
    if far > 0:
        find_lost(velocity, force, own, time, half_square, lost)
    predict(predicted, velocity, force, own, prediction, dt)
    for q in range(begin, end):
        x[q] += time * v[q] + half_square * f[q]
        v[q] += (1.0 - correction) * dt * f[q]
        f[q] = 0.0
    put_inside(position, own, edges)


@part()
def find_lost(velocity, force, own, time, half_square, lost):
    """Note the first bead that moves too far, and how far along the first such axis."""
    for i in range(own[0], own[1]):
        for k in range(velocity.shape[1]):
            move = time * velocity[i, k] + half_square * force[i, k]
            if not abs(move) <= FARTHEST and lost[0] < 0.0:
                lost[0], lost[1] = i, abs(move)


@part()
def predict(predicted, velocity, force, own, prediction, dt):
    """Predict velocities, where the prediction is not the velocity itself."""
    if predicted is not None:
        p, v, f = predicted.ravel(), velocity.ravel(), force.ravel()
        begin, end = entries(own, velocity)
        for q in range(begin, end):
            p[q] = v[q] + prediction * dt * f[q]


@part()
def any_lost(shared, identity, step):
    """Identity, step and distance of a bead that moved too far; -1 if none did."""
    for rank in range(shared.lost.shape[0]):
        slot = np.int64(shared.lost[rank, 0])
        if slot >= 0:
            return np.int64(identity[slot]), step, shared.lost[rank, 1]
    return -1, step, 0.0


@part()
def sort_together(team, source, target, own, box, grid, shared):
    """Sort beads by cell, each thread its own."""
    count_cells(source[0], own, box, grid, shared.cells, team.rank)
    meet(team)
    if team.rank == 0:
        share_cells(shared.cells, grid)
    meet(team)
    move_to_cells(source, target, own, box, shared.cells, team.rank)
    meet(team)


@part()
def friction_of(fields, exchange):
    """gamma of the pairs that are kept."""
    if exchange is None:
        return fields[1][0]
    return exchange[1]


@part()
def pair_forces(
    beads, force, shared, task, pairs, n, fields, exchange, box, keys, measure, kept, count
):  # fmt: skip
    """Add the forces of ``n`` pairs; keep them after ``count`` others, add up if asked."""
    _, velocity, predicted, identity, species = beads
    velocity = seen(velocity, predicted)
    add_pair_forces(force, pairs, n, velocity, identity, species, box, fields, keys)
    if measure:
        measure_pairs(shared.virial[task], shared.energy[task], pairs, n, species, box, fields)
    return keep_pairs(kept, count, pairs, n, friction_of(fields, exchange), box)


@part()
def add_bonds(team, beads, force, shared, bonds, box, measure):
    """Add the forces of bonds, batch by batch."""
    tasks = batches(bonds)
    task = take(team, BATCHES, 0, tasks)
    while task < tasks:
        virial, energy = shared.virial[task], shared.energy[task]
        add_bond_forces(force, beads[0], shared.slot, bonds, task, box, measure, virial, energy)
        task = take(team, BATCHES, 0, tasks)


@part()
def add_pairs(team, beads, force, shared, listed, fields, exchange, box, grid, keys, measure, kept):
    """Add the forces of pairs, block by block.

    Parameters
    ----------
    listed : None or Listed
        None to find pairs by cells. Pairs in the skin have w = 0 and feel no force.

    Returns
    -------
    None or Kept
        The pairs, where the scheme needs them again.
    """
    count, first_task = 0, batches(fields[3])
    begin, pieces = grid.blocks.phase, grid.blocks.piece
    if listed is None:
        line, pairs = search_buffers(shared.cells, box, grid)
        for phase in range(len(begin) - 1):
            meet(team)
            block = take(team, BLOCKS + phase, begin[phase], begin[phase + 1])
            while block < begin[phase + 1]:
                for piece in range(pieces[block], pieces[block + 1]):
                    at, end = pairs_of_piece(piece, shared.cells, grid)
                    while at[0] < end:
                        at, n = next_pairs(
                            at, end, beads[0], shared.cells, box, grid, 1.0, line, pairs
                        )
                        kept, count = pair_forces(
                            beads, force, shared, first_task + block, pairs, n, fields, exchange,
                            box, keys, measure, kept, count,
                        )  # fmt: skip
                block = take(team, BLOCKS + phase, begin[phase], begin[phase + 1])
            close_phase(kept, phase, count)
    else:
        pairs = pair_buffers(len(box), CHUNK)
        for phase in range(len(begin) - 1):
            meet(team)
            for q in range(listed.phase[phase], listed.phase[phase + 1]):
                end = listed.end[q + 1]
                for first in range(listed.end[q], end, CHUNK):
                    n = listed_pairs(first, end, beads[0], listed, box, pairs)
                    kept, count = pair_forces(
                        beads, force, shared, first_task + listed.block[q], pairs, n, fields,
                        exchange, box, keys, measure, kept, count,
                    )  # fmt: skip
            close_phase(kept, phase, count)
    return kept


@part()
def renew(team, beads, force, own, kept, bath, box, again):
    """Take the friction in a force once more, where the scheme does."""
    _, velocity, predicted, _, _ = beads
    if again is not None:
        change_of(predicted, velocity, own)
        for phase in range(len(kept.phase) - 1):
            meet(team)
            renew_friction(force, kept, phase, predicted, box)
        meet(team)
        renew_bath_friction(force, predicted, own, bath)


@part()
def may_owe(scheme, exchange):
    """Whether the rest of the kick may wait for the next drift, which has beads and force at hand.

    Not where friction or an exchange of momentum follows it.
    """
    return scheme[3] is None and scheme[5] is None and exchange is None


@part()
def finish(team, beads, force, own, kept, fields, exchange, box, edges, dt, scheme, keys):
    """What a step does after the force: the rest of the kick, and of the friction."""
    position, velocity, _, identity, _ = beads
    correction, again, middle = scheme[2], scheme[3], scheme[5]
    if middle is None:
        if correction > 0.0:
            add_rows(velocity, force, correction * dt, own)
            renew(team, beads, force, own, kept, fields[5], box, again)
        exchange_momentum(velocity, identity, kept, exchange, fields[2], dt, keys, box)
    else:
        add_rows(velocity, force, 0.5 * dt, own)
        exchange_momentum(velocity, identity, kept, exchange, fields[2], dt, keys, box)
        add_rows(velocity, force, 0.5 * dt, own)
        add_rows(position, velocity, 0.5 * dt, own)
        put_inside(position, own, edges)


@kernel()
def advance(
    team, beads, spare, shared, reference, force, fields, exchange, box, grid, skin, dt, scheme,
    seed, step, steps, measure,
):  # fmt: skip
    """Advance by ``steps`` steps, or for 0 steps evaluate the force where the beads are.

    Parameters
    ----------
    team : Team
        All threads of a team call this, with the same arrays.
    beads, spare : (position, velocity, predicted, identity, species)
        Arrays with a row for each bead, (n,) uint32, and (n,) uint8 or None; ``predicted`` is
        None where the velocity at that time is what is predicted. Sorting swaps the two.
    shared : Shared
    reference : None or array with a row for each bead
        None to find pairs by cells in every step. With a list, where the beads were at the
        last sort, in today's order; kept up to date. 0 steps sort and list afresh.
    force : array with a row for each bead
        The force on the beads as they are; kept up to date. Zero for 0 steps.
    fields : (repulsion, (gamma, sigma / sqrt(dt)), gaussian, bonds, core, bath)
        See `dpd.physics.pair`, `dpd.engine.bonds`, `dpd.physics.langevin`.
    exchange : None or (kind, gamma, kT)
        See `dpd.physics.exchange`; the thermostat of a scheme that splits it off. Pairs go
        one after the other: for a team of one.
    grid : Grid
        Cells with edges of at least 1 + ``skin``.
    skin : float
        Distance beyond the cutoff within which pairs are listed.
    scheme : Coefficients
    step : int
        Steps done so far: the key of the noise.
    measure : bool
        Whether the last evaluation adds up virial and energy.

    Returns
    -------
    beads : as above
        In the order of the last sort by cell; the arrays of ``beads`` or of ``spare``.
    lost : (bead, step, distance)
        Identity of a bead that moved too far, or -1.
    """
    source, target = beads, spare
    own, edges = share(team, len(beads[3])), row_edges(box)
    listed = no_list(reference, grid, len(beads[3]))
    phases = len(grid.blocks.phase) - 1
    kept = kept_buffers(scheme[3], scheme[4], len(box), 4 * len(beads[3]), phases)
    lost, owed = (-1, step, 0.0), 0.0
    for s in range(max(steps, 1)):
        if steps > 0:
            step += 1
            drift(source, force, own, edges, dt, scheme, owed, shared.lost[team.rank])
            shared.moved[team.rank] = farthest_move(source[0], reference, own, box)
            meet(team)
            lost = any_lost(shared, source[3], step)
            if lost[0] >= 0:
                break
        sort_now = steps == 0 or shared.moved.max() > 0.25 * skin * skin
        if sort_now:
            sort_together(team, source, target, own, box, grid, shared)
            source, target = target, source
        if sort_now or s == 0:
            find_slots(shared.slot, source[3], own)
        listed = listing(
            team, reference, source[0], own, sort_now, s == 0, listed, shared.cells, box, grid, skin
        )
        meet(team)
        keys = step_keys(seed, step)
        last = measure and s + 1 >= steps
        add_bonds(team, source, force, shared, fields[3], box, last)
        kept = add_pairs(
            team, source, force, shared, listed, fields, exchange, box, grid, keys, last, kept
        )
        meet(team)
        new_round(team)
        velocity = seen(source[1], source[2])
        add_bath_forces(force, velocity, source[3], own, fields[5], fields[2], box, keys)
        if s + 1 < steps and may_owe(scheme, exchange):
            owed = scheme[2] * dt
        elif steps > 0:
            finish(team, source, force, own, kept, fields, exchange, box, edges, dt, scheme, keys)
    return source, lost
