"""Beads followed from sample to sample across the faces of the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import along_axes, nearest
from dpd.errors import LostTrack

if TYPE_CHECKING:
    from dpd.engine.slide import TiltedBox

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
