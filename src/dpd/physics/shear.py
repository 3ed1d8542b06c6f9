"""Steady shear: a flow along one axis that grows linearly along another.

With the rate g, x along the flow and y along its gradient, the fluid streams with

    U(y) = g y   along x

A velocity v is kept as that about the flow, u = v - U(y). Two beads apart by r_ij then approach
each other with (the first factor of friction, Groot and Warren 1997, Eq. 4)

    r_ij . v_ij  =  r_ij . u_ij + g x_ij y_ij

and without forces beads move with v constant (Lees and Edwards 1972; Evans and Morriss 1984):

    dx/dt = u_x + g y,     du_x/dt = -g u_y
"""

from math import hypot
from typing import Any, Literal, NamedTuple

from dpd.page import Change, Refusals, Term, setting


class SteadyShear(Term, key="shear"):
    """Steady shear by Lees-Edwards boundary conditions.

    The fluid flows along one axis with a speed of rate times the place on another. Velocities are
    kept about this flow.
    """

    caption = "shear at a rate of {rate} / tau along {flow}, across {gradient}"
    mainly = Change.SLIDES
    makes = frozenset({Change.SLIDES})
    not_in_lammps = "is steady between images that slide; LAMMPS deforms a box instead"
    untried = "steps are tried at rest, which says nothing of shear; take gw-vv and dt 0.04"
    cannot = {
        Change.STRETCHES: "takes the box to keep its size, for which alone it is known how far "
        "images have slid"
    }
    rate: float = setting(
        "Shear rate, positive or negative. With 0 the fluid rests, and images stay as far slid as "
        "they are: as a file has them, or after a shear that a schedule ends.",
        unit="1 / tau", ge=-1000, le=1000,
    )  # fmt: skip
    flow: Literal["x", "y"] = setting("Axis along which the fluid flows.", "x", of="axis")
    gradient: Literal["y", "z"] = setting(
        "Axis along which its speed grows, after the other in x, y, z.", "y", of="axis"
    )

    def axes(self) -> tuple[int, int]:
        return "xyz".index(self.flow), "xyz".index(self.gradient)

    def across(self, scene: Any) -> tuple[int, ...]:
        return ("xyz".index(self.gradient),)

    def conflicts(self) -> Refusals:
        """Files could not hold the tilted box of axes in another order."""
        if self.flow >= self.gradient:
            text = f"{self.gradient!r} is the axis of the flow itself; allowed: an axis after it"
            yield "gradient", text

    def may_become(self, other: Any) -> bool:
        return self.axes() == other.axes()

    def refuses(self, scene: Any) -> Refusals:
        flow, gradient = self.axes()
        dt, height = scene.dt, scene.box[gradient]
        most = 1 / (dt * height)
        if abs(self.rate) > most:
            text = f"{self.rate:g} moves images by more than a cutoff in a step; allowed at dt "
            text += f"{dt:g} in a box of {height:g} along {self.gradient}: "
            yield "rate", f"{text}-{most:.4g} to {most:.4g}"
        if self.room(scene)[flow] < 2:
            least = 2 / (1 - 1 / height**2) ** 0.5
            text = f"the box has an edge of {scene.box[flow]:g} along the flow, where images slide "
            text += "and a bead could meet another one twice; allowed with "
            yield "", f"{text}{height:g} along {self.gradient}: >= {least:.4g}"
        if scene.data["pairs"]["search"] == "list":
            yield "", "no 'pairs.search: list' would last; take cells, or remove the key"

    def room(self, scene: Any) -> tuple[float, ...]:
        """Edges of the box; less along the flow, where images slide by up to half an edge."""
        flow, gradient = self.axes()
        edges = list(scene.box)
        edges[flow] /= hypot(1.0, 0.5 * edges[flow] / edges[gradient])
        return tuple(edges)

    def records(self, scene: Any) -> dict[str, Any]:
        return {"shear": Shear(self.rate, *self.axes())}


class Shear(NamedTuple):
    rate: float  # g in 1 / tau
    flow: int  # axis along which the fluid flows
    gradient: int  # axis along which its speed grows
