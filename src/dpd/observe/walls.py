from typing import Any

import numpy as np

from dpd.observe.common.bins import PRESSURE
from dpd.page import Change, Observable, Refusals


class WallForces(Observable, key="walls"):
    """What beads do to each wall per area, over time: conservative force, friction and noise.

    The mean of the first, outwards, is the pressure of the fluid normal to the wall; the mean of
    the second along a wall is the shear stress there.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    interval, cost, of_sums, needs_forces = 0.16, 0.7, True, True
    over = {"sample": ("wall_sample", "wall_time")}
    gives = {
        "wall_pressure": (("sample", "wall"), PRESSURE, "force on each wall per area"),
        "wall_friction": (("sample", "wall", "axis"), PRESSURE, "friction on each wall per area"),
    }

    def refuses(self, scene: Any) -> Refusals:
        if not scene.ended:
            yield "", "'walls' has nothing to measure: the scene has none; add 'walls'"

    def axes(self, scene: Any) -> Any:
        names = [f"{'xyz'[axis]} {end}" for axis in scene.ended for end in ("lower", "upper")]
        return {"wall": (names, "1", "axis and end of each wall")}

    def measure(self, now: Any) -> Any:
        from dpd.engine.beads import DRAG, PUSH

        extent = now.system.extent
        area = np.repeat([now.system.volume / extent[axis] for axis in now.scene.ended], 2)
        # What walls do to beads; the push is along the normal out of the box already.
        on_beads: Any = now.sums.walls
        return {
            "wall_pressure": on_beads[:, :, PUSH] / area,
            "wall_friction": -on_beads[:, :, DRAG:] / area[:, None],
        }
