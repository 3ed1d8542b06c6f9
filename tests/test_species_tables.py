"""Friction of pairs of species and masses, as scenes, starts, files and pages have them."""

import numpy as np
import pytest

from dpd.errors import UserError
from dpd.particles import read, write
from dpd.runs.result import of_state
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.systems import look

PLAIN = SCENE | {
    "box": 8,
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 30},
    "steps": {"equilibrate": 10, "sample": 20},
    "observe": ["thermo"],
}
BLEND = PLAIN | {"thermostat": {"gamma": {"A A": 4.5, "B A": 9, "B B": 2}}, "mass": {"B": 4}}
LANGEVIN = {"thermostat": {"kind": "langevin", "gamma": {"A": 4.5, "B": 9}}}


def test_tables_of_a_scene():
    """By the order of the species' names; a mass that is not given is 1."""
    scene = Scene(BLEND)
    np.testing.assert_array_equal(scene.friction, [[4.5, 9], [9, 2]])
    assert scene.masses.tolist() == [1, 4] and scene.lightest == 1
    np.testing.assert_array_equal(Scene(BLEND | LANGEVIN).friction, [4.5, 9])


def test_starts_have_velocities_of_their_masses():
    """No momentum; <m v^2> / 3 is kT for each species within 5 standard errors of 5 %."""
    scene = Scene(BLEND | {"start": {"kT": 2}})
    state = make_start(scene)
    momenta = system_of(scene).momenta(state)
    assert np.abs(momenta.sum(axis=1)).max() < 1e-10
    energies = np.mean(momenta * state.velocity, axis=0)
    for kind in (0, 1):
        own = energies[state.species == kind]
        assert abs(own.mean() / 2 - 1) < 5 * np.sqrt(2 / (3 * own.size))


def test_auto_looks_at_the_lightest_and_at_the_highest_friction():
    """A quarter of the mass halves the step at least; a friction of 100 was not measured."""
    auto = BLEND | {"integrator": {"scheme": "auto"}, "thermostat": {"gamma": 0.5}}
    heavy, light = (Scene(auto | {"mass": {"B": mass}}) for mass in (4, 0.25))
    assert light.dt < 0.55 * heavy.dt
    with pytest.raises(UserError, match="gamma: 100, "):
        Scene(auto | {"thermostat": {"gamma": {"A A": 1, "A B": 100, "B B": 1}}})


@pytest.mark.parametrize("suffix", ["gsd", "data", "nc"])
def test_files_keep_masses(tmp_path, suffix):
    """Those of each species, also one that single precision does not have."""
    scene = Scene(BLEND | {"mass": {"A": 1.1, "B": 4}})
    particles = of_state(scene, make_start(scene))
    write(particles, tmp_path / f"beads.{suffix}")
    found = read(tmp_path / f"beads.{suffix}")
    assert found.masses_by_name() == {"A": 1.1, "B": 4} and "mass" not in str(found.left_out)
    np.testing.assert_allclose(found.velocity, particles.velocity, rtol=1e-15)


def test_a_start_from_beads_of_other_masses_says_so(tmp_path):
    """The velocities stay as they are. Velocities that a file lacks fit the scene's masses."""
    scene, path = Scene(BLEND), tmp_path / "beads.data"
    particles = of_state(scene, make_start(scene))
    start = {"start": {"method": "file", "path": str(path)}}
    said = []
    write(particles._replace(masses=None), path)
    state = make_start(Scene(BLEND | start), say=said.append)
    assert any("other masses than the scene (B 1)" in sentence for sentence in said)
    np.testing.assert_array_equal(state.velocity, particles.velocity)
    write(particles._replace(velocity=None), path)
    scene = Scene(BLEND | start)
    state = make_start(scene, say=said.append)
    assert np.abs(system_of(scene).momenta(state).sum(axis=1)).max() < 1e-10
    heavy = state.velocity[:, state.species == 1]
    assert abs(4 * np.mean(heavy**2) - 1) < 5 * np.sqrt(2 / heavy.size)


def test_displacements_are_those_of_centres_of_mass():
    """A bead of mass 1 moves by 0.8. Its molecule has a mass of 4, all beads have 8."""
    scene = BLEND | {
        "molecules": [{"architecture": "A B", "count": 1}, {"architecture": "A", "count": 4}],
        "bond": {"stiffness": 50}, "mass": {"B": 3}, "steps": {"sample": 2},
    }  # fmt: skip
    place, moved = np.full((2, 3, 6), 5.0)
    moved[0, 0] += 0.8
    found = look(scene, {"displacement": {"every": 1}}, place, moved)["msd_centre"][0]
    np.testing.assert_allclose(found[0], (0.8 / 4 - 0.8 / 8) ** 2, rtol=1e-12)
    np.testing.assert_allclose(found[1:], (0.8 / 8) ** 2, rtol=1e-12)
