"""Each page of the physics is consistent, and a new one is one page."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest

from dpd.digest import ROOT
from dpd.physics.bond import BondLaw
from dpd.physics.common.forces import bond_record, curvature_of_bond
from dpd.physics.core import Core
from dpd.physics.fene import Fene
from dpd.physics.morse_bond import MorseBonds
from dpd.physics.repulsion import Soft

NUDGE = 1e-5
TABLE = np.array([[25.0]])
PAIRS = {
    "soft": Soft(TABLE),
    "core": Core(TABLE, 0.3, 100.0),
    "smooth core": Core(TABLE, 0.3, 100.0, 0.1),
}
# Away from the places where a force jumps or bends.
DISTANCES = [0.05, 0.2, 0.35, 0.55, 0.9, 1.1]


def at(method, r):
    """A method of a pair's page at some distance, for a 25."""
    return method(25.0, r, max(0.0, 1.0 - r))


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("r", DISTANCES)
def test_the_force_of_a_pair_is_the_slope_of_its_energy(name, r):
    page = PAIRS[name]
    slope = (at(page.energy, r + NUDGE) - at(page.energy, r - NUDGE)) / (2 * NUDGE)
    assert at(page.force, r) == pytest.approx(-slope, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("r", DISTANCES[:-1])
def test_the_curvature_of_the_soft_repulsion_is_the_slope_of_its_force(r):
    page = PAIRS["soft"]
    slope = (at(page.force, r + NUDGE) - at(page.force, r - NUDGE)) / (2 * NUDGE)
    assert at(page.curvature, r) == pytest.approx(-slope, rel=1e-6)


BONDS = {
    "harmonic": BondLaw(stiffness=60, length=0.7),
    "fene": Fene(stiffness=30, length=1.3),
    "beyond": Fene(stiffness=30, length=0.04),
    "morse": MorseBonds(depth=20, alpha=4, length=0.6),
}


@pytest.mark.parametrize("name", BONDS)
@pytest.mark.parametrize("r", DISTANCES)
def test_force_and_curvature_of_a_bond_are_slopes(name, r):
    """Of the page, and of the record that kernels get."""
    page, record = BONDS[name], bond_record([BONDS[name]], None)
    slope = (page.energy(r + NUDGE) - page.energy(r - NUDGE)) / (2 * NUDGE)
    assert page.force(r) == pytest.approx(-slope, rel=1e-6)
    assert r * record.force_over_r(r) == pytest.approx(page.force(r), rel=1e-12)
    if name != "beyond":  # where the force is the same all over
        slope = (page.force(r + NUDGE) - page.force(r - NUDGE)) / (2 * NUDGE)
        assert record.curvature(r) == pytest.approx(-slope, rel=1e-6)
        assert curvature_of_bond(record, r) == pytest.approx(-slope, rel=1e-6)


OWN_PAGE = """
    from typing import NamedTuple
    import numpy as np

    class Steep(NamedTuple):  # u = a w^3 / 3
        repulsion: np.ndarray

        def force(self, a, r, w):
            return a * w * w

        def energy(self, a, r, w):
            return a * w * w * w / 3

        def curvature(self, a, r, w):
            return 2 * a * w
"""
USES_IT = """
    import numpy as np
    from dpd.engine.queries.stress import force_and_curvature
    from own_page import Steep
    from tests.systems import by_identity, make_simulation, make_system, random_beads

    box = (4.0, 4.5, 5.0)
    position, velocity = random_beads(box, 200)
    system = make_system(box, pair=Steep(np.array([[25.0]])), friction=0.0)
    simulation = make_simulation(system, position, velocity)
    i, j = np.triu_indices(200, 1)
    apart = position[:, i] - position[:, j]
    edges = np.array(box)[:, None]
    apart -= edges * np.round(apart / edges)
    r = np.sqrt((apart**2).sum(axis=0))
    w = np.maximum(0, 1 - r)
    force = np.zeros_like(position)
    for k in range(3):
        np.add.at(force[k], i, 25 * w**2 / r * apart[k])
        np.add.at(force[k], j, -25 * w**2 / r * apart[k])
    np.testing.assert_allclose(by_identity(simulation, "force"), force, atol=1e-11)
    sums = simulation.measure()
    np.testing.assert_allclose(sums.energy[0], (25 * w**3 / 3).sum())
    np.testing.assert_allclose(np.trace(sums.virial[0]), (25 * w**2 * r).sum())
    near = w > 0
    laplacian = 2 * (50 * w - 2 * 25 * w**2 / r)[near].sum()
    found = force_and_curvature(system, simulation.state)
    np.testing.assert_allclose(found, [(force**2).sum(), laplacian])
"""


@pytest.mark.thorough
def test_a_new_pair_force_is_one_page(tmp_path):
    """Force, virial, energy and curvature come from it, and nothing else has to know of it."""
    (tmp_path / "own_page.py").write_text(textwrap.dedent(OWN_PAGE))
    (tmp_path / "uses_it.py").write_text(textwrap.dedent(USES_IT))
    # Kernels of its own: other processes could not read the name of this class from the cache.
    places = {
        "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
        "PYTHONPATH": f"{ROOT / 'src'}:{ROOT}:{tmp_path}",
    }
    done = subprocess.run(
        [sys.executable, "uses_it.py"], cwd=tmp_path, env=os.environ | places, check=False,
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
