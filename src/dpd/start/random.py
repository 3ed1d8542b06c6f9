"""Beads anywhere: molecules as random flights."""

from typing import Any, ClassVar

import numpy as np

from dpd.page import Start

FLIGHT = 0.8  # r_c, a step of a random flight where bonds have no rest length


class Random(Start, key="random"):
    """Beads anywhere."""

    in_slabs: ClassVar[bool] = False  # each kind of molecule in one of its own

    def decides(self, scene: Any) -> dict[str, Any]:
        """The length of a step as ``flight``, one for each law of a table; none without bonds."""
        if scene.bond_force is None:
            return {}
        laws = scene.bond_force.laws(scene)
        lengths = {name: float(law.at_rest()) or FLIGHT for name, law in laws.items()}
        return {"flight": lengths.get("", lengths)}

    def positions(self, scene: Any, rng: np.random.Generator) -> np.ndarray:
        """Random flights, reflected at walls and at the faces of slabs."""
        from dpd.scene.molecules import numbers_of

        flight, box = self.decides(scene).get("flight", FLIGHT), np.array(scene.box)
        along = int(np.argmax(box))
        low, filled, parts = np.zeros_like(box), 0, []
        for kind in scene.molecules:
            slab, beads = box.copy(), kind.count * len(kind.beads)
            if self.in_slabs:
                low[along] = box[along] * filled / scene.beads
                slab[along] = box[along] * beads / scene.beads
            filled += beads
            step = flight
            if isinstance(flight, dict):  # each bond of a molecule has its own
                step = np.array(list(flight.values()))[numbers_of(flight, kind.species_along(2))]
                step = step[:, None]
            first = rng.random((kind.count, 1, len(box))) * slab
            steps = rng.normal(size=(kind.count, len(kind.bonds), len(box)))
            steps *= step / np.linalg.norm(steps, axis=2, keepdims=True)
            steps = closed(steps, kind)[:, : len(kind.tree)]
            steps = np.moveaxis(np.concatenate([first, steps], axis=1), 1, 2)
            x = np.moveaxis(kind.summed(steps), 2, 1)
            if self.in_slabs:
                x = np.abs((x + slab) % (2 * slab) - slab)
            parts.append((x + low).reshape(-1, len(box)))
        x = np.concatenate(parts)
        for axis in scene.ended:
            x[:, axis] = np.abs((x[:, axis] + box[axis]) % (2 * box[axis]) - box[axis])
        return x


def closed(steps: np.ndarray, kind: Any) -> np.ndarray:
    """Steps along all bonds of a molecule that are as near to these as rings let them be.

    ``steps``: (molecules, bonds, dimension). In a ring all less their mean, a Brownian bridge.
    """
    way = np.zeros((len(kind.rings), len(kind.bonds)))  # of each ring, along bonds or against them
    for ring, (one, other) in enumerate(kind.rings):
        way[ring, len(kind.tree) + ring] = -1
        for sign, bead in ((1, other), (-1, one)):
            while bead > 0:
                way[ring, bead - 1] += sign
                bead = kind.parents[bead]
    return steps - np.linalg.pinv(way) @ (way @ steps) if kind.rings else steps
