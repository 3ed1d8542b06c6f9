"""Forces of beads on walls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.page import Change, Observable, Refusals

if TYPE_CHECKING:
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class WallForces(Observable, key="walls"):
    """What beads do to each wall per area, over time.

    The mean of the conservative force is the pressure of the fluid normal to the wall. The mean of
    the friction along a wall is the shear stress there.
    """

    needs_forces = True

    stands = frozenset(Change) - {Change.SLIDES}
    interval, is_series = 0.16, True

    def _start(self, scene: Scene, system: System) -> None:
        axes = system.walls.axis  # type: ignore[union-attr]  # the scene is refused without
        ends = ("lower", "upper") * (len(axes) // 2)
        self._names = [f"{'xyz'[axis]} {end}" for axis, end in zip(axes, ends)]
        # Beads do the opposite to walls of what walls do to them; the push is along the normal out
        # of the box already.
        self._area = system.volume / np.array(system.extent)[axes]
        n, d = scene.steps.sample // self.every, system.dimension
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "pressure": np.full((n, len(axes)), np.nan),
            "friction": np.full((n, len(axes), d), np.nan),
        }

    def refuses(self, scene: Scene) -> Refusals:
        """No walls."""
        if not scene.ended:
            yield "", "'walls' has nothing to measure: the scene has none; add 'walls'"

    def record(self, sums: Sums) -> None:
        """Take some samples."""
        from dpd.engine.external import DRAG, PUSH

        first, on_beads = int(self.arrays["taken"][0]), sums.walls
        assert on_beads is not None  # the run measures forces for whoever needs them
        at = slice(first, first + len(sums.step))
        self.arrays["taken"][0] = at.stop
        self.arrays["pressure"][at] = on_beads[:, :, PUSH] / self._area
        self.arrays["friction"][at] = -on_beads[:, :, DRAG:] / self._area[:, None]

    def variables(self) -> Variables:
        """Series for the file."""
        time = self.times(1 + np.arange(len(self.arrays["pressure"])))
        return {
            "wall_time": (("wall_sample",), time, "tau", "time since the end of equilibration"),
            "wall": (("wall",), np.array(self._names), "1", "axis and end of each wall"),
            "wall_pressure": (
                ("wall_sample", "wall"), self.arrays["pressure"], "kT / r_c^dimension",
                "conservative force of the beads on each wall per area, outwards",
            ),
            "wall_friction": (
                ("wall_sample", "wall", "axis"), self.arrays["friction"], "kT / r_c^dimension",
                "friction and noise of the beads on each wall per area, along each axis",
            ),
        }  # fmt: skip
