"""The step, and the compiled loop over steps.

With f the force, c, lambda and b the coefficients of the scheme (see `dpd.physics.integrator`), a
step is

    drift              r  += dt v + c dt^2 f
                       v~  = v + lambda dt f,      v += (1 - b) dt f
    sort, list         so that pairs are found
    densities          rho, which many-body forces go with
    forces             f   = f(r, v~)
    kick               v  += b dt f
    friction again     f   = f(r, v), in DPD-VV: for the next step
    exchange           of momentum between pairs, in schemes that split friction and noise off

A list of pairs follows from places that lie ahead of the beads when it is made (the reference), in
the order of the sort of that time, so a resumed run has the same list in the same order.

Every thread of a team runs this loop. Drifts, kicks and sorts go by beads, each thread with its
own; forces go by batches of bonds and by blocks of cells, whoever is free taking the next, in the
order of sums of one thread alone. No kernel makes an array: where a buffer turns out to be too
small, the call ends, and Python makes it again with a larger one.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine import space
from dpd.engine.beads import Across, Near, Sampled, add_bath, add_body_force, add_walls, take_sample
from dpd.engine.forces import Arms, Bonded, Cached, add_bonded, add_some, close_phase, find_slots
from dpd.engine.integrate import (
    Lost,
    Times,
    divide_by_masses,
    drift,
    finish,
    first_lost,
    look_ahead,
    slide_to,
)  # fmt: skip
from dpd.engine.neighbours import (
    Line,
    Listed,
    Pairs,
    Search,
    list_pairs,
    listed_pairs,
    longest_line,
    next_pairs,
    place_of_piece,
)
from dpd.engine.rows import first_given
from dpd.engine.threads import BLOCKS, barrier, new_round, next_task, share_of
from dpd.jit import inlined, kernel
from dpd.physics.common.forces import Forces
from dpd.physics.common.noise import Keys, step_keys
from dpd.physics.integrator import Scheme

OF_LINE, OF_LIST, OF_CACHED = 0, 1, 2  # kinds of room


class Plan(NamedTuple):
    """What stays the same from step to step."""

    edges: tuple  # of the box
    slide: space.Slide | None
    grid: space.Grid  # cells with edges of at least 1 + ``skin``
    forces: Forces
    bonds: Bonded | None
    angles: Bonded | None
    scheme: Scheme
    times: Times  # of the scheme
    # whether a kick may wait for the next drift: not where friction or an exchange follows it
    kick_waits: bool
    dt: float
    skin: float  # distance beyond the cutoff within which pairs are listed
    ahead: float  # time by which the places that they are listed at are ahead of the beads
    seed: int
    mass: np.ndarray | None  # (species,): None where all are 1
    across: Across  # cells across a flow, in which sums over beads are kept apart


class Shared(NamedTuple):
    """What the threads of a team share."""

    cells: space.Cells
    slot: np.ndarray | None  # (n,) uint32: of each identity, for bonds
    density: np.ndarray | None  # (n,): local densities, for many-body forces
    virial: np.ndarray  # (tasks, 2, dimension, dimension): of batches of bonds, then of blocks
    energy: np.ndarray  # (tasks, 2)
    moved: np.ndarray  # (threads,): largest squared distance of a bead from the reference
    lost: np.ndarray  # (threads, 2): see `dpd.engine.integrate.find_lost`
    # (walls, 2 + dimension), of one evaluation: the `ENERGY` of each wall; its `PUSH` on beads
    # along its normal into the box; and from `DRAG` on the friction and noise along each axis
    at_walls: np.ndarray | None
    deepest: np.ndarray | None  # (threads, 3): bead deepest behind a plane: `DEPTH`, `BEAD`, `STEP`
    image: np.ndarray  # (n, dimension) int32: boxes that each identity has crossed
    excess: np.ndarray | None  # rows: see `change_since`; None where friction is taken once
    sampled: Sampled
    need: np.ndarray  # (threads, 3) int64: what there must be room for, in `Own.room`


class Own(NamedTuple):
    """Buffers of one thread; None for what a scene does without."""

    wrap: np.ndarray  # see `dpd.engine.integrate.row_edges`
    line: Line
    pairs: Pairs
    listed: Listed | None
    cached: Cached | None
    arms: Arms | None  # for bonds, and for one side of angles
    others: Arms | None  # for the other side
    near: Near | None
    room: np.ndarray  # (3,) int64: size of the line, of the list and of the cache


class Span(NamedTuple):
    """The steps of one call."""

    done: int  # steps done before: they are the key of the noise
    steps: int  # 0 to evaluate the force where the beads are
    listed: bool  # whether the list at the reference is still in the buffers, from the call before
    samples: np.ndarray  # (samples,) int64: steps after which sums are taken, the earliest first
    measure: bool  # whether they are taken of virial and energy too


class Evaluation(NamedTuple):
    """One evaluation of the forces."""

    step: int
    keys: Keys  # of its noise
    measure: bool  # whether virial and energy are added up


@kernel()
def advance(team, plan, beads, spare, force, shared, own, span):
    """Advance by some steps, or for 0 steps sort and evaluate the force where the beads are.

    All threads of a team call this, with the same arrays but their own. ``force`` is over the mass;
    zero for 0 steps. Without a reference pairs are found by cells in every step. Return whether
    the beads are in ``spare`` in the end; a bead that moved too far; and whether ``shared.need`` is
    more than the buffers hold. In both cases the call has no result.
    """
    edges, slide, grid, times = plan.edges, plan.slide, plan.grid, plan.times
    image, mine = shared.image, share_of(team, len(beads.identity))
    need, room = shared.need[team.rank], own.room
    step, pending, swapped, short, taken = span.done, 0.0, False, False, 0
    lost = Lost(np.int64(-1), step, 0.0)
    for s in range(max(span.steps, 1)):
        if span.steps > 0:
            step += 1
            slide_to(step, image, beads.identity, mine, plan.dt, slide)
            drift(team, plan, beads, force, mine, shared, own, pending)
            barrier(team)
            lost = first_lost(shared.lost, beads.identity, step)
            if lost.bead >= 0:
                break
        sort_now = span.steps == 0 or farthest(shared.moved) > 0.25 * plan.skin * plan.skin
        if sort_now:
            look_ahead(plan, beads, mine, beads.reference)
            places = first_given(beads.reference, beads.position)
            sort_together(team, places, mine, shared.cells, grid, edges, slide)
            space.move_beads(beads, spare, mine, shared.cells.place, edges)
            barrier(team)
            beads, spare = spare, beads
            places = first_given(beads.reference, beads.position)
            space.copy_single(shared.cells.single, places, mine, edges, slide)
            swapped = not swapped
        if sort_now or s == 0:
            find_slots(shared.slot, beads.identity, mine)
        first = s == 0 and not span.listed
        renew_list(team, plan, beads.reference, mine, shared, own, sort_now, first)
        if sort_now:
            need[OF_LINE] = longest_line(shared.cells.most, grid)
        barrier(team)
        short = is_short(shared.need, room)
        if short:
            break
        sample_now = taken < len(span.samples) and step == span.samples[taken]
        now = Evaluation(step, step_keys(plan.seed, step), span.measure and sample_now)
        search = Search(shared.cells, grid, own.line, own.pairs, edges, slide)
        find_densities(team, plan, beads, mine, shared.density, shared, own, search)
        add_bonded(team, plan, beads.position, force, plan.bonds, shared, own, now.measure)
        need[OF_CACHED] = add_pairs(
            team, plan, beads, force, shared, own, search, 1.0, own.listed, now
        )
        barrier(team)
        new_round(team)
        short = is_short(shared.need, room)
        if short:
            break
        v, forces = first_given(beads.predicted, beads.velocity), plan.forces
        add_bath(force, v, beads, mine, forces.langevin, own.near, now.keys, edges)
        add_body_force(force, beads.position, beads.species, mine, forces.body_force)
        add_walls(team, force, v, beads, mine, forces.walls, own.near, shared, now, edges)
        divide_by_masses(force, beads.species, mine, plan.mass)
        pending = 0.0
        if s + 1 < span.steps and plan.kick_waits and not sample_now:
            pending = times.kick
        elif span.steps > 0:
            finish(team, plan, beads, force, mine, shared, own, now.keys)
        if sample_now:
            take_sample(team, plan, beads, shared, taken)
            taken += 1
    return swapped, lost, short


@inlined()
def farthest(moved):
    most = moved[0]
    for rank in range(1, moved.shape[0]):
        most = max(most, moved[rank])
    return most


@inlined()
def sort_together(team, x, mine, cells, grid, edges, slide):
    start, _, cell, place, free, most = cells
    space.count_cells(x, mine, cell, free[team.rank], edges, grid.shape, slide)
    barrier(team)
    if team.rank == 0:
        space.share_cells(start, free, most)
    barrier(team)
    space.find_places(place, mine, cell, free[team.rank])


@inlined()
def is_short(need, room):
    """Whether a thread needs more room than there is: all find the same."""
    short = False
    for rank in range(need.shape[0]):
        for kind in range(need.shape[1]):
            short |= need[rank, kind] > room[kind]
    return short


@inlined(given="reference")
def renew_list(team, plan, reference, mine, shared, own, sorted_now, first):
    """Make the list after a sort, and in a call's first step from the reference it was given.

    Without a sort beads are in the order of the one before: each goes to its own place.
    """
    cells, need = shared.cells, shared.need[team.rank]
    if first and not sorted_now:
        sort_together(team, reference, mine, cells, plan.grid, plan.edges, plan.slide)
        space.copy_single(cells.single, reference, mine, plan.edges, plan.slide)
    if sorted_now or first:
        barrier(team)
        need[OF_LINE] = longest_line(cells.most, plan.grid)
        if need[OF_LINE] <= own.room[OF_LINE]:
            search = Search(cells, plan.grid, own.line, own.pairs, plan.edges, plan.slide)
            need[OF_LIST] = list_pairs(team, search, 1.0 + plan.skin, own.listed)


@inlined(given="density")
def find_densities(team, plan, beads, mine, density, shared, own, search):
    for i in range(mine.first, mine.end):
        density[i] = 0.0
    reach = plan.forces.many_body.range
    add_pairs(team, plan, beads, None, shared, own, search, reach, own.listed, None)
    barrier(team)
    new_round(team)
    barrier(team)  # before anyone takes a task


@inlined()
def add_pairs(team, plan, beads, force, shared, own, search, cutoff, listed, now):
    """Add the forces of pairs, block by block; return how many are cached, or need room for that.

    Pairs in the skin of a list have w = 0. Without a force, local densities are added up.
    """
    count = np.int64(0)
    x, first_task = beads.position, shared.virial.shape[0] - (len(plan.grid.blocks.piece) - 1)
    rows, piece, phases = plan.grid.blocks
    start, levels = search.cells.start, plan.grid.shape[len(plan.edges) - 1]
    for phase in range(len(phases) - 1):
        barrier(team)
        if listed is None:
            first, last = phases[phase], phases[phase + 1]
            block = next_task(team, BLOCKS + phase, first, last)
            while block < last:
                task = first_task + block
                for q in range(piece[block], piece[block + 1]):
                    at, end = place_of_piece(q, rows, start, levels)
                    while at.slot < end:
                        at, n = next_pairs(at, end, x, search, cutoff)
                        count = add_some(plan, beads, force, shared, own, n, task, count, now)
                block = next_task(team, BLOCKS + phase, first, last)
        else:
            for q in range(listed.phase[phase], listed.phase[phase + 1]):
                task, first, end = first_task + listed.block[q], listed.end[q], listed.end[q + 1]
                while first < end:
                    first, n = listed_pairs(first, end, x, listed.pairs, search)
                    count = add_some(plan, beads, force, shared, own, n, task, count, now)
        close_phase(own.cached, phase, count)
    return count
