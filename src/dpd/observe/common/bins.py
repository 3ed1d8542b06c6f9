"""Bins, and layers across an axis with the thermal motion in them, about the flow."""

import math
from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from dpd.page import Axis, Observable, once, setting

CUTOFF = 1.0
PRESSURE = "kT / r_c^dimension"


def species_pairs(scene: Any, pairs: Iterable[Any], text: str = "pair of species") -> Any:
    """An axis of pairs of species, from their numbers."""
    return [f"{scene.species[i]} {scene.species[j]}" for i, j in pairs], "1", text


class Binned(Observable):
    """What is counted in equal bins from 0 to ``range``."""

    bins_of = "range"
    whole: ClassVar[Any] = math.ceil  # bins, of range / bin; `round` where a bin may be wider

    @property
    def edges(self) -> np.ndarray:
        """(bins + 1,) array."""
        end, width = self.range, self.bin  # type: ignore[attr-defined]
        return np.linspace(0.0, end, max(1, self.whole(end / width)) + 1)

    def middles(self) -> np.ndarray:
        """(bins,) array."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    def density(self, values: np.ndarray) -> np.ndarray:
        """(bins,) array: share of some numbers in each bin, over its width."""
        edges = self.edges
        counts, _ = np.histogram(values, len(edges) - 1, (0.0, edges[-1]))  # faster than with edges
        return counts / (values.size * edges[1])


class Layered(Observable):
    """What is measured in layers across an axis, whose places have the name `along`."""

    bins_of = "box"
    along: ClassVar[str]

    bin: float = setting(
        "Largest width of a layer, at most the longest edge.", 0.2, unit="r_c", ge=0.001
    )
    axis: Axis | None = setting(
        "The axis; if not given, the one across which walls, a body force that turns round, or a "
        "shear make the fluid change, or the longest.", None, of="axis",
    )  # fmt: skip

    @once
    def layers(self, scene: Any) -> "Layers":
        return Layers(scene, scene.axis_of_profile(self.axis), self.bin)

    def axes(self, scene: Any) -> Any:
        return {self.along: (self.layers(scene).middles(), "r_c", "position along the axis")}


class Layers:
    """Equal layers across an axis: of the box, or from behind one wall to behind the other."""

    def __init__(self, scene: Any, axis: int, thickness: float) -> None:
        # Behind a plane the gap is the reach of beads, and a cutoff.
        self._reach = max(0.0, scene.origin[axis] - CUTOFF)
        self._low = scene.origin[axis] - self._reach
        self._length = scene.box[axis] + 2 * self._reach
        self._edge, self._share = scene.period[axis], scene.box[axis] / self._length
        self.axis, self.count = axis, math.ceil(self._length / thickness)

    def of(self, now: Any) -> np.ndarray:
        """(n,) int64 array: the layer of each bead, in storage order."""
        return np.minimum(self.places(now).astype(np.int64), self.count - 1)

    def places(self, now: Any) -> np.ndarray:
        """(n,) array: where each bead is, in layers from the lower end of the first one."""
        place = now.state.position[self.axis] - self._low
        return place * (self.count / self._length_in(now))

    def bounds(self, now: Any) -> tuple[float, float]:
        """Where in the engine's box the first layer begins, and the last one ends, in r_c."""
        return float(self._low), float(self._low + self._length_in(now))

    def per_volume(self, now: Any) -> float:
        """One over the volume of a layer of the box as it is now."""
        return self._share * self.count / now.volume

    def middles(self, now: Any = None) -> np.ndarray:
        """(count,) array: of the layers of the scene's box, or of that now, from its lower end."""
        length = self._length if now is None else self._length_in(now)
        return (np.arange(self.count) + 0.5) * (length / self.count) - self._reach

    def _length_in(self, now):
        """All layers together, in the box as it is now."""
        edge = now.box[self.axis]
        return self._length if edge == self._edge else edge  # of another pressure: no walls


TINY = 1e-9  # of the largest: below, a number is 0 but for rounding


class ThermalMotion:
    """Velocities whose squares give kT and the kinetic part of the pressure.

    In a fluid at rest they are those about the centre of mass, along `momentum_axes`. Where
    something drives a flow, they are those about its profile at this moment: in each cell across it
    a constant and a slope, one for all species. A fit by least squares, weighted by mass, takes up
    as many degrees of freedom as it has coefficients, and those that are left stand for all.
    """

    def __init__(self, scene: Any, system: Any) -> None:
        self._system = system
        self._at_rest = np.isin(np.arange(scene.dimension), scene.momentum_axes)[:, None]
        self._layers = [Layers(scene, *each) for each in system.flow]

    def kinetic(self, sums: Any) -> np.ndarray:
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

    def velocities(self, simulation: Any) -> np.ndarray:
        """(dimension, n) array: c of each bead, in storage order; NaN where none is free.

        c = (v - u) / sqrt(1 - h), so that <m c^2> = kT, as a fit u takes up the share h of a bead's
        degree of freedom (its leverage). For a bead with h = 1 the others count.
        """
        state, momenta = simulation.state, self._system.momenta(simulation.state)
        mass = np.broadcast_to(self._system.mass_of(state.species), momenta.shape[1:])
        if self._layers:
            flow, leverage = self._flow(simulation, momenta, mass)
        else:
            flow = self._at_rest * momenta.sum(axis=1, keepdims=True) / mass.sum()
            leverage = self._at_rest * np.full(mass.shape, 1 / mass.size)
        free = 1 - leverage > TINY
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.where(free, 1 / (1 - leverage), 0) / free.mean(axis=-1, keepdims=True)
        return (state.velocity - flow) * np.sqrt(times)

    def _flow(self, simulation, momenta, mass):
        """What is fitted to the velocities, at each bead, and the leverage of each."""
        cell, terms = np.zeros(len(mass), np.int64), [np.ones(len(mass))]
        for layers in self._layers:
            place = layers.places(simulation)
            layer = layers.of(simulation)
            cell = cell * layers.count + layer
            terms.append(place - layer - 0.5)
        matrix = np.array([[np.bincount(cell, mass * a * b) for b in terms] for a in terms])
        push = np.array([[np.bincount(cell, along * a) for a in terms] for along in momenta])
        inverse = _inverse(matrix.T)
        strength = np.einsum("cpq,dqc->dcp", inverse, push)
        fitted = np.einsum("pn,dnp->dn", terms, strength[:, cell])
        return fitted, mass * np.einsum("pn,npq,qn->n", terms, inverse[cell], terms)


def _inverse(matrix):
    """Of each cell, along the last two axes; a function that is one of the others adds nothing."""
    return np.linalg.pinv(matrix, rcond=TINY, hermitian=True)
