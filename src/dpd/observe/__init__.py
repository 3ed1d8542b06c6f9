"""What is measured while a system runs: one file an observable.

An observable has ``every`` (steps between its samples), ``needs_forces``,
``sample(simulation, sums)``, ``arrays`` (all that it keeps, so that a checkpoint can hold
it) and ``variables()`` (name to (dimensions, array, units, long_name) for the file).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from dpd.observe.bonds import BondLengths
from dpd.observe.chains import Chains
from dpd.observe.configuration import Configuration
from dpd.observe.configurational import Configurational
from dpd.observe.crossings import Crossings
from dpd.observe.displacement import Displacement
from dpd.observe.end_to_end import EndToEnd
from dpd.observe.passes import Passes
from dpd.observe.profile import Profile
from dpd.observe.rdf import RadialDistribution
from dpd.observe.stretch import Stretch
from dpd.observe.thermo import Thermo
from dpd.observe.trace import Trace

if TYPE_CHECKING:
    import numpy as np

    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.scene.scene import Scene

    # Name to (dimensions, array, units, long_name).
    Variables = dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]

    class BondedSystem(System):
        """A system with bonds."""

        members: np.ndarray

    class Observable(Protocol):
        """What an observable has, as said above."""

        every: int
        needs_forces: bool
        arrays: dict[str, np.ndarray]

        def sample(self, simulation: Simulation, sums: Sums) -> None: ...

        def variables(self) -> Variables: ...


OBSERVABLES = {
    "thermo": Thermo,
    "rdf": RadialDistribution,
    "profile": Profile,
    "bonds": BondLengths,
    "chains": Chains,
    "displacement": Displacement,
    "crossings": Crossings,
    "passes": Passes,
    "end_to_end": EndToEnd,
    "configuration": Configuration,
    "trace": Trace,
    "configurational": Configurational,
}


def observables(scene: Scene, system: System) -> list[Observable]:
    """The observables that a scene asks for, and the watch over its bonds.

    Parameters
    ----------
    scene : Scene
    system : System

    Returns
    -------
    list of Observable
    """
    asked = [OBSERVABLES[name](scene, system, **s) for name, s in scene.observe.items()]
    # A checker does not know that a system with a law of bonds has bonds.
    return asked if system.bond is None else [*asked, Stretch(scene, system)]  # type: ignore[arg-type]
