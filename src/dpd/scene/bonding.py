"""What a scene says of bonds and angles: one law for all, or one for each pair and triple.

A table names pairs of species, as ``A B``, or triples along bonds, as ``A B A``. Each may be read
from either end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.page import is_table

if TYPE_CHECKING:
    from dpd.scene.molecules import Molecule
    from dpd.scene.scene import Scene

NOBODY = -1  # instead of the number of a law, where none acts


class Joined(NamedTuple):
    """Beads that a law joins: the two of bonds, or the three of angles.

    Attributes
    ----------
    members : (n, 2) or (n, 3) uint32 array
        Numbers of the beads, molecule after molecule.
    law : None or (n,) uint16 array
        The number of the law in the scene's table; None where one law is for all.
    """

    members: np.ndarray
    law: np.ndarray | None


def laws_of(given: Mapping[str, Any]) -> list[dict[str, float]]:
    """The laws of ``bond`` or ``angle`` of a scene, in the order of its table; none of nothing."""
    if not given:
        return []
    return list(given.values()) if is_table(given) else [dict(given)]


def joined(
    scene: Scene, given: Mapping[str, Any], places: Callable[[Molecule], np.ndarray]
) -> Joined:
    """What the laws of a scene join, in all of its molecules.

    Parameters
    ----------
    scene : Scene
    given : dict
        ``bond`` or ``angle`` of the scene.
    places : callable
        From a molecule to the bonds or triples in it: an array of numbers of its beads.

    Returns
    -------
    Joined
        Without the triples that a table does not name: they feel no force.
    """
    all_members, all_laws, first = [], [], 0
    for kind in scene.molecules:
        inside = places(kind)
        if is_table(given):
            law = numbers_of(given, species_along(kind, inside))
            inside, law = inside[law != NOBODY], law[law != NOBODY]
            all_laws.append(np.tile(law, kind.count))
        starts = first + len(kind.beads) * np.arange(kind.count)
        all_members.append((starts[:, None, None] + inside).reshape(-1, inside.shape[1]))
        first += len(kind.beads) * kind.count
    laws = np.concatenate(all_laws).astype(np.uint16) if is_table(given) else None
    return Joined(np.concatenate(all_members).astype(np.uint32), laws)


def species_along(kind: Molecule, places: np.ndarray) -> list[tuple[str, ...]]:
    """Names of the species of some bonds or triples of a molecule."""
    return [tuple(kind.beads[bead] for bead in beads) for beads in places.tolist()]


def numbers_of(table: Mapping[str, Any], names: list[tuple[str, ...]]) -> np.ndarray:
    """The number of the law for each pair or triple of species; `NOBODY` where there is none."""
    number = {tuple(key.split()): place for place, key in enumerate(table)}
    found = [number.get(each, number.get(each[::-1], NOBODY)) for each in names]
    return np.array(found, np.int64)


def all_species(scene: Scene, places: Callable[[Molecule], np.ndarray]) -> list[tuple[str, ...]]:
    """Species of all bonded pairs or triples, each once, in the order in which they are met."""
    names = (name for kind in scene.molecules for name in species_along(kind, places(kind)))
    return list(dict.fromkeys(min(name, name[::-1]) for name in names))
