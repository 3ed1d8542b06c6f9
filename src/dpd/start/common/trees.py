"""Which molecule of a file is which branched molecule of a scene, and bead which bead.

Two trees of beads are the same where a numbering of one makes it the other. To find out, each is
hung up by its middle. A bead then has a code that says its species and the codes of the beads that
hang on it, so beads with the same code carry the same. Read in the order of codes from the middle
on, trees that are the same come out bead by bead (Aho, Hopcroft and Ullman 1974).
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.errors import UserError, shown
from dpd.particles.particles import Particles, molecules_of
from dpd.scene.molecules import middle_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.scene.scene import Scene


class Hung(NamedTuple):
    """A tree that hangs by its middle.

    Trees that are the same have the same code, and the n-th bead of one is the n-th of the other.
    """

    code: int
    order: list[int]


class Trees:
    """Codes of trees; of all that are to be compared."""

    def __init__(self) -> None:
        self._codes: dict[tuple, int] = {}

    def hung(
        self, neighbours: Sequence[Sequence[int]], species: Sequence[int] | np.ndarray, bead: int
    ) -> Hung:
        """Hang up the tree that a bead is of, by the neighbours and species of all beads."""
        middle = dict.fromkeys(middle_of(neighbours, bead))
        found = (self._hung_by(neighbours, species, root) for root in middle)
        return min(found, key=lambda hung: hung.code)

    def _hung_by(self, neighbours, species, root):
        above, order = {root: -1}, [root]
        for bead in order:  # which grows meanwhile
            for other in neighbours[bead]:
                if other != above[bead]:
                    above[other] = bead
                    order.append(other)
        below, code = defaultdict(list), {}
        for bead in reversed(order):
            codes = tuple(sorted(code[other] for other in below[bead]))
            code[bead] = self._codes.setdefault((int(species[bead]), codes), len(self._codes))
            below[above[bead]].append(bead)
        found, waiting = [], [root]
        while waiting:
            bead = waiting.pop()
            found.append(bead)
            waiting += sorted(below[bead], key=lambda other: (code[other], other), reverse=True)
        return Hung(code[root], found)


def order_of_trees(scene: Scene, particles: Particles, number: np.ndarray, path: str) -> np.ndarray:
    """As `dpd.start.common.matching.order_of`, of a scene with molecules of any shape.

    The particles have the box of the scene, and ``number`` the scene's species of each bead.
    """
    _refuse_rings(particles, path)
    own, there = (np.unique(np.sort(each), axis=0) for each in (scene.bonded, particles.bonds))
    if np.array_equal(number, scene.kinds) and np.array_equal(own, there):
        return np.arange(len(number))
    trees, left = Trees(), defaultdict(list)
    neighbours: list[list[int]] = [[] for _ in range(particles.beads)]
    for one, other in particles.bonds.tolist():
        neighbours[one].append(other)
        neighbours[other].append(one)
    _, lowest = np.unique(molecules_of(particles), return_index=True)
    for bead in np.sort(lowest).tolist():
        hung = trees.hung(neighbours, number, bead)
        left[hung.code].append(hung.order)
    order = []
    for kind, given in zip(scene.molecules, scene.data["molecules"]):
        species = [scene.species.index(name) for name in kind.beads]
        wanted = trees.hung(kind.neighbours, species, 0)
        found, left[wanted.code] = (
            left[wanted.code][: kind.count], left[wanted.code][kind.count :],
        )  # fmt: skip
        if len(found) < kind.count:
            raise UserError(
                f"{path}: it lacks {kind.count - len(found)} of the {kind.count} molecules "
                f"{shown(given['architecture'], str)} of {scene.where}; take another file, or "
                "change 'molecules'"
            )
        beads = np.empty((kind.count, len(kind.beads)), np.int64)
        beads[:, wanted.order] = found
        order.append(beads.ravel())
    more = [beads for rest in left.values() for beads in rest]
    if more:
        first = min(more, key=min)
        raise UserError(
            f"{path}: it has {len(more)} molecules more than {scene.where}; the first is one of "
            f"{len(first)} beads with {particles.called(min(first))}; add them to 'molecules', or "
            "take another file"
        )
    return np.concatenate(order)


def _refuse_rings(particles, path):
    """Refuse a molecule with as many bonds as beads, or more."""
    molecule = molecules_of(particles)
    beads = np.bincount(molecule)
    bonds = np.bincount(molecule[particles.bonds[:, 0]], minlength=len(beads))
    if (bonds >= beads).any():
        bead = int(np.argmax((bonds >= beads)[molecule]))
        raise UserError(
            f"{path}: {particles.called(bead)} is of a molecule with a ring; molecules are chains "
            "or trees here"
        )
