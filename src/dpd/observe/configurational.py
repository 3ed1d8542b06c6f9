"""Configurational temperature: what the positions say of kT."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from dpd.observe.common.blocks import BlockSums
from dpd.page import Change, Observable

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Configurational(Observable, key="configurational"):
    """Squared conservative forces and the Laplacian of the potential, in blocks of the run.

    Their ratio, of means, is kT in equilibrium and does not look at velocities: it shows an
    integrator's error where the kinetic temperature is right by construction.
    """

    stands = frozenset(Change)
    cannot = {
        Change.SLIDES: "is a temperature in equilibrium only",
        Change.FLOWS: "is a temperature in equilibrium only",
        Change.JUMPS: "needs a force without the jump of a core",
    }

    def _start(self, scene: Scene, system: System) -> None:
        self._beads = scene.beads
        self.averages = BlockSums((2,))
        self.arrays = self.averages.arrays

    def sample(self, simulation: Simulation) -> None:
        """Take one sample."""
        from dpd.engine.queries.configurational import force_and_curvature

        system = replace(simulation.system, box=simulation.box)
        self.averages.add(force_and_curvature(system, simulation.state))

    def variables(self) -> Variables:
        """Both per bead, in blocks for the file."""
        means = self.averages.means() / self._beads
        return {
            "force_square": (
                ("block",), means[:, 0], "(kT / r_c)^2", "squared conservative force per bead",
            ),
            "curvature": (
                ("block",), means[:, 1], "kT / r_c^2", "Laplacian of the potential per bead",
            ),
        }  # fmt: skip
