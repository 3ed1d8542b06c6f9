"""Pairs for measurements: the same search as for forces, with a cutoff of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.pair import add_densities
from dpd.engine.queries.sorting import Sorted, sorted_beads
from dpd.engine.search import first_place, next_pairs
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.physics.many_body import ManyBody

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
CUTOFF = 1.0


def pair_histogram(
    position: np.ndarray,
    box: Sequence[float],
    farthest: float,
    bins: int,
    species: np.ndarray | None = None,
) -> np.ndarray:
    """Count pairs by distance, and by their species if these are given.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    box : tuple
        Edges in r_c.
    farthest : float
        Largest distance, at most half the smallest edge.
    bins : int
        Equal bins from 0 to ``farthest``.
    species : (n,) uint8 array, optional

    Returns
    -------
    (bins,) or (species, species, bins) array
        Pairs at their nearest images, each counted once; by species they are symmetric, those of
        unlike beads stand on either side of the diagonal.
    """
    beads = sorted_beads(position, box, max(farthest, SMALLEST_CELL))
    place = np.empty(beads.search.pairs.i.size, np.uint32)
    if species is None:
        counts = np.zeros((1, 1, bins + 1), np.int64)
        _histogram(counts.ravel(), place, beads, None, farthest, bins)
    else:
        kinds = species[beads.bead].astype(np.uint32)
        count = int(kinds.max(initial=0)) + 1
        counts = np.zeros((count, count, bins + 1), np.int64)
        rows = kinds * np.uint32(count * (bins + 1)), kinds * np.uint32(bins + 1)
        _histogram(counts.ravel(), place, beads, rows, farthest, bins)
    counts[..., bins - 1] += counts[..., bins]  # rounding may reach the end
    found = counts[..., :bins].astype(float)
    if species is None:
        return found[0, 0]
    return found + np.where(np.eye(count)[..., None], 0.0, found.swapaxes(0, 1))


@kernel()
def _histogram(counts, place, beads, rows, farthest, bins):
    """Find the bins of some pairs, which makes a vector loop, then count."""
    search, separation = beads.search, beads.search.pairs.separation
    scale = bins / farthest
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, farthest)
        for p in range(n):
            r2 = 0.0
            for k in range(len(search.edges)):
                r2 += separation[k, p] * separation[k, p]
            place[p] = np.uint32(np.int32(np.sqrt(r2) * scale))
        if rows is not None:
            for p in range(n):
                place[p] += rows[0][search.pairs.i[p]] + rows[1][search.pairs.j[p]]
        for p in range(n):
            counts[place[p]] += 1


def neighbour_pairs(
    position: np.ndarray, species: np.ndarray, box: Sequence[float], farthest: float, count: int
) -> np.ndarray:
    """Count pairs of beads that are near each other, by their species.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    species : (n,) uint8 array
    box : tuple
        Edges in r_c.
    farthest : float
        Largest distance, at most half the smallest edge.
    count : int
        Number of species.

    Returns
    -------
    (count, count) array
        Pairs at their nearest images: symmetric, each counted once on the diagonal and once on
        either side of it.
    """
    sums = np.zeros((2, count, count))
    _by_species(sums, sorted_beads(position, box, farthest), species, farthest)
    return _symmetric(sums[0])


def soft_energies(
    position: np.ndarray, species: np.ndarray, box: Sequence[float], repulsion: np.ndarray
) -> np.ndarray:
    """Energy of the soft repulsion (`dpd.physics.repulsion`) of all pairs of two species.

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
    sums = np.zeros((2, *repulsion.shape))
    _by_species(sums, sorted_beads(position, box, CUTOFF), species, CUTOFF)
    return 0.5 * repulsion * _symmetric(sums[1])


def densities(beads: Sorted, law: ManyBody | None) -> np.ndarray | None:
    """Local density of the bead in each slot, (n,); None without many-body forces."""
    if law is None:
        return None
    density = np.zeros(len(beads.bead))
    _add_densities(density, beads, law)
    return density


@kernel()
def _add_densities(density, beads, law):
    search = beads.search
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, law.range)
        add_densities(density, search.pairs, n, law, search.edges)


def _symmetric(sums):
    return sums + sums.T - np.diag(np.diag(sums))


@kernel()
def _by_species(sums, beads, species, farthest):
    """Count pairs by species, and add up (1 - r)^2 of them."""
    search = beads.search
    pairs, separation = search.pairs, search.pairs.separation
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, farthest)
        for p in range(n):
            r2 = 0.0
            for k in range(len(search.edges)):
                r2 += separation[k, p] * separation[k, p]
            w = 1.0 - np.sqrt(r2)
            one, other = species[beads.bead[pairs.i[p]]], species[beads.bead[pairs.j[p]]]
            sums[0, one, other] += 1.0
            sums[1, one, other] += w * w
