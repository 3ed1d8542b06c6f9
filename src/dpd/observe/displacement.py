from typing import Any

import numpy as np

from dpd.page import Change, Observable, once


class Displacement(Observable, key="displacement"):
    """Mean-square displacement of innermost beads and of centres of mass.

    By multiple-tau correlation, relative to the centre of mass of all beads (`displacements`).
    "Innermost" is the bead in the middle of the longest way through a molecule, two of them for an
    even number. Free flight, before beads diffuse, takes an ``every`` of 0.1 tau or less.
    """

    stands = frozenset(Change) - {Change.VARIES}
    interval, cost = 1.2, 5.0
    compared = "axis", "point", "molecule"
    over = {"lag": ("lag", "lag_time")}
    gives = {
        "msd_inner": (("lag", "molecule"), "r_c^2", "displacement of innermost beads, squared"),
        "msd_centre": (("lag", "molecule"), "r_c^2", "displacement of centres of mass, squared"),
        "lag_samples": (("part", "lag"), "1", "pairs of samples ending in each part of the run"),
        "msd_inner_sums": (("part", "lag"), "r_c^2", "sums over them of means over molecules"),
        "msd_centre_sums": (("part", "lag"), "r_c^2", "sums over them of means over molecules"),
    }

    def axes(self, scene: Any) -> Any:
        return {"point": len(self.inner(scene)) + int(max(scene.lengths) > 1)}

    def keeps(self, scene: Any) -> Any:
        return followed(scene)

    @once
    def inner(self, scene: Any) -> np.ndarray:
        """(1 or 2, molecules) array: the innermost beads; a second row where any has two."""
        middles = [np.tile(kind.middle, (kind.count, 1)) for kind in scene.molecules]
        inner = np.cumsum(scene.lengths) - scene.lengths + np.concatenate(middles).T
        return inner if (inner[0] != inner[1]).any() else inner[:1]

    def measure(self, now: Any) -> Any:
        moved = displacements(now)
        if (now.scene.lengths == 1).all():
            return moved[:, None]
        inner = moved[:, self.inner(now.scene)]
        return np.concatenate([inner, centres(now, moved)[:, None]], axis=1)

    def compare(self, now: np.ndarray, then: np.ndarray) -> np.ndarray:
        from dpd.engine.measure import squared_displacements

        found = np.empty((len(then), *now.shape[1:]))
        squared_displacements(found, now, then)
        if found.shape[1] < 3:  # one for both, or one for each
            return found
        return np.stack([found[:, :2].mean(axis=1), found[:, 2]], axis=1)


def followed(scene: Any) -> dict[str, np.ndarray]:
    """What a page keeps that follows beads: where they began, in which box."""
    return {"begun": np.zeros((scene.dimension, scene.beads)), "edges": np.zeros(scene.dimension)}


def displacements(now: Any) -> np.ndarray:
    """(dimension, beads) array: displacements since the first sample, less that of all beads.

    The flow of a shear does not count. At constant pressure places are those in a box that keeps
    the edges of the first sample, so that to be moved with the box does not count as a motion.
    """
    begun, edges, state = now.kept["begun"], now.kept["edges"], now.state
    if now.sample == 0:
        edges[:] = now.box
    place = now.unwrapped.T
    if state.box is not None:
        place = place * (edges / now.box)[:, None]
    if state.peculiar is not None:
        place = place.copy()
        place[now.lattice.slide.flow] = state.by_identity(state.peculiar)
    if now.sample == 0:
        begun[...] = place
    moved = place - begun
    if now.system.masses is None:
        return moved - moved.mean(axis=1, keepdims=True)
    return moved - np.average(moved, axis=1, weights=now.masses, keepdims=True)


def centres(now: Any, moved: np.ndarray) -> np.ndarray:
    """(dimension, molecules) array: displacements of centres of mass, from those of beads."""
    first = np.cumsum(now.scene.lengths) - now.scene.lengths
    return np.add.reduceat(now.masses * moved, first, axis=1) / np.add.reduceat(now.masses, first)
