"""Pairs of beads for measurements, found with any cutoff; density waves, and displacements."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dpd.engine import space
from dpd.engine.forces import length
from dpd.engine.neighbours import (
    Search,
    first_place,
    line_buffers,
    longest_line,
    near_pairs,
    next_pairs,
    pair_buffers,
)
from dpd.engine.rows import aligned, rows_of
from dpd.engine.threads import Share
from dpd.jit import inlined, kernel

SMALLEST_CELL = 0.5  # r_c; smaller cells only cost memory
CHUNK = 256  # beads that are worked on together: their waves along each axis stay in cache


class Sorted(NamedTuple):
    """Positions as they were given and sorted by cell, the bead in each slot, and a search."""

    x: np.ndarray
    ordered: np.ndarray
    bead: np.ndarray
    search: Search


def sorted_beads(position: np.ndarray, box: Sequence[float], cutoff: float) -> Sorted:
    """Positions inside the box, to be searched for pairs nearer than a cutoff in r_c."""
    x, edges, grid = rows_of(position), space.edges_of(box), space.grid_of(box, cutoff)
    ordered, bead, slide = aligned(x.shape), np.empty(len(x), np.uint32), space.slide_of(box)
    cells = space.cell_buffers(grid, len(x), 1)
    _sort(x, ordered, bead, cells, grid.shape, edges, slide)
    line = line_buffers(grid, int(longest_line(cells.most, grid)))
    return Sorted(
        x, ordered, bead, Search(cells, grid, line, pair_buffers(len(edges)), edges, slide)
    )


@kernel()
def _sort(x, ordered, bead, cells, shape, edges, slide):
    start, single, cell, place, free, most = cells
    mine = Share(np.uint64(0), np.uint64(len(bead)))
    space.count_cells(x, mine, cell, free[0], edges, shape, slide)
    space.share_cells(start, free, most)
    space.find_places(place, mine, cell, free[0])
    space.move_rows(x, ordered, mine, place, edges)
    space.copy_single(single, ordered, mine, edges, slide)
    for i in range(mine.first, mine.end):
        bead[place[i]] = np.uint32(i)


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
    place, count, rows = np.empty(beads.search.pairs.i.size, np.uint32), 1, None
    if species is not None:
        kinds = species[beads.bead].astype(np.uint32)
        count = int(kinds.max(initial=0)) + 1
        rows = kinds * np.uint32(count * (bins + 1)), kinds * np.uint32(bins + 1)
    counts = np.zeros((count, count, bins + 1), np.int64)
    _histogram(counts.ravel(), place, beads, rows, farthest, bins)
    found = counts[..., :bins].astype(float)
    if species is None:
        return found[0, 0]
    return found + np.where(np.eye(count)[..., None], 0.0, found.swapaxes(0, 1))


@kernel()
def _histogram(counts, place, beads, rows, farthest, bins):
    """Find the bins of some pairs, which makes a vector loop, then count; others are beyond all."""
    search, separation = beads.search, beads.search.pairs.separation
    scale = bins / farthest
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = next_pairs(at, len(beads.bead), beads.ordered, search, farthest)
        for p in range(n):
            r = length(separation, p, search.edges)
            place[p] = np.uint32(np.int32(min(r * scale, float(bins))))
        if rows is not None:
            for p in range(n):
                place[p] += rows[0][search.pairs.i[p]] + rows[1][search.pairs.j[p]]
        for p in range(n):
            counts[place[p]] += 1


def near_beads(
    position: np.ndarray, box: Sequence[float], within: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(pairs,) numbers of the two beads of each pair within a distance, and their distances."""
    beads, (d, n) = sorted_beads(position, box, max(within, SMALLEST_CELL)), position.shape
    room = int(2.6 * n * n * within**d / np.prod(box))  # of a fluid; one search is enough there
    while True:
        ends, distance = np.empty((2, room), np.uint32), np.empty(room)
        if (count := _list_near(ends, distance, beads, within)) <= room:
            return *ends[:, :count], distance[:count]
        room = count


@kernel()
def _list_near(ends, distance, beads, within):
    """Write down pairs where there is room for them, and count them all."""
    pairs, edges, count = beads.search.pairs, beads.search.edges, 0
    at = first_place()
    while at.slot < len(beads.bead):
        at, n = near_pairs(at, len(beads.bead), beads.ordered, beads.search, within)
        for p in range(n if count + n <= len(distance) else 0):
            distance[count + p] = length(pairs.separation, p, edges)
            ends[0, count + p] = beads.bead[pairs.i[p]]
            ends[1, count + p] = beads.bead[pairs.j[p]]
        count += n
    return count


