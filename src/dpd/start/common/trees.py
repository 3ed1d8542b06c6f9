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

    Attributes
    ----------
    code : int
        The same for trees that are the same.
    order : list of int
        Its beads: the n-th of one tree is the n-th of any other with the same code.
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
        """Hang up the tree that a bead is of.

        Parameters
        ----------
        neighbours : sequence of sequences of int
            For each bead those that it is bonded to.
        species : sequence of int
            Of each bead.
        bead : int
        """
        middle = dict.fromkeys(middle_of(neighbours, bead))
        return min((self._hung_by(neighbours, species, root) for root in middle), key=_code)

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


def _code(hung):
    return hung.code


def order_of_trees(scene: Scene, particles: Particles, number: np.ndarray, path: str) -> np.ndarray:
    """The number in the file of each bead of a scene with molecules of any shape.

    Parameters
    ----------
    scene : Scene
    particles : Particles
        With the box of the scene.
    number : (n,) array
        Species of each bead of the file, as the scene numbers them.
    path : str
        Of the file, for messages.

    Returns
    -------
    (n,) int64 array
        As `dpd.start.common.matching.order_of` has it.

    Raises
    ------
    UserError
        If the molecules are not those of the scene.
    """
    _refuse_rings(particles, path)
    if np.array_equal(number, scene.kinds) and _same_bonds(scene.bonded, particles.bonds):
        return np.arange(len(number))
    trees, there = Trees(), defaultdict(list)
    neighbours = _neighbours(particles)
    _, lowest = np.unique(molecules_of(particles), return_index=True)
    for bead in np.sort(lowest).tolist():
        hung = trees.hung(neighbours, number, bead)
        there[hung.code].append(hung.order)
    order = []
    for kind, given in zip(scene.molecules, scene.data["molecules"]):
        species = [scene.species.index(name) for name in kind.beads]
        wanted = trees.hung(kind.neighbours, species, 0)
        found, there[wanted.code] = (
            there[wanted.code][: kind.count], there[wanted.code][kind.count :],
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
    left = [beads for rest in there.values() for beads in rest]
    if left:
        first = min(left, key=min)
        raise UserError(
            f"{path}: it has {len(left)} molecules more than {scene.where}; the first is one of "
            f"{len(first)} beads with {particles.called(min(first))}; add them to 'molecules', or "
            "take another file"
        )
    return np.concatenate(order)


def _same_bonds(one, other):
    """Whether two sets of bonds are the same, in whatever order."""
    rows = [np.unique(np.sort(bonds, axis=1), axis=0) for bonds in (one, other)]
    return np.array_equal(*rows)


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


def _neighbours(particles):
    """For each bead of a file those that it is bonded to."""
    found: list[list[int]] = [[] for _ in range(particles.beads)]
    for one, other in particles.bonds.tolist():
        found[one].append(other)
        found[other].append(one)
    return found
