"""Sums over all beads and pairs, taken in the loop at some of its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.integrate import of_bead_or_one
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


def across_of(system: System) -> Across | None:
    """The cells across the flow of a system; None in a fluid at rest."""
    if not system.flow:
        return None
    found = [(axis, *system.layers(axis, thickness)) for axis, thickness in system.flow]
    axis, low, length, layers = map(np.array, zip(*found))
    return Across(axis, low, layers / length, layers)


class Sampled(NamedTuple):
    """Sums of each sample, flat, and those of tasks that they are added up from."""

    # (samples, width): as `dpd.engine.state.Sums` has them
    moments: np.ndarray
    virial: np.ndarray
    energy: np.ndarray
    walls: np.ndarray | None  # (samples, width): None without walls
    place: np.ndarray  # (tasks, axes): where a bead is in its cell
    # (tasks, cells, q + 1, q): the moments of `PER_TASK` beads each, and their number
    of_beads: np.ndarray
    # (tasks, width): that, and what tasks have found, flat; 0 between samples
    moments_of: np.ndarray
    virial_of: np.ndarray
    energy_of: np.ndarray
    walls_of: np.ndarray | None  # (1, width)


def sampled_buffers(samples: int, beads: int, across: Across | None, shared: Any) -> Sampled:
    tasks, layers = -(-beads // PER_TASK), () if across is None else across.layers
    cells, q = int(np.prod(layers)), shared.virial.shape[2] + 1 + len(layers)
    of_beads = np.zeros((tasks, cells, q + 1, q))
    parts: dict[str, Any] = {
        "moments": of_beads.reshape(tasks, -1),
        "virial": shared.virial.reshape(len(shared.virial), -1),
        "energy": shared.energy,
        "walls": None if shared.at_walls is None else shared.at_walls.sums.reshape(1, -1),
    }
    rows: dict[str, Any] = {
        name: None if each is None else np.empty((samples, each.shape[1]))
        for name, each in parts.items()
    }
    return Sampled(
        **rows,
        place=np.zeros((tasks, len(layers))),
        of_beads=of_beads,
        **{f"{name}_of": each for name, each in parts.items()},
    )


@inlined()
def add_up_beads(team, beads, mass, across, sampled, edges):
    """Add up the moments of the velocities."""
    x, v, species = beads.position, beads.velocity, beads.species
    for task in range(team.rank, sampled.place.shape[0], team.size):
        first, end = task * PER_TASK, (task + 1) * PER_TASK
        if end > x.shape[0]:
            end = x.shape[0]
        some = Share(np.uint64(first), np.uint64(end))
        if across is None:
            find_one_cell(sampled.of_beads[task, 0], v, species, mass, some, edges)
        else:
            add_moments(
                sampled.of_beads[task], sampled.place[task], x, v, species, mass, across, some,
                edges,
            )  # fmt: skip


@inlined()
def find_one_cell(moments, v, species, mass, some, edges):
    """Those of one cell, where w = (v, 1), in registers: three times as fast."""
    one, z = len(edges), len(edges) - 1  # in two dimensions z is y
    total, px, py, pz, xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(some.first, some.end):
        m = of_bead_or_one(mass, species, s)
        mx, my, mz = m * v[s, 0], m * v[s, 1], m * v[s, z]
        total += m
        px, py, pz = px + mx, py + my, pz + mz
        xx, xy, xz = xx + mx * v[s, 0], xy + mx * v[s, 1], xz + mx * v[s, z]
        yy, yz, zz = yy + my * v[s, 1], yz + my * v[s, z], zz + mz * v[s, z]
    moments[0, 0], moments[1, 1], moments[z, z], moments[one, one] = xx, yy, zz, total
    moments[0, 1], moments[0, z], moments[1, z] = xy, xz, yz
    moments[1, 0], moments[z, 0], moments[z, 1] = xy, xz, yz
    moments[0, one], moments[1, one], moments[z, one] = px, py, pz
    moments[one, 0], moments[one, 1], moments[one, z] = px, py, pz
    moments[one + 1, 0] = some.end - some.first


@inlined()
def add_moments(moments, place, x, v, species, mass, across, some, edges):
    """Add the sums of m w w over some beads, cell by cell; below the matrix, their number.

    With w = (v, 1, s), s being the places of a bead along the axes of its cell, in layers from the
    middle.
    """
    axes, one = len(across.axis), len(edges)
    for s in range(some.first, some.end):
        m, cell = of_bead_or_one(mass, species, s), np.int64(0)
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
    """Put the sums of all tasks into row k, and zero in their place."""
    for q in range(to.shape[1]):
        total = 0.0
        for task in range(parts.shape[0]):
            total += parts[task, q]
            parts[task, q] = 0.0
        to[k, q] = total
