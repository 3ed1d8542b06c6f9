from typing import Any

import numpy as np

from dpd.observe.common.bins import PRESSURE, ThermalMotion
from dpd.page import Change, Given, Observable, setting

TENSOR = ("sample", "axis", "axis2")
WITHOUT_FORCES = ("kT", "momentum", "volume")


class Thermo(Observable, key="thermo"):
    """Time series of the scalars and tensors that every run is judged by.

    kT and pressure count degrees of freedom (Allen and Tildesley, Computer Simulation of Liquids,
    Section 2.4; Groot and Warren 1997, Eqs. 13 and 15): with the velocity v_c of the centre of
    mass, and l_a = 1 for each axis along which momentum is conserved, else 0,

        c_a = sqrt(N / (N - l_a)) (v - v_c)_a,    kT = sum_i m_i c_i^2 / (dimension N)
        P   = (sum_i m_i c_i c_i + sum r_ij F_ij) / V

    In a closed fluid kT is sum m (v - v_c)^2 / (dimension (N - 1)). A third of the trace of P is
    -dF/dV, as N beads have N free places whatever their momentum. (Their flux of momentum, which
    other programs print, is kT / V less.) P is given with the
    conservative force in the virial and with all forces (Eq. 15, second and first line). Where
    something drives a flow, its profile takes the place of v_c, and the number of its coefficients
    that of l_a (`dpd.observe.common.bins`); the total energy alone holds the flow. The angular
    momentum of a cluster alone in a box is not taken off.

    Forces of walls and body forces are no part of the virial; between walls P is an average over
    the space between the planes. The shear stress is minus the element of P, with all forces, of
    the axes of the flow and of its gradient. At constant pressure V is that of each sample.
    """

    stands = frozenset(Change)
    of_sums = True
    over = {"sample": ("sample", "time")}
    gives = {
        "kT": (("sample",), "kT", "kinetic temperature per degree of freedom"),
        "momentum": (("sample", "axis"), "m r_c / tau", "total momentum"),
        "volume": (("sample",), "r_c^dimension", "volume of the box"),
        "excess_conservative": (("sample",), PRESSURE, "excess pressure, conservative virial"),
        "excess_all": (("sample",), PRESSURE, "excess pressure, virial of all forces"),
        "pressure_tensor": (TENSOR, PRESSURE, "pressure tensor, conservative forces"),
        "pressure_tensor_all": (TENSOR, PRESSURE, "pressure tensor, all forces"),
        "pair_energy": (("sample",), "kT", "pair energy"),
        "bond_energy": (("sample",), "kT", "bond energy"),
        "total_energy": (("sample",), "kT", "kinetic, pair, bond and wall energy"),
        "pressure": (("sample",), PRESSURE, "pressure, conservative virial"),
        "wall_energy": (("sample",), "kT", "energy of beads at walls"),
        "shear_stress": (("sample",), PRESSURE, "shear stress, virial of all forces"),
    }
    only_with = {
        "volume": Change.STRETCHES, "wall_energy": Change.ENDS, "shear_stress": Change.SLIDES,
    }  # fmt: skip
    # kT and pressure remember 0.3 to 0.8 tau: a mean over samples 0.16 apart has 2 % more variance
    # than one over twice as many, which would take a tenth more of the run time.
    interval = 0.16

    pressure: bool = setting("Whether to measure pressure and energy.", True)

    @property
    def needs_forces(self) -> bool:  # type: ignore[override]
        return self.pressure

    def cost_in(self, scene: Any) -> float:
        if not self.pressure:
            return 0.2
        return 0.7 if Change.FLOWS in scene.made else 0.5  # there sums are kept apart

    def given(self, scene: Any) -> dict[str, Given]:
        found = super().given(scene)
        return found if self.pressure else {n: found[n] for n in WITHOUT_FORCES if n in found}

    def measure(self, now: Any) -> Any:
        from dpd.engine.beads import ENERGY
        from dpd.engine.state import ALL_FORCES, CONSERVATIVE, OF_BONDS, OF_PAIRS

        system, sums, d = now.system, now.sums, now.system.dimension
        kinetic, moments = ThermalMotion(now.scene, system).kinetic(sums), sums.moments.sum(axis=1)
        found = {
            "kT": np.trace(kinetic, axis1=1, axis2=2) / (d * sums.beads.sum(axis=1)),
            "momentum": moments[:, :d, d],
            "volume": sums.volume,
        }
        if not self.pressure:
            return found
        conservative, all_forces = sums.virial[:, CONSERVATIVE], sums.virial[:, ALL_FORCES]
        pressed, pressed_by_all = kinetic + conservative, kinetic + all_forces
        energy = 0.5 * np.trace(moments[:, :d, :d], axis1=1, axis2=2) + sums.energy.sum(axis=1)
        if sums.walls is not None:
            found["wall_energy"] = sums.walls[:, :, ENERGY].sum(axis=1)
            energy = energy + found["wall_energy"]
        if system.shear is not None:
            x, y = system.shear.flow, system.shear.gradient
            found["shear_stress"] = -0.5 * (pressed_by_all[:, x, y] + pressed_by_all[:, y, x])
            found["shear_stress"] /= sums.volume
        volume, per_axis = sums.volume[:, None, None], d * sums.volume
        return found | {
            "excess_conservative": np.trace(conservative, axis1=1, axis2=2) / per_axis,
            "excess_all": np.trace(all_forces, axis1=1, axis2=2) / per_axis,
            "pressure_tensor": pressed / volume,
            "pressure_tensor_all": pressed_by_all / volume,
            "pair_energy": sums.energy[:, OF_PAIRS],
            "bond_energy": sums.energy[:, OF_BONDS],
            "total_energy": energy,
            "pressure": np.trace(pressed, axis1=1, axis2=2) / per_axis,
        }
