"""Pairs of beads for measurements: positions sorted by cell, and a search with any cutoff."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.bonded import angles_of, bonds_of, buffers_of
from dpd.engine.cells import (
    cell_buffers,
    count_cells,
    find_places,
    grid_of,
    move_rows,
    share_cells,
)
from dpd.engine.pair import add_densities
from dpd.engine.rows import empty_rows, rows_of
from dpd.engine.search import (
    Search,
    first_place,
    line_buffers,
    longest_line,
    next_pairs,
    pair_buffers,
)
from dpd.engine.space import edges_of, slide_of
from dpd.engine.threads import Share
from dpd.jit import kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.engine.state import State, System

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
CUTOFF = 1.0


class Sorted(NamedTuple):
    """Positions as they were given and sorted by cell, the bead in each slot, and a search."""

    x: np.ndarray
    ordered: np.ndarray
    bead: np.ndarray
    search: Search


def sorted_beads(position: np.ndarray, box: Sequence[float], cutoff: float) -> Sorted:
    """Positions inside the box, to be searched for pairs nearer than a cutoff in r_c."""
    x, edges, grid = rows_of(position), edges_of(box), grid_of(box, cutoff)
    ordered, bead, slide = empty_rows(*x.shape), np.empty(len(x), np.uint32), slide_of(box)
    cells = cell_buffers(grid, len(x), 1)
    _sort(x, ordered, bead, *cells, grid.shape, edges, slide)
    line = line_buffers(grid, int(longest_line(cells.most, grid.base)))
    return Sorted(
        x, ordered, bead, Search(cells, grid, line, pair_buffers(len(edges)), edges, slide)
    )


@kernel()
def _sort(x, ordered, bead, start, level, cell, along, place, free, most, shape, edges, slide):
    """Sort positions by cell; fill ``ordered``, ``bead`` and the arrays of `Cells`."""
    mine = Share(np.uint64(0), np.uint64(len(bead)))
    count_cells(x, mine, cell, along, free[0], edges, shape, slide)
    share_cells(start, free, most, shape[len(edges) - 1])
    find_places(place, level, mine, cell, along, free[0])
    move_rows(x, ordered, mine, place, edges)
    for i in range(mine.first, mine.end):
        bead[place[i]] = np.uint32(i)


def terms_of(system: System, beads: Sorted) -> tuple[Any, ...]:
    """Density about the bead in each slot, bonds, angles, and room for slots and both arms.

    None for what a system does without.
    """
    density, bonds, d = None, bonds_of(system), system.dimension
    if system.many_body is not None:
        density = np.zeros(len(beads.bead))
        _add_densities(density, beads, system.many_body)
    angles = angles_of(system, bonds)
    slot = None if bonds is None else np.empty(len(beads.bead), np.uint32)
    arms = buffers_of(d, bonds, angles, whole=True), buffers_of(d, angles, whole=True)
    return density, bonds, angles, slot, *arms


@kernel()
def _add_densities(density, beads, law):
    search = beads.search
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, law.range)
        add_densities(density, search.pairs, n, law, search.edges)


def pair_histogram(
    position: np.ndarray, box: Sequence[float], farthest: float, bins: int,
    species: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """(bins,) array: pairs by distance, in equal bins up to ``farthest``, each counted once.

    With species (species, species, bins): those of unlike beads stand on either side of the
    diagonal. Positions, (dimension, n), are inside the box; ``farthest`` is at most half its
    smallest edge.
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
