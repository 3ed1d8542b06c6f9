"""Density fields between the middles of their cells, as pictures show them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

IMAGES = 2  # boxes to each side that a Gaussian reaches into
LEAST = 0.5  # width of a Gaussian in cells, at which the grid does not show


def smoothed(
    density: np.ndarray,
    box: Sequence[float] | np.ndarray,
    places: Sequence[np.ndarray],
    width: float,
) -> np.ndarray:
    """Means of the cells around some places, weighted by a Gaussian.

    The box repeats: cells beyond a face are those at the opposite face.

    Parameters
    ----------
    density : (...) array
        With an axis of cells for each axis of the box.
    box : sequence of float
        Edges in r_c.
    places : sequence of (n,) arrays
        Coordinates along each axis, in r_c.
    width : float
        Standard deviation of the Gaussian in r_c; half a cell at least.

    Returns
    -------
    (...) array
        With an axis of places for each axis of the box.
    """
    for axis, (edge, along) in enumerate(zip(box, places)):
        weights = _weights(density.shape[axis], float(edge), np.asarray(along), width)
        density = np.moveaxis(np.tensordot(weights, density, (1, axis)), 0, axis)
    return density


def middles(count: int, edge: float) -> np.ndarray:
    """Middles of so many cells along an edge."""
    return (np.arange(count) + 0.5) * (edge / count)


def _weights(cells, edge, places, width):
    """(places, cells) array: the share of each cell in the mean at each place."""
    cell = edge / cells
    images = edge * np.arange(-IMAGES, IMAGES + 1)
    apart = places[:, None, None] - middles(cells, edge)[:, None] - images
    weights = np.exp(-0.5 * (apart / max(width, LEAST * cell)) ** 2).sum(axis=2)
    return weights / weights.sum(axis=1, keepdims=True)
