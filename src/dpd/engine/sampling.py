"""Sums over all beads and pairs, taken in the loop at some of its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.integrate import of_bead_or_one
from dpd.engine.rows import flat
from dpd.engine.threads import Share
from dpd.jit import inlined

if TYPE_CHECKING:
    from dpd.engine.state import System

PER_TASK = 1024  # beads that one thread adds up: the order of sums is the same for any team


class Across(NamedTuple):
    """Cells across a flow: layers along some axes."""

    axis: np.ndarray  # (axes,) int64
    low: np.ndarray  # (axes,): where the first layer begins
    per: np.ndarray  # (axes,): layers in 1 r_c
    layers: np.ndarray  # (axes,) int64: how many


def across_of(system: System) -> Across:
    """The cells across the flow of a system; one, without axes, in a fluid at rest."""
    found = [(axis, *system.layers(axis, thickness)) for axis, thickness in system.flow]
    axis, low, length, layers = np.array(found, float).reshape(-1, 4).T
    return Across(axis.astype(np.int64), low.copy(), layers / length, layers.astype(np.int64))


class Sampled(NamedTuple):
    """Sums of each sample, and those of beads that they are added up from."""

    # (samples, cells, q + 1, q): as `dpd.engine.state.Sums` has them, below each matrix the beads
    moments: np.ndarray
    virial: np.ndarray  # (samples, 2, dimension, dimension)
    energy: np.ndarray  # (samples, 2)
    walls: np.ndarray | None  # (samples, walls, 2 + dimension); None without walls
    place: np.ndarray  # (tasks, axes): where a bead is in its cell
    of_beads: np.ndarray  # (tasks, cells, q + 1, q): of `PER_TASK` beads each; 0 between samples


def sampled_buffers(
    samples: int, beads: int, across: Across, virial: np.ndarray, walls: np.ndarray | None
) -> Sampled:
    """Room for so many samples of what tasks add to a virial, and walls to their sums."""
    tasks, layers = -(-beads // PER_TASK), across.layers
    cells, q = int(np.prod(layers)), virial.shape[2] + 1 + len(layers)
    return Sampled(
        np.empty((samples, cells, q + 1, q)),
        np.empty((samples, *virial.shape[1:])),
        np.empty((samples, 2)),
        None if walls is None else np.empty((samples, *walls.shape)),
        np.zeros((tasks, len(layers))),
        np.zeros((tasks, cells, q + 1, q)),
    )


@inlined()
def add_up_beads(team, beads, mass, across, sampled, edges):
    """Add up the moments of the velocities."""
    for task in range(team.rank, sampled.place.shape[0], team.size):
        first, end = task * PER_TASK, (task + 1) * PER_TASK
        if end > beads.position.shape[0]:
            end = beads.position.shape[0]
        some = Share(np.uint64(first), np.uint64(end))
        moments, place = sampled.of_beads[task], sampled.place[task]
        add_moments(moments, place, beads, mass, across, some, edges)


@inlined()
def add_moments(moments, place, beads, mass, across, some, edges):
    """Add the sums of m w w over some beads, cell by cell; below the matrix, their number.

    With w = (v, 1, s), s being the places of a bead along the axes of its cell, in layers from the
    middle.
    """
    x, v, axes, one = beads.position, beads.velocity, len(across.axis), len(edges)
    for s in range(some.first, some.end):
        m, cell = of_bead_or_one(mass, beads.species, s), np.int64(0)
        for a in range(axes):
            along = (x[s, across.axis[a]] - across.low[a]) * across.per[a]
            layer = np.int64(along)
            if layer >= across.layers[a]:
                layer = across.layers[a] - 1
            place[a] = along - layer - 0.5
            cell = cell * across.layers[a] + layer
        into = moments[cell]
        into[one + 1 + axes, 0] += 1.0
        into[one, one] += m
        for k in range(len(edges)):
            momentum = m * v[s, k]
            into[k, one] += momentum
            into[one, k] += momentum
            for q in range(len(edges)):
                into[k, q] += momentum * v[s, q]
            for a in range(axes):
                into[k, one + 1 + a] += momentum * place[a]
                into[one + 1 + a, k] += momentum * place[a]
        for a in range(axes):
            into[one, one + 1 + a] += m * place[a]
            into[one + 1 + a, one] += m * place[a]
            for b in range(axes):
                into[one + 1 + a, one + 1 + b] += m * place[a] * place[b]


@inlined(given="to")
def move_sums(to, k, parts):
    """Put the sums of all tasks in the place of sample k, and zero in theirs."""
    sums, found = flat(to), flat(parts)
    width = sums.shape[0] // to.shape[0]
    for q in range(width):
        total = 0.0
        for p in range(q, found.shape[0], width):
            total += found[p]
            found[p] = 0.0
        sums[k * width + q] = total
