"""Which bead of a file is which bead of a scene.

A scene numbers its beads molecule after molecule. A file may have the same molecules in another
order, or the beads of a molecule from the other end.
"""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError, shown
from dpd.start.common.trees import order_of_trees

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.particles.particles import Particles
    from dpd.scene.scene import Scene

SAME = 1e-6  # relative difference of edges that counts for none: files have single precision


def order_of(scene: Scene, particles: Particles, path: str) -> np.ndarray:
    """(n,) int64 array: the number in the file of each bead of the scene.

    Molecules of a kind are taken in the order of their first beads. Where the file has all beads
    as the scene numbers them, these are 0, 1, 2 and so on.

    Raises
    ------
    UserError
        If box, species or molecules are not those of the scene; with the first difference.
    """
    _check_box(scene, particles, path)
    number = _numbers_of_species(scene, particles, path)
    if not all(kind.is_chain for kind in scene.molecules):
        return order_of_trees(scene, particles, number, path)
    chains = chains_of(particles, path)
    order = []
    for place, kind in enumerate(scene.molecules):
        wanted = np.array([scene.species.index(name) for name in kind.beads])
        there = chains.get(len(wanted), np.zeros((0, len(wanted)), np.int64))
        forward = (number[there] == wanted).all(axis=1)
        backward = (number[there[:, ::-1]] == wanted).all(axis=1)
        found = np.where(forward[:, None], there, there[:, ::-1])[forward | backward]
        needed = sum(other.count for other in scene.molecules[place:] if other.beads == kind.beads)
        if len(found) < needed:
            counts = zip(np.bincount(number, minlength=len(scene.species)), scene.species)
            in_file = ", ".join(f"{n} {name}" for n, name in counts)
            raise UserError(
                f"{path}: it has {len(found)} molecules {_formula(kind.beads)} for the {needed} of "
                f"{scene.where} (beads in the file: {in_file}; in the scene "
                f"{scene.beads} in all); take another file, or change 'molecules'"
            )
        taken = np.argsort(found.min(axis=1), kind="stable")[: kind.count]
        order.append(found[taken].ravel())
        rest = np.setdiff1d(there[:, 0], found[taken][:, [0, -1]])
        chains[len(wanted)] = there[np.isin(there[:, 0], rest)]
    _refuse_more(scene, particles, chains, number, path)
    return np.concatenate(order)


def _check_box(scene, particles, path):
    if len(particles.box) != scene.dimension:
        raise UserError(
            f"{path}: it has {len(particles.box)} dimensions, and {scene.where} has "
            f"{scene.dimension}; take another file, or change 'dimension'"
        )
    wanted = tuple(  # the scene's edges, but for those that constant pressure changes
        there if scene.stretched in ("all", name) else own
        for own, there, name in zip(scene.period, particles.box, "xyz")
    )
    if not same_box(wanted, particles.box):
        edges = ", ".join(f"{edge:.9g}" for edge in particles.box)
        own = ", ".join(f"{edge:.9g}" for edge in scene.period)
        raise UserError(
            f"{path}: its box is [{edges}], and that of {scene.where} [{own}]; they have to "
            f"agree: write 'box: [{edges}]' in the scene, or take another file"
        )


def same_box(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two boxes of the same dimension have the same edges."""
    return np.allclose(one, other, rtol=SAME, atol=0)


def _numbers_of_species(scene, particles, path):
    """Species of each bead of the file, as the scene numbers them."""
    used = np.unique(particles.species)
    unknown = [particles.names[k] for k in used if particles.names[k] not in scene.species]
    if unknown:
        raise UserError(
            f"{path}: it has beads of the species {shown(unknown[0])}, and {scene.where} has "
            f"{', '.join(scene.species)}; rename one or the other (in LAMMPS data: type labels, or "
            "comments behind the masses)"
        )
    place = [scene.species.index(name) if name in scene.species else 0 for name in particles.names]
    return np.array(place)[particles.species]


def _formula(names):
    """Species along a molecule as the scene would write them."""
    counts = [(name, len(list(alike))) for name, alike in groupby(names)]
    return shown(" ".join(name if n == 1 else f"{name} {n}" for name, n in counts), str)


def _refuse_more(scene, particles, chains, number, path):
    """Refuse molecules that the scene has not, or not as many of."""
    left = [chain for table in chains.values() for chain in table[:1]]
    if left:
        chain = min(left, key=min)
        names = [scene.species[k] for k in number[chain]]
        more = sum(len(table) for table in chains.values())
        raise UserError(
            f"{path}: it has {more} molecules more than {scene.where}; the first is "
            f"{_formula(names)} with {particles.called(min(chain))}; add them to 'molecules', or "
            "take another file"
        )


def chains_of(particles: Particles, path: str) -> dict[int, np.ndarray]:
    """Linear molecules, from their bonds, by length.

    Each is a (molecules, length) array: beads along each molecule, from the end with the lower
    number. Refused are branches and rings.
    """
    beads, beyond = particles.beads, _neighbours(particles, path)
    ends = np.flatnonzero(beyond[:, 1] < 0)
    # All molecules are followed at the same time, each from both of its ends.
    chain, now, before = np.arange(len(ends)), ends, np.full(len(ends), -1)
    chains, places, found = [chain], [np.zeros(len(ends), np.int64)], [now]
    while len(now):
        after = np.where(beyond[now, 0] == before, beyond[now, 1], beyond[now, 0])
        goes_on = after >= 0
        chain, before, now = chain[goes_on], now[goes_on], after[goes_on]
        chains.append(chain)
        places.append(np.full(len(now), len(places)))
        found.append(now)
    order = np.lexsort([np.concatenate(places), np.concatenate(chains)])
    along = np.concatenate(found)[order]
    lengths = np.bincount(np.concatenate(chains), minlength=len(ends))
    first = np.cumsum(lengths) - lengths
    once = along[first] <= along[first + lengths - 1]
    if lengths[once].sum() < beads:
        ring = np.setdiff1d(np.arange(beads), along)[0]
        raise UserError(
            f"{path}: {particles.called(ring)} is of a molecule that is a ring; molecules are "
            "chains or trees here"
        )
    return {
        int(length): along[first[once & (lengths == length)][:, None] + np.arange(length)]
        for length in np.unique(lengths[once])
    }


def _neighbours(particles, path):
    """(beads, 2) array: the beads to which each one is bonded, -1 for none."""
    bonds, beads = particles.bonds, particles.beads
    one, other = np.concatenate([bonds, bonds[:, ::-1]]).astype(np.int64).T
    count = np.bincount(one, minlength=beads)
    if count.max(initial=0) > 2:
        bead = np.argmax(count > 2)
        raise UserError(
            f"{path}: {particles.called(bead)} has {count[bead]} bonds; allowed: 2, since all "
            "molecules of the scene are linear"
        )
    order = np.argsort(one, kind="stable")
    one, other = one[order], other[order]
    again = np.zeros(len(one), np.int64)
    again[1:] = one[1:] == one[:-1]
    beyond = np.full((beads, 2), -1)
    beyond[one, again] = other
    return beyond
