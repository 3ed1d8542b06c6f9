"""The way of one molecule."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.chains import unwrapped
from dpd.page import Change, Observable, Refusals

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

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
    is_series = True

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        self._kind = scene.molecules[0]
        self._length = len(self._kind.beads)
        shape = (scene.steps.sample // self.every, system.dimension, self._length)
        self.arrays: dict[str, np.ndarray] = {
            "taken": np.zeros(1, np.int64),
            "image": np.zeros(system.dimension, np.int32),
            "trace": np.full(shape, np.nan),
        }

    def refuses(self, scene: Scene) -> Refusals:
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

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.space import unfolded

        state, arrays, box = simulation.state, self.arrays, self._system.box
        beads = state.by_identity(state.position)[:, None, : self._length]
        at, image = int(arrays["taken"][0]), state.image[:, 0]
        if not at:
            arrays["image"][...] = image
        boxes = (image - arrays["image"])[:, None]
        arrays["trace"][at] = unfolded(unwrapped(beads, box, self._kind)[:, 0], boxes, box)
        arrays["taken"][0] += 1

    def variables(self) -> Variables:
        """Configurations for the file."""
        time = self.times(1 + np.arange(len(self.arrays["trace"])))
        return {
            "trace_time": (("moment",), time, "tau", "time since the end of equilibration"),
            "trace": (
                ("moment", "axis", "monomer"), self.arrays["trace"], "r_c",
                "positions of the first molecule in one piece",
            ),
        }  # fmt: skip
