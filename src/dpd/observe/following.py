"""Beads followed from sample to sample across the faces of the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import along_axes, nearest
from dpd.errors import LostTrack

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.engine.slide import TiltedBox
    from dpd.engine.state import System
    from dpd.scene.scene import Scene

FARTHEST = 1 / 3  # of an edge that a bead may move between samples and still be followed


def flow_at(position: np.ndarray, box: tuple[float, ...]) -> np.ndarray:
    """Velocity of the flow of a shear at some places; zeros without shear.

    A bead has this velocity beside that of the state, which is about the flow.

    Parameters
    ----------
    position : (dimension, n) array
    box : tuple of float
        As `dpd.engine.simulation.Simulation.box` has it.

    Returns
    -------
    (dimension, n) array, or (dimension, 1) without shear
        In r_c / tau.
    """
    slide = getattr(box, "slide", None)
    if slide is None:
        return np.zeros((len(position), 1))
    flow = np.zeros_like(position)
    flow[slide.flow] = slide.rate * position[slide.gradient]
    return flow


def edges_between(former: TiltedBox, now: TiltedBox, time: float) -> int:
    """Whole edges by which an image above has slid in a time, beyond what the tilts tell."""
    return round((former.tilt + now.slide.rate * time - now.tilt) / now.slide.ratio)


def in_box_of(position: np.ndarray, box: tuple[float, ...], other: tuple[float, ...]) -> np.ndarray:
    """Positions in one box as they would lie in another one, stretched with it.

    At constant pressure the box of a run changes. Beads are followed in the box that it began
    with, so that to be moved with the box does not count as a motion.

    Parameters
    ----------
    position : (dimension, n) array
    box, other : tuple of float
        In which they are; in which they shall be.
    """
    return position if box == other else position * (np.array(other) / np.array(box))[:, None]


def moved_between(
    last: np.ndarray,
    position: np.ndarray,
    box: tuple[float, ...],
    step: int,
    name: str,
    every: int,
) -> np.ndarray:
    """How far beads have moved since the last sample, over nearest images.

    Parameters
    ----------
    last, position : (dimension, n) array
        At the last sample, where a flow has carried it since (`flow_at`), and now in the box.
    box : tuple of float
    step : int
        Of the run, for messages.
    name : str
        Of the observable, for messages.
    every : int
        Steps between its samples, for messages.

    Returns
    -------
    (dimension, n) array

    Raises
    ------
    LostTrack
        If a bead has moved more than a third of an edge: it might as well have gone the other way.
    """
    moved = nearest(position - last, box)
    if (np.abs(along_axes(moved, box)) / np.array(box)[:, None]).max() > FARTHEST:
        raise LostTrack(
            f"observe.{name}.every: a bead moved more than a third of the box between samples "
            f"{every} steps apart; sample more often",
            step,
        )
    return moved


class Followed:
    """Displacements of all beads since the first sample, and of their molecules.

    They are relative to the centre of mass of all beads, so a drift of the box does not count; nor
    does the flow of a shear, in which a bead moves by the integral of its velocity about the flow,
    with the flow at the mean place between samples; nor, at constant pressure, that beads are
    moved with the box.

    Parameters
    ----------
    scene : Scene
    system : System
    every : int
        Steps between samples.
    name : str
        Of the observable, for messages.

    Attributes
    ----------
    arrays : dict
        For a checkpoint.
    """

    def __init__(self, scene: Scene, system: System, every: int, name: str) -> None:
        self._every, self._name, self._time = every, name, every * system.dt
        self._first = np.cumsum(scene.lengths) - scene.lengths
        self._mass = system.mass_of(None if len(scene.species) == 1 else scene.kinds)
        each = np.broadcast_to(self._mass, scene.beads)
        self._of_molecule = np.add.reduceat(each, self._first)
        shape = system.dimension, scene.beads
        self.arrays = {"last": np.zeros(shape), "moved": np.zeros(shape)}

    def sample(self, simulation: Simulation, first: bool) -> np.ndarray:
        """Follow the beads from the last sample to this one.

        Parameters
        ----------
        simulation : Simulation
        first : bool
            Whether there is no last sample.

        Returns
        -------
        (dimension, beads) array
            Displacements, in the order of identities.

        Raises
        ------
        LostTrack
            See `moved_between`.
        """
        arrays, state, box = self.arrays, simulation.state, simulation.first_box
        position = in_box_of(state.by_identity(state.position), simulation.box, box)
        if not first:
            begun = arrays["last"] + self._time * flow_at(arrays["last"], box)
            moved = moved_between(begun, position, box, state.step, self._name, self._every)
            moved = moved - 0.5 * self._time * flow_at(moved, box)
            arrays["moved"] += in_box_of(moved, box, simulation.box)
        arrays["last"][...] = position
        weights = self._mass if np.ndim(self._mass) else None
        return arrays["moved"] - np.average(arrays["moved"], axis=1, weights=weights, keepdims=True)

    def centres(self, moved: np.ndarray) -> np.ndarray:
        """(dimension, molecules) array: displacements of centres of mass, from those of beads."""
        return np.add.reduceat(self._mass * moved, self._first, axis=1) / self._of_molecule
