"""Bonds that pass through each other in three dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.page import Change, Observable, interval_setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene


class Passes(Observable, key="passes"):
    """Number of pairs of bonds that passed through each other since the sample before."""

    stands = frozenset(Change)
    cannot = {
        Change.SLIDES: "takes beads to move in straight lines, and a flow carries them past each "
        "other"
    }
    interval, dimensions, needs_bonds, is_series = 0.1, (3,), True, True

    every: int = interval_setting(
        "Steps between samples, between which beads are taken to move in straight lines."
    )

    def _start(self, scene: Scene, system: BondedSystem) -> None:
        self._system = system
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "last": np.zeros((system.dimension, scene.beads)),
            "passes": np.full(scene.steps.sample // self.every, np.nan),
        }

    def sample(self, simulation: Simulation) -> None:
        """Take one sample; the first one has none before it."""
        from dpd.engine.queries.passes import passed_bonds

        state, arrays = simulation.state, self.arrays
        # What passes does so in any box, so all are taken in the one that the run began with.
        box = self._system.box
        stretched = np.array(simulation.box) / np.array(box)
        position = state.by_identity(state.position) / stretched[:, None]
        at = int(arrays["taken"][0])
        if at:
            found = passed_bonds(arrays["last"], position, self._system.members, box)
            arrays["passes"][at] = found.shape[1]
        else:
            arrays["passes"][at] = 0
        arrays["last"][...] = position
        arrays["taken"][0] += 1

    def variables(self) -> Variables:
        """Counts for the file."""
        time = self.times(1 + np.arange(len(self.arrays["passes"])))
        along = ("pass_sample",)
        return {
            "pass_time": (along, time, "tau", "time since the end of equilibration"),
            "passes": (
                along, self.arrays["passes"], "1", "bonds passed through since the sample before",
            ),
        }  # fmt: skip