def density_waves(
    position: np.ndarray, box: Sequence[float], begins: np.ndarray, numbers: np.ndarray
) -> np.ndarray:
    """(2, species, waves): real and negative imaginary part of rho(q) = sum_j exp(-i q r_j).

    Positions, (dimension, n), are species after species; ``begins`` has the first bead of each
    and the number of all; ``numbers``, (waves, dimension), are the whole m of q = 2 pi m / L.
    Waves that differ in the last axis alone, and follow each other, share half of the work.
    """
    share, most = position / np.array(box)[:, None], int(np.abs(numbers).max(initial=0))
    # A row for each head, all axes but the last, with the place of the wave of each last number.
    differs = (np.diff(numbers[:, :-1], axis=0, prepend=most + 1) != 0).any(axis=1)
    place = np.full((differs.sum(), 2 * most + 1), -1)
    place[np.cumsum(differs) - 1, numbers[:, -1] + most] = np.arange(len(numbers))
    found = np.zeros((2, len(begins) - 1, len(numbers)))
    waves = np.empty((2, len(box), most + 1, CHUNK))
    _add_waves(found, share, begins, numbers[differs], place, *waves, np.empty((2, CHUNK)))
    return found


@kernel()
def _add_waves(found, share, begins, heads, place, cosine, sine, head):
    last, most = len(share) - 1, cosine.shape[1] - 1
    for species in range(len(begins) - 1):
        for first in range(begins[species], begins[species + 1], CHUNK):
            n = min(CHUNK, begins[species + 1] - first)
            _waves_along_axes(share, first, n, cosine, sine)
            for row in range(len(heads)):
                _put_head(head, heads[row], n, cosine, sine)
                for m in range(most + 1):
                    up, down = place[row, most + m], place[row, most - m]
                    if up < 0 and down < 0:
                        continue
                    rc, rs, ic, js = 0.0, 0.0, 0.0, 0.0
                    for p in range(n):
                        c, s = cosine[last, m, p], sine[last, m, p]
                        rc += head[0, p] * c
                        rs += head[0, p] * s
                        ic += head[1, p] * c
                        js += head[1, p] * s
                    if up >= 0:
                        found[0, species, up] += rc - js
                        found[1, species, up] += ic + rs
                    if down >= 0 and m > 0:
                        found[0, species, down] += rc + js
                        found[1, species, down] += ic - rs


@inlined()
def _waves_along_axes(share, first, n, cosine, sine):
    """cos and sin of 2 pi m x / L of some beads, for each axis and each m from 0 on."""
    for k in range(len(share)):
        for p in range(n):
            angle = 2.0 * np.pi * share[k, first + p]
            cosine[k, 0, p], sine[k, 0, p] = 1.0, 0.0
            if cosine.shape[1] > 1:
                cosine[k, 1, p], sine[k, 1, p] = np.cos(angle), np.sin(angle)
        for m in range(2, cosine.shape[1]):  # by halves, so that rounding hardly adds up
            a, b = m // 2, m - m // 2
            for p in range(n):
                cosine[k, m, p] = cosine[k, a, p] * cosine[k, b, p] - sine[k, a, p] * sine[k, b, p]
                sine[k, m, p] = sine[k, a, p] * cosine[k, b, p] + cosine[k, a, p] * sine[k, b, p]


@inlined()
def _put_head(head, number, n, cosine, sine):
    """The product of the waves along all axes but the last."""
    for p in range(n):
        head[0, p], head[1, p] = 1.0, 0.0
    for k in range(len(number) - 1):
        m, sign = abs(number[k]), 1.0 if number[k] >= 0 else -1.0
        for p in range(n):
            c, s = cosine[k, m, p], sign * sine[k, m, p]
            real = head[0, p] * c - head[1, p] * s
            head[1, p] = head[0, p] * s + head[1, p] * c
            head[0, p] = real


@kernel()
def squared_displacements(found, now, then):
    """Find (earlier, points, n) |now - then|^2; ``then`` has one more axis in front than ``now``.

    Loops one inside the other in this order vectorise: a tenth of the time of NumPy's temporaries.
    """
    points, n = found.shape[1:]
    for i in range(len(then)):
        for p in range(points):
            for m in range(n):
                apart = now[0, p, m] - then[i, 0, p, m]
                found[i, p, m] = apart * apart
            for axis in range(1, len(now)):
                for m in range(n):
                    apart = now[axis, p, m] - then[i, axis, p, m]
                    found[i, p, m] += apart * apart


@kernel()
def add_lags(sums, means, found):
    """Add what was found for each lag, and its mean over molecules.

    To ``sums``, (lags, quantities, molecules), and ``means``, (lags, quantities), from the shortest
    lag on; ``found``, (lags, quantities or 1, molecules), is from the longest on.
    """
    lags, quantities, molecules = sums.shape
    for lag in range(lags):
        for quantity in range(quantities):
            q = min(quantity, found.shape[1] - 1)
            total = 0.0
            for m in range(molecules):
                one = found[lags - 1 - lag, q, m]
                sums[lag, quantity, m] += one
                total += one
            means[lag, quantity] += total / molecules
