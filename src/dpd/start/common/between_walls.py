"""Beads of a file in the periodic box of a scene with walls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError
from dpd.start.common.matching import SAME

if TYPE_CHECKING:
    from dpd.particles.particles import Particles
    from dpd.scene.scene import Scene


def between_walls(scene: Scene, particles: Particles, path: str) -> Particles:
    """The beads of a file between the walls of a scene; as they are for a scene without walls.

    The middle of the file's box is taken for the middle between the planes. So a box may be as
    long as the distance of the planes, or longer by some empty space, as this program writes it.

    Parameters
    ----------
    scene : Scene
    particles : Particles
        Of the scene's dimension.
    path : str
        Of the file, for messages.

    Returns
    -------
    Particles

    Raises
    ------
    UserError
        If the box of the file is shorter than the distance of the planes, a bead is further behind
        one of them than it could get, or a bond goes through one.
    """
    if not scene.ended:
        return particles
    edges, position = list(particles.box), particles.position.copy()
    for axis in scene.ended:
        apart, period = scene.box[axis], scene.period[axis]
        if edges[axis] < apart * (1 - SAME):
            raise UserError(
                f"{path}: its box has an edge of {edges[axis]:.9g} along {'xyz'[axis]}, and the "
                f"walls of {scene.where} are {apart:.9g} apart; they have to be nearer, or take "
                "another file"
            )
        position[axis] += 0.5 * (period - edges[axis])
        edges[axis] = period
        reach = scene.origin[axis] - 1.0  # the rest of the gap is for the cutoff
        depth = np.abs(position[axis] - 0.5 * period) - 0.5 * apart
        bead = int(np.argmax(depth))
        if depth[bead] > reach:
            raise UserError(
                f"{path}: {particles.called(bead)} would be {depth[bead]:.3g} r_c behind a wall "
                f"along {'xyz'[axis]}; allowed: {reach:g}. The walls of {scene.where} are "
                "about the middle of the file's box; make them further apart, or take another file"
            )
        one, two = particles.bonds.T
        torn = np.abs(position[axis, one] - position[axis, two]) > 0.5 * particles.box[axis]
        if torn.any():
            raise UserError(
                f"{path}: {particles.called(int(one[torn.argmax()]))} is bonded through the face "
                f"at which a wall of {scene.where} stands; make molecules whole before"
            )
    return particles._replace(box=tuple(edges), position=position)
