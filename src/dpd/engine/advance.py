"""The compiled loop over steps."""

import numpy as np

from dpd.engine.bath import add_bath_forces
from dpd.engine.bonds import add_bond_forces, bonded_slots
from dpd.engine.cells import cell_of, row_buffers, row_pairs, starts_from_counts
from dpd.engine.forces import add_pair_forces, measure_pairs
from dpd.engine.friction import keep_pairs, kept_buffers, renew_friction
from dpd.engine.jit import kernel, part
from dpd.engine.noise import step_keys

FARTHEST = 1.0  # a bead that moves a cutoff along an axis in one step has lost its way


@part()
def drift(position, velocity, predicted, force, box, dt, scheme):
    """Move beads, predict velocities; return a bead that moved too far, or -1.

    On return ``velocity`` holds v + dt (1 - b) f, ``predicted`` holds v + lambda dt f.
    """
    acceleration, prediction, correction, _ = scheme
    lost, distance = -1, 0.0
    for k in range(len(box)):
        edge = box[k]
        for i in range(position.shape[1]):
            f, v = force[k, i], velocity[k, i]
            move = dt * v + acceleration * dt * dt * f
            if lost < 0 and not abs(move) <= FARTHEST:  # also true for NaN
                lost, distance = i, abs(move)
            x = position[k, i] + move
            x -= edge * np.floor(x / edge)
            position[k, i] = x if x < edge else 0.0
            predicted[k, i] = v + prediction * dt * f
            velocity[k, i] = v + (1.0 - correction) * dt * f
    return lost, distance


@part()
def count_cells(position, box, shape, start):
    """Fill ``start`` with the first slot of each cell; return the fullest cell's count."""
    start[:] = 0
    for i in range(position.shape[1]):
        start[cell_of(position, i, box, shape) + 1] += np.uint32(1)
    return starts_from_counts(start)


@part()
def sort_by_cell(source, target, box, shape, start):
    """Copy (position, velocity, predicted, identity, species) sorted by cell.

    The sort is stable, so the order of storage follows from the state alone and a
    resumed run adds up its forces in the same order as an uninterrupted one.

    Returns
    -------
    int
        Beads in the fullest cell.
    """
    position, velocity, predicted, identity, species = source
    n = position.shape[1]
    fullest = count_cells(position, box, shape, start)
    free = start.copy()
    for i in range(n):
        cell = cell_of(position, i, box, shape)
        s = free[cell]
        free[cell] += np.uint32(1)
        for k in range(len(box)):
            target[0][k, s] = position[k, i]
            target[1][k, s] = velocity[k, i]
            target[2][k, s] = predicted[k, i]
        target[3][s] = identity[i]
        copy_species(target[4], s, species, i)
    return fullest


@part()
def copy_species(target, s, source, i):
    """Copy one bead's species, where there are several."""
    if source is not None:
        target[s] = source[i]


@part()
def like(array):
    """An empty array like another; None for None."""
    if array is None:
        return None
    return np.empty_like(array)


@part()
def total_force(beads, force, fields, box, shape, ahead, start, fullest, keys, measure, sums, kept):
    """Evaluate all forces on sorted beads; add virial and energy to ``sums`` if asked.

    Returns
    -------
    None or Kept, int
        The pairs, where the scheme needs them again, and their number.
    """
    position, _, predicted, identity, species = beads
    virial, energy = sums
    bonds, core = fields[3], fields[4]
    slots = bonded_slots(bonds, identity)
    pairs = row_buffers(start, box, shape, ahead, fullest)
    force[:] = 0.0
    count = 0
    for row in range((len(start) - 1) // shape[len(box) - 1]):
        n = row_pairs(row, position, start, box, shape, ahead, 1.0, fullest, pairs)
        add_pair_forces(force, pairs, n, predicted, identity, species, box, fields, keys)
        kept = keep_pairs(kept, count, pairs, n, fields[1][0], box)
        count += np.int64(n)
        if measure:
            measure_pairs(virial, energy, pairs, n, box, core)
    add_bond_forces(force, position, slots, bonds, box, measure, sums)
    add_bath_forces(force, predicted, identity, fields[5], fields[2], box, keys)
    return kept, count


@part()
def cells_in(shape):
    """Number of cells."""
    cells = 1
    for k in range(len(shape)):
        cells *= shape[k]
    return cells


@kernel()
def advance(beads, force, fields, box, shape, ahead, dt, scheme, seed, step, steps, measure):
    """Advance by ``steps`` steps, or for 0 steps evaluate the force where the beads are.

    Parameters
    ----------
    beads : (position, velocity, identity, species)
        (dimension, n) arrays, (n,) uint32 and (n,) uint8 or None.
    force : (dimension, n) array
        The force on the beads as they are; ignored for 0 steps.
    fields : (repulsion, (gamma, sigma / sqrt(dt)), gaussian, bonds, core, bath)
        See `dpd.engine.forces`, `dpd.engine.bonds`, `dpd.engine.bath`.
    step : int
        Steps done so far: the key of the noise.
    measure : bool
        Whether the last evaluation adds up virial and energy.

    Returns
    -------
    beads : as above, sorted by cell
    force : (dimension, n) array
    sums : (virial, energy)
        (2, dimension, dimension) and (2,) arrays: conservative and full virial; pair and
        bond energy. Zero unless measured.
    lost : (bead, step, distance)
        Identity of a bead that moved too far, or -1.
    """
    position, velocity, identity, species = beads
    predicted = velocity.copy()
    source = (position, velocity, predicted, identity, species)
    target = (
        np.empty_like(position), np.empty_like(position), np.empty_like(position),
        np.empty_like(identity), like(species),
    )  # fmt: skip
    start = np.empty(cells_in(shape) + 1, np.uint32)
    sums = (np.zeros((2, len(box), len(box))), np.zeros(2))
    correction = scheme[2]
    kept = kept_buffers(scheme[3], len(box), 4 * position.shape[1])
    lost = (-1, step, 0.0)
    for s in range(max(steps, 1)):
        if steps > 0:
            step += 1
            bead, distance = drift(source[0], source[1], source[2], force, box, dt, scheme)
            if bead >= 0:
                lost = (np.int64(source[3][bead]), step, distance)
                break
        fullest = sort_by_cell(source, target, box, shape, start)
        source, target = target, source
        kept, count = total_force(
            source, force, fields, box, shape, ahead, start, fullest, step_keys(seed, step),
            measure and s + 1 >= steps, sums, kept,
        )  # fmt: skip
        if steps > 0 and correction > 0.0:
            source[1][:] += (correction * dt) * force
            renew_friction(force, kept, count, source[1], source[2], fields[5], box)
    return (source[0], source[1], source[3], source[4]), force, sums, lost
