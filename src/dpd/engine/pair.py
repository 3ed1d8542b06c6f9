"""Forces of pairs of beads, some hundred pairs at a time.

What acts between two beads stands in `dpd.physics`. Here are the loops: what each pair needs is
gathered first, then the forces of all are worked out in one loop that the compiler makes into
vectors, then the beads are pushed. Loops over axes count to the length of a tuple, which the
compiler knows; an array's shape it does not, and the loops over pairs would not vectorise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dpd.engine.rows import columns, difference_along, push_apart
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_PAIRS
from dpd.jit import inlined
from dpd.physics.forces import energy, force
from dpd.physics.noise import gaussian_noise, uniform_noise

CLOSEST = 1e-30  # keeps e finite for two beads at the same point; their force is zero
CACHED_PER_BEAD = 8  # for which there is room at first


class Cached(NamedTuple):
    """Pairs within the cutoff that a step needs again after its forces.

    Attributes
    ----------
    ends : (2, size) uint32 array
        Slots.
    drag : (dimension, size) array
        sqrt(gamma) w e of each, whose square is its friction.
    phase : (phases + 1,) int64 array
        How many were found before each phase of the blocks, and in all.
    count : int
        How many there are so far.
    gamma : float
    shares : (species, species) array or None
        gamma_ij / gamma where pairs of species differ.
    """

    ends: np.ndarray
    drag: np.ndarray
    phase: np.ndarray
    count: int  # type: ignore[assignment]  # in place of tuple.count
    gamma: float
    shares: np.ndarray | None


def cache_buffers(
    dimension: int, beads: int, phases: int, gamma: float, shares: np.ndarray | None
) -> Cached:
    """Room for pairs, which are yet to be found."""
    size = CACHED_PER_BEAD * beads
    return Cached(
        np.empty((2, size), np.uint32), np.empty((dimension, size)),
        np.zeros(phases + 1, np.int64), 0, gamma, shares,
    )  # fmt: skip


@inlined()
def of_pair(values, species, i, j):
    """The value for the species of the beads in slots i and j; without species there is one."""
    if species is None:
        return values[0, 0]
    return values[species[i], species[j]]


@inlined()
def gather_friction(pairs, n, v, identity, species, friction, shares, edges, slide, keys):
    """Find the approach r_ij . v_ij and the random number of ``n`` pairs, if there is friction."""
    if friction is None:
        return
    i, j, separation, _, approach, theta, _, _, low, high = pairs
    for p in range(n):
        approach[p] = difference_along(v, i[p], j[p], separation, p, edges)
    if slide is not None:  # and the flow between the two
        for p in range(n):
            apart = separation[slide.flow, p] * separation[slide.gradient, p]
            approach[p] += slide.rate * apart
    for p in range(n):
        a, b = identity[i[p]], identity[j[p]]
        low[p], high[p] = min(a, b), max(a, b)
    if friction.gaussian:
        gaussian_noise(theta, low, high, n, keys)
    else:
        uniform_noise(theta, low, high, n, keys)
    if shares is not None:  # gamma_ij = share gamma, and sigma_ij^2 with it
        for p in range(n):
            share = of_pair(shares, species, i[p], j[p])
            approach[p] *= share
            theta[p] *= np.sqrt(share)


@inlined()
def thermostat_force(friction, approach, inverse, w, theta):
    """Friction and noise of a pair; zero without."""
    if friction is None:
        return 0.0
    return force(friction, approach, inverse, w, theta)


@inlined()
def add_pair_forces(f, pairs, n, species, pair, friction, edges):
    """Add the forces of ``n`` pairs; leave F / r and w / r of each.

    Parameters
    ----------
    f : array with a row for each bead
        The force.
    pairs : Pairs
        With what `gather_friction` finds.
    n : uint64
    species : (n,) uint8 array or None
    pair : Soft or Core
    friction : Friction or None
    edges : tuple of float
    """
    i, j, separation, repulsion, approach, theta, force_over_r, weight_over_r, _, _ = pairs
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
        thermal = thermostat_force(friction, approach[p], inverse, w, theta[p])
        force_over_r[p] = inverse * (force(pair, a, r, w) + thermal)
        weight_over_r[p] = w * inverse
    for p in range(n):
        push_apart(f, i[p], j[p], force_over_r[p], separation, p, edges)


@inlined()
def measure_pairs(virial, sums, pairs, n, species, pair, edges):
    """Add the virials sum r_ij F_ij and the energy of ``n`` pairs to those of a task."""
    for p in range(n):
        r2 = CLOSEST
        for k in range(len(edges)):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = of_pair(pair.repulsion, species, pairs.i[p], pairs.j[p])
        conservative = force(pair, a, r, w) * inverse
        sums[OF_PAIRS] += energy(pair, a, r, w)
        for k in range(len(edges)):
            for m in range(len(edges)):
                moment = pairs.separation[k, p] * pairs.separation[m, p]
                virial[CONSERVATIVE, k, m] += conservative * moment
                virial[ALL_FORCES, k, m] += pairs.force_over_r[p] * moment


@inlined()
def emptied(cached):
    """The same buffers for the pairs of another evaluation."""
    if cached is None:
        return None
    return Cached(
        cached.ends, cached.drag, cached.phase, np.int64(0), cached.gamma, cached.shares
    )


@inlined()
def shares_of(term):
    """The shares of a term; None where it is not there, or where all have one friction."""
    if term is None:
        return None
    return term.shares


@inlined()
def cache_pairs(cached, pairs, n, species, shares, edges):
    """Keep those of ``n`` pairs that are within the cutoff, if the step needs them again."""
    if cached is None:
        return None
    ends, drag, phase, count, gamma, _ = cached
    if count + np.int64(n) >= ends.shape[1]:
        size = 2 * (count + np.int64(n))
        ends, drag = columns(ends, count, size), columns(drag, count, size)
    root, end = np.sqrt(gamma), np.uint64(count)
    for p in range(n):
        i, j, weight = pairs.i[p], pairs.j[p], root * pairs.weight_over_r[p]
        if shares is not None:
            weight *= np.sqrt(of_pair(shares, species, i, j))
        ends[0, end] = i
        ends[1, end] = j
        for k in range(len(edges)):
            drag[k, end] = weight * pairs.separation[k, p]
        end += np.uint64(weight > 0.0)
    return Cached(ends, drag, phase, np.int64(end), gamma, cached.shares)


@inlined()
def close_phase(cached, phase):
    """Note how many pairs were found up to the end of a phase."""
    if cached is not None:
        cached.phase[phase + 1] = cached.count
