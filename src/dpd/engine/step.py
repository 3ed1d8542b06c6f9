"""The step, and the compiled loop over steps.

With f the force, c, lambda and b the coefficients of the scheme (`dpd.physics.schemes`), a step is

    drift              r  += dt v + c dt^2 f
                       v~  = v + lambda dt f,      v += (1 - b) dt f
    sort, list         so that pairs are found
    forces             f   = f(r, v~)
    kick               v  += b dt f
    friction again     f   = f(r, v), in DPD-VV: for the next step
    exchange           of momentum between pairs, in schemes that split friction and noise off

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

from dpd.engine.bond_forces import Bonded, add_bond_forces, batches, find_slots
from dpd.engine.external import AtWalls, add_external, renew_wall_friction
from dpd.engine.masses import divide_by_masses, multiply_by_masses
from dpd.engine.moves import Lost, drift, first_lost, velocity_of_friction
from dpd.engine.neighbours.cells import Cells, Grid, count_cells, move_to_cells, share_cells
from dpd.engine.neighbours.lists import (
    CHUNK,
    empty_list,
    farthest_move,
    listed_pairs,
    renewed_list,
)
from dpd.engine.neighbours.search import new_search, next_pairs, pair_buffers, place_of_piece
from dpd.engine.pair_forces import add_pair_forces, measure_pairs
from dpd.engine.second_friction import (
    close_phase,
    emptied,
    empty_touching,
    lose,
    renew_friction,
    with_pairs,
)
from dpd.engine.slide import slide_to, turn_images
from dpd.engine.space import Space, put_inside, row_edges
from dpd.engine.state import Sums
from dpd.engine.thermostats import (
    add_langevin_forces,
    exchange_momentum,
    renew_langevin_friction,
)
from dpd.engine.threads.borrowed import borrowed
from dpd.engine.threads.team import BATCHES, BLOCKS, meet, new_round, next_task, share_of
from dpd.engine.vectors.rows import add_rows
from dpd.jit import kernel, part
from dpd.physics.forces import Forces
from dpd.physics.noise import Keys, step_keys
from dpd.physics.schemes import Scheme


class Plan(NamedTuple):
    """What stays the same from step to step.

    Attributes
    ----------
    space : Space
    grid : Grid
        Cells with edges of at least 1 + ``skin``.
    forces : Forces
    bonds : Bonded or None
    scheme : Scheme
    dt, skin : float
        Time step; distance beyond the cutoff within which pairs are listed.
    seed : uint64
    inverse_mass : None or (species,) array
        1 / m of each species; None where all masses are 1.
    """

    space: Space
    grid: Grid
    forces: Forces
    bonds: Bonded | None
    scheme: Scheme
    dt: float
    skin: float
    seed: int
    inverse_mass: np.ndarray | None = None


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
        `SLOT` of a bead of each thread's that moved too far, or -1; and the `DISTANCE`.
    at_walls : AtWalls or None
        None without walls.
    image : (n, dimension) int32 array
        Boxes that each identity has crossed.
    """

    cells: Cells
    slot: np.ndarray | None
    virial: np.ndarray
    energy: np.ndarray
    moved: np.ndarray
    lost: np.ndarray
    at_walls: AtWalls | None
    image: np.ndarray


class Span(NamedTuple):
    """Steps of one call.

    Attributes
    ----------
    done : int
        Steps done before: they are the key of the noise.
    steps : int
        0 to evaluate the force where the beads are.
    measure : bool
        Whether the last evaluation adds up virial and energy.
    """

    done: int
    steps: int
    measure: bool


class Evaluation(NamedTuple):
    """One evaluation of the forces.

    Attributes
    ----------
    step : int
    keys : Keys
        Of its noise.
    measure : bool
        Whether virial and energy are added up.
    virial, energy : arrays
        Where to, see `Shared`.
    """

    step: int
    keys: Keys
    measure: bool
    virial: np.ndarray
    energy: np.ndarray


@kernel()
def advance(team, plan, beads, spare, force, reference, shared, span):
    """Advance by some steps, or for 0 steps evaluate the force where the beads are.

    Parameters
    ----------
    team : Team
        All threads of a team call this, with the same arrays.
    plan : Plan
    beads, spare : Beads
        Sorting swaps the two.
    force : array with a row for each bead
        The force on the beads as they are, over their mass if they have one; kept up to date. Zero
        for 0 steps.
    reference : None or array with a row for each bead
        None to find pairs by cells in every step. With a list, where the beads were at the
        last sort, in today's order; kept up to date. 0 steps sort and list afresh.
    shared : Shared
    span : Span

    Returns
    -------
    Beads
        In the order of the last sort by cell; the arrays of ``beads`` or of ``spare``.
    Lost
    """
    swapped, lost = take_steps(
        borrowed(team), borrowed(plan), borrowed(beads), borrowed(spare), borrowed(force),
        borrowed(reference), borrowed(shared), span,
    )  # fmt: skip
    if swapped:
        return spare, lost
    return beads, lost


