"""What is measured while a system runs: one file an observable.

An observable has ``every`` (steps between its samples), ``needs_forces``,
``sample(simulation, sums)``, ``arrays`` (all that it keeps, so that a checkpoint can hold
it) and ``variables()`` (name to (dimensions, array, units, long_name) for the file).
"""

from dpd.observe.bonds import Bonds
from dpd.observe.chains import Chains
from dpd.observe.configuration import Configuration
from dpd.observe.crossings import Crossings
from dpd.observe.displacement import Displacement
from dpd.observe.profile import Profile
from dpd.observe.rdf import RadialDistribution
from dpd.observe.thermo import Thermo

OBSERVABLES = {
    "thermo": Thermo,
    "rdf": RadialDistribution,
    "profile": Profile,
    "bonds": Bonds,
    "chains": Chains,
    "displacement": Displacement,
    "crossings": Crossings,
    "configuration": Configuration,
}


def observables(scene, system):
    """The observables that a scene asks for.

    Parameters
    ----------
    scene : Scene
    system : System

    Returns
    -------
    list
    """
    return [OBSERVABLES[name](scene, system, **s) for name, s in scene.observe.items()]
