"""Conservative forces: where in a box their virial lies, and the curvature of their potential."""

from typing import Any, NamedTuple

import numpy as np

from dpd.engine import forces
from dpd.engine.forces import CLOSEST
from dpd.engine.measure import Sorted, sorted_beads
from dpd.engine.neighbours import first_place, near_pairs
from dpd.engine.rows import of_bead, of_pair, push_apart, rows_of
from dpd.engine.state import State, System
from dpd.engine.threads import Share
from dpd.jit import inlined, kernel
from dpd.physics.common.forces import curvature, force, force_over_r, law_of, slope

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
    _add_virial(virial.reshape(2, -1), beads, species, acting_on(system, state, beads), slices)
    virial[TANGENTIAL] /= system.dimension - 1
    return virial.sum(axis=1)  # of the box, and of an image on either side, where lines may end


@kernel()
def _add_virial(virial, beads, species, acting, slices):
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
    spread_bonds(virial, beads.x, slot, acting.bonds, arms, edges, slices)
    spread_angles(virial, beads.x, slot, acting.angles, arms, others, edges, slices)


@inlined(given="bonds")
def spread_bonds(virial, x, slot, bonds, arms, edges, slices):
    _, n = forces.gather(arms, bonds, 0, x, slot, 0, edges, None)
    for b in range(n):
        r, along = forces.length(arms.apart, b, edges), arms.apart[slices.axis, b]
        over_r = force_over_r(law_of(bonds.law, b), r)
        normal = over_r * along * along
        begin = x[arms.i[b], slices.axis]
        spread(virial, begin, begin - along, normal, over_r * r * r - normal, slices)


@inlined(given="angles")
def spread_angles(virial, x, slot, angles, arms, others, edges, slices):
    forces.gather(arms, angles, 0, x, slot, 0, edges, None)
    _, n = forces.gather(others, angles, 0, x, slot, 2, edges, None)
    for a in range(n):
        at = forces.opening(arms.apart, others.apart, a, edges)
        across = -force(law_of(angles.law, a), at.theta) * at.sine / (at.sine * at.sine + CLOSEST)
        spread_arm(virial, x, arms, others, a, across, at, at.over_i, at.over_k, edges, slices)
        spread_arm(virial, x, others, arms, a, across, at, at.over_k, at.over_i, edges, slices)


@inlined()
def spread_arm(virial, x, arm, other, a, across, at, over_arm, over_other, edges, slices):
    """Spread what an angle does along one of its bonds, from the outer bead to the middle one."""
    normal, every = 0.0, 0.0
    for k in range(len(edges)):
        aside = other.apart[k, a] * over_other - at.cosine * arm.apart[k, a] * over_arm
        push = across * over_arm * aside
        every += arm.apart[k, a] * push
        if k == slices.axis:
            normal += arm.apart[k, a] * push
    begin = x[arm.i[a], slices.axis]
    end = begin - arm.apart[slices.axis, a]
    spread(virial, begin, end, normal, every - normal, slices)


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


def force_and_curvature(system: System, state: State) -> np.ndarray:
    """Sum of squared conservative forces, and the Laplacian of the potential, without a core.

    In equilibrium <sum F_i^2> = kT <sum nabla_i^2 U> (Rugh 1997; Butler et al. 1998).
    """
    beads = sorted_beads(state.position, system.box, 1.0)
    total, d = np.zeros_like(beads.x), system.dimension
    slopes = None if system.many_body is None else np.zeros_like(beads.x)
    acting, unused = acting_on(system, state, beads), (np.zeros((2, d, d)), np.zeros(2))
    laplacian = _laplacian(total, slopes, beads, state.species, acting, system.walls, *unused)
    if slopes is not None:  # of each bead's density, by its own place
        laplacian += (slopes * slopes).sum()
    return np.array([(total * total).sum(), laplacian])


