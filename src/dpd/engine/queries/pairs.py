"""Pairs for measurements: the same search as for forces, with a cutoff of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.queries.sorting import sorted_beads
from dpd.engine.search import first_place, next_pairs
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.engine.state import State

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
CUTOFF = 1.0


def pair_histogram(
    position: np.ndarray, box: Sequence[float], farthest: float, bins: int,
    species: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """Count pairs by distance, and by their species if these are given.

    Parameters
    ----------
    position : (dimension, n) array
        Inside the box.
    box : tuple
        Edges in r_c.
    farthest : float
        Largest distance, at most half the smallest edge; bins are equal from 0 to there.

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


def near_by_species(state: State, box: Sequence[float], count: int) -> np.ndarray:
    """(2, species, species) array: numbers of pairs within the cutoff, and their (1 - r)^2 summed.

    Both are symmetric: those of unlike beads stand on either side of the diagonal.
    """
    beads, sums = sorted_beads(state.position, box, CUTOFF), np.zeros((2, count, count))
    kinds = np.zeros(len(beads.bead), np.uint8) if state.species is None else state.species
    _by_species(sums, beads, kinds[beads.bead])
    return sums + sums.swapaxes(1, 2) * ~np.eye(count, dtype=bool)


@kernel()
def _by_species(sums, beads, species):
    pairs, edges = beads.search.pairs, beads.search.edges
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, beads.search, CUTOFF)
        for p in range(n):
            r2 = 0.0
            for k in range(len(edges)):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            w = 1.0 - np.sqrt(r2)
            one, other = species[pairs.i[p]], species[pairs.j[p]]
            sums[0, one, other] += 1.0
            sums[1, one, other] += w * w
