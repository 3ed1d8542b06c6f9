"""``start: {method: file}``: the first configuration is read from a file of any origin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.engine.state import State
from dpd.errors import UserError
from dpd.particles.formats import read
from dpd.scene.start import LAST_FRAME, file_digest, start_description
from dpd.start.matching import order_of
from dpd.start.velocities import thermal_velocities

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene


def state_from_file(
    scene: Scene, species: np.ndarray | None, say: Callable[[str], object]
) -> State:
    """Read the first configuration that a scene names.

    Beads are renumbered where the file has the molecules in another order. Velocities are drawn at
    the temperature of the start where the file has none.

    Parameters
    ----------
    scene : Scene
        With ``start: {method: file}``.
    species : (n,) uint8 array or None
        Of the scene's beads.
    say : callable
        Called with a sentence for each thing that the file had otherwise.

    Returns
    -------
    State
        In the order of identities, with no force yet and step 0.

    Raises
    ------
    UserError
        If the file cannot be read, is not what it was when the scene was read, or holds another
        system.
    """
    start = scene.data["start"]
    path = start["path"]
    if file_digest(path, scene.where) != start["sha256"]:
        raise UserError(
            f"{path}: is not the file that {scene.where} means: its content is not that of "
            "start.sha256. If the file was changed on purpose, start again without that key"
        )
    particles = read(path, start.get("frame", LAST_FRAME))
    for sentence in particles.left_out:
        say(f"{path}: {sentence}")
    order = order_of(scene, particles, path)
    if (order != np.arange(len(order))).any():
        say(f"{path}: its molecules are in another order, so beads are numbered as in the scene")
    if len(particles.angles) not in (0, len(scene.angled)):
        say(
            f"{path}: it has {len(particles.angles)} angles, and the scene {len(scene.angled)}; "
            "those of the scene act"
        )
    velocity = particles.velocity
    if velocity is None:
        description = start_description(scene)
        kT, rng = description["kT"], np.random.default_rng(description["seed"])
        velocity = thermal_velocities(particles.position.shape, kT, rng)
        say(f"{path}: it has no velocities, so they are drawn at kT {kT:g}")
    identity = np.arange(len(order), dtype=np.uint32)
    return State(particles.position[:, order], velocity[:, order], None, identity, species, 0)
