"""Where in a box the virial of conservative forces lies: each pair's along the line of the pair."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.angle_forces import Opening, gather_angles, opening
from dpd.engine.bond_forces import bonded_of, empty_slots, find_slots
from dpd.engine.external import of_species
from dpd.engine.neighbours.cells import grid
from dpd.engine.neighbours.search import first_place, next_pairs
from dpd.engine.pair_forces import CLOSEST, gather_repulsion, repulsion_of
from dpd.engine.queries.sorted_beads import sorted_beads
from dpd.engine.space import nearest_images, space_of
from dpd.engine.state import Beads
from dpd.engine.threads.team import Share
from dpd.engine.vectors.arrays import rows_of
from dpd.jit import kernel, part
from dpd.physics.forces import force, force_over_r

if TYPE_CHECKING:
    from dpd.engine.state import State, System

NORMAL, TANGENTIAL = 0, 1
SHORTEST = 1e-12  # slices that a line has to cross to be cut: below it lies in one slice


class Slices(NamedTuple):
    """Equal slices across an axis.

    Attributes
    ----------
    axis, number : int
    low, high : float
        Where the first one begins in the box, and where the last one ends, in r_c.
    """

    axis: int
    number: int
    low: float
    high: float


def virial_in_slices(system: System, state: State, slices: Slices) -> np.ndarray:
    """The conservative virial in slices across an axis, after Irving and Kirkwood (1950).

    What a pair adds to the virial, r_ij F_ij, is spread evenly along the straight line between its
    beads at their nearest images, and each slice gets the share of the line that lies in it. So do
    bonds. In an angle i-j-k the force on bead i passes along the bond from j to i, and that on bead
    k along the bond from j to k; the middle bead feels the opposite of both. Forces of walls and
    body forces are left out.

    Parameters
    ----------
    system : System
        Without shear, and with the box as it is now.
    state : State
    slices : Slices
        They cover the box along the axis, or, between walls, all places of beads.

    Returns
    -------
    (2, slices) array
        In kT: the `NORMAL` element of the virial, and the `TANGENTIAL` one, which is the mean over
        the other axes. Summed over slices they are those of the whole virial.
    """
    rows = rows_of(state.position)
    beads = Beads(rows, rows, None, state.identity, state.species, None)
    space = space_of(system.box)
    pair, bonds = system.forces.pair, bonded_of(system)
    virial = _virial(beads, pair, bonds, space, grid(space, 1.0), slices)
    virial[TANGENTIAL] /= system.dimension - 1
    return virial


@kernel()
def _virial(beads, pair, bonds, space, grid, slices):
    n_beads = len(beads.identity)
    ordered, search = sorted_beads(beads, space, grid)
    virial = np.zeros((2, slices.number))
    add_pairs(virial, ordered, search, pair, slices)
    slot = empty_slots(bonds, n_beads)
    find_slots(slot, ordered.identity, Share(np.uint64(0), np.uint64(n_beads)))
    add_bonds(virial, ordered.position, slot, bonds, space, slices)
    return virial


@part()
def add_pairs(virial, beads, search, pair, slices):
    """Add what the soft forces between all pairs do."""
    pairs, dimension, n_beads = search.pairs, len(search.space.edges), len(beads.identity)
    at = first_place()
    while at.slot < n_beads:
        at, n = next_pairs(at, n_beads, beads.position, search, 1.0)
        gather_repulsion(pairs, n, beads.species, pair)
        for p in range(n):
            r2 = CLOSEST
            for k in range(dimension):
                r2 += pairs.separation[k, p] * pairs.separation[k, p]
            r = np.sqrt(r2)
            w = max(0.0, 1.0 - r)
            a = repulsion_of(pairs, p, beads.species, pair)
            along = pairs.separation[slices.axis, p]
            normal = force(pair, a, r, w) / r * along * along
            every = force(pair, a, r, w) / r * r2
            begin = beads.position[pairs.i[p], slices.axis]
            add_line(virial, begin, begin - along, normal, every - normal, slices)


@part()
def add_bonds(virial, position, slot, bonds, space, slices):
    """Add what bonds and the angles between them do, if there are any."""
    if bonds is None:
        return
    dimension, n = len(space.edges), np.uint64(len(bonds.members))
    apart = np.empty((dimension, n))
    for b in range(n):
        i, j = slot[bonds.members[b, 0]], slot[bonds.members[b, 1]]
        for k in range(dimension):
            apart[k, b] = position[i, k] - position[j, k]
    nearest_images(apart, n, space)
    for b in range(n):
        r2 = CLOSEST
        for k in range(dimension):
            r2 += apart[k, b] * apart[k, b]
        over_r = force_over_r(bonds.law, np.sqrt(r2), b)
        along = apart[slices.axis, b]
        normal = over_r * along * along
        begin = position[slot[bonds.members[b, 0]], slices.axis]
        add_line(virial, begin, begin - along, normal, over_r * r2 - normal, slices)
    add_angles(virial, position, slot, bonds.angles, space, slices)


@part()
def add_angles(virial, position, slot, angles, space, slices):
    """Add what angles do, along both bonds of each; see `add_angle_forces` for their forces."""
    if angles is None:
        return
    dimension, n = len(space.edges), np.uint64(len(angles.members))
    slots = np.empty((3, n), np.uint32)
    to_i, to_k = np.empty((dimension, n)), np.empty((dimension, n))
    gather_angles(to_i, to_k, slots, position, slot, angles, np.uint64(0), space)
    for a in range(n):
        at = opening(to_i, to_k, a, dimension)
        across = -force(angles.law, at.theta, a) * at.sine / (at.sine * at.sine + CLOSEST)
        add_arm(virial, position[slots[0, a], slices.axis], to_i, to_k, a, across, at, slices)
        turned = Opening(at.theta, at.cosine, at.sine, at.over_k, at.over_i)
        add_arm(virial, position[slots[2, a], slices.axis], to_k, to_i, a, across, turned, slices)


@part()
def add_arm(virial, begin, arm, other, a, across, at, slices):
    """Add what an angle does along one of its bonds, from the outer bead at ``begin``."""
    normal, every = 0.0, 0.0
    for k in range(len(arm)):
        push = across * at.over_i * (other[k, a] * at.over_k - at.cosine * arm[k, a] * at.over_i)
        every += arm[k, a] * push
        if k == slices.axis:
            normal += arm[k, a] * push
    add_line(virial, begin, begin - arm[slices.axis, a], normal, every - normal, slices)


@part()
def add_line(virial, begin, end, normal, tangential, slices):
    """Spread a virial evenly along a line over the slices that it crosses.

    Parameters
    ----------
    virial : (2, slices) array
    begin, end : float
        Of the line on the axis: one of them in the box, the other one up to an edge outside.
    normal, tangential : float
        What is to be spread.
    slices : Slices
    """
    per_length = slices.number / (slices.high - slices.low)
    low = (min(begin, end) - slices.low) * per_length
    high = (max(begin, end) - slices.low) * per_length
    first, last = int(np.floor(low)), int(np.floor(high))
    if first == last or high - low < SHORTEST:
        add_share(virial, last, 1.0, normal, tangential, slices)
        return
    over = 1.0 / (high - low)
    add_share(virial, first, (first + 1 - low) * over, normal, tangential, slices)
    for between in range(first + 1, last):
        add_share(virial, between, over, normal, tangential, slices)
    add_share(virial, last, (high - last) * over, normal, tangential, slices)


@part()
def add_share(virial, place, share, normal, tangential, slices):
    """Add a share to the slice at a place, which may lie in the next image of the box."""
    if place < 0:
        place += slices.number
    elif place >= slices.number:
        place -= slices.number
    virial[NORMAL, place] += share * normal
    virial[TANGENTIAL, place] += share * tangential


def wall_virial_in_slices(system: System, state: State, slices: Slices) -> np.ndarray:
    """What walls across the axis add to the normal pressure, in slices.

    The force of a wall on a bead passes along the normal from behind the wall, the end of the
    slices, to the bead. With it the mean normal pressure is the same in all slices, as in any fluid
    at rest; without, it rises over the range of the walls.

    Parameters
    ----------
    system : System
        With walls.
    state : State
    slices : Slices

    Returns
    -------
    (slices,) array
        In kT, as the normal virial of beads.
    """
    virial = np.zeros((2, slices.number))
    _add_walls(virial, rows_of(state.position), state.species, system.walls, slices)
    return virial[NORMAL]


@kernel()
def _add_walls(virial, position, species, walls, slices):
    for wall in range(len(walls.axis)):
        if walls.axis[wall] == slices.axis:
            place, inward = walls.place[wall], walls.inward[wall]
            end = slices.low if inward > 0.0 else slices.high
            for s in range(len(position)):
                z = inward * (position[s, slices.axis] - place)
                push = force(walls, of_species(walls.repulsion, species, s), z)
                if push > 0.0:
                    begin = position[s, slices.axis]
                    add_line(virial, begin, end, push * abs(begin - end), 0.0, slices)
