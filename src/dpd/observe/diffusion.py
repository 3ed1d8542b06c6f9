"""Diffusion coefficients as they settle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.following import Followed
from dpd.page import Change, Observable

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Diffusion(Observable, key="diffusion"):
    """D(t) = <|r(t) - r(0)|^2> / (2 dimension t) of beads of each species, and of molecules.

    The time t counts from the first sample. Displacements are those from that one start, relative
    to the centre of mass of all beads, as `dpd.observe.common.following.Followed` has them; of a
    molecule, that of its centre of mass. D(t) tends to the diffusion coefficient where t is long
    enough for beads to have lost their velocity, and chains to have moved their own size. For an
    error, or for averages over many starts, see the observable ``displacement``.
    """

    stands = frozenset(Change) - {Change.PACE}
    interval, is_series = 0.2, True

    def _start(self, scene: Scene, system: System) -> None:
        self._system = system
        self._names = scene.species
        self._kinds = scene.kinds.astype(np.int64)
        self._molecule_kinds = np.repeat(
            np.arange(len(scene.molecules)), [kind.count for kind in scene.molecules]
        )
        samples = scene.steps.sample // self.every
        self._followed = Followed(scene, system)
        self.arrays = self._followed.arrays | {
            "taken": np.zeros(1, np.int64),
            "beads": np.full((samples, len(self._names)), np.nan),
            "molecules": np.full((samples, len(scene.molecules)), np.nan),
        }

    def sample(self, simulation: Simulation) -> None:
        """Follow the beads, and compare with the start."""
        arrays = self.arrays
        at = int(arrays["taken"][0])
        moved = self._followed.sample(simulation, first=at == 0)
        arrays["beads"][at] = arrays["molecules"][at] = 0.0
        if at:
            arrays["beads"][at] = _mean_squares(moved, self._kinds)
            centre = self._followed.centres(moved)
            arrays["molecules"][at] = _mean_squares(centre, self._molecule_kinds)
        arrays["taken"][0] += 1

    def variables(self) -> Variables:
        """Coefficients over time for the file; NaN at the start, and where a run was lost."""
        beads, molecules = self.arrays["beads"], self.arrays["molecules"]
        time = self._system.dt * self.every * np.arange(len(beads))
        over = 2 * self._system.dimension * np.where(time > 0, time, np.nan)[:, None]
        return {
            "diffusion_time": (("diffusion_sample",), time, "tau", "time since the first sample"),
            "species": (("species",), np.array(self._names), "1", "species"),
            "diffusion_bead": (
                ("diffusion_sample", "species"), beads / over, "r_c^2 / tau",
                "squared displacement of beads over 2 dimension t",
            ),
            "diffusion_molecule": (
                ("diffusion_sample", "kind"), molecules / over, "r_c^2 / tau",
                "squared displacement of centres of molecules over 2 dimension t",
            ),
        }  # fmt: skip


def _mean_squares(moved, kinds):
    """Mean squared displacement of each kind, by the number of the kind of each."""
    return np.bincount(kinds, (moved**2).sum(axis=0)) / np.bincount(kinds)
