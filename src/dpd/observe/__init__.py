"""What is measured while a system runs: one file an observable.

An observable has ``every`` (steps between its samples), ``sample(simulation)`` or ``record(sums)``
(see `dpd.engine.loop.run`), ``arrays`` (all that it keeps, so that a checkpoint can hold it) and
``variables()`` (name to (dimensions, array, units, long_name) for the file).

One that writes a file of its own (`dpd.scene.beside`) takes its path, and has ``file_bytes``, its
size, and ``file`` (None without a path). That goes on with what a former process has left
(``cut``), is whole up to each checkpoint (``flush``), and takes its place in the end (``finish``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from dpd.observe.bond_lengths import PairBondLengths
from dpd.observe.bonds import BondLengths
from dpd.observe.chains import Chains
from dpd.observe.configuration import Configuration
from dpd.observe.configurational import Configurational
from dpd.observe.crossings import Crossings
from dpd.observe.density_field import DensityField
from dpd.observe.diffusion import Diffusion
from dpd.observe.displacement import Displacement
from dpd.observe.end_points import EndPoints
from dpd.observe.end_to_end import EndToEnd
from dpd.observe.mixing import Mixing
from dpd.observe.pair_energies import PairEnergies
from dpd.observe.passes import Passes
from dpd.observe.profile import Profile
from dpd.observe.rdf import RadialDistribution
from dpd.observe.stress_profile import StressProfile
from dpd.observe.stretch import Stretch
from dpd.observe.structure_factor import StructureFactor
from dpd.observe.thermo import Thermo
from dpd.observe.trace import Trace
from dpd.observe.trajectory import Trajectory
from dpd.observe.velocity_profile import VelocityProfile
from dpd.observe.walls import WallForces
from dpd.scene.beside import files_beside

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from dpd.engine.state import System
    from dpd.scene.scene import Scene

    # Name to (dimensions, array, units, long_name).
    Variables = dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]

    class BondedSystem(System):
        """A system with bonds."""

        members: np.ndarray

    class Observable(Protocol):
        """What an observable has, as said above."""

        every: int
        arrays: dict[str, np.ndarray]

        def variables(self) -> Variables: ...


OBSERVABLES = {
    "thermo": Thermo,
    "walls": WallForces,
    "rdf": RadialDistribution,
    "profile": Profile,
    "density_field": DensityField,
    "structure_factor": StructureFactor,
    "mixing": Mixing,
    "pair_energies": PairEnergies,
    "velocity_profile": VelocityProfile,
    "stress_profile": StressProfile,
    "bonds": BondLengths,
    "bond_lengths": PairBondLengths,
    "chains": Chains,
    "displacement": Displacement,
    "diffusion": Diffusion,
    "crossings": Crossings,
    "passes": Passes,
    "end_to_end": EndToEnd,
    "end_points": EndPoints,
    "configuration": Configuration,
    "trace": Trace,
    "configurational": Configurational,
    "trajectory": Trajectory,
}


def observables(scene: Scene, system: System, path: str | Path | None = None) -> list[Observable]:
    """The observables that a scene asks for, and the watch over its bonds.

    Parameters
    ----------
    scene : Scene
    system : System
    path : path or None
        Of the result, beside which some write files of their own; without it they do not.

    Returns
    -------
    list of Observable
    """
    beside = {} if path is None else files_beside(scene, path)
    asked: list[Observable] = []
    for name, settings in scene.observe.items():
        own = {"path": beside[name]} if name in beside else {}
        asked.append(OBSERVABLES[name](scene, system, **settings, **own))
    # A checker does not know that a system with a law of bonds has bonds.
    return asked if system.bond is None else [*asked, Stretch(scene, system)]  # type: ignore[arg-type]
