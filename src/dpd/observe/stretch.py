"""A watch over bonds that reach across half the box."""

import numpy as np

from dpd.engine.periodic import MOST_STRETCHED, STRETCHED
from dpd.errors import LostTrack

EVERY = 500  # steps between looks; every step is counted
FEW = 100  # times that say nothing in a short run


class Stretch:
    """Ends a run in which bonds reach across half the box more than once in a while.

    Bonds pull at their nearest image. One that grows longer than half an edge along an axis flips
    to another image of its bead, and lengths, pressures and sizes of chains come out too small.
    Before it does, it is stretched: it reaches over 48 % of the edge. As long as that is so in a
    share of less than `MOST_STRETCHED` of all bonds and steps, the mean square length of harmonic
    bonds without a rest length is less than 3e-4 too small, and that of stiffer ones less.

    Parameters
    ----------
    scene : Scene
    system : System
        With bonds.
    """

    needs_forces = False

    def __init__(self, scene, system):
        self.every = min(EVERY, scene.steps[1])
        self._box, self._chances = system.box, len(system.bonds[0]) * sum(scene.steps)
        self.arrays = {"count": np.zeros(1, np.int64)}

    def sample(self, simulation, sums):
        """Count, and end the run if this is too often for all of its steps."""
        self.arrays["count"] += simulation.take_stretched()
        count, step = int(self.arrays["count"][0]), simulation.state.step
        allowed = max(FEW, MOST_STRETCHED * self._chances)
        if count > allowed:
            edges = " x ".join(f"{edge:g}" for edge in self._box)
            raise LostTrack(
                f"bonds are too long for the box of {edges} r_c: by step {step} they reached over "
                f"{STRETCHED:.0%} of an edge {count} times, and beyond half of it the pull goes to "
                f"another image, which makes every number wrong (allowed in this run: "
                f"{round(allowed)} times, {MOST_STRETCHED:g} of all bonds and steps). Take a "
                "larger box, or stiffer or shorter bonds",
                step,
            )

    def variables(self):
        """Nothing: a run that ends well has nothing to tell."""
        return {}
