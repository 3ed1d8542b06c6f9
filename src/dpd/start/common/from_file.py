"""``start: {method: file}``: the first configuration is read from a file of any origin."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.engine.state import State
from dpd.errors import UserError
from dpd.particles.formats import read
from dpd.particles.particles import UPRIGHT, shear_of, whole_images
from dpd.start.common.description import start_description
from dpd.start.common.make import species_of, system_of, thermal_velocities
from dpd.start.common.matching import SAME, order_of, same_box
from dpd.start.file import LAST_FRAME, file_digest

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene


def state_from_file(scene: Scene, say: Callable[[str], object]) -> State:
    """Read the first configuration that a scene names, as a state with no force yet and step 0.

    Beads are renumbered where the file has the molecules in another order. Velocities are drawn at
    the temperature of the start where the file has none. All such things are said.

    Raises
    ------
    UserError
        If the file cannot be read, is not what it was when the scene was read, or holds another
        system.
    """
    path, frame = scene.start.path, scene.start.frame
    if file_digest(path, scene.where) != scene.start.sha256:
        raise UserError(
            f"{path}: is not the file that {scene.where} means: its content is not that of "
            "start.sha256. If the file was changed on purpose, start again without that key"
        )
    particles = read(path, LAST_FRAME if frame is None else frame)
    for sentence in particles.left_out:
        say(f"{path}: {sentence}")
    if particles.dimension == scene.dimension:
        particles = _between_walls(scene, particles, path)
    order = order_of(scene, particles, path)
    if scene.stretched and not same_box(scene.box, particles.box):
        edges = " x ".join(f"{edge:.6g}" for edge in particles.box)
        say(f"{path}: its box of {edges} is that of the start, instead of the scene's")
    if (order != np.arange(len(order))).any():
        say(f"{path}: its molecules are in another order, so beads are numbered as in the scene")
    if sentence := _other_masses(scene, particles):
        say(f"{path}: {sentence}")
    if len(particles.angles) not in (0, len(scene.angled)):
        say(
            f"{path}: it has {len(particles.angles)} angles, and the scene {len(scene.angled)}; "
            "those of the scene act"
        )
    species, velocity = species_of(scene), particles.velocity
    if velocity is None:
        description = start_description(scene)
        kT, rng = description["kT"], np.random.default_rng(description["seed"])
        mass: Any = system_of(scene).mass_of(species)
        in_file = mass if np.ndim(mass) == 0 else mass[np.argsort(order)]
        velocity = thermal_velocities(particles.position.shape, kT, rng, in_file)
        say(f"{path}: it has no velocities, so they are drawn at kT {kT:g}")
    if sentence := _together(particles, velocity):
        say(f"{path}: {sentence}")
    position, image = particles.position[:, order], particles.image[:, order]
    whole = whole_images(scene.molecules, position, image, particles.box)
    if image.any() and (whole != image).any():
        say(
            f"{path}: by its images not all molecules are in one piece; beads are put at those at "
            "which their bonds pull"
        )
    identity = np.arange(len(order), dtype=np.uint32)
    return State(
        position, velocity[:, order], None, identity, species, 0,
        slid=_slid(scene, particles.box, path),
        box=particles.box if scene.stretched else None,
        image=whole,
    )  # fmt: skip


def _together(particles, velocity):
    """A sentence if beads are at one place with one velocity: no force between them parts them."""
    rows = np.concatenate([particles.position, velocity])
    order = np.lexsort(rows)
    same = (np.diff(rows[:, order]) == 0).all(axis=0)
    if not same.any():
        return ""
    one, other = map(particles.called, sorted(order[np.argmax(same) :][:2]))
    return (
        f"{one} and {other} are at one place with one velocity ({same.sum()} such pairs), so that "
        "no force between them has a direction: unless other beads push, they stay together"
    )


def _other_masses(scene, particles):
    """A sentence if the masses of a file are not those of the scene."""
    there = particles.masses_by_name()
    own = scene.data.get("mass", {})
    differing = [name for name in scene.species if there.get(name, 1) != own.get(name, 1)]
    if not differing:
        return ""
    masses = ", ".join(f"{name} {there.get(name, 1):g}" for name in differing)
    return f"it has other masses than the scene ({masses}); those of the scene count"


def _slid(scene, box, path):
    """By how much images have slid in the file, see `State`; refused where the scene has none."""
    if abs(getattr(box, "tilt", 0.0)) < UPRIGHT:
        return None
    axes, shear = (box.slide.flow, box.slide.gradient), shear_of(scene)
    if shear is None or (shear.flow, shear.gradient) != axes:
        raise UserError(
            f"{path}: its box is tilted by shear with the flow along {'xyz'[axes[0]]} and the "
            f"gradient along {'xyz'[axes[1]]}, and {scene.where} has no such shear; give it one, "
            "or take a file whose box has right angles"
        )
    if scene.start.relax:
        raise UserError(
            f"{scene.where}: start.relax: the box of {path} is tilted by shear, and relaxation is "
            "at rest; remove the key, or take a file whose box has right angles"
        )
    return box.slid


def _between_walls(scene, particles, path):
    """The beads of a file between the walls of a scene; as they are for a scene without walls.

    The middle of the file's box is taken for the middle between the planes. So a box may be as
    long as the distance of the planes, or longer by some empty space, as this program writes it.

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
