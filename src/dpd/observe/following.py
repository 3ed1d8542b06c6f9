"""Beads followed from sample to sample across the faces of the box."""

from __future__ import annotations

import numpy as np

from dpd.engine.space import nearest
from dpd.errors import LostTrack

FARTHEST = 1 / 3  # of an edge that a bead may move between samples and still be followed


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
        In the box, at the last sample and now.
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
    if (np.abs(moved) / np.array(box)[:, None]).max() > FARTHEST:
        raise LostTrack(
            f"observe.{name}.every: a bead moved more than a third of the box between samples "
            f"{every} steps apart; sample more often",
            step,
        )
    return moved
