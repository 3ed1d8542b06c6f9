"""Conservative forces: where in a box their virial lies, and the curvature of their potential."""

from typing import Any, NamedTuple

import numpy as np

from dpd.engine import forces
from dpd.engine.forces import CLOSEST
from dpd.engine.measure import Sorted, sorted_beads
from dpd.engine.neighbours import first_place, near_pairs
from dpd.engine.rows import push_apart, rows_of
from dpd.engine.state import State, System
from dpd.engine.threads import Share
from dpd.jit import inlined, kernel
from dpd.physics.common.forces import curvature, energy, force, law_of, of_bead, of_pair, slope

NORMAL, TANGENTIAL = 0, 1
SHORTEST = 1e-12  # slices that a line has to cross to be cut: below it lies in one slice


class Acting(NamedTuple):
    """Conservative forces, and what their loops need; None for what a system does without."""

    pair: Any
    many_body: Any
    density: np.ndarray | None  # (n,): about the bead in each slot
    bonds: forces.Bonded | None  # in one batch, as angles are
    angles: forces.Bonded | None
    identity: np.ndarray  # (n,) uint32
    slot: np.ndarray | None  # (n,) uint32: where to put that of each identity
    arms: forces.Arms | None
    others: forces.Arms | None


def acting_on(system: System, state: State, beads: Sorted) -> Acting:
    density, bonds, d = None, _whole(forces.bonds_of(system)), system.dimension
    if system.many_body is not None:
        density = np.zeros(len(beads.bead))
        _add_densities(density, beads, system.many_body)
    angles = None if bonds is None else _whole(forces.angles_of(system, bonds))
    slot = None if bonds is None else np.empty(len(beads.bead), np.uint32)
    arms, others = forces.buffers_of(d, bonds, angles), forces.buffers_of(d, angles)
    pair = system.forces.pair
    return Acting(
        pair, system.many_body, density, bonds, angles, state.identity, slot, arms, others
    )


def _whole(bonded):
    if bonded is None:
        return None
    return bonded._replace(batch=np.array([0, len(bonded.members)], np.int64))


@kernel()
def _add_densities(density, beads, law):
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = near_pairs(at, len(beads.bead), beads.ordered, beads.search, law.range)
        forces.add_densities(density, beads.search.pairs, n, law, beads.search.edges)


class Slices(NamedTuple):
    """Equal slices across an axis, in r_c, that cover the box or, between walls, all beads."""

    axis: int
    number: int
    low: float
    high: float


def virial_in_slices(system: System, state: State, slices: Slices) -> np.ndarray:
    """The conservative virial in slices across an axis, after Irving and Kirkwood (1950).

    What a pair adds to the virial, r_ij F_ij, is spread evenly along the straight line between its
    beads at their nearest images, and each slice gets the share of the line that lies in it. So do
    bonds. In an angle i-j-k the force on bead i passes along the bond from j to i, and that on bead
    k along the bond from j to k; the middle bead feels the opposite of both. Forces of walls and
    body forces are left out. Returned is a (2, slices) array in kT: the `NORMAL` element of the
    virial, and the `TANGENTIAL` one, which is the mean over the other axes.
    """
    beads, virial = sorted_beads(state.position, system.box, 1.0), np.zeros((2, 3, slices.number))
    species = None if state.species is None else state.species[beads.bead]
    unused = np.zeros_like(beads.x), np.zeros((2, system.dimension, system.dimension)), np.zeros(2)
    acting = acting_on(system, state, beads)
    _add_virial(virial.reshape(2, -1), beads, species, acting, slices, unused)
    virial[TANGENTIAL] /= system.dimension - 1
    return virial.sum(axis=1)  # of the box, and of an image on either side, where lines may end


