"""kT, momentum, pressure tensors and energy over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.external import ENERGY

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.scene.scene import Scene


class Thermo:
    """Time series of the scalars and tensors that every run is judged by.

    What a run that blew up did not sample is NaN.

    kT is the kinetic temperature <m v^2> / dimension (Groot and Warren 1997, Eq. 13). The
    pressure tensor is (sum_i m_i v_i v_i + sum r_ij F_ij) / V, once with the conservative force
    in the virial and once with all forces (their Eq. 15, second and first line). Forces of walls
    and body forces are no part of the virial. Between walls the tensor is an average over the
    space between the planes, which near them is not that of the bulk. Under shear velocities are
    those about the flow, and the shear stress is minus the element of the pressure tensor, with all
    forces, of the axes of the flow and of its gradient. At constant pressure V is the volume at
    each sample, which is then a series as well.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    pressure : bool
        Whether to measure pressure and energy, which costs a second look at the pairs.
    """

    def __init__(self, scene: Scene, system: System, every: int, pressure: bool) -> None:
        self.every, self.needs_forces = every, pressure
        self._system = system
        n, d = scene.steps.sample // every, system.dimension
        self.arrays = {
            "taken": np.zeros(1, np.int64),
            "kT": np.full(n, np.nan),
            "momentum": np.full((n, d), np.nan),
        }
        if system.pressure is not None:
            self.arrays["volume"] = np.full(n, np.nan)
        if pressure:
            self.arrays |= {
                "kinetic": np.full((n, d, d), np.nan),
                "virial": np.full((n, 2, d, d), np.nan),
                "energy": np.full((n, 2), np.nan),
            }
        if pressure and system.walls is not None:
            self.arrays["wall_energy"] = np.full(n, np.nan)

    def sample(self, simulation: Simulation, sums: Sums) -> None:
        """Take one sample."""
        arrays, velocity = self.arrays, simulation.state.velocity
        momenta = self._system.momenta(simulation.state)
        at = int(arrays["taken"][0])
        arrays["taken"][0] += 1
        # A square takes NumPy less time than a product, and has the same bits.
        products = velocity**2 if momenta is velocity else velocity * momenta
        arrays["kT"][at] = np.mean(products)
        arrays["momentum"][at] = momenta.sum(axis=1)
        if "volume" in arrays:
            arrays["volume"][at] = simulation.volume
        if self.needs_forces:
            arrays["kinetic"][at] = velocity @ momenta.T
            arrays["virial"][at] = sums.virial
            arrays["energy"][at] = sums.energy
            if sums.walls is not None:
                arrays["wall_energy"][at] = sums.walls[:, ENERGY].sum()

    def variables(self) -> Variables:
        """Series for the file."""
        time = self._system.dt * self.every * (1 + np.arange(len(self.arrays["kT"])))
        along = ("sample",)
        found = {
            "time": (along, time, "tau", "time since the end of equilibration"),
            "kT": (along, self.arrays["kT"], "kT", "kinetic temperature <m v^2>/dimension"),
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
        kinetic = 0.5 * np.trace(self.arrays["kinetic"], axis1=1, axis2=2)
        return kinetic + self.arrays["energy"].sum(axis=1) + self.arrays.get("wall_energy", 0.0)

    def _trace(self, virial):
        d = self._system.dimension
        return np.trace(virial, axis1=1, axis2=2) / (d * self._volume(1))

    def _volume(self, axes):
        """Volume at each sample, for an array of so many axes; one number where it stays."""
        if "volume" not in self.arrays:
            return self._system.volume
        return self.arrays["volume"].reshape(-1, *[1] * (axes - 1))
