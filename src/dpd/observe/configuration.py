from typing import Any

from dpd.page import MOST_STEPS, Change, Observable, setting


class Configuration(Observable, key="configuration"):
    """Positions at the last sample, molecule after molecule.

    Under shear the tilt of the box is there as well, and at constant pressure its edges.
    """

    stands = frozenset(Change)
    gives = {
        "position": (("last", "axis", "bead"), "r_c", "positions at the end, in the box"),
        "box_tilt": (("last", "tilt"), "1", "tilt factors xy, xz, yz of the lattice of images"),
        "box_edges": (("last", "axis"), "r_c", "edges of that box"),
    }
    only_with = {"box_tilt": Change.SLIDES, "box_edges": Change.STRETCHES}

    every: int = setting(
        "Steps between looks; only the last look is kept. If not given, the length of the run.",
        0, ge=1, le=MOST_STEPS,
    )  # fmt: skip

    def steps_between(self, scene: Any) -> int:
        return int(scene.steps.sample)

    def axes(self, scene: Any) -> Any:
        return {"tilt": 3}

    def measure(self, now: Any) -> Any:
        from dpd.particles.particles import tilt_factors

        tilt = tilt_factors(now.lattice)
        return {"position": now.coordinates, "box_edges": now.box, "box_tilt": tilt}
