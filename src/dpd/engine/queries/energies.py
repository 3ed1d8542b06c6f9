"""Energies of pairs by the species of their beads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.neighbours.cells import grid
from dpd.engine.neighbours.search import first_place, next_pairs
from dpd.engine.queries.sorted_beads import sorted_beads
from dpd.engine.space import space_of
from dpd.engine.state import Beads
from dpd.engine.vectors.arrays import rows_of
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

CUTOFF = 1.0


def soft_energies(
    position: np.ndarray, species: np.ndarray, box: Sequence[float], repulsion: np.ndarray
) -> np.ndarray:
    """Energy of the soft repulsion (`dpd.physics.soft`) of all pairs of two species.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    species : (n,) uint8 array
    box : tuple
        Edges in r_c.
    repulsion : (species, species) array
        a_ij.

    Returns
    -------
    (species, species) array
        In kT; symmetric, the energy of unlike beads stands on either side of the diagonal.
    """
    space = space_of(box)
    squares = _squares(rows_of(position), species, space, grid(space, CUTOFF), len(repulsion))
    squares = squares + squares.T - np.diag(np.diag(squares))
    return 0.5 * repulsion * squares


@kernel()
def _squares(position, species, space, grid, count):
    """Sums of (1 - r)^2 over pairs within the cutoff."""
    beads = Beads(position, position, None, np.empty(len(position), np.uint32), species, None)
    ordered, search = sorted_beads(beads, space, grid)
    pairs = search.pairs
    separation = pairs.separation
    sums = np.zeros((count, count))
    at = first_place()
    while at.slot < len(position):
        at, n = next_pairs(at, len(position), ordered.position, search, 1.0)
        for p in range(n):
            r2 = 0.0
            for k in range(len(space.edges)):
                r2 += separation[k, p] * separation[k, p]
            w = 1.0 - np.sqrt(r2)
            sums[ordered.species[pairs.i[p]], ordered.species[pairs.j[p]]] += w * w
    return sums
