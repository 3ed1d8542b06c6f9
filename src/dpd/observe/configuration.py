"""Where the beads are in the end."""

import numpy as np


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

    def __init__(self, scene, system, every):
        self.every = every
        self.arrays = {"position": np.full((system.dimension, scene.beads), np.nan)}

    def sample(self, simulation, sums):
        """Take one sample."""
        state = simulation.state
        self.arrays["position"][...] = state.by_identity(state.position)

    def variables(self):
        """Positions for the file."""
        position = self.arrays["position"]
        return {"position": (("axis", "bead"), position, "r_c", "positions at the end, in the box")}
