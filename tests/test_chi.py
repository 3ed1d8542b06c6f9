"""chi in the place of a repulsion: closed form, scene, command."""

import numpy as np
import pytest

from dpd.scene.scene import Scene
from dpd.start import start_digest
from dpd.theory.repulsion import relation_at, unlike_repulsion
from tests.conftest import command
from tests.test_species_tables import PLAIN


@pytest.mark.parametrize(
    ("density", "length", "slope"), [(3, 1, 0.286), (5, 1, 0.689), (3, 2, 0.306), (3, 10, 0.306)]
)
def test_relations_as_printed(density, length, slope):
    """Groot and Warren 1997: chi = slope (a_AB - a_AA) / kT, Eqs. 24 and 27, at a = 75 kT / rho."""
    for chi, kT in ((3.5, 1.0), (5.0, 2.0)):
        found = unlike_repulsion(chi, density, length, kT)
        assert (found - 75 * kT / density) * slope / kT == pytest.approx(chi, rel=1e-12)
    assert relation_at(density * 1.015, length) == relation_at(density, length)


BLEND = PLAIN | {"repulsion": {"A A": 25, "B B": 25}, "chi": {"A B": 4}}
CHAINS = [{"architecture": "A 5", "density": 1.5}, {"architecture": "B 4 C 2", "density": 1.5}]
BOND = {"bond": {"stiffness": 2}}


def test_a_scene_with_chi_has_its_repulsion():
    """Single beads by Eq. 24, in either order of the names; said, and part of the digest."""
    for pair in ("A B", "B A"):
        scene = Scene(BLEND | {"chi": {pair: 4}})
        excess = 4 / 0.286
        np.testing.assert_allclose(scene.repulsion, [[25, 25 + excess], [25 + excess, 25]])
    assert "chi.B A: 4 makes a_ij 38.98" in scene.notes[0] and "Eq. 24" in scene.notes[0]
    assert "38.98" in repr(scene)
    plain = BLEND | {"repulsion": {"A A": 25, "B B": 25, "B A": float(scene.repulsion[0, 1])}}
    del plain["chi"]
    plain = Scene(plain)
    np.testing.assert_array_equal(plain.repulsion, scene.repulsion)
    assert plain.digest != scene.digest and start_digest(plain) == start_digest(scene)


def test_the_shortest_molecule_decides():
    """Chains with chains by Eq. 27; a solvent of single beads by Eq. 24."""
    three = {"A A": 25, "B B": 25, "C C": 25, "A C": 30, "B C": 30}
    scene = Scene(BLEND | BOND | {"molecules": CHAINS, "repulsion": three, "chi": {"A B": 0.7}})
    assert scene.repulsion[0, 1] == pytest.approx(25 + 0.7 / 0.306)
    water = [CHAINS[0], {"architecture": "W", "density": 1.5}]
    table = {"A A": 25, "W W": 25}
    scene = Scene(BLEND | BOND | {"molecules": water, "repulsion": table, "chi": {"A W": 4}})
    assert scene.repulsion[0, 1] == pytest.approx(25 + 4 / 0.286)


def test_the_command_answers_alone(tmp_path):
    """Both repulsions, chi N and the range; outside of it one message."""
    done = command("repulsion", "--chi", 4, "--density", 3, "--length", 10, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for phrase in ("25 kT / r_c", "38.0719", "chi N        40", "Eq. 27", "(chi N = 3) to 12.2"):
        assert phrase in done.stdout
    refused = command("repulsion", "--chi", 4, "--density", 3, "--length", 11, cwd=tmp_path)
    assert refused.returncode == 1 and "2 to 10 beads" in refused.stderr
