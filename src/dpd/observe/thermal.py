"""Velocities about the flow, in which each degree of freedom counts as one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.layers import Layers
from dpd.scene.flow import flows, gradient_axes, momentum_axes

if TYPE_CHECKING:
    from dpd.engine.simulation import Snapshot
    from dpd.engine.state import System
    from dpd.scene.scene import Scene

FINEST = 1.0  # r_c, thickness of cells across a flow
LEAST = 10  # beads in a cell, in the mean, for each function that is fitted to their velocities
TINY = 1e-9  # of the largest: below, a number is 0 but for rounding


class ThermalMotion:
    """Velocities whose squares give kT and the kinetic part of the pressure.

    Along each axis c = (v - u) / sqrt(1 - h), so that <m c^2> = kT for each bead: a fit u to
    independent velocities, by least squares weighted by mass, takes up the share h of a bead's
    degree of freedom (its leverage; the sum of all h is the number of coefficients). In a fluid at
    rest u is the velocity of the centre of mass, and h = m / sum m, along `momentum_axes`: all in a
    closed fluid, those along walls without friction, none with Langevin's thermostat or rough
    walls. Where something drives a flow (`flows`), u is its profile at this moment: in each cell
    across it (`gradient_axes`) a constant and a slope, one for all species: where a force drives
    them through each other, that counts as heat. A bead with h = 1 says nothing of kT; the others
    then count for it.
    """

    def __init__(self, scene: Scene, system: System) -> None:
        self._system, self._layers = system, None
        self._at_rest = np.isin(np.arange(scene.dimension), momentum_axes(scene))[:, None]
        if flows(scene):
            axes = gradient_axes(scene)
            across = float(np.prod([system.extent[axis] for axis in axes]))
            least = LEAST * (1 + len(axes)) * across / scene.beads
            thickness = max(FINEST, least ** (1 / len(axes)))
            self._layers = [Layers(system, axis, thickness) for axis in axes]

    def kinetic(self, simulation: Snapshot, total: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(dimension, dimension) array: the sum of m c c over all beads; NaN where none is free.

        Parameters
        ----------
        simulation : Snapshot
        total : (dimension,) array
            The sum of m v.
        second : (dimension, dimension) array
            The sum of m v v, from which that of m c c follows for beads of one mass without a flow.
        """
        system, state = self._system, simulation.state
        if self._layers is not None or system.masses is not None:
            thermal = self.velocities(simulation)
            return np.einsum("an,bn->ab", thermal, system.mass_of(state.species) * thermal)
        beads, at_rest = state.identity.size, self._at_rest[:, 0]
        centre = np.where(at_rest, total / beads, 0.0)
        crossed = np.outer(centre, total)
        about = second - crossed - crossed.T + beads * np.outer(centre, centre)
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.sqrt(np.where(at_rest, np.float64(beads) / (beads - 1), 1.0))
            return about * np.outer(times, times)

    def velocities(self, simulation: Snapshot) -> np.ndarray:
        """(dimension, n) array: c of each bead, in storage order; NaN where none is free."""
        state, momenta = simulation.state, self._system.momenta(simulation.state)
        mass = np.broadcast_to(self._system.mass_of(state.species), momenta.shape[1:])
        if self._layers is not None:
            flow, leverage = self._flow(simulation, momenta, mass)
        elif self._at_rest.any():
            flow = self._at_rest * momenta.sum(axis=1, keepdims=True) / mass.sum()
            leverage = self._at_rest * mass / mass.sum()
        else:
            return state.velocity
        free = 1 - leverage > TINY
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.where(free, 1 / (1 - leverage), 0) / free.mean(axis=-1, keepdims=True)
        return (state.velocity - flow) * np.sqrt(times)

    def _flow(self, simulation, momenta, mass):
        """What is fitted to the velocities, at each bead, and the leverage of each."""
        cell, terms = np.zeros(len(mass), np.int64), [np.ones(len(mass))]
        for layers in self._layers:
            place = layers.places(simulation)
            layer = np.minimum(place.astype(np.int64), layers.count - 1)
            cell = cell * layers.count + layer
            terms.append(place - layer - 0.5)
        matrix = np.array([[np.bincount(cell, mass * a * b) for b in terms] for a in terms])
        push = np.array([[np.bincount(cell, along * a) for a in terms] for along in momenta])
        inverse = _inverse(matrix.T)
        strength = np.einsum("cpq,dqc->dcp", inverse, push)
        fitted = np.einsum("pn,dnp->dn", terms, strength[:, cell])
        return fitted, mass * np.einsum("pn,npq,qn->n", terms, inverse[cell], terms)


def _inverse(matrix):
    """Inverses of the matrices of all cells, (cells, functions, functions).

    A function that is one of the others in a cell, as its beads lie, adds nothing there.
    """
    if matrix.shape[1] > 2:
        return np.linalg.pinv(matrix, rcond=TINY, hermitian=True)
    a, b, c = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 1]
    determinant, inverse = a * c - b * b, np.zeros_like(matrix)
    both = determinant > TINY * a * (a + c)
    one = ~both & (a > 0)
    inverse[one, 0, 0] = 1 / a[one]
    for place, element in (((0, 0), c), ((0, 1), -b), ((1, 0), -b), ((1, 1), a)):
        inverse[(both, *place)] = element[both] / determinant[both]
    return inverse
