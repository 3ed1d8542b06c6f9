from dataclasses import replace
from typing import Any

from dpd.page import Change, Observable


class Configurational(Observable, key="configurational"):
    """Squared conservative forces and the Laplacian of the potential, in blocks of the run.

    Their ratio, of means, is kT in equilibrium and does not look at velocities: it shows an
    integrator's error where the kinetic temperature is right by construction. A sample takes as
    long as 2 to 3 steps.
    """

    stands = frozenset(Change)
    interval, cost = 2.0, 4.5
    cannot = {
        Change.SLIDES: "is a temperature in equilibrium only",
        Change.FLOWS: "is a temperature in equilibrium only",
        Change.JUMPS: "needs a force without the jump of a core",
    }
    gives = {
        "force_square": (("block",), "(kT / r_c)^2", "squared conservative force per bead"),
        "curvature": (("block",), "kT / r_c^2", "Laplacian of the potential per bead"),
    }

    def measure(self, now: Any) -> Any:
        from dpd.engine.stress import force_and_curvature

        square, curvature = force_and_curvature(replace(now.system, box=now.lattice), now.state)
        return {"force_square": square / now.beads, "curvature": curvature / now.beads}
