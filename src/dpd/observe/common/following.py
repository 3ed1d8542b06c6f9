"""Beads followed across the faces of the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dpd.engine.simulation import Snapshot
    from dpd.engine.state import System
    from dpd.scene.scene import Scene


class Followed:
    """Displacements of all beads since the first sample, and of their molecules.

    By the boxes that the state counts for each bead, however far apart samples are. They are
    relative to the centre of mass of all beads, so a drift of the box does not count; nor does the
    flow of a shear, along which the state has the way of each bead by itself. At constant pressure
    places are those in a box that keeps the edges of the first sample, so that to be moved with the
    box does not count as a motion.

    Parameters
    ----------
    scene : Scene
    system : System

    Attributes
    ----------
    arrays : dict
        For a checkpoint.
    """

    def __init__(self, scene: Scene, system: System) -> None:
        self._first = np.cumsum(scene.lengths) - scene.lengths
        self._mass = system.mass_of(None if len(scene.species) == 1 else scene.kinds)
        each = np.broadcast_to(self._mass, scene.beads)
        self._of_molecule = np.add.reduceat(each, self._first)
        shape = system.dimension, scene.beads
        self.arrays = {"begun": np.zeros(shape), "edges": np.zeros(system.dimension)}

    def sample(self, snapshot: Snapshot, first: bool) -> np.ndarray:
        """Follow the beads from the first sample to this one.

        Parameters
        ----------
        snapshot : Snapshot
        first : bool
            Whether this is the first sample.

        Returns
        -------
        (dimension, beads) array
            Displacements, in the order of identities.
        """
        state, box, edges = snapshot.state, snapshot.box, self.arrays["edges"]
        if first:
            edges[:] = box
        place = snapshot.unfolded * (edges / np.array(box))[:, None]
        if state.peculiar is not None:
            place[box.slide.flow] = state.by_identity(state.peculiar)  # type: ignore[attr-defined]
        if first:
            self.arrays["begun"][...] = place
        moved = place - self.arrays["begun"]
        weights = self._mass if np.ndim(self._mass) else None
        return moved - np.average(moved, axis=1, weights=weights, keepdims=True)

    def centres(self, moved: np.ndarray) -> np.ndarray:
        """(dimension, molecules) array: displacements of centres of mass, from those of beads."""
        return np.add.reduceat(self._mass * moved, self._first, axis=1) / self._of_molecule
