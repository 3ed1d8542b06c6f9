"""Body forces: a constant force on every bead, as of gravity or of a gradient of pressure.

With ``opposite`` it acts the other way round in half of the box: two opposite flows, which need no
walls (Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys. 122, 154503 (2005)).
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from dpd.page import Axis, Change, PerSpecies, Refusals, Term, setting

BALANCED = 1e-9  # share of all forces that their sum may be, by rounding


class DrivingForce(Term, key="body_force"):
    """A constant force on every bead, which drives a flow."""

    caption = "body force of {strength} kT/r_c along {axis}[, turned round across {opposite}]"
    mainly = Change.FLOWS
    untried = "schemes were measured in the bulk at rest; with a body force take gw-vv"
    axis: Axis = setting("The axis that it acts along.", of="axis")
    strength: PerSpecies[Annotated[float, Field(ge=-1000, le=1000)]] = setting(
        "Force on each bead, one number or one per species, as {A: 0.02, B: 0}.",
        unit="kT / r_c", of="species",
    )  # fmt: skip
    opposite: Axis | None = setting(
        "The axis in whose upper half the force acts in the opposite direction: two opposite flows "
        "in a periodic box.", None, of="axis",
    )  # fmt: skip

    def conflicts(self) -> Refusals:
        if self.opposite == self.axis:
            yield "opposite", f"{self.axis} is the axis that the force acts along; take another one"

    def refuses(self, scene: Any) -> Refusals:
        if self.opposite and "xyz".index(self.opposite) in scene.ended:
            yield "opposite", f"there are walls along {self.opposite}; remove the key"
        strengths = np.array(scene.by_species(self.strength))
        forces = np.bincount(scene.kinds, minlength=len(scene.species)) * strengths
        adds_up = abs(forces.sum()) > BALANCED * abs(forces).sum()
        is_held = "xyz".index(self.axis) in scene.ended
        if adds_up and not (self.opposite or is_held or scene.brakes):
            text = f"along {self.axis} nothing brakes the beads; give walls with a gamma, or "
            yield "", f"{text}'opposite', or strengths of which the sum over all beads is 0"
        if Change.FLOWS in self.changes(scene) and not scene.takes_heat:
            text = "nothing takes up the heat of the flow; allowed: thermostat.gamma > 0, or walls "
            yield "", f"{text}with a gamma"

    def changes(self, scene: Any) -> frozenset[Change]:
        drives = any(scene.by_species(self.strength))
        flows = self.opposite is not None or "xyz".index(self.axis) not in scene.ended
        return frozenset({Change.FLOWS} if drives and flows else ())

    def across(self, scene: Any) -> tuple[int, ...]:
        return ("xyz".index(self.opposite),) if self.opposite else ()

    def lammps(self, scene: Any) -> list[str] | str:
        turned = ""
        if self.opposite:
            edge, x = scene.box["xyz".index(self.opposite)], self.opposite
            turned = f"*(1-2*({x}-{edge}*floor({x}/{edge})>={edge / 2}))"
        of_type = [f"(type=={n})*{f}" for n, f in enumerate(scene.by_species(self.strength), 1)]
        along = " ".join("v_push" if axis == self.axis else "0.0" for axis in "xyz")
        push = f'variable push atom "({"+".join(of_type)}){turned}"'
        return [push, f"fix push all addforce {along}"]

    def records(self, scene: Any) -> dict[str, Any]:
        axis, across = "xyz".index(self.axis), "xyz".index(self.opposite or self.axis)
        middle = 0.5 * scene.box[across] if self.opposite else math.inf
        strength = np.array(scene.by_species(self.strength))
        return {"body_force": BodyForce(strength, axis, across, float(middle))}


class BodyForce(NamedTuple):
    strength: np.ndarray  # (species,): in kT / r_c
    axis: int  # that it acts along
    across: int  # the axis on which the position decides about its direction
    middle: float  # where on that axis it turns round, in r_c; infinite if it acts in one direction

    def force(self, strength: float, x: float) -> float:
        """On a bead at the place x on the axis across."""
        return strength if x < self.middle else -strength
