"""Periodic boundaries in NumPy, for what looks at beads between steps."""

import numpy as np


def nearest(apart, box):
    """Separations at their nearest image.

    Parameters
    ----------
    apart : (dimension, ...) array
    box : tuple
        Edges in r_c.
    """
    edges = _edges(apart, box)
    return apart - edges * np.rint(apart / edges)


def wrapped(position, box):
    """Positions moved into the box, 0 <= x < edge."""
    edges = _edges(position, box)
    inside = position - edges * np.floor(position / edges)
    return np.where(inside < edges, inside, 0.0)  # rounding may reach the edge


def _edges(array, box):
    return np.array(box).reshape(-1, *[1] * (np.ndim(array) - 1))
