"""Forces and curvature of the potential, whose ratio is a temperature without velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.bonded import (
    add_angles,
    add_bonds,
    angle_curvature,
    bond_curvature,
    find_slots,
)
from dpd.engine.external import add_wall_curvature
from dpd.engine.pair import CLOSEST, gather_crowds, of_pair
from dpd.engine.queries.sorting import sorted_beads, terms_of
from dpd.engine.rows import push_apart
from dpd.engine.search import first_place, next_pairs
from dpd.engine.threads import Share
from dpd.jit import inlined, kernel
from dpd.physics.common.forces import curvature, force, slope

if TYPE_CHECKING:
    from dpd.engine.state import State, System


def force_and_curvature(system: System, state: State) -> np.ndarray:
    """Sum of squared conservative forces, and the Laplacian of the potential, without a core.

    In equilibrium <sum F_i^2> = kT <sum nabla_i^2 U> (Rugh 1997; Butler et al. 1998).
    """
    beads = sorted_beads(state.position, system.box, 1.0)
    total, d = np.zeros_like(beads.x), system.dimension
    slopes = None if system.many_body is None else np.zeros_like(beads.x)
    laplacian = _laplacian(
        total, slopes, beads, state.identity, state.species, system.forces.pair, system.many_body,
        *terms_of(system, beads), system.walls, np.zeros((2, d, d)), np.zeros(2),
    )  # fmt: skip
    if slopes is not None:  # of each bead's density, by its own place
        laplacian += (slopes * slopes).sum()
    return np.array([(total * total).sum(), laplacian])


@kernel()
def _laplacian(
    total, slopes, beads, identity, species, pair, many_body, density, bonds, angles, slot, arms,
    others, walls, virial, sums,
):  # fmt: skip
    """Add up all forces, by the number of the bead; return the Laplacian of the potential."""
    search = beads.search
    pairs, edges, n_beads = search.pairs, search.edges, np.uint64(len(beads.bead))
    laplacian = 0.0
    at = first_place()
    while at.slot < n_beads:
        at, n = next_pairs(at, n_beads, beads.ordered, search, 1.0)
        gather_crowds(pairs, n, density)
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
    find_slots(slot, identity, Share(np.uint64(0), n_beads))
    add_bonded(total, beads.x, slot, bonds, angles, arms, others, virial, sums, edges)
    laplacian += bond_curvature(beads.x, slot, bonds, arms, edges)
    laplacian += angle_curvature(beads.x, slot, angles, arms, others, edges)
    return laplacian + add_wall_curvature(total, beads.x, species, walls)


@inlined()
def add_slopes(slopes, many_body, i, j, r, separation, p, edges):
    """Add a pair's slopes of both densities by each bead's own place; return what else it adds.

    That are the squares of those by the other bead's place; 0 without many-body forces.
    """
    if slopes is None:
        return 0.0
    steep = slope(many_body, r)
    push_apart(slopes, i, j, steep / r, separation, p, edges)
    return 2.0 * steep * steep


@inlined(given="arms")
def add_bonded(total, x, slot, bonds, angles, arms, others, virial, sums, edges):
    """Add the forces of all bonds and angles, if there are any."""
    add_bonds(
        total, x, slot, bonds.law, bonds.members, 0, len(bonds.members), arms, virial, sums,
        False, edges, None,
    )  # fmt: skip
    if angles is not None:
        add_angles(
            total, x, slot, angles.law, angles.members, 0, len(angles.members), arms, others,
            virial, sums, False, edges, None,
        )  # fmt: skip
