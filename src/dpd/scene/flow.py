"""What drives a flow in a scene: a body force, or walls that move."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from dpd.scene.walls import AXES, axis_number, per_species, walls_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene

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
    """Whether something drives a flow, so that the mean of v^2 says more than the temperature."""
    walls = walls_of(scene)
    moving = walls is not None and any(map(any, walls.velocity))
    return moving or "body_force" in scene.data


def flow_notes(scene: Scene) -> list[str]:
    """A sentence for a person, if what is called a temperature holds a flow too."""
    if not flows(scene) or "thermo" not in scene.observe:
        return []
    return [
        "kT of 'thermo' includes the flow; observe 'velocity_profile', whose temperature is "
        "measured about it"
    ]


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
    for name in ("profile", "velocity_profile", "stress_profile"):
        if name in scene.observe:
            profile_axis(scene, scene.observe[name].get("axis"))
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
    if "configurational" in scene.observe:
        refuse("observe", "'configurational' holds in equilibrium, not with a body force")
    if not _is_braked(scene, body, walls):
        refuse(
            "body_force",
            f"along {AXES[body.axis]} nothing brakes the beads, and they would go faster and "
            "faster; give walls with a gamma, or 'opposite', or strengths of which the sum over "
            "all beads is 0",
        )


def _is_braked(scene, body, walls):
    """Whether the force meets a wall or friction, or adds up to none."""
    if body.opposite is not None:
        return True
    if walls is not None and (walls.gamma or body.axis in walls.axes):
        return True
    thermostat = scene.data["thermostat"]
    if thermostat["kind"] == "langevin" and thermostat["gamma"]:
        return True
    beads = [0] * len(scene.species)
    for kind in scene.molecules:
        for name in kind.beads:
            beads[scene.species.index(name)] += kind.count
    forces = [number * strength for number, strength in zip(beads, body.strength)]
    return abs(sum(forces)) <= BALANCED * sum(map(abs, forces))
