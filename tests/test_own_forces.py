"""Pair forces of a user's own: a file with an energy and its slope, beside the repulsion."""

import numpy as np
import pytest
import yaml

import dpd
from dpd.engine.simulation import Simulation
from dpd.files import read
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import command, documented, folder_with
from tests.test_bad_input import refusal
from tests.test_own_pages import SCENE

MORSE = '''"""A Morse attraction between beads, times w^2 so that it ends smoothly at the cutoff."""

from math import exp

from dpd.page import NotNegative, PairForce, PerPair, part, setting


@part
def decay(alpha, length, r):
    return exp(-alpha * (r - length))


class Morse(PairForce, key="morse"):
    """Morse attraction that ends at the cutoff."""

    depth: PerPair[NotNegative] = setting("Depth of the well.", unit="kT")
    alpha: float = setting("Steepness.", 4.0, unit="1 / r_c", gt=0, le=100)
    length: float = setting("Place of the well.", 0.6, unit="r_c", gt=0, le=1)

    def energy(self, r, w):
        e = decay(self.alpha, self.length, r)
        return self.depth * (e * e - 2.0 * e) * w * w

    def force(self, r, w):
        e = decay(self.alpha, self.length, r)
        well, slope = e * e - 2.0 * e, -2.0 * self.alpha * (e * e - e)
        return -self.depth * (slope * w * w - 2.0 * w * well)
'''
PLAIN = SCENE | {
    "repulsion": {"A A": 25, "A B": 30, "B B": 20},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 10, "sample": 40},
    "observe": [{"thermo": {"every": 10}}, {"configuration": {"every": 10}}],
}
DEPTH = {"A A": 1, "A B": 0, "B B": 3}
OWN = PLAIN | {"pages": ["morse.py"], "morse": {"depth": DEPTH}}


folder = folder_with({"morse.py": MORSE})


def by_hand(position, kinds, repulsion, depth, box, alpha=4.0, length=0.6):
    """Forces, and the energy of pairs, as plain NumPy adds them up."""
    apart = position[:, :, None] - position[:, None]
    apart -= box * np.round(apart / box)
    r = np.sqrt((apart**2).sum(axis=0)) + np.eye(position.shape[1]) * 9
    w = np.maximum(0, 1 - r)
    a, d = repulsion[kinds[:, None], kinds], depth[kinds[:, None], kinds]
    e = np.exp(-alpha * (r - length))
    energy = a * w**2 / 2 + d * (e * e - 2 * e) * w**2
    force = a * w - d * (-2 * alpha * (e * e - e) * w**2 - 2 * w * (e * e - 2 * e))
    return (force * apart / r).sum(axis=2), energy.sum() / 2


@pytest.mark.parametrize("depth", [DEPTH, 2.0], ids=["by pair", "one"])
def test_forces_and_energy_are_those_of_the_formulas(folder, depth):
    """Of every bead, to 1e-12; also where one number is for all pairs."""
    scene = Scene(OWN | {"morse": {"depth": depth}, "thermostat": {"gamma": 0}})
    simulation = Simulation(system_of(scene), make_start(scene))
    state = simulation.state
    table = np.array([[1, 0], [0, 3.0]]) if depth is DEPTH else np.full((2, 2), 2.0)
    force, energy = by_hand(
        state.by_identity(state.position), scene.kinds, scene.repulsion, table, 4.0
    )
    np.testing.assert_allclose(state.by_identity(state.force), force, rtol=1e-10, atol=1e-10)
    sums = simulation.measure().of(-1)
    assert float(np.ravel(sums.energy)[0]) == pytest.approx(energy, rel=1e-11)


def test_the_same_bits_for_threads_and_processes(folder):
    """Compiled here, read from the disk in a process of its own, shared by two threads."""
    first = dpd.run(OWN, progress=False)
    threads = dpd.run(OWN, threads=2, progress=False)
    assert first.position.values.tobytes() == threads.position.values.tobytes()
    (folder / "scene.yaml").write_text(yaml.safe_dump(OWN))
    done = command("run", "scene.yaml", "-o", "run.nc")
    assert done.returncode == 0, done.stderr
    assert read("run.nc")[0]["position"].tobytes() == first.position.values.tobytes()


def test_an_edited_force_is_the_new_one(folder):
    """In the process at hand: one that is twice as strong is that of settings twice as large."""
    first = dpd.run(OWN, progress=False)
    (folder / "morse.py").write_text(MORSE.replace("self.depth *", "2.0 * self.depth *"))
    second = dpd.run(OWN, progress=False)
    assert abs(second.position.values - first.position.values).max() > 1e-3
    doubled = {key: 2 * value for key, value in DEPTH.items()}
    (folder / "morse.py").write_text(MORSE)
    same = dpd.run(OWN | {"morse": {"depth": doubled}}, progress=False)
    np.testing.assert_allclose(same.position, second.position, atol=1e-9)


BAD = [
    (("e * e - 2.0 * e) * w * w", "e * e - 3.0 * e) * w * w"), "its force is not minus the slope"),
    (("self.alpha, self.length, r)\n        return", "self.alfa, self.length, r)\n        return"),
     "line 21: AttributeError: 'Morse' object has no attribute 'alfa'"),
    (("exp(-alpha", "exq(-alpha"), "line 10: NameError: name 'exq' is not defined"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "said"), BAD, ids=range(len(BAD)))
def test_what_is_wrong_is_told_before_anything_compiles(folder, change, said):
    """With the line, and where it is a slope, with both numbers."""
    (folder / "morse.py").write_text(MORSE.replace(*change))
    assert said in refusal(Scene, OWN)


def test_the_page_of_the_documentation(folder):
    """As it stands there, it draws beads together."""
    (folder / "attraction.py").write_text(documented("## A pair force of your own"))
    own = {"pages": ["attraction.py"], "attraction": {"depth": 2}}
    pulled, plain = dpd.run(PLAIN | own, progress=False), dpd.run(PLAIN, progress=False)
    assert float(pulled.pressure.mean()) < float(plain.pressure.mean()) - 2
