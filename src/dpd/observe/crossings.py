"""Bonds that cross in two dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError
from dpd.page import Change, Observable

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import BondedSystem, Variables
    from dpd.scene.scene import Scene

MOST = 8  # pairs of crossing bonds per bond that are kept in mind


class Crossings(Observable, key="crossings"):
    """Pairs of bonds that cross, over time.

    Where chains cannot pass through each other there is none at any time. ``crossings``
    counts the pairs at a sample, ``crossings_begun`` those that the sample before did not
    have.
    """

    stands = frozenset(Change)
    interval, dimensions, needs_bonds, is_series = 0.2, (2,), True, True

    def _start(self, scene: Scene, system: BondedSystem) -> None:
        self._system = system
        n, bonds = scene.steps.sample // self.every, len(system.members)
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "crossings": np.full(n, np.nan),
            "begun": np.full(n, np.nan),
            "pairs": np.full(MOST * bonds, -1, np.int64),
        }

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.crossings import crossing_bonds

        state, arrays = simulation.state, self.arrays
        members = self._system.members
        one, other = crossing_bonds(state.by_identity(state.position), members, simulation.box)
        pairs = one.astype(np.int64) * len(members) + other
        if len(pairs) > len(arrays["pairs"]):
            raise UserError(
                f"{len(pairs)} pairs of {len(members)} bonds cross: too many to follow; "
                "take 'crossings' out of observe"
            )
        at = int(arrays["taken"][0])
        arrays["taken"][0] += 1
        arrays["crossings"][at] = len(pairs)
        former = arrays["pairs"][: int(arrays["crossings"][at - 1]) if at else 0]
        arrays["begun"][at] = np.isin(pairs, former, invert=True).sum()
        arrays["pairs"][:] = -1
        arrays["pairs"][: len(pairs)] = pairs

    def variables(self) -> Variables:
        """Counts for the file."""
        time = self.times(1 + np.arange(len(self.arrays["crossings"])))
        along = ("crossing_sample",)
        return {
            "crossing_time": (along, time, "tau", "time since the end of equilibration"),
            "crossings": (along, self.arrays["crossings"], "1", "pairs of bonds that cross"),
            "crossings_begun": (
                along, self.arrays["begun"], "1", "those that did not cross at the sample before",
            ),
        }  # fmt: skip
