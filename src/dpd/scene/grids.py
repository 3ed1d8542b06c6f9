"""Grids of density fields and wave vectors of structure factors, and how large they may be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene

# What a run may keep: with copies for checkpoint and result it fits into the memory that a cluster
# is asked for, `dpd.pipeline.resources`.
MOST_CELLS = 5 * 10**7  # numbers of a field over time, of 4 bytes
MOST_WAVES = 5 * 10**5  # wave vectors times pairs of species, each with numbers for 50 blocks
MOST_SUMS = 10**11  # terms of a structure factor: minutes for each look


def grid_shape(box: tuple[float, ...], spacing: float) -> tuple[int, ...]:
    """Cells along each axis: equal ones, not wider than ``spacing``."""
    return tuple(math.ceil(edge / spacing - 1e-9) for edge in box)


def frames_of(scene: Scene) -> int:
    """Frames of ``density_field``; the last one may have fewer looks than the others."""
    settings = scene.observe["density_field"]
    return -(-(scene.steps.sample // settings["every"]) // settings["average"])


def wave_numbers(box: tuple[float, ...], most: float) -> np.ndarray:
    """The wave vectors that a periodic box has up to a length, one of each pair q and -q.

    Parameters
    ----------
    box : tuple of float
        Edges L in r_c.
    most : float
        Largest |q| in 1 / r_c.

    Returns
    -------
    (n, dimension) int64 array
        Whole numbers m of q = 2 pi m / L; the last axis changes first.
    """
    reach = [_farthest(edge, most) for edge in box]
    axes = [np.arange(-count, count + 1) for count in reach]
    numbers = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    numbers = numbers[len(numbers) // 2 + 1 :]  # behind 0 stand the opposites of those before it
    length = np.sqrt(((2 * np.pi * numbers / np.array(box)) ** 2).sum(axis=1))
    return numbers[length <= most * (1 + 1e-12)]


def _farthest(edge, most):
    """The largest whole number along an axis."""
    return int(most * edge / (2 * np.pi) * (1 + 1e-12))


def check_grids(scene: Scene, refuse: Callable[[str, str], Any]) -> None:
    """Refuse fields and structure factors that are too large or empty.

    Parameters
    ----------
    scene : Scene
        With all else checked.
    refuse : callable
        Called with a key and what is wrong; it raises an error.
    """
    if "density_field" in scene.observe:
        _check_field(scene, refuse)
    if "structure_factor" in scene.observe:
        _check_structure(scene, refuse)
    if "pair_energies" in scene.observe and "core" in scene.data:
        refuse("observe", "'pair_energies' knows the soft repulsion alone, and there is a core")
    if "mixing" in scene.observe and len(scene.species) < 2:
        refuse("observe", "'mixing' has nothing to measure: there is a single species")


def _check_field(scene, refuse):
    settings = scene.observe["density_field"]
    spacing, smallest = settings["spacing"], min(scene.box)
    if spacing > smallest / 2:
        refuse(
            "observe.density_field.spacing",
            f"{spacing:g} makes fewer than two cells along an edge of {smallest:g}; allowed: <= "
            f"{smallest / 2:g}",
        )
    cells = math.prod(grid_shape(scene.box, spacing)) * len(scene.species)
    numbers = frames_of(scene) * cells
    if numbers > MOST_CELLS:
        refuse(
            "observe.density_field",
            f"{frames_of(scene)} frames of {cells} cells (all species together) make "
            f"{numbers:.3g} numbers; allowed: <= {MOST_CELLS}. Take a larger every, average or "
            "spacing",
        )


def _check_structure(scene, refuse):
    most, longest = scene.observe["structure_factor"]["max"], max(scene.box)
    if most * longest < 2 * np.pi:
        refuse(
            "observe.structure_factor.max",
            f"{most:g} is below the smallest wave number of the box, 2 pi / {longest:g}; allowed: "
            f">= {2 * np.pi / longest:.4g}",
        )
    # Their number, before they are all written down.
    around = math.prod(2 * _farthest(edge, most) + 1 for edge in scene.box) // 2
    pairs = len(scene.species) * (len(scene.species) + 1) // 2
    if around * pairs > MOST_WAVES or around * scene.beads > MOST_SUMS:
        refuse(
            "observe.structure_factor.max",
            f"{most:g} makes up to {around:.3g} wave vectors for {scene.beads} beads; allowed: "
            f"<= {min(MOST_WAVES // pairs, MOST_SUMS // scene.beads)} vectors. Take a smaller max",
        )
