"""A rigid core inside the soft repulsion.

With the diameter d = 2 r_s (Liu et al. 2008, Eq. 5):

    F(r)   =  F_max          r < d
           =  a_ij (1 - r)   d <= r < 1

With a width it goes over from F_max into the soft repulsion along a straight line from d to
d + width, so that schemes of second order keep their order.
"""

from typing import Any, NamedTuple

import numpy as np

from dpd.page import Change, NotNegative, Refusals, Term, part, setting


class RigidCore(Term, key="core"):
    """Rigid core; within twice the radius the force is constant (Liu et al. 2008, Eq. 5)."""

    caption = "rigid core r_s = {radius} r_c, F_max = {force} kT/r_c[, its edge {smooth} r_c wide]"
    in_start = True
    own_in_start = True
    not_in_lammps = ""
    untried = "a rigid core sets the step by its jump; take gw-vv and a dt of 0.002 or less"
    radius: float = setting("Core radius r_s; 0 for none.", unit="r_c", ge=0, lt=0.5)
    force: NotNegative = setting("Force F_max.", unit="kT / r_c")
    smooth: float = setting(
        "Width beyond twice the radius within which the force goes over into the soft repulsion; "
        "0 for a jump, as published.", 0.0, unit="r_c", ge=0, le=1,
    )  # fmt: skip

    def conflicts(self) -> Refusals:
        room = 1 - 2 * self.radius
        if self.smooth > room:
            yield "smooth", f"{self.smooth:g} goes past the cutoff; allowed: <= {room:g}"

    def changes(self, scene: Any) -> frozenset[Change]:
        return frozenset({Change.JUMPS} if self.radius else ())

    def records(self, scene: Any) -> dict[str, Any]:
        core = Core(scene.repulsion, 2.0 * self.radius, float(self.force), self.smooth or None)
        return {"pair": core} if self.radius else {}


class Core(NamedTuple):
    repulsion: np.ndarray  # (species, species): a_ij in kT / r_c
    diameter: float  # 2 r_s in r_c
    push: float  # F_max in kT / r_c
    width: float | None = None  # of the straight line, in r_c; None for a jump

    def force(self, a: float, r: float, w: float) -> float:
        """Force F at distance r, for a pair with the repulsion a; w = max(0, 1 - r)."""
        return self.push if r < self.diameter else force_beyond(self, a, r, w, self.width)

    def energy(self, a: float, r: float, w: float) -> float:
        """Energy u, continuous at the core and zero from the cutoff on."""
        if r < self.diameter:
            edge = energy_beyond(self, a, self.diameter, 1.0 - self.diameter, self.width)
            return self.push * (self.diameter - r) + edge
        return energy_beyond(self, a, r, w, self.width)

    def curvature(self, a: float, r: float, w: float) -> float:  # without the jump
        return a if self.diameter <= r < 1.0 else 0.0


@part
def force_beyond(core, a, r, w, width):
    if width is None:
        return a * w
    outer = a * (1.0 - core.diameter - width)
    slope = (outer - core.push) / width
    return core.push + slope * (r - core.diameter) if r < core.diameter + width else a * w


@part
def energy_beyond(core, a, r, w, width):
    if width is None:
        return 0.5 * a * w * w
    left = core.diameter + width - r
    if left <= 0.0:
        return 0.5 * a * w * w
    outer = a * (1.0 - core.diameter - width)
    here = force_beyond(core, a, r, w, width)
    return 0.5 * (here + outer) * left + 0.5 * a * (1.0 - core.diameter - width) ** 2
