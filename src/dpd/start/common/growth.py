"""Chains that grow by one monomer at a time, in two dimensions and without crossing.

An active end picks a free monomer within the reaction radius; the new bond is refused if
it would cross an existing one (Liu et al. 2008, Sec. II C).
"""

from typing import NamedTuple

import numpy as np

from dpd.engine.images import nearest_image
from dpd.jit import inlined, kernel

FREE = -1  # of a monomer that belongs to no chain
TRIED, CROSSED, FAR, MADE = range(4)  # what `grow` counts


@kernel()
def segments_intersect(ax, ay, bx, by, cx, cy, dx, dy):
    """Whether the closed segments AB and CD have a point in common.

    The point t1 A + (1 - t1) B = t2 C + (1 - t2) D of Liu et al. 2008, Eqs. 6 to 9, with
    the division that the text's t2 has lost. Parallel segments meet if they lie on one
    line and an end of one lies on the other.
    """
    m, n = ax - bx, ay - by
    p, q = dx - cx, dy - cy
    u, v = dx - bx, dy - by
    below = m * q - n * p
    if below != 0.0:
        t1 = (u * q - p * v) / below
        t2 = (m * v - n * u) / below
        return 0.0 <= t1 <= 1.0 and 0.0 <= t2 <= 1.0
    if m * v - n * u != 0.0 or p * v - q * u != 0.0:
        return False
    if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx):
        return False
    return not (max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by))


@inlined()
def cell_at(x, y, edges, shape):
    """Column and row of the cell of a point inside the box."""
    a = min(int(x * (shape[0] / edges[0])), shape[0] - 1)
    return a, min(int(y * (shape[1] / edges[1])), shape[1] - 1)


@inlined()
def cell_of_image(x, y, edges, shape):
    """The same for a point anywhere."""
    width, height = edges
    x -= width * np.floor(x / width)
    y -= height * np.floor(y / height)
    return cell_at(x, y, edges, shape)


@inlined()
def around(along, cells):
    """First and last offset to the neighbours of a cell, each cell once."""
    if cells >= 3:
        return -1, 2
    return -along, cells - along


class Chains(NamedTuple):
    """Chains while they grow; all arrays are changed.

    Attributes
    ----------
    chain : (n,) int64 array
        Chain of each bead, or `FREE`.
    beads : (chains, longest) int64 array
        Identities along each chain.
    length : (chains,) int64 array
        Beads in each chain.
    """

    chain: np.ndarray
    beads: np.ndarray
    length: np.ndarray


class Rule(NamedTuple):
    """How a chain takes up a monomer: within a radius, at random or the nearest one first.

    Attributes
    ----------
    species : (n,) uint8 array
        Of the beads.
    wanted : (chains, longest) int64 array
        Species along each chain.
    """

    radius: float
    nearest: bool
    species: np.ndarray
    wanted: np.ndarray


class BondCells(NamedTuple):
    """Bonds in the cells of their middles, as linked lists.

    Attributes
    ----------
    head : (columns, rows) int64 array
        The bond that was put last into each cell, or -1.
    following : (n,) int64 array
        The one before it, or -1.
    ends : (2, n) int64 array
    """

    head: np.ndarray
    following: np.ndarray
    ends: np.ndarray


@inlined()
def insert_bond(b, first, second, position, edges, bonds):
    """Put a bond into the cell of its middle."""
    x, y = position[0, first], position[1, first]
    x += 0.5 * nearest_image(position[0, second] - x, edges[0])
    y += 0.5 * nearest_image(position[1, second] - y, edges[1])
    a, c = cell_of_image(x, y, edges, bonds.head.shape)
    bonds.ends[0, b], bonds.ends[1, b] = first, second
    bonds.following[b] = bonds.head[a, c]
    bonds.head[a, c] = b


