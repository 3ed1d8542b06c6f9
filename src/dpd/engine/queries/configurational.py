"""Forces and curvature of the potential, whose ratio is a temperature without velocities."""

import numpy as np

from dpd.engine.bonds import add_bond_forces, batches, find_slots, make_bonds, no_slots
from dpd.engine.neighbours.cells import cell_buffers, empty_like, grid, sort_by_cell
from dpd.engine.neighbours.search import next_pairs, search_buffers
from dpd.engine.vectors.arrays import rows_of
from dpd.engine.vectors.rows import push_apart
from dpd.jit import kernel, part
from dpd.physics.pair import CLOSEST, pair_repulsion, strength_of


def force_and_curvature(position, identity, species, repulsion, bonds, box):
    """Sum of squared conservative forces, and the Laplacian of the potential.

    In equilibrium <sum F_i^2> = kT <sum nabla_i^2 U> (Rugh 1997; Butler et al. 1998).

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    identity : (n,) uint32 array
    species : (n,) uint8 array or None
    repulsion : (species, species) array
    bonds : None or (members, stiffness, length)
    box : tuple

    Returns
    -------
    (2,) array
        In (kT / r_c)^2 and kT / r_c^2.
    """
    bonds = None if bonds is None else make_bonds(*bonds)
    return _sums(rows_of(position), identity, species, repulsion, bonds, box, grid(box, 1.0))


@kernel()
def _sums(position, identity, species, repulsion, bonds, box, grid):
    dimension, beads = len(box), len(position)
    source = (position, position, None, identity, species)
    ordered = empty_like(source)
    cells = cell_buffers(grid, beads, 1)
    sort_by_cell(source, ordered, box, grid, cells)
    place, _, _, number, kinds = ordered
    line, pairs = search_buffers(cells, box, grid)
    force = np.zeros_like(position)
    curvature = 0.0
    at = (0, -1)
    while at[0] < beads:
        at, n = next_pairs(at, beads, place, cells, box, grid, 1.0, line, pairs)
        strength = pairs.strength
        pair_repulsion(strength, pairs, n, kinds, repulsion)
        for p in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            r = np.sqrt(r2)
            a = strength_of(strength, p, kinds, repulsion)
            push = a * max(0.0, 1.0 - r) / r
            # u'' + (d - 1) u' / r, for both beads of the pair
            curvature += 2.0 * (a - (dimension - 1) * push)
            push_apart(force, pairs.i[p], pairs.j[p], push, pairs.separation, p, box)
    slot = no_slots(bonds, beads)
    find_slots(slot, number, (np.uint64(0), np.uint64(beads)))
    virial, energy = np.zeros((2, dimension, dimension)), np.zeros(2)
    for batch in range(batches(bonds)):
        add_bond_forces(force, place, slot, bonds, batch, box, False, virial, energy)
    curvature += bond_curvature(place, slot, bonds, box)
    return np.array([(force * force).sum(), curvature])


@part()
def bond_curvature(position, slot, bonds, box):
    """The part of bonds in the Laplacian."""
    if bonds is None:
        return 0.0
    total = 0.0
    for b in range(len(bonds.members)):
        i, j = slot[bonds.members[b, 0]], slot[bonds.members[b, 1]]
        r2 = CLOSEST
        for k in range(len(box)):
            d = position[i, k] - position[j, k]
            d -= box[k] * np.rint(d / box[k])
            r2 += d * d
        pull = 1.0 - bonds.length / np.sqrt(r2)
        total += 2.0 * bonds.stiffness * (1.0 + (len(box) - 1) * pull)
    return total
