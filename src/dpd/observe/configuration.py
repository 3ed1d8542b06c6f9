"""Where the beads are in the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.page import Change, Observable

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Configuration(Observable, key="configuration"):
    """Positions at the last sample, molecule after molecule.

    Under shear the tilt of the box is there as well, and at constant pressure its edges.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between looks; the last one stays.
    """

    stands = frozenset(Change)

    def __init__(self, scene: Scene, system: System, every: int) -> None:
        from dpd.particles.tilt import FACTORS

        self.every = every
        self.arrays: dict[str, np.ndarray] = {
            "position": np.full((system.dimension, scene.beads), np.nan)
        }
        if system.shear is not None:
            self.arrays["tilt"] = np.full(len(FACTORS), np.nan)
        if system.pressure is not None:
            self.arrays["edges"] = np.full(system.dimension, np.nan)

    @classmethod
    def steps_between(cls, settings: dict[str, Any], dt: float, sample: int) -> int:
        """The last step alone."""
        return sample

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