@kernel()
def _add_virial(virial, beads, species, acting, slices, unused):
    search, n_beads, pair = beads.search, len(beads.bead), acting.pair
    pairs, edges = search.pairs, search.edges
    slot, arms, others = acting.slot, acting.arms, acting.others
    at = first_place()
    while at.slot < n_beads:
        at, n = near_pairs(at, n_beads, beads.ordered, search, 1.0)
        forces.gather_crowds(pairs, n, acting.density)
        for p in range(n):
            pairs.repulsion[p] = of_pair(pair.repulsion, species, pairs.i[p], pairs.j[p])
        for p in range(n):
            r2 = CLOSEST
            for k in range(len(edges)):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            r = np.sqrt(r2)
            push = force(pair, pairs.repulsion[p], r, max(0.0, 1.0 - r))
            over_r = (push + force(acting.many_body, pairs.crowd[p], r)) / r
            normal = over_r * pairs.separation[slices.axis, p] ** 2
            pairs.force_over_r[p], pairs.weight_over_r[p] = normal, over_r * r2 - normal
        for p in range(n):
            begin = beads.ordered[pairs.i[p], slices.axis]
            end = begin - pairs.separation[slices.axis, p]
            spread(virial, begin, end, pairs.force_over_r[p], pairs.weight_over_r[p], slices)
    forces.find_slots(slot, acting.identity, Share(np.uint64(0), np.uint64(n_beads)))
    forces.add_bonds(
        unused[0], beads.x, slot, acting.bonds, 0, arms, *unused[1:], False, edges, None
    )
    spread_arms(virial, beads.x, acting.bonds, arms, False, edges, slices)
    forces.add_angles(
        unused[0], beads.x, slot, acting.angles, 0, arms, others, *unused[1:], False, edges, None
    )
    spread_arms(virial, beads.x, acting.angles, arms, True, edges, slices)
    spread_arms(virial, beads.x, acting.angles, others, True, edges, slices)


@inlined(given="bonded")
def spread_arms(virial, x, bonded, arms, aside, edges, slices):
    """Spread along bonds what these do, or what angles do, aside of each of their two."""
    for b in range(len(bonded.members)):
        every, normal, along = 0.0, 0.0, arms.apart[slices.axis, b]
        for k in range(len(edges)):
            push = arms.push[k, b] if aside else arms.scale[b] * arms.apart[k, b]
            moment = push * arms.apart[k, b]
            every += moment
            if k == slices.axis:
                normal += moment
        begin = x[arms.i[b], slices.axis]
        spread(virial, begin, begin - along, normal, every - normal, slices)


@inlined()
def spread(virial, begin, end, normal, tangential, slices):
    """Spread a virial evenly over the slices that a line along the axis crosses.

    One end of it lies in the box, the other one up to an edge outside.
    """
    per_length = slices.number / (slices.high - slices.low)
    low = (min(begin, end) - slices.low) * per_length + slices.number
    high = (max(begin, end) - slices.low) * per_length + slices.number
    first, last = np.uint64(low), np.uint64(high)
    if first == last or high - low < SHORTEST:
        add_share(virial, last, 1.0, normal, tangential)
        return
    over = 1.0 / (high - low)
    add_share(virial, first, (first + 1.0 - low) * over, normal, tangential)
    for between in range(first + np.uint64(1), last):
        add_share(virial, between, over, normal, tangential)
    add_share(virial, last, (high - last) * over, normal, tangential)


@inlined()
def add_share(virial, place, share, normal, tangential):
    virial[NORMAL, place] += share * normal
    virial[TANGENTIAL, place] += share * tangential


def wall_virial_in_slices(system: System, state: State, slices: Slices) -> np.ndarray:
    """(slices,) array in kT: what walls across the axis add to the normal virial.

    The force of a wall on a bead passes along the normal from behind the wall, the end of the
    slices, to the bead. With it the mean normal pressure is the same in all slices, as in any fluid
    at rest; without, it rises over the range of the walls.
    """
    virial, place = np.zeros((2, 3, slices.number)), rows_of(state.position)
    _add_walls(virial.reshape(2, -1), place, state.species, system.walls, slices)
    return virial[NORMAL].sum(axis=0)