@kernel()
def _laplacian(total, slopes, beads, species, acting, walls, virial, sums):
    """Add up all forces, by the number of the bead; return the Laplacian of the potential."""
    search, pair, many_body = beads.search, acting.pair, acting.many_body
    pairs, edges, n_beads = search.pairs, search.edges, np.uint64(len(beads.bead))
    slot, arms, others, laplacian = acting.slot, acting.arms, acting.others, 0.0
    at = first_place()
    while at.slot < n_beads:
        at, n = near_pairs(at, n_beads, beads.ordered, search, 1.0)
        forces.gather_crowds(pairs, n, acting.density)
        for p in range(n):
            i, j = beads.bead[pairs.i[p]], beads.bead[pairs.j[p]]
            r2 = CLOSEST
            for k in range(len(edges)):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            r = np.sqrt(r2)
            w = max(0.0, 1.0 - r)
            a = of_pair(pair.repulsion, species, i, j)
            over_r = (force(pair, a, r, w) + force(many_body, pairs.crowd[p], r)) / r
            bent = curvature(pair, a, r, w) + curvature(many_body, pairs.crowd[p], r)
            # u'' + (d - 1) u' / r, for both beads of the pair
            laplacian += 2.0 * (bent - (len(edges) - 1) * over_r)
            push_apart(total, i, j, over_r, pairs.separation, p, edges)
            laplacian += add_slopes(slopes, many_body, i, j, r, pairs.separation, p, edges)
    forces.find_slots(slot, acting.identity, Share(np.uint64(0), n_beads))
    forces.add_bonds(total, beads.x, slot, acting.bonds, 0, arms, virial, sums, False, edges, None)
    forces.add_angles(
        total, beads.x, slot, acting.angles, 0, arms, others, virial, sums, False, edges, None
    )
    laplacian += bond_curvature(beads.x, slot, acting.bonds, arms, edges)
    laplacian += angle_curvature(beads.x, slot, acting.angles, arms, others, edges)
    return laplacian + add_wall_curvature(total, beads.x, species, walls)


@inlined()
def add_slopes(slopes, many_body, i, j, r, separation, p, edges):
    """Add a pair's slopes of both densities by each bead's own place; return the squared others."""
    if slopes is None:
        return 0.0
    steep = slope(many_body, r)
    push_apart(slopes, i, j, steep / r, separation, p, edges)
    return 2.0 * steep * steep


@inlined()
def bond_curvature(x, slot, bonds, arms, edges):
    """The part of bonds in the Laplacian of the potential: u'' + (d - 1) u' / r at both ends."""
    if bonds is None:
        return 0.0
    total, (_, n) = 0.0, forces.gather(arms, bonds, 0, x, slot, 0, edges, None)
    for b in range(n):
        r = forces.length(arms.apart, b, edges)
        law = law_of(bonds.law, b)
        over_r = force_over_r(law, r)
        total += 2.0 * (curvature(law, r) - (len(edges) - 1) * over_r)
    return total


@inlined()
def angle_curvature(x, slot, angles, arms, others, edges):
    """The part of angles in the Laplacian of the potential, summed over their three beads.

    With c and s the cosine and sine of theta, d the dimension, and beads as in `add_angles`, the
    squared gradients of theta add up to 2 / r_i^2 + 2 / r_k^2 - 2 c / (r_i r_k), and its Laplacians
    to 2 (d - 2) (c (1 / r_i^2 + 1 / r_k^2) - 1 / (r_i r_k)) / s.
    """
    if angles is None:
        return 0.0
    forces.gather(arms, angles, 0, x, slot, 0, edges, None)
    total, (_, n) = 0.0, forces.gather(others, angles, 0, x, slot, 2, edges, None)
    for a in range(n):
        at = forces.opening(arms.apart, others.apart, a, edges)
        over_s = at.sine / (at.sine * at.sine + CLOSEST)
        squares = at.over_i * at.over_i + at.over_k * at.over_k
        product = at.over_i * at.over_k
        law = law_of(angles.law, a)
        total += curvature(law, at.theta) * 2.0 * (squares - at.cosine * product)
        bend = 2.0 * (len(edges) - 2) * over_s * (at.cosine * squares - product)
        total -= force(law, at.theta) * bend
    return total


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
