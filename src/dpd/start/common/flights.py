"""Molecules as random flights."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.scene.molecules import numbers_of

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

FLIGHT = 0.8  # r_c, a step of a random flight where bonds have no rest length


def lengths_of(scene: Scene) -> dict[str, Any]:
    """The length of a step as ``flight``, one for each law of a table; nothing without bonds."""
    if scene.bond_force is None:
        return {}
    laws = scene.bond_force.laws(scene)
    lengths = {name: float(law.at_rest()) or FLIGHT for name, law in laws.items()}
    return {"flight": lengths.get("", lengths)}


def flights(scene: Scene, rng: np.random.Generator, in_slabs: bool = False) -> np.ndarray:
    """(beads, dimension) array of random flights, reflected at walls.

    Each kind of molecule is in the whole box or in a slab of its own.
    """
    flight, box = lengths_of(scene).get("flight", FLIGHT), np.array(scene.box)
    along = int(np.argmax(box))
    low, filled, parts = np.zeros_like(box), 0, []
    for kind in scene.molecules:
        beads = kind.count * len(kind.beads)
        slab = box.copy()
        if in_slabs:
            low[along] = box[along] * filled / scene.beads
            slab[along] = box[along] * beads / scene.beads
        filled += beads
        step: Any = flight
        if isinstance(flight, dict):  # each bond of a molecule has its own
            step = np.array(list(flight.values()))[numbers_of(flight, kind.species_along(2))]
            step = step[:, None]
        x = _of_kind(kind, slab, step, rng)
        if in_slabs:
            x = np.abs((x + slab) % (2 * slab) - slab)  # reflected at both faces
        parts.append((x + low).reshape(-1, len(box)))
    x = np.concatenate(parts)
    for axis in scene.ended:
        x[:, axis] = np.abs((x[:, axis] + box[axis]) % (2 * box[axis]) - box[axis])
    return x


def _of_kind(kind, size, flight, rng):
    """(count, length, dimension) positions of random flights that begin in a box."""
    first = rng.random((kind.count, 1, len(size))) * size
    steps = rng.normal(size=(kind.count, len(kind.beads) - 1, len(size)))
    steps *= flight / np.linalg.norm(steps, axis=2, keepdims=True)
    steps = np.concatenate([first, steps], axis=1)
    return np.moveaxis(kind.summed(np.moveaxis(steps, 1, 2)), 2, 1)
