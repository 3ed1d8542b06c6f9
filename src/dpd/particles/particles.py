"""One configuration of beads, whatever file it came from or goes to."""

from typing import NamedTuple

import numpy as np


class Particles(NamedTuple):
    """Beads in the order of their identities, with their bonds.

    Attributes
    ----------
    box : tuple of float
        Edges in r_c, two or three. The box goes from 0 to its edges.
    position : (dimension, n) array
        In r_c, inside the box.
    image : (dimension, n) int32 array
        How many boxes further the bead is than its position says.
    velocity : None or (dimension, n) array
        In r_c / tau.
    species : (n,) uint8 array
        Numbers in ``names``.
    names : tuple of str
    bonds : (bonds, 2) uint32 array
        Identities of the two ends of each.
    step : int
    """

    box: tuple[float, ...]
    position: np.ndarray
    image: np.ndarray
    velocity: np.ndarray | None
    species: np.ndarray
    names: tuple[str, ...]
    bonds: np.ndarray
    step: int = 0
