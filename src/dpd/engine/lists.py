"""Lists of pairs that serve for several steps. Each thread keeps those of its own layers."""

from typing import NamedTuple

import numpy as np

from dpd.engine.arrays import columns
from dpd.engine.cells import count_cells, share_cells
from dpd.engine.jit import part
from dpd.engine.search import layer_of_pairs, next_pairs, search_buffers
from dpd.engine.team import LAYERS, PHASES, layer_of, layers_in, meet, take

CHUNK = 1024  # pairs whose forces are worked out together: their buffers stay in cache


class Listed(NamedTuple):
    """Pairs of some layers.

    Attributes
    ----------
    pairs : (2, n) uint32 array
        Slots.
    layer : (layers,) int64 array
        Numbers of the layers.
    end : (layers + 1,) int64 array
        ``end[q]`` pairs are listed before those of the q-th of them.
    phase : (phases + 1,) int64 array
        ``phase[f]`` of these layers belong to phases before f.
    """

    pairs: np.ndarray
    layer: np.ndarray
    end: np.ndarray
    phase: np.ndarray


@part()
def no_list(reference, grid, beads):
    """A list yet to be made; None where pairs are found by cells."""
    if reference is None:
        return None
    layers = grid.shape[0]
    pairs = np.empty((2, 8 * beads), np.uint32)
    return Listed(
        pairs,
        np.empty(layers, np.int64),
        np.zeros(layers + 1, np.int64),
        np.zeros(PHASES + 1, np.int64),
    )


@part()
def list_pairs(team, position, cells, box, grid, reach, listed):
    """All pairs within ``reach`` of beads of the layers that this thread gets hold of."""
    line, pairs = search_buffers(cells, box, grid)
    kept, count, total = listed.pairs, 0, 0
    for phase in range(PHASES):
        task = take(team, LAYERS + phase)
        while task < layers_in(phase, grid.shape[0]):
            layer = layer_of(phase, task, grid.shape[0])
            at, end = layer_of_pairs(layer, cells, grid)
            while at[0] < end:
                at, found = next_pairs(at, end, position, cells, box, grid, reach, line, pairs)
                n = np.int64(found)
                if total + n > kept.shape[1]:
                    kept = columns(kept, total, 2 * (total + n))
                for p in range(n):
                    kept[0, total + p] = pairs.i[p]
                    kept[1, total + p] = pairs.j[p]
                total += n
            listed.layer[count] = layer
            count += 1
            listed.end[count] = total
            task = take(team, LAYERS + phase)
        listed.phase[phase + 1] = count
    return Listed(kept, listed.layer, listed.end, listed.phase)


@part()
def listing(
    team, reference, position, own, sorted_now, first, listed, cells, box, grid, skin
):  # fmt: skip
    """The list after a sort, or for the first step of a call; else as it was.

    After a sort, the reference is where the beads are. A call begins with the list that was
    made at the reference it was given. (Numba drops the branch on None only of an argument
    that is never assigned to.)
    """
    if reference is None:
        return None
    if sorted_now:
        for k in range(len(box)):
            for i in range(own[0], own[1]):
                reference[k, i] = position[k, i]
    elif first:
        count_cells(reference, own, box, grid, cells, team.rank)
        meet(team)
        if team.rank == 0:
            share_cells(cells, grid)
        for i in range(own[0], own[1]):
            cells.level[i] = cells.along[i]
    if sorted_now or first:
        meet(team)
        return list_pairs(team, reference, cells, box, grid, 1.0 + skin, listed)
    return listed


@part()
def farthest_move(position, reference, own, box):
    """Largest squared distance of a bead from where the list was made; any without a list."""
    if reference is None:
        return np.inf
    farthest = 0.0
    for i in range(own[0], own[1]):
        r2 = 0.0
        for k in range(len(box)):
            d = position[k, i] - reference[k, i]
            d -= box[k] * np.rint(d / box[k])
            r2 += d * d
        farthest = max(farthest, r2)
    return farthest


@part()
def listed_pairs(first, end, position, listed, box, pairs):
    """Fill the pairs with up to `CHUNK` of the list from ``first`` to ``end``; return how many."""
    n = np.uint64(min(CHUNK, end - first))
    start = np.uint64(first)
    for p in range(n):
        pairs.i[p] = listed.pairs[0, start + p]
        pairs.j[p] = listed.pairs[1, start + p]
    for k in range(len(box)):
        edge = box[k]
        for p in range(n):
            d = position[k, pairs.i[p]] - position[k, pairs.j[p]]
            pairs.separation[k, p] = d - edge * np.rint(d / edge)
    return n