@part()
def take_steps(team, plan, beads, spare, force, reference, shared, span):
    """Take the steps of `advance`; return whether beads are in ``spare`` in the end, and `Lost`."""
    swapped = False
    mine, edges = share_of(team, len(beads.identity)), row_edges(plan.space)
    listed = empty_list(reference, plan.grid, len(beads.identity))
    touching = empty_touching(
        plan.scheme.renewal, plan.forces.exchange, plan.space, len(beads.identity),
        len(plan.grid.blocks.phase) - 1,
    )  # fmt: skip
    step, waiting = span.done, 0.0
    lost = Lost(np.int64(-1), step, 0.0)
    for s in range(max(span.steps, 1)):
        if span.steps > 0:
            step += 1
        slide_to(plan.space.slide, step)
        if span.steps > 0:
            turn_images(shared.image, beads.identity, mine, plan.space.slide, step, plan.dt)
            drift(beads, force, shared.image, mine, edges, plan, waiting, shared.lost[team.rank])
            shared.moved[team.rank] = farthest_move(beads.position, listed, mine, plan.space)
            meet(team)
            lost = first_lost(shared, beads.identity, step)
            if lost.bead >= 0:
                break
        sort_now = span.steps == 0 or shared.moved.max() > 0.25 * plan.skin * plan.skin
        if sort_now:
            sort_together(team, plan, beads, spare, mine, shared)
            beads, spare = spare, beads
            swapped = not swapped
        if sort_now or s == 0:
            find_slots(shared.slot, beads.identity, mine)
        listed = renewed_list(
            team, plan, beads.position, mine, listed, shared.cells, sort_now, s == 0
        )
        meet(team)
        measure = span.measure and s + 1 >= span.steps
        now = Evaluation(step, step_keys(plan.seed, step), measure, shared.virial, shared.energy)
        touching = add_forces(team, plan, beads, force, shared, listed, touching, now)
        add_langevin(plan, beads, force, mine, now)
        add_external(team, plan, beads, force, mine, shared.at_walls, now)
        divide_by_masses(force, beads.species, mine, plan.inverse_mass)
        if s + 1 < span.steps and kick_can_wait(plan.scheme, plan.forces.exchange):
            waiting = plan.scheme.correction * plan.dt
        elif span.steps > 0:
            finish(team, plan, beads, force, shared.image, mine, edges, touching, now)
    return swapped, lost


@part()
def sort_together(team, plan, source, target, mine, shared):
    """Sort beads by cell, each thread its own."""
    count_cells(source.position, mine, plan.space, plan.grid, shared.cells, team.rank)
    meet(team)
    if team.rank == 0:
        share_cells(shared.cells, plan.grid)
    meet(team)
    move_to_cells(source, target, mine, plan.space, shared.cells, team.rank)
    meet(team)


@part()
def add_forces(team, plan, beads, force, shared, listed, touching, now):
    """Add the forces of bonds and of pairs.

    Returns
    -------
    Touching or None
        The pairs, where the scheme needs them again.
    """
    add_bonds(team, plan, beads, force, shared.slot, now)
    if listed is None:
        touching = add_searched(team, plan, beads, force, shared, emptied(touching), now)
    else:
        touching = add_listed(team, plan, beads, force, shared, listed, emptied(touching), now)
    meet(team)
    new_round(team)
    return touching


@part()
def add_bonds(team, plan, beads, force, slot, now):
    """Add the forces of bonds and of the angles between them, batch by batch."""
    tasks = batches(plan.bonds)
    task = next_task(team, BATCHES, 0, tasks)
    while task < tasks:
        sums = Sums(now.virial[task], now.energy[task])
        add_bond_forces(
            force, beads.position, slot, plan.bonds, task, plan.space, sums, now.measure
        )
        task = next_task(team, BATCHES, 0, tasks)


