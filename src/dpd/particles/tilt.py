"""Tilted boxes in files: what a shear (`dpd.engine.space`) leaves of a box in right angles.

Other programs have them as tilt factors xy, xz, yz: how far the second or third vector of the box
goes along the first or second axis, over its edge. Here positions stay in the upright box, whose
images have slid; elsewhere they lie in the tilted one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.space import TURN, along_axes, tilted
from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.particles.particles import Particles
    from dpd.physics.shear import Shear
    from dpd.scene.scene import Scene

FACTORS = (0, 1), (0, 2), (1, 2)  # axes of xy, xz and yz
SLID = "slid"  # attribute of a first configuration whose images have slid
ROUNDING = 1e-5  # of an edge by which a tilt may be beyond half of it
UPRIGHT = 1e-9  # a tilt factor that is less is rounding: the box has right angles


def shear_of(scene: Scene) -> Shear | None:
    """The shear of a scene, if it has one."""
    return scene.terms["shear"].record(scene) if "shear" in scene.terms else None


def box_at(scene: Scene, step: int, slid: int | None) -> tuple[float, ...]:
    """The box of a scene with its images where they are at a step.

    Parameters
    ----------
    scene : Scene
    step : int
    slid : int or None
        As in `dpd.engine.state.State`.
    """
    return tilted(scene.period, shear_of(scene), scene.dt, step, slid or 0)


def tilt_factors(box: Sequence[float]) -> list[float]:
    """xy, xz and yz of a box; zeros without shear."""
    slide = getattr(box, "slide", None)
    if slide is None:
        return [0.0] * len(FACTORS)
    axes = slide.flow, slide.gradient
    return [float(slide.tilt[0]) if pair == axes else 0.0 for pair in FACTORS]


def box_of_file(
    edges: Sequence[float], factors: Sequence[float] | np.ndarray, path: object
) -> tuple[float, ...]:
    """A box with tilt factors, one of which may differ from 0.

    Parameters
    ----------
    edges : tuple of float
        In r_c.
    factors : sequence of float
        xy, xz and yz, or none.
    path : path
        Of the file that has them, for messages.

    Raises
    ------
    UserError
        If more than one do, or if it tilts by more than half an edge.
    """
    edges, tilts = tuple(map(float, edges)), [0.0 if abs(f) < UPRIGHT else f for f in factors]
    pairs = [pair for pair, tilt in zip(FACTORS, tilts) if tilt]
    if not pairs or not all(edge > 0 for edge in edges):
        return edges
    (flow, gradient), factor = pairs[0], next(filter(None, tilts))
    turns = float(factor) * edges[gradient] / edges[flow] if gradient < len(edges) else np.nan
    if len(pairs) > 1 or not abs(turns) <= 0.5 + ROUNDING:
        found = ", ".join(f"{factor:g}" for factor in factors)
        raise UserError(
            f"{path}: its box has the tilt factors {found}; allowed: one that is not 0, by which "
            "the box tilts by up to half an edge"
        )
    slid = round(float(np.clip(turns, -0.5, 0.5)) * TURN) % TURN
    from dpd.physics.shear import Shear

    return tilted(edges, Shear(0.0, flow, gradient), 1.0, 0, slid)


def in_tilted_box(particles: Particles) -> tuple[np.ndarray, np.ndarray]:
    """Positions and images of beads put into the tilted box, as other programs want them."""
    position, image = particles.position.copy(), particles.image.copy()
    slide = getattr(particles.box, "slide", None)
    if slide is not None:
        edge = particles.box[slide.flow]
        beside = np.floor(along_axes(position, particles.box)[slide.flow] / edge)
        position[slide.flow] -= edge * beside
        image[slide.flow] += beside.astype(image.dtype)
    return position, image


def centre(box: Sequence[float]) -> np.ndarray:
    """(dimension, 1) array: the middle of a box, tilted or not, whose corner is at 0."""
    middle, slide = 0.5 * np.array(box, dtype=float), getattr(box, "slide", None)
    if slide is not None:
        middle[slide.flow] += slide.tilt[0] * middle[slide.gradient]
    return middle[:, None]
