"""What drives a flow in a scene: a body force, or walls that move."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.scene.walls import AXES, axis_number, per_species, walls_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from dpd.scene.scene import Scene

FINEST = 1.0  # r_c, thickness of layers across a flow
LEAST = 10  # beads in a cell, in the mean, for each function that is fitted to their velocities
BALANCED = 1e-9  # share of all forces that their sum may be, by rounding


class BodyForce(NamedTuple):
    """The body force of a scene.

    Attributes
    ----------
    axis : int
        That it acts along.
    strength : tuple of float
        On a bead of each species, in kT / r_c.
    opposite : int or None
        The axis in whose upper half it acts in the opposite direction.
    """

    axis: int
    strength: tuple[float, ...]
    opposite: int | None


def body_force_of(scene: Scene) -> BodyForce | None:
    """The body force of a scene; None if it has none.

    Raises
    ------
    UserError
        If its axes or its species are not those of the scene.
    """
    asked = scene.data.get("body_force")
    if asked is None:
        return None
    opposite = None
    if "opposite" in asked:
        opposite = axis_number(scene, "body_force.opposite", asked["opposite"])
    return BodyForce(
        axis_number(scene, "body_force.axis", asked["axis"]),
        per_species(scene, "body_force.strength", asked["strength"]),
        opposite,
    )


def flows(scene: Scene) -> bool:
    """Whether something drives a flow: walls that move, or a body force no wall stands against."""
    walls, body = walls_of(scene), body_force_of(scene)
    if walls is not None and any(map(any, walls.velocity)):
        return True
    held = walls is not None and body is not None and body.axis in walls.axes
    return body is not None and any(body.strength) and (body.opposite is not None or not held)


def gradient_axes(scene: Scene) -> tuple[int, ...]:
    """The axes across which a flow that is driven changes."""
    walls, body = walls_of(scene), body_force_of(scene)
    turns = () if body is None or body.opposite is None else (body.opposite,)
    return (*(walls.axes if walls else ()), *turns) or (profile_axis(scene, None),)


def flow_layers(scene: Scene, extent: Sequence[float]) -> tuple[tuple[int, float], ...]:
    """The axes across which a driven flow changes, each with the thickness of layers.

    In cells that are cut by these layers the flow's profile is fitted to the velocities of beads.

    Parameters
    ----------
    scene : Scene
    extent : tuple of float
        Edges of the space that beads fill.
    """
    if not flows(scene):
        return ()
    axes = gradient_axes(scene)
    least = LEAST * (1 + len(axes)) * float(np.prod([extent[axis] for axis in axes])) / scene.beads
    return tuple((axis, max(FINEST, least ** (1 / len(axes)))) for axis in axes)


def takes_momentum(scene: Scene) -> bool:
    """Whether friction with what is no bead takes up momentum, along all axes."""
    walls = walls_of(scene)
    bath = scene.data["thermostat"]["kind"] == "langevin" and bool(np.any(scene.friction))
    return bath or (walls is not None and walls.gamma > 0)


def takes_heat(scene: Scene) -> bool:
    """Whether a friction holds the temperature: of pairs, of beads, or of walls."""
    return bool(np.any(scene.friction)) or takes_momentum(scene)


def momentum_axes(scene: Scene) -> tuple[int, ...]:
    """The axes along which nothing but a body force changes the total momentum."""
    if takes_momentum(scene):
        return ()
    walls = walls_of(scene)
    return tuple(axis for axis in range(scene.dimension) if not walls or axis not in walls.axes)


def profile_axis(scene: Scene, name: str | None) -> int:
    """The axis of a profile: the one named, or the one across which things change most.

    That is the axis of the walls, or the one across which a body force turns round, or that of the
    gradient of a shear, or the longest.
    """
    if name is not None:
        return axis_number(scene, "observe: axis of a profile", name)
    walls, body = walls_of(scene), body_force_of(scene)
    if walls is not None:
        return walls.axes[0]
    if body is not None and body.opposite is not None:
        return body.opposite
    if "shear" in scene.data:
        return AXES.index(scene.data["shear"]["gradient"])
    return scene.box.index(max(scene.box))


def check_flow(scene: Scene, refuse: Callable[[str, str], object]) -> None:
    """Refuse body forces that cannot be, and what cannot be beside one.

    Parameters
    ----------
    scene : Scene
    refuse : callable
        Called with a key and a problem; raises.
    """
    body, walls = body_force_of(scene), walls_of(scene)
    if body is None:
        return
    if body.opposite == body.axis:
        refuse(
            "body_force.opposite",
            f"{AXES[body.axis]} is the axis that the force acts along; take another one, across "
            "which the two flows lie",
        )
    if body.opposite is not None and walls is not None and body.opposite in walls.axes:
        refuse(
            "body_force.opposite",
            f"there are walls along {AXES[body.opposite]}, between which one flow is enough; "
            "remove the key, or name an axis without walls",
        )
    if not _is_braked(scene, body, walls):
        refuse(
            "body_force",
            f"along {AXES[body.axis]} nothing brakes the beads, and they would go faster and "
            "faster; give walls with a gamma, or 'opposite', or strengths of which the sum over "
            "all beads is 0",
        )
    if flows(scene) and not takes_heat(scene):
        refuse(
            "thermostat.gamma",
            "every gamma is 0: nothing takes up the heat of the flow that body_force drives; "
            "allowed: > 0 here, or as walls.gamma",
        )


def _is_braked(scene, body, walls):
    """Whether the force meets a wall or friction, or adds up to none."""
    if body.opposite is not None or takes_momentum(scene):
        return True
    if walls is not None and body.axis in walls.axes:
        return True
    forces = np.bincount(scene.kinds, minlength=len(scene.species)) * body.strength
    return abs(forces.sum()) <= BALANCED * abs(forces).sum()
