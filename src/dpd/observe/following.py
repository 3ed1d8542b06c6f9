"""Beads followed from sample to sample across the faces of the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import along_axes, nearest
from dpd.errors import LostTrack

if TYPE_CHECKING:
    from dpd.engine.slide import TiltedBox

FARTHEST = 1 / 3  # of an edge that a bead may move between samples and still be followed


def carried(position: np.ndarray, box: tuple[float, ...], time: float) -> np.ndarray:
    """How far a flow carries what is at some place in a time; zeros without shear.

    Parameters
    ----------
    position : (dimension, n) array
    box : tuple of float
    time : float
        In tau.

    Returns
    -------
    (dimension, n) array, or one that goes with it
    """
    slide = getattr(box, "slide", None)
    if slide is None:
        return np.zeros((len(position), 1))
    way = np.zeros_like(position)
    way[slide.flow] = slide.rate * time * position[slide.gradient]
    return way


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
        At the last sample, where a flow has carried it since (`carried`), and now in the box.
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
