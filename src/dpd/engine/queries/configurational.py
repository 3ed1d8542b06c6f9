"""Forces and curvature of the potential, whose ratio is a temperature without velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.bond_forces import (
    add_bond_forces,
    batches,
    bond_curvature,
    bonded_of,
    empty_slots,
    find_slots,
)
from dpd.engine.external import add_wall_curvature
from dpd.engine.neighbours.cells import grid
from dpd.engine.neighbours.search import first_place, next_pairs
from dpd.engine.pair_forces import CLOSEST, gather_repulsion, repulsion_of
from dpd.engine.queries.sorted_beads import sorted_beads
from dpd.engine.space import space_of
from dpd.engine.state import Beads, Sums
from dpd.engine.threads.team import Share
from dpd.engine.vectors.arrays import rows_of
from dpd.engine.vectors.rows import push_apart
from dpd.jit import kernel
from dpd.physics.forces import curvature, force

if TYPE_CHECKING:
    from dpd.engine.state import State, System


def force_and_curvature(system: System, state: State) -> np.ndarray:
    """Sum of squared conservative forces, and the Laplacian of the potential.

    In equilibrium <sum F_i^2> = kT <sum nabla_i^2 U> (Rugh 1997; Butler et al. 1998).

    Parameters
    ----------
    system : System
        With a pair force that has a curvature everywhere: no core.
    state : State

    Returns
    -------
    (2,) array
        In (kT / r_c)^2 and kT / r_c^2.
    """
    rows = rows_of(state.position)
    beads = Beads(rows, rows, None, state.identity, state.species, None)
    space = space_of(system.box)
    return _sums(
        beads, system.forces.pair, bonded_of(system), system.walls, space, grid(space, 1.0)
    )


@kernel()
def _sums(beads, pair, bonds, walls, space, grid):
    dimension, n_beads = len(space.edges), len(beads.identity)
    ordered, search = sorted_beads(beads, space, grid)
    pairs, species = search.pairs, ordered.species
    total = np.zeros_like(beads.position)
    laplacian = 0.0
    at = first_place()
    while at.slot < n_beads:
        at, n = next_pairs(at, n_beads, ordered.position, search, 1.0)
        gather_repulsion(pairs, n, species, pair)
        for p in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            r = np.sqrt(r2)
            w = max(0.0, 1.0 - r)
            a = repulsion_of(pairs, p, species, pair)
            over_r = force(pair, a, r, w) / r
            # u'' + (d - 1) u' / r, for both beads of the pair
            laplacian += 2.0 * (curvature(pair, a, r, w) - (dimension - 1) * over_r)
            push_apart(total, pairs.i[p], pairs.j[p], over_r, pairs.separation, p, space)
    slot = empty_slots(bonds, n_beads)
    find_slots(slot, ordered.identity, Share(np.uint64(0), np.uint64(n_beads)))
    sums = Sums(np.zeros((2, dimension, dimension)), np.zeros(2))
    for batch in range(batches(bonds)):
        add_bond_forces(total, ordered.position, slot, bonds, batch, space, sums, False)
    laplacian += bond_curvature(ordered.position, slot, bonds, space)
    laplacian += add_wall_curvature(total, ordered.position, species, walls)
    return np.array([(total * total).sum(), laplacian])
