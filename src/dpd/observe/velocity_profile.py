from typing import Any

import numpy as np

from dpd.observe.common.bins import Layered
from dpd.page import Change
from dpd.particles.particles import shear_of


class VelocityProfile(Layered, key="velocity_profile"):
    """Mean velocity of the beads in layers across an axis, and their temperature about it.

    The temperature of a layer is <m (v - u)^2> / dimension, with u the mean velocity of its beads
    in the whole run, weighted by mass, for the degrees of freedom that conserved momentum leaves.
    Across the gradient of a shear the velocity is that in the laboratory, else that about the flow.
    """

    stands = frozenset(Change)
    along = "layer"
    gives = {
        "velocity_profile": (("block", "axis", "layer"), "r_c / tau", "mean velocity of beads"),
        "temperature_profile": (("block", "layer"), "kT", "temperature about the mean velocity"),
        "bead_profile": (("block", "layer"), "1 / r_c^dimension", "number density of all beads"),
        "_beads": (("block", "layer"), "1", "their number"),
        "_mass": (("block", "layer"), "m", "mass of these beads"),
        "_sheared": (("block", "layer"), "m / tau", "the same, each times the rate of shear"),
    }
    only_with = {"_sheared": Change.SLIDES}

    def measure(self, now: Any) -> Any:
        layers, velocity, species = self.layers(now.whole), now.state.velocity, now.state.species
        layer = layers.of(now)
        mass = np.broadcast_to(now.system.mass_of(species), layer.shape)
        momenta = now.system.momenta(now.state)
        each = [None, mass, np.einsum("kn,kn->n", velocity, momenta), *momenta]
        beads, mass, squares, *momentum = (np.bincount(layer, one, layers.count) for one in each)
        found = {
            "bead_profile": layers.per_volume(now) * beads, "_mass": mass, "_beads": beads,
            "temperature_profile": squares, "velocity_profile": momentum,
        }  # fmt: skip
        if now.system.shear is not None:
            found["_sheared"] = mass * now.system.shear.rate
        return found

    def finish(self, scene: Any, found: dict[str, Any]) -> Any:
        beads, mass = found["_beads"], found["_mass"]
        momentum, square = found["velocity_profile"], found["temperature_profile"]
        coordinates, layers = np.float64(scene.dimension * scene.beads), self.layers(scene)
        with np.errstate(invalid="ignore", divide="ignore"):
            per_freedom = coordinates / (coordinates - len(scene.momentum_axes))
            flow = np.nansum(momentum, axis=0) / np.nansum(mass, axis=0)
            velocity = momentum / mass[:, None]
            square = square - mass * (2 * (flow * velocity).sum(axis=1) - (flow**2).sum(axis=0))
            temperature = square / beads * per_freedom / scene.dimension
        shear = shear_of(scene)
        if shear is not None and shear.gradient == layers.axis:  # about its flow are velocities
            velocity[:, shear.flow] += found["_sheared"] / mass * layers.middles()
        return {
            "velocity_profile": velocity, "temperature_profile": temperature,
            "bead_profile": found["bead_profile"],
        }  # fmt: skip
