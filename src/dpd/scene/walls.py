"""Walls in a scene, and the periodic box in which beads between walls move.

The engine knows periodic boxes alone. Along an axis with walls its box has a gap behind each
plane, so wide that beads behind opposite planes do not feel each other: nothing repeats then.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from dpd.errors import UserError
from dpd.physics.schemes import scheme_named
from dpd.scene.tables import no_species

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene

AXES = "xyz"
RANGE = 1.0  # of a wall's force in r_c
# A bead gets behind a plane by chance, and because its neighbours push it. There is room for it as
# far as the wall's energy is below this many kT and what the neighbours can push with: further out
# it is met with a chance below 1e-13.
RARE = 30.0
# Energy of a bead among neighbours without order, for the density 1 and the repulsion 1: the
# integral of the pair energy (1 - r)^2 / 2 over the range of the force.
ENERGY_OF_FLUID = {2: math.pi / 12, 3: math.pi / 15}
DEEPEST = 10  # r_c behind a plane for which room is made


class Walls(NamedTuple):
    """The walls of a scene.

    Attributes
    ----------
    axes : tuple of int
        Those with a plane at both ends, by number.
    repulsion : tuple of float
        a_w of each species in kT / r_c.
    gamma : float
        Friction of beads with the walls.
    velocity : tuple
        Of the lower and of the upper wall, each with a component per axis, in r_c / tau.
    reach : float
        How far behind a plane there is room for a bead, in r_c: a whole number.
    """

    axes: tuple[int, ...]
    repulsion: tuple[float, ...]
    gamma: float
    velocity: tuple[tuple[float, ...], ...]
    reach: float


def walls_of(scene: Scene) -> Walls | None:
    """The walls of a scene; None if it has none.

    Raises
    ------
    UserError
        If they cannot be, see `check_walls` for the rest.
    """
    asked = scene.data.get("walls")
    if asked is None:
        return None
    names = asked["axis"] if isinstance(asked["axis"], list) else [asked["axis"]]
    axes = tuple(sorted(axis_number(scene, "walls.axis", name) for name in names))
    repulsion = per_species(scene, "walls.repulsion", asked["repulsion"])
    at_rest = [[0.0] * scene.dimension] * 2
    velocity = tuple(tuple(map(float, each)) for each in asked.get("velocity", at_rest))
    reach = _reach(scene, min(repulsion))
    return Walls(axes, repulsion, float(asked["gamma"]), velocity, reach)


def period_of(scene: Scene) -> tuple[float, ...]:
    """Edges of the periodic box in which the beads of a scene move.

    Those of the scene; where there are walls, longer by the gaps behind both planes.
    """
    return tuple(edge + 2 * low for edge, low in zip(scene.box, origin_of(scene)))


def origin_of(scene: Scene) -> tuple[float, ...]:
    """Where the box of a scene begins in the periodic one: 0, or the place of the lower plane."""
    walls = walls_of(scene)
    if walls is None:
        return (0.0,) * scene.dimension
    # In a step a bead moves by 1 r_c at most. None can pass the middle of both gaps before it is
    # noticed, and beads within reach of opposite planes are 2 r_c or more apart.
    gap = walls.reach + 1.0
    return tuple(gap if axis in walls.axes else 0.0 for axis in range(scene.dimension))


def axis_number(scene: Scene, key: str, name: str) -> int:
    """The number of an axis by its name.

    Raises
    ------
    UserError
        If the scene has no such axis.
    """
    number = AXES.index(name)
    if number >= scene.dimension:
        allowed = ", ".join(AXES[: scene.dimension])
        raise UserError(
            f"{scene.where}: {key}: {name!r} is no axis in {scene.dimension} dimensions; allowed: "
            f"{allowed}"
        )
    return number


def per_species(scene: Scene, key: str, given: float | dict[str, float]) -> tuple[float, ...]:
    """A value for each species, from one for all or from a table.

    Raises
    ------
    UserError
        If the table lacks a species, or has one that no molecule has.
    """
    if not isinstance(given, dict):
        return (float(given),) * len(scene.species)
    for name in given:
        if name not in scene.species:
            raise UserError(f"{scene.where}: {key}.{name}: {no_species(scene, name)}")
    for name in scene.species:
        if name not in given:
            raise UserError(
                f"{scene.where}: {key}: no value for the species {name!r}; it needs one for each "
                f"of {', '.join(scene.species)}, or one number for all"
            )
    return tuple(float(given[name]) for name in scene.species)


def _reach(scene, softest):
    """How far behind a plane of that repulsion a bead may get, up to a chance that is `RARE`."""
    strongest = max(scene.data["repulsion"].values())
    pushed = ENERGY_OF_FLUID[scene.dimension] * scene.density * strongest
    most = RARE * scene.data["thermostat"]["kT"] + pushed
    least = 2 * most / (DEEPEST + RANGE) ** 2
    if softest < least:
        raise UserError(
            f"{scene.where}: walls.repulsion: {softest:g} is too soft: beads would get more than "
            f"{DEEPEST} r_c behind the planes; allowed: >= {least:.3g} for this fluid"
        )
    return float(max(1, math.ceil(math.sqrt(2 * most / softest) - RANGE)))


def check_walls(scene: Scene, refuse: Callable[[str, str], object]) -> None:
    """Refuse walls that cannot be, and what cannot be beside walls.

    Parameters
    ----------
    scene : Scene
    refuse : callable
        Called with a key and a problem; raises.
    """
    walls = walls_of(scene)
    if walls is None:
        return
    for axis in walls.axes:
        if scene.box[axis] < 2 * RANGE:
            refuse(
                "walls.axis",
                f"the box has an edge of {scene.box[axis]:g} along {AXES[axis]}, and a bead would "
                f"feel both walls at the same time; allowed: >= {2 * RANGE:g}",
            )
    scheme = scene.data["integrator"]["scheme"]
    if walls.gamma and scheme_named(scheme).exchange is not None:
        refuse(
            "walls.gamma",
            f"{scheme!r} splits friction off the forces, and the friction of walls is a force; "
            "take gw-vv or dpd-vv, or walls without gamma",
        )
    _check_velocity(scene, walls, refuse)


def _check_velocity(scene, walls, refuse):
    """Walls move along themselves, and take beads along by friction alone."""
    if "velocity" not in scene.data["walls"]:
        return
    if len(walls.axes) > 1:
        refuse("walls.velocity", "has no meaning for walls along several axes; keep one axis")
    for side, velocity in zip(("lower", "upper"), walls.velocity):
        if len(velocity) != scene.dimension:
            refuse(
                "walls.velocity",
                f"{len(velocity)} components for the {side} wall; allowed: {scene.dimension}, one "
                "per axis",
            )
        if velocity[walls.axes[0]]:
            refuse(
                "walls.velocity",
                f"the {side} wall would move along its own normal {AXES[walls.axes[0]]}; allowed "
                "there: 0",
            )
    if not walls.gamma:
        refuse("walls.velocity", "has no effect on walls without friction; add walls.gamma")
