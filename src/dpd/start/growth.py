"""Chains that grow by one monomer at a time, in two dimensions and without crossing.

An active end picks a free monomer within the reaction radius; the new bond is refused if
it would meet an existing one (Liu et al. 2008, Sec. II C).
"""

import numpy as np

from dpd.jit import kernel, part

FREE = -1  # of a monomer that belongs to no chain
TRIED, CROSSED, FAR, MADE = range(4)  # what `grow` counts


@part()
def nearest_image(d, edge):
    """A difference of coordinates at its nearest image."""
    return d - edge * np.rint(d / edge)


@kernel()
def segments_meet(ax, ay, bx, by, cx, cy, dx, dy):
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


@part()
def cell_at(x, y, box, shape):
    """Column and row of the cell of a point inside the box."""
    a = min(int(x * (shape[0] / box[0])), shape[0] - 1)
    return a, min(int(y * (shape[1] / box[1])), shape[1] - 1)


@part()
def around(along, cells):
    """First and last offset to the neighbours of a cell, each cell once."""
    if cells >= 3:
        return -1, 2
    return -along, cells - along


@part()
def insert_bond(b, first, second, position, box, shape, head, following, ends):
    """Put a bond into the cell of its middle."""
    x, y = position[0, first], position[1, first]
    x += 0.5 * nearest_image(position[0, second] - x, box[0])
    y += 0.5 * nearest_image(position[1, second] - y, box[1])
    a, c = cell_at(x - box[0] * np.floor(x / box[0]), y - box[1] * np.floor(y / box[1]), box, shape)
    ends[0, b], ends[1, b] = first, second
    following[b] = head[a, c]
    head[a, c] = b


@part()
def crosses_some(end, monomer, position, box, shape, head, following, ends):
    """Whether a bond between two beads would meet an existing one."""
    ax, ay = position[0, end], position[1, end]
    bx = ax + nearest_image(position[0, monomer] - ax, box[0])
    by = ay + nearest_image(position[1, monomer] - ay, box[1])
    x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
    a, c = cell_at(x - box[0] * np.floor(x / box[0]), y - box[1] * np.floor(y / box[1]), box, shape)
    low_a, high_a = around(a, shape[0])
    low_c, high_c = around(c, shape[1])
    for i in range(low_a, high_a):
        for j in range(low_c, high_c):
            b = head[(a + i) % shape[0], (c + j) % shape[1]]
            while b >= 0:
                first, second = ends[0, b], ends[1, b]
                if first != end and second != end:
                    # The image of the bond that is near is the one whose middle is.
                    cx, cy = position[0, first], position[1, first]
                    hx = 0.5 * nearest_image(position[0, second] - cx, box[0])
                    hy = 0.5 * nearest_image(position[1, second] - cy, box[1])
                    mx = x + nearest_image(cx + hx - x, box[0])
                    my = y + nearest_image(cy + hy - y, box[1])
                    if segments_meet(ax, ay, bx, by, mx - hx, my - hy, mx + hx, my + hy):
                        return True
                b = following[b]
    return False


@kernel()
def grow(position, box, shape, radius, nearest, chain, species, beads, length, wanted, active, rng):
    """Let every active end try to take up one monomer.

    Parameters
    ----------
    position : (2, n) array
        In the order of identities, inside the box.
    box, shape : tuples
        Edges; cells, whose edges are at least the radius, and at least half the sum of
        the radius and the longest bond.
    radius : float
        Reaction radius.
    nearest : bool
        Try the nearest monomer first instead of one at random.
    chain : (n,) int64 array
        Chain of each bead, or `FREE`; changed.
    species : (n,) uint8 array
    beads : (chains, longest) int64 array
        Identities along each chain; changed.
    length : (chains,) int64 array
        Beads in each chain; changed.
    wanted : (chains, longest) int64 array
        Species along each chain.
    active : (ends,) int64 array
        Chains with an active end, in the order in which they try.
    rng : numpy.random.Generator

    Returns
    -------
    (4,) int64 array
        Bonds tried, refused for crossing, refused for distance, made.
    """
    n = position.shape[1]
    counts = np.zeros(4, np.int64)
    head = np.full(shape, -1)
    following = np.empty(n, np.int64)
    for i in range(n):
        if chain[i] == FREE:
            a, c = cell_at(position[0, i], position[1, i], box, shape)
            following[i] = head[a, c]
            head[a, c] = i
    bond_head = np.full(shape, -1)
    bond_following = np.empty(n, np.int64)
    ends = np.empty((2, n), np.int64)
    bonds = 0
    for c in range(len(length)):
        for k in range(length[c] - 1):
            insert_bond(
                bonds, beads[c, k], beads[c, k + 1], position, box, shape,
                bond_head, bond_following, ends,
            )  # fmt: skip
            bonds += 1
    near = np.empty(n, np.int64)
    order = np.empty(n)
    for c in active:
        end = beads[c, length[c] - 1]
        next_species = wanted[c, length[c]]
        x, y = position[0, end], position[1, end]
        a, b = cell_at(x, y, box, shape)
        low_a, high_a = around(a, shape[0])
        low_b, high_b = around(b, shape[1])
        found = 0
        for i in range(low_a, high_a):
            for j in range(low_b, high_b):
                monomer = head[(a + i) % shape[0], (b + j) % shape[1]]
                while monomer >= 0:
                    if chain[monomer] == FREE and species[monomer] == next_species:
                        dx = nearest_image(position[0, monomer] - x, box[0])
                        dy = nearest_image(position[1, monomer] - y, box[1])
                        counts[TRIED] += 1
                        if dx * dx + dy * dy > radius * radius:
                            counts[FAR] += 1
                        else:
                            near[found] = monomer
                            order[found] = dx * dx + dy * dy if nearest else rng.random()
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
            if crosses_some(end, monomer, position, box, shape, bond_head, bond_following, ends):
                counts[CROSSED] += 1
                continue
            insert_bond(bonds, end, monomer, position, box, shape, bond_head, bond_following, ends)
            bonds += 1
            beads[c, length[c]] = monomer
            length[c] += 1
            chain[monomer] = c
            counts[MADE] += 1
            break
    return counts
