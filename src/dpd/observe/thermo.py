"""kT, momentum, pressure tensors and energy over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.thermal import ThermalMotion
from dpd.page import Change, Observable, setting

if TYPE_CHECKING:
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene

MOST_SAMPLES = 10_000  # unless the scene says how often


class Thermo(Observable, key="thermo"):
    """Time series of the scalars and tensors that every run is judged by.

    What a run that blew up did not sample is NaN.

    kT and pressure count degrees of freedom (Allen and Tildesley, Computer Simulation of Liquids,
    Section 2.4; Groot and Warren 1997, Eqs. 13 and 15): with the velocity v_c of the centre of
    mass, and l_a = 1 for each axis along which momentum is conserved, else 0,

        c_a = sqrt(N / (N - l_a)) (v - v_c)_a,    kT = sum_i m_i c_i^2 / (dimension N)
        P   = (sum_i m_i c_i c_i + sum r_ij F_ij) / V

    In a closed fluid kT is sum m (v - v_c)^2 / (dimension (N - 1)). A third of the trace of P is
    N kT / V and the virial: it is -dF/dV, as N beads have N free places whatever their momentum.
    (Their flux of momentum, which other programs print, is kT / V less.) P is given with the
    conservative force in the virial and with all forces (Eq. 15, second and first line). Where
    something drives a flow, its profile takes the place of v_c, and the number of its coefficients
    that of l_a (`dpd.observe.common.thermal`); the total energy alone holds the flow. A
    cluster alone in a box keeps its angular momentum too, which is not taken off: that energy stays
    as the start has left it.

    Forces of walls and body forces are no part of the virial. Between walls P is an average over
    the space between the planes, which near them is not that of the bulk. The shear stress is minus
    the element of P, with all forces, of the axes of the flow and of its gradient. At constant
    pressure V is the volume at each sample, which is then a series as well.
    """

    stands = frozenset(Change)
    is_series = True
    # kT and pressure remember 0.3 to 0.8 tau: a mean over samples 0.16 apart has 2 % more variance
    # than one over twice as many, which would take a tenth more of the run time.
    interval = 0.16

    pressure: bool = setting("Whether to measure pressure and energy.", True)

    def _start(self, scene: Scene, system: System) -> None:
        self.needs_forces = self.pressure  # type: ignore[misc]  # of a page without it, False
        self._system, self._thermal = system, ThermalMotion(scene, system)
        n, d = scene.steps.sample // self.every, system.dimension
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "kT": np.full(n, np.nan),
            "momentum": np.full((n, d), np.nan),
        }
        if system.pressure is not None:
            self.arrays["volume"] = np.full(n, np.nan)
        if self.pressure:
            self.arrays |= {
                "kinetic": np.full((n, d, d), np.nan),
                "virial": np.full((n, 2, d, d), np.nan),
                "energy": np.full((n, 2), np.nan),
                "motion": np.full(n, np.nan),
            }
        if self.pressure and system.walls is not None:
            self.arrays["wall_energy"] = np.full(n, np.nan)

    def record(self, sums: Sums) -> None:
        """Take some samples."""
        from dpd.engine.external import ENERGY

        arrays, d, first = self.arrays, self._system.dimension, int(self.arrays["taken"][0])
        at = slice(first, first + len(sums.step))
        arrays["taken"][0] = at.stop
        kinetic, moments = self._thermal.kinetic(sums), sums.moments.sum(axis=1)
        beads = sums.beads.sum(axis=1)
        arrays["kT"][at] = np.trace(kinetic, axis1=1, axis2=2) / (d * beads)
        arrays["momentum"][at] = moments[:, :d, d]
        if "volume" in arrays:
            arrays["volume"][at] = sums.volume
        if self.needs_forces:
            arrays["kinetic"][at] = kinetic
            arrays["motion"][at] = 0.5 * np.trace(moments[:, :d, :d], axis1=1, axis2=2)
            arrays["virial"][at] = sums.virial
            arrays["energy"][at] = sums.energy
            if sums.walls is not None:
                arrays["wall_energy"][at] = sums.walls[:, :, ENERGY].sum(axis=1)

    def variables(self) -> Variables:
        """Series for the file."""
        time = self.times(1 + np.arange(len(self.arrays["kT"])))
        along = ("sample",)
        found = {
            "time": (along, time, "tau", "time since the end of equilibration"),
            "kT": (along, self.arrays["kT"], "kT", "kinetic temperature per degree of freedom"),
            "momentum": (
                ("sample", "axis"), self.arrays["momentum"], "m r_c / tau", "total momentum",
            ),
        }  # fmt: skip
        if "volume" in self.arrays:
            volume = self.arrays["volume"]
            found["volume"] = (along, volume, "r_c^dimension", "volume of the box")
        if self.needs_forces:
            volume, tensor = self._volume(3), ("sample", "axis", "axis2")
            kinetic, virial = self.arrays["kinetic"], self.arrays["virial"]
            pressure = "kT / r_c^dimension"
            found |= {
                "excess_conservative": (
                    along, self._trace(virial[:, 0]), pressure,
                    "excess pressure, conservative virial over dimension times volume",
                ),
                "excess_all": (
                    along, self._trace(virial[:, 1]), pressure,
                    "excess pressure, virial of all forces over dimension times volume",
                ),
                "pressure_tensor": (
                    tensor, (kinetic + virial[:, 0]) / volume, pressure,
                    "pressure tensor, conservative forces",
                ),
                "pressure_tensor_all": (
                    tensor, (kinetic + virial[:, 1]) / volume, pressure,
                    "pressure tensor, all forces",
                ),
                "pair_energy": (along, self.arrays["energy"][:, 0], "kT", "pair energy"),
                "bond_energy": (along, self.arrays["energy"][:, 1], "kT", "bond energy"),
                "total_energy": (
                    along, self._total_energy(), "kT", "kinetic, pair, bond and wall energy",
                ),
                "pressure": (
                    along, self._trace(kinetic + virial[:, 0]), pressure,
                    "pressure, conservative virial",
                ),
            }  # fmt: skip
            if "wall_energy" in self.arrays:
                energy = self.arrays["wall_energy"]
                found["wall_energy"] = (along, energy, "kT", "energy of beads at walls")
        if self.needs_forces and self._system.shear is not None:
            found["shear_stress"] = (
                along, self._shear_stress(), pressure, "shear stress, virial of all forces",
            )  # fmt: skip
        return found

    def _shear_stress(self):
        x, y = self._system.shear.flow, self._system.shear.gradient
        tensor = self.arrays["kinetic"] + self.arrays["virial"][:, 1]
        return -0.5 * (tensor[:, x, y] + tensor[:, y, x]) / self._system.volume

    def _total_energy(self):
        kinetic = self.arrays["motion"]
        return kinetic + self.arrays["energy"].sum(axis=1) + self.arrays.get("wall_energy", 0.0)

    def _trace(self, virial):
        d = self._system.dimension
        return np.trace(virial, axis1=1, axis2=2) / (d * self._volume(1))

    def _volume(self, axes):
        """Volume at each sample, for an array of so many axes; one number where it stays."""
        if "volume" not in self.arrays:
            return self._system.volume
        return self.arrays["volume"].reshape(-1, *[1] * (axes - 1))
