"""What a scene says of bonds and angles: one law for all, or one for each pair and triple.

A table names pairs of species, as ``A B``, or triples along bonds, as ``A B A``. Each may be read
from either end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

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


def is_table(given: Mapping[str, Any]) -> bool:
    """Whether a scene gives a law for each pair or triple, not one for all."""
    return any(" " in key for key in given)


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


def check_bonding(scene: Scene, refuse: Callable[[str, str], None]) -> None:
    """Refuse bonds and angles that do not fit to the molecules.

    Parameters
    ----------
    scene : Scene
    refuse : callable
        Called with the key and what is wrong with it; raises.

    Raises
    ------
    UserError
    """
    chains = any(len(kind.beads) > 1 for kind in scene.molecules)
    if chains and "bond" not in scene.data:
        refuse("bond", "molecules of several beads need one, as {stiffness: 2, length: 0}")
    if not chains and "bond" in scene.data:
        refuse(
            "bond",
            "every molecule is a single bead; remove the key, or give an architecture "
            "of several beads, as 'A 10'",
        )
    if is_table(scene.data.get("bond", {})):
        pairs = _all_names(scene, lambda kind: kind.bonds)
        _check_table(scene, "bond", pairs, refuse)
        for pair, law in zip(pairs, numbers_of(scene.data["bond"], pairs)):
            if law == NOBODY:
                named = " ".join(pair)
                refuse(
                    "bond", f"no law for the pair {named!r}, which is bonded; add '{named}: ...'"
                )
    if "angle" in scene.data:
        if not any(len(kind.triples) for kind in scene.molecules):
            refuse("angle", "no molecule has three beads in a row; remove the key")
        if is_table(scene.data["angle"]):
            triples = _all_names(scene, lambda kind: kind.triples)
            _check_table(scene, "angle", triples, refuse)


def _all_names(scene, places):
    """Species of all bonded pairs or triples, each once, in the order in which they are met."""
    names = (name for kind in scene.molecules for name in species_along(kind, places(kind)))
    return list(dict.fromkeys(min(name, name[::-1]) for name in names))


def _check_table(scene, key, there, refuse):
    """Refuse a law that is there twice, or for beads that are nowhere bonded."""
    table = scene.data[key]
    for name in table:
        along = tuple(name.split())
        if along != along[::-1] and " ".join(along[::-1]) in table:
            refuse(f"{key}.{name}", "is there in the other order, too; keep one")
        if min(along, along[::-1]) not in there:
            allowed = ", ".join(repr(" ".join(each)) for each in there[:20])
            refuse(f"{key}.{name}", f"no molecule has these beads bonded; allowed: {allowed}")
