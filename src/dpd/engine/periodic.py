"""Periodic boundaries in NumPy, for what looks at beads between steps."""

import numpy as np

# Of an edge: a bond that reaches further along an axis may soon be nearer to another image of its
# bead than to its own. It may so in this share of all bonds and steps; see dpd.observe.stretch.
STRETCHED = 0.48
MOST_STRETCHED = 1e-4


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
