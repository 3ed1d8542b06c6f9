from typing import Any

import numpy as np

from dpd.page import MOST_STEPS, Change, Observable, setting


class Passes(Observable, key="passes"):
    """Number of pairs of bonds that passed through each other since the sample before.

    No interval is both right and cheap, so a scene says it: a sample takes as long as several steps
    of a melt, and between two of them a bead should move far less than a bond. In a melt of a 25
    looks 0.02, 0.1, 0.2 and 0.4 tau apart count 1853, 1814, 1728 and 1546 passes of the same run.
    """

    stands = frozenset(Change)
    cannot = {
        Change.SLIDES: "takes beads to move in straight lines, and a flow carries them past others"
    }
    dimensions, needs_bonds = (3,), True
    over = {"sample": ("pass_sample", "pass_time")}
    gives = {"passes": (("sample",), "1", "bonds passed through since the sample before")}

    every: int = setting(
        "Steps between samples, between which beads are taken to move in straight lines: in a melt "
        "those of 0.1 tau or fewer.", ge=1, le=MOST_STEPS,
    )  # fmt: skip

    def keeps(self, scene: Any) -> Any:
        return {"last": np.zeros((scene.dimension, scene.beads))}

    def measure(self, now: Any) -> Any:
        from dpd.engine.crossings import passed_bonds

        # What passes does so in any box, so all are taken in the one that the run began with.
        box, last = now.system.box, now.kept["last"]
        position, count = now.coordinates / (now.box / np.array(box))[:, None], 0
        if now.sample:
            count = passed_bonds(last, position, now.scene.bonded, box).shape[1]
        last[...] = position
        return count
