"""Where the beads are in the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.page import Change, Observable, interval_setting

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Configuration(Observable, key="configuration"):
    """Positions at the last sample, molecule after molecule.

    Under shear the tilt of the box is there as well, and at constant pressure its edges.
    """

    stands = frozenset(Change)

    every: int = interval_setting(
        "Steps between looks; only the last look is kept. If not given, the length of the run."
    )

    def _start(self, scene: Scene, system: System) -> None:
        from dpd.particles.tilt import FACTORS

        self.arrays: dict[str, np.ndarray] = {
            "position": np.full((system.dimension, scene.beads), np.nan)
        }
        if system.shear is not None:
            self.arrays["tilt"] = np.full(len(FACTORS), np.nan)
        if system.pressure is not None:
            self.arrays["edges"] = np.full(system.dimension, np.nan)

    def steps_between(self, scene: Scene) -> int:
        """The last step alone."""
        return int(scene.steps.sample)

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.particles.tilt import tilt_factors

        state = simulation.state
        self.arrays["position"][...] = state.by_identity(state.position)
        if "tilt" in self.arrays:
            self.arrays["tilt"][...] = tilt_factors(simulation.box)
        if "edges" in self.arrays:
            self.arrays["edges"][...] = simulation.box

    def variables(self) -> Variables:
        """Positions for the file."""
        position = self.arrays["position"]
        found: Variables = {
            "position": (("axis", "bead"), position, "r_c", "positions at the end, in the box")
        }
        if "tilt" in self.arrays:
            text = "tilt factors xy, xz and yz of the lattice of its images"
            found["box_tilt"] = (("tilt",), self.arrays["tilt"], "1", text)
        if "edges" in self.arrays:
            found["box_edges"] = (("axis",), self.arrays["edges"], "r_c", "edges of that box")
        return found
