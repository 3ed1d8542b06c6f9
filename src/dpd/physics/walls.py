"""Soft walls: planes that push beads away, and the friction of beads with them.

A bead at the distance z < 1 from a plane feels the pair force of Groot and Warren 1997 (Eq. 3),
with the plane in the place of the other bead:

    u(z)   =  a_w (1 - z)^2 / 2        energy
    F(z)   =  a_w (1 - z)              force along the normal into the box, -u'
    u''(z) =  a_w                      curvature

Behind the plane, at z < 0, the same line goes on. A wall with friction also takes hold of the
velocity v of a bead, in all directions, with w = 1 - z (and w = 1 behind the plane):

    F = -gamma w^2 (v - v_wall) + sigma w zeta dt^(-1/2),     sigma^2 = 2 gamma kT
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from dpd.page import Axis, Change, OneOrMore, PerSpecies, Positive, Refusals, Term, setting
from dpd.physics.thermostat import Friction

RANGE = 1.0  # of a wall's force in r_c
# kT of chance, beside what neighbours push with, that a bead behind a plane may have in energy:
# more has a chance below 1e-13.
RARE = 30.0
# Energy of a bead among neighbours without order, for density and repulsion of 1: the integral of
# (1 - r)^2 / 2.
ENERGY_OF_FLUID = {2: math.pi / 12, 3: math.pi / 15}
DEEPEST = 10  # r_c behind a plane for which room is made
Velocity = Annotated[
    list[Annotated[float, Field(ge=-1000, le=1000)]], Field(min_length=2, max_length=3)
]


class SoftWalls(Term, key="walls"):
    """Soft planes at both ends of one or more axes, which then do not repeat.

    The box along such an axis is the distance of the planes. A bead at a distance z < 1 r_c from a
    plane is pushed away with the force repulsion times (1 - z), also behind the plane, where z < 0.
    """

    caption = "walls along {axis}, a_w = {repulsion} kT/r_c[, friction gamma = {gamma}]"
    in_start = True
    mainly = Change.ENDS
    not_in_lammps = "are soft behind their planes and rub on beads, which no walls of LAMMPS are"
    untried = "schemes were measured in the bulk at rest; with walls take gw-vv"
    cannot = {
        Change.SLIDES: "stand still, and the fluid would flow through or past them",
        Change.STRETCHES: "stand where they are",
    }
    axis: OneOrMore[Axis] = setting(
        "The axis that the planes are normal to, or a list of axes.", of="axis"
    )
    repulsion: PerSpecies[Positive] = setting(
        "Force a_w at the plane, one number or one per species, as {A: 25, B: 40}.",
        unit="kT / r_c", of="species",
    )  # fmt: skip
    gamma: float = setting(
        "Friction of beads with the walls, with the noise that belongs to it; 0 for smooth walls, "
        "along which beads slip.", 0.0, ge=0, le=1e6,
    )  # fmt: skip
    velocity: Annotated[list[Velocity], Field(min_length=2, max_length=2)] | None = setting(
        "Velocities of the lower and of the upper wall, as [[-1, 0, 0], [1, 0, 0]]; needs a gamma, "
        "and one axis alone. Walls are at rest if not given.", None, unit="r_c / tau",
    )  # fmt: skip

    def axes(self) -> tuple[int, ...]:
        names = self.axis if isinstance(self.axis, list) else [self.axis]
        return tuple(sorted("xyz".index(name) for name in names))

    def conflicts(self) -> Refusals:
        axes, velocities = self.axes(), self.velocity or []
        if len(set(axes)) < len(axes):
            yield "axis", f"{self.axis} should name each axis once"
        if velocities and len(axes) > 1:
            yield "velocity", "has no meaning for walls along several axes; keep one axis"
        elif any(velocity[axes[0]] for velocity in velocities if axes[0] < len(velocity)):
            yield "velocity", f"a wall would move along its normal {self.axis}; allowed there: 0"
        if velocities and not self.gamma:
            yield "velocity", "has no effect on walls without friction; add walls.gamma"

    def refuses(self, scene: Any) -> Refusals:
        for velocity in self.velocity or ():
            if len(velocity) != scene.dimension:
                text = f"{len(velocity)} components for a wall; allowed: {scene.dimension}"
                yield "velocity", f"{text}, one per axis"

    def reach(self, scene: Any) -> float:
        """How far behind a plane there is room for a bead, in r_c: a whole number."""
        strongest = max(0.0, *scene.repulsions.values())
        pushed = ENERGY_OF_FLUID[scene.dimension] * scene.density * strongest
        most = float(RARE * scene.kT + pushed)  # energy of a bead at a wall
        deep = math.sqrt(2 * most / min(scene.by_species(self.repulsion))) - RANGE
        return float(max(1, math.ceil(min(deep, DEEPEST))))

    def changes(self, scene: Any) -> frozenset[Change]:
        moves = any(map(any, self.velocity or ()))
        return frozenset({Change.ENDS, Change.FLOWS} if moves else {Change.ENDS})

    def gap(self, scene: Any, axis: int) -> float:
        """With a cutoff: beads behind opposite planes never feel each other."""
        return self.reach(scene) + 1.0 if axis in self.axes() else 0.0

    def across(self, scene: Any) -> tuple[int, ...]:
        return self.axes()

    def brakes(self, scene: Any) -> bool:
        return self.gamma > 0

    def records(self, scene: Any) -> dict[str, Any]:
        axes = list(self.axes())
        low = np.array(scene.origin)
        at_rest = [[0.0] * scene.dimension] * 2
        walls = Walls(
            repulsion=np.array(scene.by_species(self.repulsion)),
            axis=np.repeat(np.array(axes, np.int64), 2),
            place=np.stack([low, low + scene.box], axis=1)[axes].ravel(),
            inward=np.tile([1.0, -1.0], len(axes)),
            velocity=np.tile(np.array(self.velocity or at_rest), (len(axes), 1)),
            reach=self.reach(scene),
        )
        return {"walls": walls, "wall_friction": float(self.gamma)}


class Walls(NamedTuple):
    """Planes at both ends of some axes: of each axis the lower one, then the upper one."""

    repulsion: np.ndarray  # (species,): a_w in kT / r_c
    axis: np.ndarray  # (walls,) int64: the axis that each plane is normal to
    place: np.ndarray  # (walls,): where the plane is on that axis, in r_c
    inward: np.ndarray  # (walls,): 1.0 for a lower plane; -1.0 for an upper one
    velocity: np.ndarray  # (walls, dimension): of the wall, in r_c / tau
    reach: float  # how far behind a plane a bead may get, in r_c
    friction: Friction | None = None

    def force(self, a: float, z: float) -> float:
        """Force F at the distance z, for a bead with the repulsion a."""
        return a * max(0.0, 1.0 - z)

    def energy(self, a: float, z: float) -> float:
        return 0.5 * a * max(0.0, 1.0 - z) ** 2

    def curvature(self, a: float, z: float) -> float:
        return a if z < 1.0 else 0.0

    def weight(self, z: float) -> float:
        return min(1.0, max(0.0, 1.0 - z))
