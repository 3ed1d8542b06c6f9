"""A watch over bonds that reach across half the box."""

from typing import Any

import numpy as np

from dpd.errors import LostRun
from dpd.laws import MOST_STRETCHED, STRETCHED
from dpd.page import Observable

EVERY = 200  # steps between looks: less than half a per cent of the run time
FEW = 10  # finds that say nothing: so short a run knows its means far less well


class Stretch(Observable, key="stretch"):
    """Ends a run in which bonds reach across half the box more than once in a while.

    Bonds pull at their nearest image. One that grows longer than half an edge along an axis flips
    to another image of its bead, and lengths, pressures and sizes of chains come out too small.
    Before it does, and after it has, it is stretched: it reaches over 48 % of the edge. As long as
    a share of less than `MOST_STRETCHED` of all bonds is found so, the mean square length of
    harmonic bonds without a rest length is less than 3e-4 too small, and that of stiffer ones less.

    It looks while the run samples. A hot or crowded start may stretch bonds before that, and leaves
    nothing behind: a bond remembers no image, so it comes back to the length that it should have.
    """

    def keeps(self, scene: Any) -> Any:
        return {"count": 0}

    def measure(self, now: Any) -> Any:
        """Look, and end the run if there are too many for all of its looks."""
        bonds, looks = len(now.bond_vectors), now.scene.steps.sample // self.every
        now.kept["count"] += stretched(now.bond_vectors.T, now.lattice)
        count, allowed = int(now.kept["count"][0]), max(FEW, MOST_STRETCHED * bonds * looks)
        if count > allowed:
            edges = " x ".join(f"{edge:g}" for edge in now.box)
            raise LostRun(
                f"bonds are too long for the box of {edges} r_c: by step {now.step}, {count} "
                f"were found to reach over {STRETCHED:.0%} of an edge. Beyond half of it the pull "
                "goes to another image, which makes every number wrong (allowed in the whole run: "
                f"{round(allowed)}, {MOST_STRETCHED:g} of all bonds looked at). Take a "
                "larger box, or stiffer or shorter bonds",
                now.step,
            )
        return {}


def stretched(bonds: np.ndarray, box: tuple[float, ...]) -> int:
    """Number of bonds, once for each axis, along which they reach over `STRETCHED` of an edge.

    (dimension, bonds) vectors, at nearest images; where images slide, axes are those of the box.
    """
    from dpd.engine.space import along_axes

    return int((np.abs(along_axes(bonds, box)) > STRETCHED * np.array(box)[:, None]).sum())
