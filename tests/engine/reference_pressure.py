"""The plain engine at constant pressure, as Bernetti and Bussi 2020 write it, in sqrt(V).

It shares the random numbers of a trial with the engine, and no formula.
"""

import copy

import numpy as np

from dpd.physics.pressure import draw
from tests.engine.reference import Reference


class PressedReference(Reference):
    """A `Reference` whose box is stretched after every so many steps."""

    def __init__(self, system, *arguments):
        self.accepted = self.tried = 0
        super().__init__(copy.copy(system), *arguments)

    def step(self):
        """A step, and where one is due, a trial of another volume."""
        super().step()
        if self.steps % self.system.pressure.every == 0:
            self.rescale()

    def rescale(self):
        """Propose sqrt(V) by an Euler step, and take it as Metropolis and Hastings do."""
        law, system = self.system.pressure, self.system
        now = np.sqrt(np.prod(system.box))
        normal, chance = draw(system.seed, self.steps)
        kept = copy.copy(vars(self))
        step = law.every * system.dt
        variance = system.kT * law.compressibility / (2 * law.time) * step
        mean = now + self.drift(step)
        energy = self.enthalpy()
        new = mean + np.sqrt(variance) * normal
        self.stretch(new**2 / now**2)
        mean_back = new + self.drift(step)
        # Densities of sqrt(V) in equilibrium, and of the proposals there and back.
        here = now * np.exp(-(energy - self.enthalpy()) / system.kT)
        forth = np.exp(-((new - mean) ** 2) / (2 * variance))
        back = np.exp(-((now - mean_back) ** 2) / (2 * variance))
        self.tried += 1
        if chance < new * back / (here * forth):
            self.accepted += 1
        else:
            vars(self).update({name: kept[name] for name in kept if name != "tried"})

    def drift(self, step):
        """Change of sqrt(V) without noise; the volume changes by a tenth at most."""
        law, volume, kT = self.system.pressure, np.prod(self.system.box), self.system.kT
        push = self.pressure() - law.target + kT / (2 * volume)
        rate = law.compressibility * np.sqrt(volume) / (2 * law.time) * push
        most = 0.05 * np.sqrt(volume)
        return np.clip(rate * step, -most, most)

    def pressure(self):
        """Mean over the stretched axes of (sum v v + conservative virial) / V; see `enthalpy`."""
        each = [
            (self.velocity[k] @ self.velocity[k] + self.virial[0][k, k])
            for k in self.system.pressure.axes
        ]
        return (np.mean(each) + self.kept_momentum()) / np.prod(self.system.box)

    def enthalpy(self):
        """Kinetic and potential energy, and P_0 V; kT ln V less where momentum is conserved."""
        volume = np.prod(self.system.box)
        held = self.system.pressure.target * volume - self.kept_momentum() * np.log(volume)
        return (self.velocity**2).sum() / 2 + np.sum(self.energy) + held

    def kept_momentum(self):
        """kT, or 0 in a bath that takes momentum."""
        return 0.0 if self.system.per_bead else self.system.kT

    def stretch(self, times):
        """Stretch the box to so many times its volume."""
        axes = list(self.system.pressure.axes)
        factor = np.ones((len(self.position), 1))
        factor[axes] = times ** (1 / len(axes))
        self.position, self.velocity = self.position * factor, self.velocity / factor
        self.system = copy.copy(self.system)
        object.__setattr__(self.system, "box", tuple(np.array(self.system.box) * factor[:, 0]))
        self.evaluate(self.velocity)
