from typing import Any

import numpy as np

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
    gives = {"trace": (("sample", "axis", "monomer"), "r_c", "positions of the first molecule")}

    def axes(self, scene: Any) -> Any:
        return {"monomer": len(scene.molecules[0].beads)}

    def keeps(self, scene: Any) -> Any:
        return {"image": np.zeros(scene.dimension, np.int32)}

    def refuses(self, scene: Any) -> Refusals:
        each, steps = len(scene.molecules[0].beads) * scene.dimension, scene.steps.sample
        if (numbers := steps // self.every * each) > MOST_NUMBERS:
            text = f"{self.every} keeps {numbers:.3g} coordinates of the first molecule; allowed"
            yield "every", f"{text}: <= {MOST_NUMBERS}, every >= {-(-steps * each // MOST_NUMBERS)}"

    def measure(self, now: Any) -> Any:
        from dpd.engine.space import unfolded

        beads, image = now.in_one_piece[0][:, 0], now.state.image[:, 0]
        if now.sample == 0:
            now.kept["image"][...] = image
        return unfolded(beads, (image - now.kept["image"])[:, None], now.lattice)