@inlined()
def crosses_some(end, monomer, position, edges, bonds):
    """Whether a bond between two beads would cross an existing one."""
    width, height = edges
    shape = bonds.head.shape
    ax, ay = position[0, end], position[1, end]
    bx = ax + nearest_image(position[0, monomer] - ax, width)
    by = ay + nearest_image(position[1, monomer] - ay, height)
    x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
    a, c = cell_of_image(x, y, edges, shape)
    low_a, high_a = around(a, shape[0])
    low_c, high_c = around(c, shape[1])
    for i in range(low_a, high_a):
        for j in range(low_c, high_c):
            b = bonds.head[(a + i) % shape[0], (c + j) % shape[1]]
            while b >= 0:
                first, second = bonds.ends[0, b], bonds.ends[1, b]
                if first != end and second != end:
                    # The image of the bond that is near is the one whose middle is.
                    cx, cy = position[0, first], position[1, first]
                    hx = 0.5 * nearest_image(position[0, second] - cx, width)
                    hy = 0.5 * nearest_image(position[1, second] - cy, height)
                    mx = x + nearest_image(cx + hx - x, width)
                    my = y + nearest_image(cy + hy - y, height)
                    if segments_intersect(ax, ay, bx, by, mx - hx, my - hy, mx + hx, my + hy):
                        return True
                b = bonds.following[b]
    return False


@kernel(allocates=True)
def grow(position, edges, shape, rule, chains, active, rng):
    """Let every active end try to take up one monomer.

    Parameters
    ----------
    position : (2, n) array
        In the order of identities, inside the box.
    shape : tuple
        Cells, whose edges are at least the radius, and at least half the sum of the radius and
        the longest bond.
    active : (ends,) int64 array
        Chains with an active end, in the order in which they try.

    Returns
    -------
    (4,) int64 array
        Bonds tried, refused for crossing, refused for distance, made.
    """
    n = position.shape[1]
    chain, beads, length = chains
    counts = np.zeros(4, np.int64)
    head = np.full(shape, -1)
    following = np.empty(n, np.int64)
    for i in range(n):
        if chain[i] == FREE:
            a, c = cell_at(position[0, i], position[1, i], edges, shape)
            following[i] = head[a, c]
            head[a, c] = i
    bonds = BondCells(np.full(shape, -1), np.empty(n, np.int64), np.empty((2, n), np.int64))
    made = 0
    for c in range(len(length)):
        for k in range(length[c] - 1):
            insert_bond(made, beads[c, k], beads[c, k + 1], position, edges, bonds)
            made += 1
    near = np.empty(n, np.int64)
    order = np.empty(n)
    for c in active:
        end = beads[c, length[c] - 1]
        x, y = position[0, end], position[1, end]
        a, b = cell_at(x, y, edges, shape)
        low_a, high_a = around(a, shape[0])
        low_b, high_b = around(b, shape[1])
        found = 0
        for i in range(low_a, high_a):
            for j in range(low_b, high_b):
                monomer = head[(a + i) % shape[0], (b + j) % shape[1]]
                while monomer >= 0:
                    wanted = rule.species[monomer] == rule.wanted[c, length[c]]
                    if chain[monomer] == FREE and wanted:
                        dx = nearest_image(position[0, monomer] - x, edges[0])
                        dy = nearest_image(position[1, monomer] - y, edges[1])
                        counts[TRIED] += 1
                        if dx * dx + dy * dy > rule.radius * rule.radius:
                            counts[FAR] += 1
                        else:
                            near[found] = monomer
                            order[found] = dx * dx + dy * dy if rule.nearest else rng.random()
                            found += 1
                    monomer = following[monomer]
        while found > 0:
            best = 0
            for t in range(1, found):
                if order[t] < order[best]:
                    best = t
            monomer = near[best]
            found -= 1
            near[best], order[best] = near[found], order[found]
            if crosses_some(end, monomer, position, edges, bonds):
                counts[CROSSED] += 1
                continue
            insert_bond(made, end, monomer, position, edges, bonds)
            made += 1
            beads[c, length[c]] = monomer
            length[c] += 1
            chain[monomer] = c
            counts[MADE] += 1
            break
    return counts
