"""Beads followed across the faces of the box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dpd.observe.common.snapshot import Snapshot
    from dpd.scene.scene import Scene


def followed(scene: Scene) -> dict[str, np.ndarray]:
    """What a page keeps that follows beads: where they began, in which box."""
    return {"begun": np.zeros((scene.dimension, scene.beads)), "edges": np.zeros(scene.dimension)}


def displacements(now: Snapshot) -> np.ndarray:
    """Displacements of all beads since the first sample.

    By the boxes that the state counts for each bead, however far apart samples are. They are
    relative to the centre of mass of all beads, so a drift of the box does not count; nor does the
    flow of a shear, along which the state has the way of each bead by itself. At constant pressure
    places are those in a box that keeps the edges of the first sample, so that to be moved with the
    box does not count as a motion.

    Returns
    -------
    (dimension, beads) array
    """
    begun, edges, state = now.kept["begun"], now.kept["edges"], now.state
    if now.sample == 0:
        edges[:] = now.box
    place = now.unwrapped.T
    place = place * (edges / now.box)[:, None] if (edges != now.box).any() else place.copy()
    if state.peculiar is not None:
        place[now.lattice.slide.flow] = state.by_identity(state.peculiar)  # type: ignore[attr-defined]
    if now.sample == 0:
        begun[...] = place
    moved = np.subtract(place, begun, out=place)
    if now.system.masses is None:
        return moved - moved.mean(axis=1, keepdims=True)
    return moved - np.average(moved, axis=1, weights=now.masses, keepdims=True)


def centres(now: Snapshot, moved: np.ndarray) -> np.ndarray:
    """(dimension, molecules) array: displacements of centres of mass, from those of beads."""
    first = np.cumsum(now.scene.lengths) - now.scene.lengths
    return np.add.reduceat(now.masses * moved, first, axis=1) / np.add.reduceat(now.masses, first)
