"""How beads move once forces are known: drifts, kicks, friction again, exchange of momentum.

Each thread moves beads of its own, as if all masses were 1: in a scene with masses each row of the
forces is divided by the mass of its bead once all are added up, and then holds accelerations.

Friction depends on velocities that it changes itself. The DPD-VV scheme (Besold, Vattulainen,
Karttunen and Polson 2000) takes it with the predicted velocities during the step and replaces it by
that of the final ones before the next, while conservative and random forces stay.
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.beads import renew_bath, renew_wall_friction
from dpd.engine.neighbours import PAIRS_AT_ONCE
from dpd.engine.rows import difference_along, flat, push_apart
from dpd.engine.state import System
from dpd.engine.threads import Share, barrier
from dpd.jit import inlined
from dpd.physics.common.forces import change, of_bead, of_pair
from dpd.physics.common.noise import Keys, fill_noise, pair_word
from dpd.physics.integrator import SHARDLOW, Scheme

ENTRIES = 256  # entries of rows whose edges are written out, for a loop without a look at the axis
IN_CACHE = np.uint64(256)  # beads that stay there from one loop over them to the next
FAST = 4.0  # times sqrt(kT / m), of a fast bead: lists then last longest
FARTHEST = 1.0  # a bead that moves a cutoff along an axis in one step has lost its way
SLOT, DISTANCE = 0, 1  # what is noted of such a bead
PER_WORD = 1.0 / 2**32  # a 32-bit word to [0, 1)


class Lost(NamedTuple):
    """A bead that moved too far: its identity, or -1; the step; how far along an axis."""

    bead: int
    step: int
    distance: float


class Times(NamedTuple):
    """What a drift multiplies with."""

    # dt, or half of it where a scheme has its force in the middle of a step, and c dt^2
    drift: float
    half_square: float
    prediction: float  # lambda dt
    half_kick: float  # with the force at the beginning of a step, (1 - b) dt
    kick: float  # with the new one, b dt, or half of that where the force is in the middle


def times_of(scheme: Scheme, dt: float) -> Times:
    return Times(
        0.5 * dt if scheme.middle else dt, scheme.acceleration * dt * dt,
        (scheme.prediction or 0.0) * dt, (1.0 - scheme.correction) * dt,
        scheme.correction * (0.5 * dt if scheme.middle else dt),
    )  # fmt: skip


def row_edges(edges: tuple[float, ...], width: int) -> np.ndarray:
    """(3, `ENTRIES`): edges as rows have them, 1 for padding; their inverses; room for boxes."""
    padded = np.ones(width)
    padded[: len(edges)] = edges
    repeated = np.tile(padded, ENTRIES // width)
    return np.stack([repeated, 1.0 / repeated, np.zeros(ENTRIES)])


@inlined()
def add_rows(target, source, times, mine):
    to, more, width = flat(target), flat(source), np.uint64(target.shape[1])
    for q in range(mine.first * width, mine.end * width):
        to[q] += times * more[q]


@inlined()
def drift(team, plan, beads, f, mine, shared, own, kick):
    """Move a thread's share of the beads, predict velocities; note one that moved too far.

    In the end ``v`` holds v + dt (1 - b) f, ``predicted`` v + lambda dt f, and ``f`` is zero.
    ``kick`` is the part of the last step's kick that this begins with: b dt, or 0 if it was done.
    """
    x, v, times, edges = beads.position, beads.velocity, plan.times, plan.edges
    lost, farthest = shared.lost[team.rank], 0.0
    lost[SLOT] = -1.0
    for first in range(mine.first, mine.end, IN_CACHE):
        some = Share(first, min(mine.end, first + IN_CACHE))
        if kick > 0.0:
            add_rows(v, f, kick, some)
        drift_with_flow(x, v, f, beads.peculiar, some, times.drift, times.half_square, plan.slide)
        if move_too_far(v, f, some, times):
            find_lost(v, f, some, times, edges, lost)
        predict(beads.predicted, v, f, some, times.prediction)
        move(x, v, f, some, times)
        put_inside(x, shared.image, beads.identity, some, own.wrap, edges, plan.slide)
        farthest = max(farthest, farthest_move(x, beads.reference, some, own.wrap, edges))
    shared.moved[team.rank] = farthest


@inlined()
def move_too_far(v, f, mine, times):
    velocity, force, width, far = flat(v), flat(f), np.uint64(v.shape[1]), 0
    for q in range(mine.first * width, mine.end * width):
        far += not abs(times.drift * velocity[q] + times.half_square * force[q]) <= FARTHEST
    return far > 0


@inlined()
def find_lost(v, f, mine, times, edges, lost):
    """Note the first bead that moves too far, and how far along the first such axis."""
    for i in range(mine.first, mine.end):
        for k in range(len(edges)):
            way = abs(times.drift * v[i, k] + times.half_square * f[i, k])
            if not way <= FARTHEST and lost[SLOT] < 0.0:
                lost[SLOT], lost[DISTANCE] = i, way


@inlined(given="predicted")
def predict(predicted, v, f, mine, prediction):
    to, velocity, force, width = flat(predicted), flat(v), flat(f), np.uint64(v.shape[1])
    for q in range(mine.first * width, mine.end * width):
        to[q] = velocity[q] + prediction * force[q]


@inlined()
def move(x, v, f, mine, times):
    place, velocity, force, width = flat(x), flat(v), flat(f), np.uint64(v.shape[1])
    for q in range(mine.first * width, mine.end * width):
        place[q] += times.drift * velocity[q] + times.half_square * force[q]
        velocity[q] += times.half_kick * force[q]
        force[q] = 0.0


@inlined()
def put_inside(x, image, identity, mine, wrap, edges, slide):
    """Move beads to their image in the box, and count the boxes."""
    if slide is not None:
        put_inside_sliding(x, image, identity, mine, edges, slide)
        return
    entries, width = flat(x), np.uint64(x.shape[1])
    begin, end = mine.first * width, mine.end * width
    for first in range(begin, end, np.uint64(ENTRIES)):
        size = min(np.uint64(ENTRIES), np.uint64(end - first))
        outside = 0.0
        for t in range(size):
            edge = wrap[0, t]
            boxes = np.floor(entries[first + t] * wrap[1, t])
            inside = entries[first + t] - edge * boxes
            entries[first + t] = max(inside, 0.0) if inside < edge else 0.0  # by rounding
            wrap[2, t] = boxes if inside < edge else boxes + 1.0
            outside += abs(wrap[2, t])
        if outside > 0.0:
            bead = np.uint64(first // width)
            for t in range(np.uint64(0), size, width):
                for k in range(len(edges)):
                    count_box(image, identity[bead], k, wrap[2, t + np.uint64(k)])
                bead += np.uint64(1)


def time_ahead(system: System) -> float:
    """Time in which a fast bead moves by half the skin; 0 where none is known to move."""
    lightest = 1.0 if system.masses is None else np.min(system.masses)
    fast = FAST * np.sqrt(system.kT / lightest)
    return float(0.5 * system.skin / fast) if fast > 0.0 else 0.0


@inlined(given="reference")
def look_ahead(plan, beads, mine, reference):
    """Let a list be made where beads will be about half way through its life.

    A list lasts until a bead is half the skin away from its place in the reference. A bead that
    keeps its velocity comes up to a place ahead of it, and goes as far again behind it. So in W2
    and W3 lists last 1.7 times as long as with places where beads are. No place is further ahead
    than half the skin, or it would be too far away at once.
    """
    x, v, edges, half = beads.position, beads.velocity, plan.edges, 0.5 * plan.skin
    for i in range(mine.first, mine.end):
        v2, by = 0.0, plan.ahead
        for k in range(len(edges)):
            v2 += v[i, k] * v[i, k]
        if by * by * v2 > half * half:
            by = half / np.sqrt(v2)
        for k in range(len(edges)):
            place = x[i, k] + by * v[i, k]
            inside = place - edges[k] * np.floor(place / edges[k])
            reference[i, k] = max(inside, 0.0) if inside < edges[k] else 0.0  # by rounding


@inlined()
def farthest_move(x, reference, mine, wrap, edges):
    """Largest squared distance of a bead from the reference; infinity without a list."""
    if reference is None:
        return np.inf
    here, there, width = flat(x), flat(reference), np.uint64(x.shape[1])
    begin, end, room, farthest = mine.first * width, mine.end * width, np.uint64(wrap.shape[1]), 0.0
    for first in range(begin, end, room):
        size = min(room, np.uint64(end - first))
        for t in range(size):
            apart = here[first + t] - there[first + t]
            apart -= wrap[0, t] * np.rint(apart * wrap[1, t])
            wrap[2, t] = apart * apart
        for t in range(np.uint64(0), size, width):
            r2 = 0.0
            for k in range(len(edges)):
                r2 += wrap[2, t + np.uint64(k)]
            farthest = max(farthest, r2)
    return farthest


@inlined()
def count_box(image, bead, k, boxes):
    if boxes != 0.0:
        image[bead, k] += np.int32(boxes)


@inlined()
def put_inside_sliding(x, image, identity, mine, edges, slide):
    """The same in the upright box, with boxes counted along the tilted lattice."""
    flow, gradient, tilt = slide.flow, slide.gradient, slide.tilt[0]
    height = edges[gradient]
    for i in range(mine.first, mine.end):
        up = np.floor(x[i, gradient] / height)
        inside = x[i, gradient] - height * up
        if inside >= height:  # by rounding: it is the lower end of the next image
            inside = 0.0
            up += 1.0
        x[i, gradient] = max(inside, 0.0)
        x[i, flow] -= up * tilt * height
        count_box(image, identity[i], gradient, up)
        for k in range(len(edges)):
            if k != gradient:
                edge = edges[k]
                boxes = np.floor(x[i, k] / edge)
                inside = x[i, k] - edge * boxes
                x[i, k] = max(inside, 0.0) if inside < edge else 0.0
                count_box(image, identity[i], k, boxes if inside < edge else boxes + 1.0)


@inlined()
def tilt_at(slide, step):
    slid = np.int64(np.uint64(slide.parts * np.uint64(step) + slide.begun))
    return slid / 2.0**64 * slide.ratio


@inlined(given="slide")
def slide_to(step, image, identity, mine, dt, slide):
    """Put the images where they are at a step, and count whole edges by which the tilt falls back.

    A bead that is images above is as many times those edges further along the flow.
    """
    slide.tilt[0] = tilt_at(slide, step)
    ahead = tilt_at(slide, step - 1) + slide.rate * dt - slide.tilt[0]
    boxes = np.int32(np.rint(ahead / slide.ratio))
    if boxes != 0:
        for i in range(mine.first, mine.end):
            bead = identity[i]
            image[bead, slide.flow] += boxes * image[bead, slide.gradient]


@inlined(given="slide")
def drift_with_flow(x, v, f, peculiar, mine, time, half_square, slide):
    """Do to a thread's share of the beads what the flow does to the drift that follows.

    The drift takes ``time`` and adds half_square f. A bead keeps its velocity v, so that about the
    flow changes with the way along the gradient, and x grows by time v. Its way by itself is what
    remains when the flow has carried it as at the middle of that way.
    """
    flow, gradient = slide.flow, slide.gradient
    for i in range(mine.first, mine.end):
        across = time * v[i, gradient] + half_square * f[i, gradient]
        x[i, flow] += time * slide.rate * (x[i, gradient] + across)
        v[i, flow] -= slide.rate * across
        along = time * v[i, flow] + half_square * f[i, flow]
        peculiar[i] += along + 0.5 * time * slide.rate * across


@inlined()
def first_lost(lost, identity, step):
    for rank in range(lost.shape[0]):
        slot = np.int64(lost[rank, SLOT])
        if slot >= 0:
            return Lost(np.int64(identity[slot]), step, lost[rank, DISTANCE])
    return Lost(np.int64(-1), step, 0.0)


@inlined(given="middle")
def second_half(beads, f, image, mine, wrap, plan, middle):
    """Kick and drift once more, in a scheme with its force in the middle of a step."""
    add_rows(beads.velocity, f, plan.times.kick, mine)
    add_rows(beads.position, beads.velocity, plan.times.drift, mine)
    put_inside(beads.position, image, beads.identity, mine, wrap, plan.edges, plan.slide)


@inlined(given="mass")
def divide_by_masses(f, species, mine, mass):
    for i in range(mine.first, mine.end):
        inverse = 1.0 / of_bead(mass, species, i)
        for k in range(f.shape[1]):
            f[i, k] *= inverse


@inlined(given="mass")
def multiply_by_masses(f, species, mine, mass):
    for i in range(mine.first, mine.end):
        for k in range(f.shape[1]):
            f[i, k] *= of_bead(mass, species, i)


@inlined()
def change_since(excess, f, mine, time):
    """By how much the velocity that friction has seen exceeds that after a kick of that time."""
    to, force, width = flat(excess), flat(f), np.uint64(f.shape[1])
    for q in range(mine.first * width, mine.end * width):
        to[q] = -time * force[q]


@inlined(given="exchange")
def exchange_momentum(beads, cached, exchange, mass, pairs, plan, keys):
    """Let pairs exchange momentum, one after the other, in the order in which they were found.

    Each finds the velocities that the pairs before it have left.
    """
    v, identity, species = beads.velocity, beads.identity, beads.species
    dt, edges = plan.dt, plan.edges
    drag, theta, of_i, of_j = cached.drag, pairs.theta, pairs.of_i, pairs.of_j
    swapped = Keys(keys.second, keys.first)  # numbers that the noise has not drawn
    count = np.uint64(cached.phase[len(cached.phase) - 1])
    for first in range(np.uint64(0), count, PAIRS_AT_ONCE):
        n = min(PAIRS_AT_ONCE, count - first)
        for p in range(n):
            of_i[p] = identity[cached.ends[0, first + p]]
            of_j[p] = identity[cached.ends[1, first + p]]
        gaussian = exchange.gaussian or exchange.kind != SHARDLOW
        fill_noise(theta, of_i, of_j, n, keys, gaussian)
        for p in range(n):
            q = first + p
            i, j = cached.ends[0, q], cached.ends[1, q]
            square, u = 0.0, difference_along(v, i, j, drag, q, edges)
            for k in range(len(edges)):
                square += drag[k, q] * drag[k, q]
            if square == 0.0:  # two beads at the same point have no line between them
                continue
            root = np.sqrt(square)
            rate = exchange.gamma * of_pair(exchange.shares, species, i, j)
            drawn = PER_WORD * pair_word(of_i[p], of_j[p], swapped) < rate * dt
            a, b = 1.0 / of_bead(mass, species, i), 1.0 / of_bead(mass, species, j)
            mean = 0.5 * (a + b)  # 1 / (2 mu), with the reduced mass mu
            scale = np.sqrt(mean)
            gained = change(exchange, u / (root * scale), square * dt * mean, theta[p], drawn)
            momentum = 0.5 * gained * scale / (mean * root)
            for k in range(len(edges)):
                v[i, k] += a * momentum * drag[k, q]
                v[j, k] -= b * momentum * drag[k, q]


@inlined()
def finish(team, plan, beads, force, mine, shared, own, keys):
    add_rows(beads.velocity, force, plan.times.kick, mine)
    take_friction_again(team, plan, beads, force, mine, own.cached, shared.excess)
    exchange = plan.forces.exchange
    exchange_momentum(beads, own.cached, exchange, plan.mass, own.pairs, plan, keys)
    second_half(beads, force, shared.image, mine, own.wrap, plan, plan.scheme.middle)


@inlined(given="excess")
def take_friction_again(team, plan, beads, force, mine, cached, excess):
    """Replace the friction in a force by that of the velocities now, of pairs phase by phase."""
    species, edges, forces = beads.species, plan.edges, plan.forces
    ends, drag = cached.ends, cached.drag
    change_since(excess, force, mine, plan.times.kick)
    multiply_by_masses(force, species, mine, plan.mass)
    for phase in range(len(cached.phase) - 1):
        barrier(team)
        for p in range(np.uint64(cached.phase[phase]), np.uint64(cached.phase[phase + 1])):
            i, j = ends[0, p], ends[1, p]
            pull = difference_along(excess, i, j, drag, p, edges)
            push_apart(force, i, j, pull, drag, p, edges)
    barrier(team)
    renew_bath(force, excess, species, mine, forces.langevin, edges)
    renew_wall_friction(force, excess, beads.position, mine, forces.walls, edges)
    divide_by_masses(force, species, mine, plan.mass)
