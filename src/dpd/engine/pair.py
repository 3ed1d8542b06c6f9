"""Forces of pairs of beads, some hundred pairs at a time.

What each pair needs is gathered first, then the forces of all are worked out in one loop that the
compiler makes into vectors, then the beads are pushed. Loops over axes count to the length of a
tuple, which the compiler knows; to that of an array the loops over pairs would not vectorise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dpd.engine.rows import difference_along, push_apart
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_PAIRS
from dpd.jit import inlined
from dpd.physics.common.forces import energy, force, weight
from dpd.physics.common.noise import gaussian_noise, uniform_noise

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
def of_pair(values, species, i, j):
    """The value for the species of the beads in slots i and j."""
    if species is None:
        return values[0, 0]
    return values[species[i], species[j]]


@inlined()
def share_of_pair(shares, species, i, j):
    if shares is None:
        return 1.0
    return of_pair(shares, species, i, j)


@inlined(given="friction")
def gather_friction(pairs, n, v, beads, friction, edges, slide, keys):
    """Find the approach r_ij . v_ij and the random number of ``n`` pairs."""
    i, j, separation, low, high = pairs.i, pairs.j, pairs.separation, pairs.low, pairs.high
    approach, theta = pairs.approach, pairs.theta
    for p in range(n):
        approach[p] = difference_along(v, i[p], j[p], separation, p, edges)
    if slide is not None:  # and the flow between the two
        for p in range(n):
            apart = separation[slide.flow, p] * separation[slide.gradient, p]
            approach[p] += slide.rate * apart
    for p in range(n):
        a, b = beads.identity[i[p]], beads.identity[j[p]]
        low[p], high[p] = min(a, b), max(a, b)
    if friction.gaussian:
        gaussian_noise(theta, low, high, n, keys)
    else:
        uniform_noise(theta, low, high, n, keys)
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
        r2 = CLOSEST
        for k in range(len(edges)):
            r2 += separation[k, p] * separation[k, p]
        more[p] = weight(many_body, np.sqrt(r2))
    for p in range(n):
        density[i[p]] += more[p]
        density[j[p]] += more[p]


@inlined(given="density")
def gather_crowds(pairs, n, density):
    """Find the sum of both local densities of each of ``n`` pairs."""
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
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = pair.repulsion[0, 0] if species is None else repulsion[p]
        conservative = force(pair, a, r, w) + force(many_body, crowd[p], r)
        thermal = force(friction, approach[p], inverse, w, theta[p])
        force_over_r[p] = inverse * (conservative + thermal)
        weight_over_r[p] = w * inverse
    for p in range(n):
        push_apart(f, i[p], j[p], force_over_r[p], separation, p, edges)


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
        inverse = 1.0 / np.sqrt(r2)
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
