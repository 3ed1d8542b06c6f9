"""Laws of bonds beside the harmonic one: pages of the package, and of a user's own."""

import numpy as np
import pytest

from dpd.engine.simulation import Simulation
from dpd.scene.scene import Scene
from dpd.start import start_description, start_digest
from dpd.start.common.make import make_start, system_of
from tests import test_own_forces
from tests.conftest import documented, folder_with
from tests.test_bad_input import refusal

QUARTIC = '''"""Bonds with a term of fourth order."""

from dpd.page import BondForce, NotNegative, PerPair, part, setting


@part
def beyond(r, length):
    return r - length


class Quartic(BondForce, key="quartic"):
    """Bonds that get stiffer as they get longer, or shorter."""

    stiffness: PerPair[NotNegative] = setting("Of small changes.", unit="kT / r_c^2")
    fourth: float = setting("Of large ones.", 0.0, unit="kT / r_c^4", ge=0)
    length: float = setting("Rest length.", 0.5, unit="r_c", gt=0)

    def energy(self, r):
        x = beyond(r, self.length)
        return 0.5 * self.stiffness * x * x + 0.25 * self.fourth * x**4

    def force(self, r):
        x = beyond(r, self.length)
        return -self.stiffness * x - self.fourth * x**3
'''
PLAIN = test_own_forces.PLAIN | {
    "molecules": [{"architecture": "A 2 B 2", "count": 30}, {"architecture": "B", "count": 60}],
    "integrator": {"scheme": "gw-vv", "dt": 0.01},
}
BOND = {"bond": {"stiffness": 50}}
STIFF = {"A A": 50, "B A": 30, "B B": 80}
OWN = PLAIN | {"pages": ["quartic.py"], "quartic": {"stiffness": STIFF, "fourth": 90}}
RELAX = {"relax": {"steps": 5, "dt": 0.005}}
FENE = {"stiffness": {"A A": 30, "A B": 20, "B B": 40}, "length": 1.5}


folder = folder_with({"quartic.py": QUARTIC})


def quartic(r, stiffness):
    """Energy and force."""
    x = r - 0.5
    return stiffness * x**2 / 2 + 90 * x**4 / 4, -stiffness * x - 90 * x**3


def fene(r, stiffness):
    """Energy and force; a table by pairs that has other numbers than `STIFF`."""
    k = {50: 30, 30: 20, 80: 40}
    stiffness = np.array([k[int(c)] for c in stiffness])
    square = (r / 1.5) ** 2
    return -stiffness * 2.25 / 2 * np.log(1 - square), -stiffness * r / (1 - square)


LAWS = {"quartic": (OWN, quartic), "fene": (PLAIN | {"fene": FENE}, fene)}


@pytest.mark.parametrize("name", LAWS)
def test_forces_energy_and_pressure_are_those_of_the_formulas(folder, name):
    """Added up by NumPy, bond by bond; of tables each has its own numbers."""
    data, law = LAWS[name]
    quiet = {"repulsion": dict.fromkeys(PLAIN["repulsion"], 0), "thermostat": {"gamma": 0}}
    scene = Scene(data | quiet)
    simulation = Simulation(system_of(scene), make_start(scene))
    state = simulation.state
    i, j = scene.bonded.T
    position = state.by_identity(state.position)
    apart = position[:, i] - position[:, j]
    apart -= 4 * np.round(apart / 4)
    r = np.sqrt((apart**2).sum(axis=0))
    names = np.array(scene.species)[scene.kinds]
    pairs = [" ".join(sorted(pair)) for pair in zip(names[i], names[j])]
    stiffness = np.array([STIFF.get(pair, STIFF["B A"]) for pair in pairs], float)
    energy, push = law(r, stiffness)
    force = np.zeros_like(position)
    for k in range(3):
        np.add.at(force[k], i, push / r * apart[k])
        np.subtract.at(force[k], j, push / r * apart[k])
    np.testing.assert_allclose(state.by_identity(state.force), force, rtol=1e-9, atol=1e-9)
    sums = simulation.measure().of(-1)
    assert float(np.ravel(sums.energy)[1]) == pytest.approx(energy.sum(), rel=1e-10)
    assert np.trace(sums.virial[0]) == pytest.approx((push * r).sum(), rel=1e-10)


WRONG = [
    (OWN | BOND, "quartic: the scene has 'bond' as well; keep one law of bonds"),
    (PLAIN, "molecules: those of several beads need a law of bonds, one of bond, fene, morse_bond"),
    (PLAIN | {"fene": FENE, "start": RELAX | {"forces": BOND}},
     "start.forces: unknown key 'bond'; allowed: core, fene, gamma"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "said"), WRONG, ids=range(len(WRONG)))
def test_what_does_not_fit_is_refused(folder, data, said):
    """With key, value and what is allowed."""
    assert said in refusal(Scene, data)


def test_a_start_may_have_another_law():
    """Under the page's key; it decides the start."""
    scene = Scene(PLAIN | {"fene": FENE, "start": RELAX})
    softer = Scene(PLAIN | {"fene": FENE, "start": RELAX | {"forces": {"fene": {"stiffness": 9}}}})
    assert start_digest(scene) != start_digest(softer)
    law = softer.start_terms["fene"]
    assert (law.stiffness, law.length) == (9, 1.5)
    assert scene.start_terms["fene"] is scene.bond_force


def test_the_page_of_the_documentation(folder):
    """As it stands there, its force is the slope of its energy."""
    (folder / "quartic.py").write_text(documented("## Bonds of your own"))
    scene = Scene(OWN | {"quartic": {"strength": {"A A": 100, "A B": 50, "B B": 80}}})
    assert start_description(scene)["flight"]["A B"] == 0.5