@part()
def add_searched(team, plan, beads, force, shared, touching, now):
    """Add the forces of pairs that are found by cells, block by block."""
    first_task, blocks = batches(plan.bonds), plan.grid.blocks
    search = new_search(shared.cells, plan.space, plan.grid)
    for phase in range(len(blocks.phase) - 1):
        meet(team)
        first, last = blocks.phase[phase], blocks.phase[phase + 1]
        block = next_task(team, BLOCKS + phase, first, last)
        while block < last:
            task = first_task + block
            for piece in range(blocks.piece[block], blocks.piece[block + 1]):
                at, end = place_of_piece(piece, shared.cells, plan.grid)
                while at.slot < end:
                    at, n = next_pairs(at, end, beads.position, search, 1.0)
                    touching = add_some(plan, beads, force, search.pairs, n, task, touching, now)
            block = next_task(team, BLOCKS + phase, first, last)
        close_phase(touching, phase)
    return touching


@part()
def add_listed(team, plan, beads, force, shared, listed, touching, now):
    """Add the forces of pairs from a list. Pairs in the skin have w = 0 and feel no force."""
    first_task = batches(plan.bonds)
    pairs = pair_buffers(len(plan.space.edges), CHUNK)
    for phase in range(len(plan.grid.blocks.phase) - 1):
        meet(team)
        for q in range(listed.phase[phase], listed.phase[phase + 1]):
            task, end = first_task + listed.block[q], listed.end[q + 1]
            for first in range(listed.end[q], end, CHUNK):
                n = listed_pairs(first, end, beads.position, listed, plan.space, pairs)
                touching = add_some(plan, beads, force, pairs, n, task, touching, now)
        close_phase(touching, phase)
    return touching


@part()
def add_some(plan, beads, force, pairs, n, task, touching, now):
    """Add the forces of ``n`` pairs; measure them if asked, keep them if needed again."""
    velocity = velocity_of_friction(beads.velocity, beads.predicted)
    add_pair_forces(force, pairs, n, velocity, beads, plan, now.keys)
    if now.measure:
        sums = Sums(now.virial[task], now.energy[task])
        measure_pairs(sums, pairs, n, beads.species, plan.forces.pair, plan.space)
    return with_pairs(touching, pairs, n, beads.species, plan.forces, plan.space)


@part()
def add_langevin(plan, beads, force, mine, now):
    """Add the forces of a thermostat that acts on each bead on its own."""
    velocity = velocity_of_friction(beads.velocity, beads.predicted)
    langevin = plan.forces.langevin
    add_langevin_forces(force, velocity, beads, mine, langevin, plan.space, now.keys)


@part()
def kick_can_wait(scheme, exchange):
    """Whether the kick may wait for the next drift, which has beads and force at hand.

    Not where friction or an exchange of momentum follows it.
    """
    return scheme.renewal is None and scheme.middle is None and exchange is None


@part()
def finish(team, plan, beads, force, image, mine, edges, touching, now):
    """What a step does after the force: kick, friction again, exchange of momentum."""
    scheme, exchange, dt = plan.scheme, plan.forces.exchange, plan.dt
    if scheme.middle is None:
        if scheme.correction > 0.0:
            add_rows(beads.velocity, force, scheme.correction * dt, mine)
            take_friction_again(team, plan, beads, force, mine, touching, scheme.renewal)
        exchange_momentum(beads, touching, exchange, plan.inverse_mass, dt, now.keys, plan.space)
    else:
        add_rows(beads.velocity, force, 0.5 * dt, mine)
        exchange_momentum(beads, touching, exchange, plan.inverse_mass, dt, now.keys, plan.space)
        add_rows(beads.velocity, force, 0.5 * dt, mine)
        add_rows(beads.position, beads.velocity, 0.5 * dt, mine)
        put_inside(beads.position, image, beads.identity, mine, edges, plan.space, plan.space.slide)


@part()
def take_friction_again(team, plan, beads, force, mine, touching, renewal):
    """Replace the friction in the force by that of the velocities now, where the scheme does."""
    if renewal is not None:
        multiply_by_masses(force, beads.species, mine, plan.inverse_mass)
        lose(beads.predicted, beads.velocity, mine)
        for phase in range(len(touching.phase) - 1):
            meet(team)
            renew_friction(force, touching, phase, beads.predicted, plan.space)
        meet(team)
        renew_langevin_friction(force, beads.predicted, beads.species, mine, plan.forces.langevin)
        renew_wall_friction(force, beads, mine, plan.forces.walls, plan.space)
        divide_by_masses(force, beads.species, mine, plan.inverse_mass)
