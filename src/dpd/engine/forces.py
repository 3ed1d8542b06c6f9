"""Forces of pairs of beads, of bonds, and of the angles between them.

Of pairs some hundred at a time: what each pair needs is gathered first, then the forces of all are
worked out in one loop that the compiler makes into vectors, then the beads are pushed. Loops over
axes count to the length of a tuple, which the compiler knows; to that of an array the loops over
pairs would not vectorise.

Of bonds in batches that threads share. A batch holds whole molecules, and so all beads of their
angles: the thread that works on its bonds goes on with its angles, and no other thread pushes these
beads meanwhile.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import uint32, uint64

from dpd.engine import lanes, rows
from dpd.engine.neighbours import FOUR, fill_up
from dpd.engine.space import nearest_images
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_BONDS, OF_PAIRS, System
from dpd.engine.threads import BATCHES, next_task
from dpd.jit import inlined
from dpd.physics.common.forces import energy, force, law_of, of_pair, weight
from dpd.physics.common.noise import fill_noise

CLOSEST = 1e-30  # keeps e finite for two beads at the same point; their force is zero


class Cached(NamedTuple):
    """Pairs that a step needs again after its forces."""

    ends: np.ndarray  # (2, size) uint32: slots
    # (dimension, size): sqrt(gamma) w e of each, whose square is its friction; 0 for pairs in the
    # skin of a list, as to leave them out takes longer where there is no list
    drag: np.ndarray
    phase: np.ndarray  # (phases + 1,) int64: how many were found before each phase, and in all
    root: np.ndarray  # (species, species): sqrt(gamma) of each pair of species


def cache_buffers(dimension: int, size: int, phases: int, gamma: np.ndarray) -> Cached:
    return Cached(
        np.empty((2, size), np.uint32), np.empty((dimension, size)),
        np.zeros(phases + 1, np.int64), np.sqrt(gamma),
    )  # fmt: skip


@inlined()
def inverse_root(x):
    """1 / sqrt(x) within 0.6 ulp: in single precision, and a step that cubes the error."""
    y = np.float64(np.float32(1.0) / np.sqrt(np.float32(x)))
    error = 1.0 - x * y * y
    return y + y * error * (0.5 + 0.375 * error)


@inlined(given="friction")
def gather_friction(pairs, n, v, beads, friction, edges, slide, keys):
    """Find the approach r_ij . v_ij and the random number of ``n`` pairs."""
    i, j, separation, of_i, of_j = pairs.i, pairs.j, pairs.separation, pairs.of_i, pairs.of_j
    approach, theta = pairs.approach, pairs.theta
    for p in range(uint64(0), n, FOUR):
        rows.differences_along(approach, p, v, i, j, separation, edges)
    for p in range(n):
        of_i[p], of_j[p] = beads.identity[i[p]], beads.identity[j[p]]
    if slide is not None:  # and the flow between the two
        for p in range(n):
            apart = separation[slide.flow, p] * separation[slide.gradient, p]
            approach[p] += slide.rate * apart
    fill_noise(theta, of_i, of_j, n, keys, friction.gaussian)
    share_friction(pairs, n, beads.species, friction.shares)


@inlined(given="shares")
def share_friction(pairs, n, species, shares):
    """Make gamma_ij and sigma_ij^2 of each pair its share of theirs."""
    for p in range(n):
        share = of_pair(shares, species, pairs.i[p], pairs.j[p])
        pairs.approach[p] *= share
        pairs.theta[p] *= np.sqrt(share)


@inlined(given="many_body")
def add_densities(density, pairs, n, many_body, edges):
    """Add to the local densities of the beads of ``n`` pairs what each is to the other."""
    i, j, separation, more = pairs.i, pairs.j, pairs.separation, pairs.crowd
    for p in range(n):
        more[p] = weight(many_body, length(separation, p, edges))
    for p in range(n):
        density[i[p]] += more[p]
        density[j[p]] += more[p]


@inlined(given="density")
def gather_crowds(pairs, n, density):
    for p in range(n):
        pairs.crowd[p] = density[pairs.i[p]] + density[pairs.j[p]]


@inlined()
def add_pair_forces(f, pairs, n, species, pair, many_body, friction, edges):
    """Add the forces of ``n`` pairs; leave F / r and w / r of each."""
    i, j, separation, repulsion = pairs.i, pairs.j, pairs.separation, pairs.repulsion
    approach, theta, crowd = pairs.approach, pairs.theta, pairs.crowd
    force_over_r, weight_over_r = pairs.force_over_r, pairs.weight_over_r
    if species is not None:
        for p in range(n):
            repulsion[p] = pair.repulsion[species[i[p]], species[j[p]]]
    for p in range(n):
        r2 = CLOSEST
        for k in range(len(edges)):
            r2 += separation[k, p] * separation[k, p]
        inverse = inverse_root(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = pair.repulsion[0, 0] if species is None else repulsion[p]
        conservative = force(pair, a, r, w) + force(many_body, crowd[p], r)
        thermal = force(friction, approach[p], inverse, w, theta[p])
        force_over_r[p] = inverse * (conservative + thermal)
        weight_over_r[p] = w * inverse
    push_all(f, i, j, force_over_r, separation, n, edges)


@inlined()
def push_all(f, i, j, scale, along, n, edges):
    """Push the beads of ``n`` pairs apart, at four places in turns.

    Pairs that follow each other often share a bead, and one would wait for the other.
    """
    quarter = n // FOUR
    whole = quarter // FOUR * FOUR
    for first in range(uint64(0), whole, FOUR):
        rows.push_sixteen(f, i, j, scale, along, first, quarter, edges)
    for first in range(whole, quarter):
        for p in range(first, FOUR * quarter, quarter):
            rows.push_apart(f, i[p], j[p], scale[p], along, p, edges)
    for p in range(FOUR * quarter, n):
        rows.push_apart(f, i[p], j[p], scale[p], along, p, edges)


@inlined()
def measure_pairs(virial, sums, pairs, n, species, pair, many_body, edges):
    """Add the virials sum r_ij F_ij and the energy of ``n`` pairs to those of a task.

    Element by element: what is added up in one loop is then in registers.
    """
    total, over_r, conservative = 0.0, pairs.force_over_r, pairs.conservative_over_r
    for p in range(n):
        r2 = CLOSEST
        for k in range(len(edges)):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = inverse_root(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = pair.repulsion[0, 0] if species is None else pairs.repulsion[p]
        conservative[p] = (force(pair, a, r, w) + force(many_body, pairs.crowd[p], r)) * inverse
        total += energy(pair, a, r, w) + energy(many_body, pairs.crowd[p], r)
    sums[OF_PAIRS] += total
    for k in range(len(edges)):
        for m in range(k, len(edges)):
            of_conservative, of_all = 0.0, 0.0
            for p in range(n):
                moment = pairs.separation[k, p] * pairs.separation[m, p]
                of_conservative += conservative[p] * moment
                of_all += over_r[p] * moment
            virial[CONSERVATIVE, k, m] += of_conservative
            virial[ALL_FORCES, k, m] += of_all
            if m > k:
                virial[CONSERVATIVE, m, k] += of_conservative
                virial[ALL_FORCES, m, k] += of_all


@inlined()
def cache_pairs(cached, count, pairs, n, species, edges):
    """Cache ``n`` pairs; return how many are, or how many there would have to be room for."""
    if cached is None:
        return count
    ends, drag, end = cached.ends, cached.drag, np.uint64(count)
    if count + np.int64(n) > ends.shape[1]:
        return max(count, ends.shape[1]) + np.int64(n)
    for p in range(n):
        ends[0, end + p] = pairs.i[p]
        ends[1, end + p] = pairs.j[p]
    for p in range(n):
        weight = of_pair(cached.root, species, pairs.i[p], pairs.j[p]) * pairs.weight_over_r[p]
        for k in range(len(edges)):
            drag[k, end + p] = weight * pairs.separation[k, p]
    return np.int64(end + n)


@inlined(given="cached")
def close_phase(cached, phase, count):
    cached.phase[phase + 1] = count


@inlined()
def add_some(plan, beads, force, shared, own, n, task, count, now):
    pair, many_body, friction = plan.forces.pair, plan.forces.many_body, plan.forces.friction
    edges, species, pairs = plan.edges, beads.species, own.pairs
    if force is None:
        add_densities(shared.density, pairs, n, many_body, edges)
        return count
    gather_crowds(pairs, n, shared.density)
    v = rows.first_given(beads.predicted, beads.velocity)
    gather_friction(pairs, n, v, beads, friction, edges, plan.slide, now.keys)
    add_pair_forces(force, pairs, n, species, pair, many_body, friction, edges)
    if now.measure:
        virial, sums = shared.virial[task], shared.energy[task]
        measure_pairs(virial, sums, pairs, n, species, pair, many_body, edges)
    return cache_pairs(own.cached, count, pairs, n, species, edges)


BONDS_AT_ONCE = 512  # in a batch, or a few more: their buffers stay in cache


class Bonded(NamedTuple):
    """The bonds of a system, or its angles, in the same batches."""

    law: Any  # what acts in each
    members: np.ndarray  # (n, 2 or 3) uint32: identities, that in the middle of an angle as second
    batch: np.ndarray  # (batches + 1,) int64: where each begins, and the end


class Arms(NamedTuple):
    """Buffers for some bonds, or for one side of some angles."""

    # (size,) uint32: slots of the two beads
    i: np.ndarray
    j: np.ndarray
    apart: np.ndarray  # (dimension, size): r_i - r_j at the nearest image
    scale: np.ndarray  # (size,): F / r of a bond
    push: np.ndarray  # (dimension, size): what an angle does to bead i


class Opening(NamedTuple):
    """The shape of an angle i-j-k, as its forces need it."""

    theta: float
    cosine: float
    sine: float
    # one over the lengths of the two bonds; 0 for a bond without a length
    over_i: float
    over_k: float


def bonds_of(system: System) -> Bonded | None:
    """Bonds, cut into batches between molecules that are numbered one after the other."""
    if system.bond is None:
        return None
    members = np.ascontiguousarray(system.members, dtype=np.uint32)
    highest = np.maximum.accumulate(members.max(axis=1))
    lowest = np.minimum.accumulate(members.min(axis=1)[::-1])[::-1]
    cuts = 1 + np.flatnonzero(highest[:-1] < lowest[1:])
    batch = [0]  # type: list[int | np.integer]
    for cut in cuts:
        if cut - batch[-1] >= BONDS_AT_ONCE:
            batch.append(cut)
    batch.append(len(members))
    return Bonded(_as_compiled(system.bond), members, np.array(batch, np.int64))


def angles_of(system: System, bonds: Bonded | None) -> Bonded | None:
    """Angles, cut into the batches of the bonds between them."""
    if system.angle is None or bonds is None:
        return None
    members = np.ascontiguousarray(system.angle_members, dtype=np.uint32)
    # Batches are cut between molecules, where all numbers of beads go up.
    lowest = np.minimum.reduceat(bonds.members.min(axis=1), bonds.batch[:-1])
    of_batch = np.searchsorted(lowest, members.min(axis=1), side="right") - 1
    order = np.argsort(of_batch, kind="stable")
    batch = np.searchsorted(of_batch[order], np.arange(len(lowest) + 1)).astype(np.int64)
    law = _as_compiled(system.angle)
    if law.number is not None:
        law = law._replace(number=law.number[order])
    return Bonded(law, members[order], batch)


def _as_compiled(law):
    """A law or a table with the types that kernels are compiled for."""
    *values, number = law
    if number is None:
        return type(law)(*map(float, values), None)
    columns = (np.ascontiguousarray(value, dtype=np.float64) for value in values)
    return type(law)(*columns, np.ascontiguousarray(number, dtype=np.uint16))


def buffers_of(dimension: int, *bonded: Bonded | None) -> Arms | None:
    there = [each for each in bonded if each is not None]
    if not there:
        return None
    size = max(int(np.diff(each.batch).max()) for each in there) + lanes.LANES
    return Arms(
        np.empty(size, np.uint32), np.empty(size, np.uint32), np.empty((dimension, size)),
        np.empty(size), np.empty((dimension, size)),
    )  # fmt: skip


@inlined(given="slot")
def find_slots(slot, identity, mine):
    for s in range(mine.first, mine.end):
        slot[identity[s]] = uint32(s)


@inlined()
def gather(arms, bonded, task, x, slot, outer, edges, slide):
    """Fill the arms of a batch, from members 1 to those in column ``outer`` or, of bonds, back.

    Return the first of the batch, and how many there are.
    """
    i, j, apart, members = arms.i, arms.j, arms.apart, bonded.members
    begin, n = uint64(bonded.batch[task]), uint64(bonded.batch[task + 1] - bonded.batch[task])
    for b in range(n):
        i[b], j[b] = slot[members[begin + b, outer]], slot[members[begin + b, 1]]
    fill_up(i, j, n)
    for b in range(uint64(0), n, FOUR):
        rows.apart_to_columns(apart, b, x, i, j, edges, slide, None, None)
    nearest_images(apart, n, edges, slide)
    return begin, n


@inlined()
def length(apart, b, edges):
    """Length of column ``b``, at least such that one may divide by it."""
    r2 = CLOSEST
    for k in range(len(edges)):
        r2 += apart[k, b] * apart[k, b]
    return np.sqrt(r2)


@inlined(given="arms")
def add_bonds(f, x, slot, bonds, task, arms, virial, sums, measure, edges, slide):
    """Add the forces of a batch of bonds, if there are any; if asked, their virial and energy."""
    first, n = gather(arms, bonds, task, x, slot, 0, edges, slide)
    apart, over_r = arms.apart, arms.scale
    for b in range(n):
        r2 = CLOSEST
        for k in range(len(edges)):
            r2 += apart[k, b] * apart[k, b]
        inverse = inverse_root(r2)
        over_r[b] = force(law_of(bonds.law, first + b), r2 * inverse) * inverse
    push_all(f, arms.i, arms.j, over_r, apart, n, edges)
    if measure:
        for b in range(n):
            sums[OF_BONDS] += energy(law_of(bonds.law, first + b), length(apart, b, edges))
            for k in range(len(edges)):
                add_moment(virial, k, over_r[b] * apart[k, b], apart, b, edges)


@inlined(given="bonds")
def add_bonded(team, plan, x, force, bonds, shared, own, measure):
    batches, slot, edges, slide = len(bonds.batch) - 1, shared.slot, plan.edges, plan.slide
    task = next_task(team, BATCHES, 0, batches)
    while task < batches:
        virial, energy = shared.virial[task], shared.energy[task]
        add_bonds(force, x, slot, bonds, task, own.arms, virial, energy, measure, edges, slide)
        add_angles(
            force, x, slot, plan.angles, task, own.arms, own.others, virial, energy, measure,
            edges, slide,
        )  # fmt: skip
        task = next_task(team, BATCHES, 0, batches)


@inlined()
def add_moment(virial, k, push, apart, b, edges):
    for m in range(len(edges)):
        virial[CONSERVATIVE, m, k] += apart[m, b] * push
        virial[ALL_FORCES, m, k] += apart[m, b] * push


@inlined()
def over_length(apart, b, edges):
    """One over the length of column ``b``; 0 for no length, where there is no direction."""
    r2 = 0.0
    for k in range(len(edges)):
        r2 += apart[k, b] * apart[k, b]
    return np.sqrt(r2) / (r2 + CLOSEST)


@inlined()
def opening(to_i, to_k, b, edges):
    """The angle between columns ``b`` of two (dimension, n) arrays.

    The sine is taken from the part of one bond across the other: of the cosine near a straight
    angle it would be the root of a rounding error.
    """
    over_i, over_k = over_length(to_i, b, edges), over_length(to_k, b, edges)
    cosine, across = 0.0, 0.0
    for k in range(len(edges)):
        cosine += to_i[k, b] * over_i * (to_k[k, b] * over_k)
    for k in range(len(edges)):
        aside = to_k[k, b] * over_k - cosine * (to_i[k, b] * over_i)
        across += aside * aside
    sine = np.sqrt(across)
    return Opening(np.arctan2(sine, cosine), cosine, sine, over_i, over_k)


@inlined(given="angles")
def add_angles(f, x, slot, angles, task, arms, others, virial, sums, measure, edges, slide):
    """Add the forces of a batch of angles, if there are any; if asked, their virial and energy.

    With e_i and e_k along the bonds from the middle bead, r_i and r_k their lengths, and F the
    derivative -du/dtheta, bead i feels -F (e_k - cos(theta) e_i) / (r_i sin(theta)), bead k the
    same with i and k exchanged, and the middle bead the opposite of both. In a straight angle no
    direction is across, and where F is not 0 there either, the force is 0.
    """
    gather(arms, angles, task, x, slot, 0, edges, slide)
    first, n = gather(others, angles, task, x, slot, 2, edges, slide)
    law, to_i, to_k, push_i, push_k = angles.law, arms.apart, others.apart, arms.push, others.push
    for a in range(n):
        at = opening(to_i, to_k, a, edges)
        across = -force(law_of(law, first + a), at.theta) * at.sine / (at.sine * at.sine + CLOSEST)
        for k in range(len(edges)):
            e_i, e_k = to_i[k, a] * at.over_i, to_k[k, a] * at.over_k
            push_i[k, a] = across * at.over_i * (e_k - at.cosine * e_i)
            push_k[k, a] = across * at.over_k * (e_i - at.cosine * e_k)
        if measure:
            sums[OF_BONDS] += energy(law_of(law, first + a), at.theta)
    for a in range(n):
        rows.push_apart(f, arms.i[a], arms.j[a], 1.0, push_i, a, edges)
        rows.push_apart(f, others.i[a], others.j[a], 1.0, push_k, a, edges)
    if measure:
        for a in range(n):
            for k in range(len(edges)):
                add_moment(virial, k, push_i[k, a], to_i, a, edges)
                add_moment(virial, k, push_k[k, a], to_k, a, edges)
