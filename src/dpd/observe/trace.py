"""The way of one molecule."""

from typing import Any

import numpy as np

from dpd.observe.chains import unwrapped
from dpd.page import Change, Observable, Refusals

MOST_NUMBERS = 10**8  # of all configurations: 0.8 gigabytes


class Trace(Observable, key="trace"):
    """Configurations of the first molecule, one after the other.

    Each is in one piece, and they go on where it leaves the box; the first begins in it.
    """

    stands = frozenset(Change)
    cannot = {
        Change.SLIDES: "follows one molecule, which a flow carries off",
        Change.STRETCHES: "cannot follow a molecule in a box that changes",
    }
    over = {"sample": ("moment", "trace_time")}
    gives = {
        "trace": (
            ("sample", "axis", "monomer"), "r_c", "positions of the first molecule in one piece",
        ),
    }  # fmt: skip

    def axes(self, scene: Any) -> Any:
        return {"monomer": len(scene.molecules[0].beads)}

    def keeps(self, scene: Any) -> Any:
        return {"image": np.zeros(scene.dimension, np.int32)}

    def refuses(self, scene: Any) -> Refusals:
        """Too many coordinates."""
        every, beads = self.every, len(scene.molecules[0].beads)
        numbers = scene.steps.sample // every * beads * scene.dimension
        if numbers > MOST_NUMBERS:
            least = -(-scene.steps.sample * beads * scene.dimension // MOST_NUMBERS)
            yield (
                "every",
                f"{every} keeps {numbers:.3g} coordinates of the first molecule; allowed: <= "
                f"{MOST_NUMBERS}, every >= {least}",
            )

    def measure(self, now: Any) -> Any:
        from dpd.engine.space import unfolded

        kind, state, image = now.scene.molecules[0], now.state, now.state.image[:, 0]
        if now.sample == 0:
            now.kept["image"][...] = image
        places = np.flatnonzero(state.identity < len(kind.beads))
        beads = state.position[:, None, places[np.argsort(state.identity[places])]]
        beads = unwrapped(beads, now.lattice, kind)[:, 0]
        return unfolded(beads, (image - now.kept["image"])[:, None], now.lattice)
