from dataclasses import replace
from typing import Any

import numpy as np

from dpd.observe.common.bins import PRESSURE, Layered, ThermalMotion
from dpd.page import Change, Given


class StressProfile(Layered, key="stress_profile"):
    """Pressure normal to an axis's slices, and tangential to them, slice by slice.

    The pressure tensor of conservative forces, as `thermo` has it, is divided among the slices: the
    kinetic part of a bead belongs to the slice that it is in, and what a pair adds is spread evenly
    along the straight line between its beads (Irving and Kirkwood 1950). Bonds are pairs, and
    angles act along their two bonds (`dpd.engine.stress.virial_in_slices`). The mean over
    all slices is the tensor of the box. Tangential is the mean over the other axes.

    Between walls across the axis the normal pressure falls to zero: what walls do to the beads
    further in is given apart, and where a fluid is at rest the sum is the same everywhere, the
    force per area on each wall.
    """

    stands = frozenset(Change) - {Change.SLIDES}
    interval, cost = 4.0, 19.0
    along = "slice"
    gives = {
        "slice": (("run", "slice"), "r_c", "position along the axis"),
        "normal_pressure_profile": (("block", "slice"), PRESSURE, "pressure along the axis"),
        "tangential_pressure_profile": (("block", "slice"), PRESSURE, "pressure across the axis"),
        "wall_pressure_profile": (("block", "slice"), PRESSURE, "what walls add along the axis"),
    }
    only_with = {"slice": Change.STRETCHES}  # the mean box; another stays

    def given(self, scene: Any) -> dict[str, Given]:
        found = super().given(scene)
        if self.layers(scene).axis not in scene.ended:
            del found["wall_pressure_profile"]
        return found

    def measure(self, now: Any) -> Any:
        from dpd.engine.stress import Slices, virial_in_slices, wall_virial_in_slices

        system, layers = replace(now.system, box=now.lattice), self.layers(now.whole)
        slices = Slices(layers.axis, layers.count, *layers.bounds(now))
        mass, layer = system.mass_of(now.state.species), layers.of(now)
        thermal = mass * ThermalMotion(now.scene, now.system).velocities(now) ** 2
        across = [np.bincount(layer, one, layers.count) for one in thermal]
        along = across.pop(layers.axis)
        kinetic = np.array([along, np.mean(across, axis=0)])
        normal, tangential = virial_in_slices(system, now.state, slices) + kinetic
        found = {"normal_pressure_profile": normal, "tangential_pressure_profile": tangential}
        if layers.axis in now.scene.ended:
            found["wall_pressure_profile"] = wall_virial_in_slices(system, now.state, slices)
        per = layers.per_volume(now)
        return {"slice": layers.middles(now)} | {name: per * each for name, each in found.items()}