@kernel()
def _add_walls(virial, position, species, walls, slices):
    for wall in range(len(walls.axis)):
        if walls.axis[wall] == slices.axis:
            place, inward = walls.place[wall], walls.inward[wall]
            end = slices.low if inward > 0.0 else slices.high
            for s in range(len(position)):
                z = inward * (position[s, slices.axis] - place)
                push = force(walls, of_bead(walls.repulsion, species, s), z)
                if push > 0.0:
                    begin = position[s, slices.axis]
                    spread(virial, begin, end, push * abs(begin - end), 0.0, slices)


class AtBeads(NamedTuple):
    """Of conservative forces; half of what acts between two beads, or along a bond, is of each."""

    force: Any  # (n, dimension) in kT / r_c; of kernels None
    energy: np.ndarray  # (n,) in kT
    virial: np.ndarray  # (n, dimension, dimension) in kT: sum of r_ij F_ij / 2


def at_beads(system: System, state: State) -> AtBeads:
    """Of each bead by its identity; a body force is left out."""
    d, n = state.position.shape
    halves = AtBeads(None, np.zeros(n), np.zeros((n, d, d)))
    force = _evaluated(system, state, halves)[0][:, :d]
    virial = (halves.virial + halves.virial.swapaxes(1, 2)) / 2  # of angles it is not symmetric
    order = np.argsort(state.identity)
    return AtBeads(force[order], halves.energy[order], virial[order])


def force_and_curvature(system: System, state: State) -> np.ndarray:
    """Sum of squared conservative forces, and the Laplacian of the potential, without a core.

    In equilibrium <sum F_i^2> = kT <sum nabla_i^2 U> (Rugh 1997; Butler et al. 1998).
    """
    total, laplacian = _evaluated(system, state, None)
    return np.array([(total * total).sum(), laplacian])


def _evaluated(system, state, halves):
    """Forces by the slot of the bead, and the Laplacian of the potential; halves are added up."""
    beads, d = sorted_beads(state.position, system.box, 1.0), system.dimension
    total = np.zeros_like(beads.x)
    slopes = None if system.many_body is None else np.zeros_like(beads.x)
    acting, unused = acting_on(system, state, beads), (np.zeros((2, d, d)), np.zeros(2))
    more = acting, system.walls, halves, *unused
    laplacian = _laplacian(total, slopes, beads, state.species, *more)
    if slopes is not None:  # of each bead's density, by its own place
        laplacian += (slopes * slopes).sum()
    return total, laplacian


@kernel()
def _laplacian(total, slopes, beads, species, acting, walls, halves, virial, sums):
    """Add up all forces, by the number of the bead; return the Laplacian of the potential."""
    search, pair, many_body = beads.search, acting.pair, acting.many_body
    pairs, edges, slide, n_beads = search.pairs, search.edges, search.slide, np.uint64(len(beads.x))
    slot, arms, others, laplacian = acting.slot, acting.arms, acting.others, 0.0
    at = first_place()
    while at.slot < n_beads:
        at, n = near_pairs(at, n_beads, beads.ordered, search, 1.0)
        forces.gather_crowds(pairs, n, acting.density)
        for p in range(n):
            i, j = beads.bead[pairs.i[p]], beads.bead[pairs.j[p]]
            r = forces.length(pairs.separation, p, edges)
            w = max(0.0, 1.0 - r)
            a = of_pair(pair.repulsion, species, i, j)
            over_r = (force(pair, a, r, w) + force(many_body, pairs.crowd[p], r)) / r
            bent = curvature(pair, a, r, w) + curvature(many_body, pairs.crowd[p], r)
            # u'' + (d - 1) u' / r, for both beads of the pair
            laplacian += 2.0 * (bent - (len(edges) - 1) * over_r)
            push_apart(total, i, j, over_r, pairs.separation, p, edges)
            held = energy(pair, a, r, w) + energy(many_body, pairs.crowd[p], r)
            share(halves, i, j, held, over_r, pairs.separation, pairs.separation, p, edges)
            laplacian += add_slopes(slopes, many_body, i, j, r, pairs.separation, p, edges)
    forces.find_slots(slot, acting.identity, Share(np.uint64(0), n_beads))
    forces.add_bonds(total, beads.x, slot, acting.bonds, 0, arms, virial, sums, False, edges, slide)
    laplacian += bond_curvature(arms, acting.bonds, halves, edges)
    forces.add_angles(
        total, beads.x, slot, acting.angles, 0, arms, others, virial, sums, False, edges, slide
    )
    laplacian += angle_curvature(arms, others, acting.angles, halves, edges)
    return laplacian + add_wall_curvature(total, beads.x, species, walls, halves)


