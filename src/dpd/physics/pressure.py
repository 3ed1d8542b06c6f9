"""Constant pressure by stochastic cell rescaling (Bernetti and Bussi, JCP 153, 114107, 2020).

The box takes part in the motion: its volume V follows

    dV  =  -(beta V / tau) (P_0 - P - kT/V) dt + sqrt(2 kT beta V / tau) dW

with the target P_0, the relaxation time tau, an estimate beta of the isothermal compressibility,
and the pressure P of the moment. All positions are stretched with the box, and velocities are
divided by the same factor, so that P is -dH/dV, H being kinetic and potential energy. P therefore
has the virial of *conservative* forces. Friction and noise add nothing to the mean of the virial,
but they fluctuate: in P they would be a noise of the volume that no term above balances.

The box may be stretched along some axes only. P is then the mean of the normal pressures along
those axes, and everything else stays as it is.

In lambda = sqrt(V) the noise has the same size at every volume (the paper's Section II D):

    d lambda  =  (beta lambda / (2 tau)) (P - P_0 + kT/(2V)) dt + sqrt(kT beta / (2 tau)) dW

A step of this equation over a time h is only a good guess, unless h is much shorter than tau. So
it is taken as a trial of the Metropolis method: it counts with the probability
min(1, exp(-Delta)), where Delta is what the paper calls the change of the effective energy, in kT.
Volumes then have the distribution of the isothermal-isobaric ensemble, exp(-(H + P_0 V) / kT), for
every h, tau and beta; those decide how fast it is explored.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

# Largest share of the volume that the mean of a trial moves. It matters where a start is far from
# its pressure; a trial as large as the equation wants would then leave what the forces know.
LARGEST = 0.1
STREAM = 0x70726573  # so that no other random numbers have the same key


class Look(NamedTuple):
    """What is known of a system at one volume.

    Attributes
    ----------
    volume : float
        In r_c^dimension.
    pressure : float
        P, with the virial of conservative forces.
    energy : float
        Kinetic and potential energy in kT.
    """

    volume: float
    pressure: float
    energy: float


class Pressure(NamedTuple):
    """Constant pressure.

    Attributes
    ----------
    target : float
        P_0 in kT / r_c^dimension.
    time : float
        Relaxation time tau.
    compressibility : float
        Estimate of the isothermal compressibility, in r_c^dimension / kT.
    axes : tuple of int
        Along which the box is stretched.
    every : int
        Steps from trial to trial.
    """

    target: float
    time: float
    compressibility: float
    axes: tuple[int, ...]
    every: int

    def spread(self, kT: float, h: float) -> float:
        """Standard deviation of sqrt(V) in a trial over the time h."""
        return math.sqrt(kT * self.compressibility * h / (2 * self.time))

    def drift(self, look: Look, kT: float, h: float) -> float:
        """Mean change of sqrt(V) in a trial over the time h, `LARGEST` at most."""
        excess = look.pressure - self.target + kT / (2 * look.volume)
        share = self.compressibility * h / (2 * self.time) * excess
        return math.sqrt(look.volume) * min(max(share, -LARGEST / 2), LARGEST / 2)

    def trial(self, look: Look, kT: float, h: float, normal: float) -> float:
        """Volume to try next.

        Parameters
        ----------
        look : Look
            At the volume now.
        kT : float
        h : float
            Time since the trial before.
        normal : float
            A random number of the standard normal distribution.
        """
        return (math.sqrt(look.volume) + self.drift(look, kT, h) + self.spread(kT, h) * normal) ** 2

    def change(self, here: Look, there: Look, kT: float, h: float) -> float:
        """Delta, the change of the effective energy in kT from one volume to another."""
        root, other = math.sqrt(here.volume), math.sqrt(there.volume)
        enthalpy = there.energy - here.energy + self.target * (there.volume - here.volume)
        forth = other - root - self.drift(here, kT, h)
        back = root - other - self.drift(there, kT, h)
        proposal = (back**2 - forth**2) / (2 * self.spread(kT, h) ** 2)
        # Of lambda, at the same scaled positions and momenta, the density is 2 lambda exp(-H/kT).
        return enthalpy / kT + proposal - math.log(other / root)


class Draw(NamedTuple):
    """The random numbers of a trial: standard normal, and uniform in (0, 1]."""

    normal: float
    chance: float


def draw(seed: int, step: int) -> Draw:
    """Random numbers of the trial at a step: a function of seed and step alone."""
    rng = np.random.Generator(np.random.Philox(key=[seed, STREAM], counter=[step, 0, 0, 0]))
    return Draw(float(rng.standard_normal()), 1.0 - float(rng.random()))
