"""Pair forces of dissipative particle dynamics.

F_ij = [ a_ij w - gamma w^2 (e . v_ij) + sigma w theta dt^(-1/2) ] e, with
w = max(0, 1 - r) and e = r_ij / r (Groot and Warren 1997, Eqs. 3 to 8).
"""

import numpy as np

from dpd.engine.vectors.rows import difference_along, push_apart
from dpd.jit import part
from dpd.physics.noise import gaussian_noise, uniform_noise

# A rigid core (diameter d, force F, width) replaces the soft repulsion below d: a constant push
# F, F_max and 2 r_s of Liu et al. 2008, Eq. 5. The force jumps at d, or, with a width, goes over
# into the soft repulsion in a straight line within it.

CLOSEST = 1e-30  # keeps e finite for two beads at the same point; their force is zero


@part()
def conservative_force(strength, r, w, core):
    """Repulsion at distance r, with w = max(0, 1 - r)."""
    if core is None:
        return strength * w
    diameter, push, width = core
    return push if r < diameter else beyond_core(strength, r, w, diameter, push, width)


@part()
def beyond_core(strength, r, w, diameter, push, width):
    """Repulsion from the edge of a core on."""
    if width is None:
        return strength * w
    outer = strength * (1.0 - diameter - width)
    slope = (outer - push) / width
    return push + slope * (r - diameter) if r < diameter + width else strength * w


@part()
def conservative_energy(strength, r, w, core):
    """Potential of `conservative_force`, continuous at the core, zero from r = 1 on."""
    if core is None:
        return 0.5 * strength * w * w
    diameter, push, width = core
    if r < diameter:
        edge = energy_beyond_core(strength, diameter, 1.0 - diameter, diameter, push, width)
        return push * (diameter - r) + edge
    return energy_beyond_core(strength, r, w, diameter, push, width)


@part()
def energy_beyond_core(strength, r, w, diameter, push, width):
    """Potential of `beyond_core`."""
    if width is None:
        return 0.5 * strength * w * w
    left = diameter + width - r
    if left <= 0.0:
        return 0.5 * strength * w * w
    outer = strength * (1.0 - diameter - width)
    here = beyond_core(strength, r, w, diameter, push, width)
    return 0.5 * (here + outer) * left + 0.5 * strength * (1.0 - diameter - width) ** 2


@part()
def pair_repulsion(strength, pairs, n, species, repulsion):
    """Fill ``strength[:n]`` with a_ij, if there are species."""
    if species is not None:
        for p in range(n):
            strength[p] = repulsion[species[pairs.i[p]], species[pairs.j[p]]]


@part()
def strength_of(strength, p, species, repulsion):
    """a_ij of pair p; without species there is one value."""
    if species is None:
        return repulsion[0, 0]
    return strength[p]


@part()
def pair_approach(approach, pairs, n, velocity, box):
    """Fill ``approach[:n]`` with r_ij . v_ij."""
    for p in range(n):
        i, j = pairs.i[p], pairs.j[p]
        approach[p] = difference_along(velocity, i, j, pairs.separation, p, box)


@part()
def pair_identities(pairs, n, identity):
    """Fill ``pairs.low`` and ``pairs.high`` with the sorted identities."""
    for p in range(n):
        a, b = identity[pairs.i[p]], identity[pairs.j[p]]
        pairs.low[p] = min(a, b)
        pairs.high[p] = max(a, b)


@part()
def add_pair_forces(force, pairs, n, velocity, identity, species, box, fields, keys):
    """Add the forces of ``n`` pairs; leave w / r in ``theta``, force / r in ``over_r``.

    Parameters
    ----------
    force, velocity : arrays with a row for each bead
        In storage order; the velocity is the one that the friction sees.
    fields : (repulsion, (gamma, sigma / sqrt(dt)), gaussian, bonds, core, bath)
        A table of a_ij; with gamma 0 no random number is drawn; ``core`` is None or its
        diameter, force, and width or None. The rest belongs to `dpd.engine.bonds` and
        `dpd.physics.langevin`.

    Notes
    -----
    Loops over axes count to ``len(box)``, the length of a tuple, which the compiler knows;
    an array's shape it does not, and the loops over pairs would not vectorise.
    """
    repulsion, (friction, noise), gaussian, _, core, _ = fields
    strength, approach, theta, over_r = pairs.strength, pairs.approach, pairs.theta, pairs.over_r
    pair_repulsion(strength, pairs, n, species, repulsion)
    if friction > 0.0:
        pair_approach(approach, pairs, n, velocity, box)
        pair_identities(pairs, n, identity)
        if gaussian:
            gaussian_noise(theta, pairs.low, pairs.high, n, keys[0], keys[1])
        else:
            uniform_noise(theta, pairs.low, pairs.high, n, keys[0], keys[1])
    else:
        for p in range(n):
            approach[p] = 0.0
            theta[p] = 0.0
    for p in range(n):
        r2 = CLOSEST
        for k in range(len(box)):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        push = conservative_force(strength_of(strength, p, species, repulsion), r, w, core)
        drag = friction * w * approach[p] * inverse
        over_r[p] = inverse * (push + w * (noise * theta[p] - drag))
        theta[p] = w * inverse
    for p in range(n):
        push_apart(force, pairs.i[p], pairs.j[p], over_r[p], pairs.separation, p, box)


@part()
def measure_pairs(virial, energy, pairs, n, species, box, fields):
    """Add the virials sum r_ij F_ij and the energy of ``n`` pairs.

    ``virial[0]`` takes the conservative force, ``virial[1]`` all three.
    """
    repulsion, core, dimension = fields[0], fields[4], len(box)
    strength, over_r = pairs.strength, pairs.over_r
    for p in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += pairs.separation[k, p] * pairs.separation[k, p]
        inverse = 1.0 / np.sqrt(r2)
        r = r2 * inverse
        w = max(0.0, 1.0 - r)
        a = strength_of(strength, p, species, repulsion)
        conservative = conservative_force(a, r, w, core) * inverse
        energy[0] += conservative_energy(a, r, w, core)
        for k in range(dimension):
            for m in range(dimension):
                moment = pairs.separation[k, p] * pairs.separation[m, p]
                virial[0, k, m] += conservative * moment
                virial[1, k, m] += over_r[p] * moment
