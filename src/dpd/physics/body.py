"""Body forces: a constant force on every bead, as of gravity or of a gradient of pressure.

It drives a flow along its axis. In the half of the box beyond a middle plane it may act the other
way round: then two flows go in opposite directions, no net momentum arises, and no walls are
needed (Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys. 122, 154503 (2005)).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class BodyForce(NamedTuple):
    """A constant force on every bead.

    Attributes
    ----------
    strength : (species,) array
        In kT / r_c.
    axis : int
        That it acts along.
    across : int
        The axis on which the position decides about its direction.
    middle : float
        Where on that axis it turns round, in r_c; infinite if it acts in one direction.
    """

    strength: np.ndarray
    axis: int
    across: int
    middle: float

    def force(self, strength: float, x: float) -> float:
        """Force on a bead at the place x on the axis across."""
        return strength if x < self.middle else -strength
