"""Forces of pairs of beads, some hundred pairs at a time.

What acts between two beads stands in `dpd.physics`. Here are the loops: what each pair needs is
gathered first, then the forces of all are worked out in one loop that the compiler makes into
vectors, then the beads are pushed.
"""

import numpy as np

from dpd.engine.shares import share_friction, shares_of
from dpd.engine.slide import add_flow_between
from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_PAIRS
from dpd.engine.vectors.rows import difference_along, push_apart
from dpd.jit import part
from dpd.physics.forces import energy, force
from dpd.physics.noise import gaussian_noise, uniform_noise

CLOSEST = 1e-30  # keeps e finite for two beads at the same point; their force is zero


@part()
def gather_repulsion(pairs, n, species, pair):
    """Fill ``pairs.repulsion[:n]`` with a_ij, if there are species."""
    if species is not None:
        for p in range(n):
            pairs.repulsion[p] = pair.repulsion[species[pairs.i[p]], species[pairs.j[p]]]


@part()
def repulsion_of(pairs, p, species, pair):
    """a_ij of pair p; without species there is one value."""
    if species is None:
        return pair.repulsion[0, 0]
    return pairs.repulsion[p]


@part()
def gather_friction(pairs, n, velocity, identity, friction, space, keys):
    """Fill ``pairs.approach[:n]`` with r_ij . v_ij and ``pairs.theta[:n]`` with noise."""
    if friction is None:
        return
    for p in range(n):
        i, j = pairs.i[p], pairs.j[p]
        pairs.approach[p] = difference_along(velocity, i, j, pairs.separation, p, space)
    add_flow_between(pairs, n, space.slide)
    for p in range(n):
        a, b = identity[pairs.i[p]], identity[pairs.j[p]]
        pairs.low[p] = min(a, b)
        pairs.high[p] = max(a, b)
    if friction.gaussian:
        gaussian_noise(pairs.theta, pairs.low, pairs.high, n, keys)
    else:
        uniform_noise(pairs.theta, pairs.low, pairs.high, n, keys)


@part()
def thermostat_force(pairs, p, friction, inverse, w):
    """Friction and noise of pair p; zero without."""
    if friction is None:
        return 0.0
    return force(friction, pairs.approach[p], inverse, w, pairs.theta[p])


@part()
def add_pair_forces(total, pairs, n, velocity, beads, plan, keys):
    """Add the forces of ``n`` pairs; leave F / r and, in the place of theta, w / r.

    Parameters
    ----------
    total : array with a row for each bead
        The force.
    pairs : Pairs
    velocity : array with a row for each bead
        The one that the friction sees.
    beads : Beads
    plan : Plan
    keys : Keys
        Of the step, for the noise.

    Notes
    -----
    Loops over axes count to the length of a tuple, which the compiler knows; an array's shape it
    does not, and the loops over pairs would not vectorise.
    """
    pair, friction = plan.forces.pair, plan.forces.friction
    space, species, dimension = plan.space, beads.species, len(plan.space.edges)
    gather_repulsion(pairs, n, species, pair)
    gather_friction(pairs, n, velocity, beads.identity, friction, space, keys)
    share_friction(pairs, n, species, shares_of(friction))
    for p in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        push = force(pair, repulsion_of(pairs, p, species, pair), r, w)
        pairs.force_over_r[p] = inverse * (push + thermostat_force(pairs, p, friction, inverse, w))
        pairs.theta[p] = w * inverse
    for p in range(n):
        push_apart(total, pairs.i[p], pairs.j[p], pairs.force_over_r[p], pairs.separation, p, space)


@part()
def measure_pairs(sums, pairs, n, species, pair, space):
    """Add the virials sum r_ij F_ij and the energy of ``n`` pairs to a task's sums."""
    dimension = len(space.edges)
    for p in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = repulsion_of(pairs, p, species, pair)
        conservative = force(pair, a, r, w) * inverse
        sums.energy[OF_PAIRS] += energy(pair, a, r, w)
        for k in range(dimension):
            for m in range(dimension):
                moment = pairs.separation[k, p] * pairs.separation[m, p]
                sums.virial[CONSERVATIVE, k, m] += conservative * moment
                sums.virial[ALL_FORCES, k, m] += pairs.force_over_r[p] * moment
