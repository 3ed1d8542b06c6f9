"""Where the beads are in the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Configuration:
    """Positions at the last sample, molecule after molecule.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between looks; the last one stays.
    """

    needs_forces = False

    def __init__(self, scene: Scene, system: System, every: int) -> None:
        self.every = every
        self.arrays = {"position": np.full((system.dimension, scene.beads), np.nan)}

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        state = simulation.state
        self.arrays["position"][...] = state.by_identity(state.position)

    def variables(self) -> Variables:
        """Positions for the file."""
        position = self.arrays["position"]
        return {"position": (("axis", "bead"), position, "r_c", "positions at the end, in the box")}