@inlined(given="halves")
def share(halves, i, j, held, scale, push, apart, p, edges):
    """Give two beads their halves of an energy, and of the virial of scale times the push on i."""
    halves.energy[i] += 0.5 * held
    halves.energy[j] += 0.5 * held
    for k in range(len(edges)):
        for m in range(len(edges)):
            half = 0.5 * scale * apart[k, p] * push[m, p]
            halves.virial[i, k, m] += half
            halves.virial[j, k, m] += half


@inlined()
def add_slopes(slopes, many_body, i, j, r, separation, p, edges):
    """Add a pair's slopes of both densities by each bead's own place; return the squared others."""
    if slopes is None:
        return 0.0
    steep = slope(many_body, r)
    push_apart(slopes, i, j, steep / r, separation, p, edges)
    return 2.0 * steep * steep


@inlined()
def bond_curvature(arms, bonds, halves, edges):
    """The part of bonds in the Laplacian of the potential: u'' + (d - 1) u' / r at both ends."""
    if bonds is None:
        return 0.0
    total = 0.0
    for b in range(len(bonds.members)):
        r = forces.length(arms.apart, b, edges)
        law = law_of(bonds.law, b)
        over_r = force(law, r) / r
        total += 2.0 * (curvature(law, r) - (len(edges) - 1) * over_r)
        i, j = arms.i[b], arms.j[b]
        share(halves, i, j, energy(law, r), over_r, arms.apart, arms.apart, b, edges)
    return total


@inlined()
def angle_curvature(arms, others, angles, halves, edges):
    """The part of angles in the Laplacian of the potential, summed over their three beads.

    With c and s the cosine and sine of theta, d the dimension, and beads as in `add_angles`, the
    squared gradients of theta add up to 2 / r_i^2 + 2 / r_k^2 - 2 c / (r_i r_k), and its Laplacians
    to 2 (d - 2) (c (1 / r_i^2 + 1 / r_k^2) - 1 / (r_i r_k)) / s.
    """
    if angles is None:
        return 0.0
    total = 0.0
    for a in range(len(angles.members)):
        at = forces.opening(arms.apart, others.apart, a, edges)
        over_s = at.sine / (at.sine * at.sine + CLOSEST)
        squares = at.over_i * at.over_i + at.over_k * at.over_k
        product = at.over_i * at.over_k
        law = law_of(angles.law, a)
        total += curvature(law, at.theta) * 2.0 * (squares - at.cosine * product)
        bend = 2.0 * (len(edges) - 2) * over_s * (at.cosine * squares - product)
        total -= force(law, at.theta) * bend
        half = 0.5 * energy(law, at.theta)
        share(halves, arms.i[a], arms.j[a], half, 1.0, arms.push, arms.apart, a, edges)
        share(halves, others.i[a], others.j[a], half, 1.0, others.push, others.apart, a, edges)
    return total


@inlined()
def add_wall_curvature(f, x, species, walls, halves):
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
            if halves is not None:
                halves.energy[s] += energy(walls, a, z)
    return laplacian
