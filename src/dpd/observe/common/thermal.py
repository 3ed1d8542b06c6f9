"""Velocities about the flow, in which each degree of freedom counts as one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.observe.common.bins import Layers

if TYPE_CHECKING:
    from dpd.engine.simulation import Snapshot
    from dpd.engine.state import Sums, System
    from dpd.scene.scene import Scene

TINY = 1e-9  # of the largest: below, a number is 0 but for rounding


class ThermalMotion:
    """Velocities whose squares give kT and the kinetic part of the pressure.

    In a fluid at rest they are those about the centre of mass, along `momentum_axes`. Where
    something drives a flow, they are those about its profile at this moment: in each cell across it
    a constant and a slope, one for all species: where a force drives them through each other, that
    counts as heat. A fit by least squares, weighted by mass, takes up as many degrees of freedom as
    it has coefficients, and those that are left stand for all.
    """

    def __init__(self, scene: Scene, system: System) -> None:
        self._system = system
        self._at_rest = np.isin(np.arange(scene.dimension), scene.momentum_axes)[:, None]
        self._layers = [Layers(scene, *each) for each in system.flow]

    def kinetic(self, sums: Sums) -> np.ndarray:
        """(samples, dimension, dimension) array: the sum of m c c; NaN where no bead is free."""
        d, beads = self._system.dimension, sums.beads.sum(axis=1)
        second, crossed, matrix = (
            sums.moments[..., :d, :d], sums.moments[..., :d, d:], sums.moments[..., d:, d:]
        )  # fmt: skip
        inverse = _inverse(matrix)
        fitted = np.einsum("scap,scpq,scbq->sab", crossed, inverse, crossed)
        coefficients = np.einsum("scpq,scqp->s", matrix, inverse)
        # Along some axes alone: then sum m u_a v_b = sum m u_a u_b, if along a.
        along = np.ones(d, bool) if self._layers else self._at_rest[:, 0]
        about = second.sum(axis=1) - (along | along[:, None]) * fitted
        free = beads[:, None] - coefficients[:, None] * along
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.sqrt(np.where(free > 0.5, beads[:, None] / free, np.nan))
        return about * times[:, None] * times[..., None]

    def velocities(self, simulation: Snapshot) -> np.ndarray:
        """(dimension, n) array: c of each bead, in storage order; NaN where none is free.

        Each counts as one degree of freedom: c = (v - u) / sqrt(1 - h), so that <m c^2> = kT for
        each bead, as a fit u takes up the share h of a bead's degree of freedom (its leverage; the
        sum of all h is the number of coefficients). A bead with h = 1 says nothing of kT; the
        others then count for it.
        """
        state, momenta = simulation.state, self._system.momenta(simulation.state)
        mass = np.broadcast_to(self._system.mass_of(state.species), momenta.shape[1:])
        if self._layers:
            flow, leverage = self._flow(simulation, momenta, mass)
        elif self._at_rest.any():
            flow = self._at_rest * momenta.sum(axis=1, keepdims=True) / mass.sum()
            leverage = self._at_rest * np.full(mass.shape, 1 / mass.size)
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
    """Inverses of matrices along the last two axes: of each cell, of its functions.

    A function that is one of the others in a cell, as its beads lie, adds nothing there.
    """
    return np.linalg.pinv(matrix, rcond=TINY, hermitian=True)
