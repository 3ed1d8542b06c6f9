"""chi in the place of a repulsion: closed form, scene, command."""

import numpy as np
import pytest

from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.start import start_digest
from dpd.theory.repulsion import relation_at, unlike_repulsion
from tests.conftest import command


@pytest.mark.parametrize(
    ("density", "length", "slope"), [(3, 1, 0.286), (5, 1, 0.689), (3, 2, 0.306), (3, 10, 0.306)]
)
def test_relations_as_printed(density, length, slope):
    """Groot and Warren 1997: chi = slope (a_AB - a_AA) / kT, Eqs. 24 and 27, at a = 75 kT / rho."""
    for chi, kT in ((3.5, 1.0), (5.0, 2.0)):
        found = unlike_repulsion(chi, density, length, kT)
        assert (found - 75 * kT / density) * slope / kT == pytest.approx(chi, rel=1e-12)
    assert relation_at(density * 1.015, length) == relation_at(density, length)


BLEND = {
    "dimension": 3,
    "box": 8,
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25},
    "chi": {"A B": 4},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 20},
}
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


BAD = [
    ({"chi": {"A B": 2}}, "chi.A B: 2 is outside .* allowed: 3 "),
    ({"repulsion": {"A A": 25, "B B": 25, "B A": 30}}, "chi.A B: the pair has a repulsion as well"),
    ({"chi": {"A C": 4}}, "chi.A C: no molecule has the species 'C'; allowed: A, B"),
    ({"repulsion": {"A A": 25, "B B": 26}}, "the same repulsion for A A and B B"),
    ({"box": [8, 8, 9]}, "chi.A B: no relation .* at density 2.667"),
    ({"dimension": 2}, "three dimensions"),
    ({"thermostat": {"kT": 2}}, "25 between like beads .* = 50"),
]


@pytest.mark.parametrize(("change", "message"), BAD)
def test_bad_chi_is_one_message(change, message):
    data = BLEND | change
    if "box" in change:
        data = data | {"molecules": [{"architecture": k, "count": 768} for k in "AB"]}
    with pytest.raises(UserError, match=message) as problem:
        Scene(data, "my.yaml")
    assert str(problem.value).startswith("my.yaml: ") and "\n" not in str(problem.value)


def test_the_command_answers_alone(tmp_path):
    """Both repulsions, chi N and the range; outside of it one message."""
    done = command("repulsion", "--chi", 4, "--density", 3, "--length", 10, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for phrase in ("25 kT / r_c", "38.0719", "chi N        40", "Eq. 27", "(chi N = 3) to 12.2"):
        assert phrase in done.stdout
    refused = command("repulsion", "--chi", 4, "--density", 3, "--length", 11, cwd=tmp_path)
    assert refused.returncode == 1 and "2 to 10 beads" in refused.stderr
