from typing import Any

import numpy as np

from dpd.page import Change, Observable, Refusals, Species, setting


class Membrane(Observable, key="membrane"):
    """Area, thickness and order of a bilayer that is normal to z, over time.

    A molecule is of the side to which its heads point from its tails. The area is that of the box
    for each molecule of one side, of as many as there are in the mean. The thickness is the
    distance along z between the mean places of the heads of both sides. The order is
    <3 cos^2 theta - 1> / 2 of the bonds between tail beads and the normal: 1 along it, 0 in any
    direction. The tension is the height times `pressure_tensor` zz less the mean of xx and yy.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    dimensions, needs_bonds = (3,), True
    interval, cost = 0.8, 3.0
    gives = {
        "area_per_molecule": (("sample",), "r_c^2", "area of the box per molecule of a side"),
        "thickness": (("sample",), "r_c", "distance of the heads of both sides"),
        "tail_order": (("sample",), "1", "order of the bonds of tails along z"),
        "height": (("sample",), "r_c", "edge of the box along z"),
    }

    heads: list[Species] = setting(
        "Species of heads; if not given, that of the first bead of each molecule.", [],
        of="some species",
    )  # fmt: skip
    tails: list[Species] = setting(
        "Species of tails; if not given, that of the last bead of each molecule.", [],
        of="some species",
    )  # fmt: skip

    def refuses(self, scene: Any) -> Refusals:
        if not any(map(self._parts, scene.molecules)):
            yield "", "'membrane' has nothing to measure: no molecule has heads and tails"

    def _parts(self, kind):
        """Which beads of a molecule are heads, and which tails; nothing if it has not both."""
        head = np.isin(kind.beads, self.heads or kind.beads[:1])
        tail = np.isin(kind.beads, self.tails or kind.beads[-1:])
        return (head, tail) if head.any() and tail.any() and not (head & tail).any() else ()

    def measure(self, now: Any) -> Any:
        heads: list[Any] = []
        tails: list[Any] = []
        bonds: list[Any] = []
        for kind, beads in zip(now.scene.molecules, now.in_one_piece):
            if parts := self._parts(kind):
                for found, part in zip((heads, tails), parts):
                    found.append(beads[2][:, part].mean(axis=1))
                of_tails = kind.tree[parts[1][kind.tree].all(axis=1)]
                along = beads[:, :, of_tails[:, 1]] - beads[:, :, of_tails[:, 0]]
                bonds.append(along.reshape(3, -1))
        head, tail = np.concatenate(heads), np.concatenate(tails)
        edge = float(now.box[2])
        # The middle is where tails are on a circle as long as the box, as its images repeat.
        middle = np.angle(np.exp(2j * np.pi * tail / edge).sum()) / (2 * np.pi) * edge
        place = head - middle - edge * np.rint((tail - middle) / edge)
        up = head > tail
        sides = [place[side].mean() if side.any() else 0.0 for side in (up, ~up)]
        along = np.concatenate(bonds, axis=1)
        cosines = along[2] ** 2 / (along**2).sum(axis=0)
        return {
            "area_per_molecule": 2 * float(now.box[0] * now.box[1]) / len(head),
            "thickness": sides[0] - sides[1],
            "tail_order": 1.5 * cosines.mean() - 0.5 if len(cosines) else 0.0,
            "height": edge,
        }
