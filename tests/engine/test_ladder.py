"""From one bead at rest to fifty beads beside the plain reference."""

import numpy as np
import pytest

from tests.engine.reference import pair_noise
from tests.systems import (
    BOX_3D,
    assert_same_place,
    by_identity,
    chains,
    make_simulation,
    make_system,
)

DIRECTION = np.array([2.0, -1.0, 2.0]) / 3
pytestmark = pytest.mark.plain


def test_moving_bead_keeps_its_velocity_and_wraps():
    """200 additions of numbers below 6, each rounded by 4.4e-16 at most, err below 1e-13."""
    start, velocity = np.array([[0.3], [3.6], [2.5]]), np.array([[1.0], [-2.0], [0.5]])
    simulation = make_simulation(make_system(BOX_3D), start, velocity)
    for _ in range(200):
        simulation.advance(1)
        assert (simulation.state.position >= 0).all()
        assert (simulation.state.position < np.array(BOX_3D)[:, None]).all()
    assert_same_place(simulation.state.position, start + 200 * 0.04 * velocity, BOX_3D, 1e-12)
    np.testing.assert_array_equal(simulation.state.velocity, velocity)


def two_beads(distance, middle, velocity=(0.0, 0.0), **changes):
    """Bead 0 ahead of bead 1 along `DIRECTION`, with velocities along it: forces on both."""
    along = DIRECTION[:, None]
    position = np.array(middle)[:, None] + along * np.array([[0.5, -0.5]]) * distance
    position %= np.array(BOX_3D)[:, None]
    system = make_system(BOX_3D, **changes)
    return by_identity(make_simulation(system, position, along * np.array([velocity])), "force")


CENTRE, CORNER = (1.1, 1.8, 2.5), (2.2, 0.0, 5.1)


@pytest.mark.parametrize("middle", [CENTRE, CORNER], ids=["centre", "across the boundary"])
@pytest.mark.parametrize("distance", [0.01, 0.5, 0.999, 1 + 1e-12, 1.5])
def test_repulsion_and_friction_of_two_beads(distance, middle):
    """Eqs. 3 and 4 without noise; positions below 6 are rounded by 4.4e-16, a 25 times that."""
    force = two_beads(distance, middle, velocity=(0.7, -0.4), kT=0.0)
    w = max(1 - distance, 0)
    expected = (25 * w - 4.5 * w**2 * 1.1) * DIRECTION
    np.testing.assert_allclose(force[:, 0], expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(force[:, 0], -force[:, 1])


@pytest.mark.parametrize("gaussian", [False, True])
def test_noise_of_two_beads(gaussian):
    """Eq. 8 with sigma^2 = 2 gamma kT; the noise is alone without repulsion and motion."""
    changes = {"repulsion": np.zeros((1, 1)), "kT": 2.0, "dt": 0.01, "seed": 7}
    force = two_beads(0.4, CENTRE, gaussian=gaussian, **changes)
    theta = pair_noise(np.array([0]), np.array([1]), 7, 0, gaussian)
    expected = np.sqrt(2 * 4.5 * 2.0) * 0.6 * theta / np.sqrt(0.01) * DIRECTION
    assert abs(theta[0]) > 0.01
    np.testing.assert_allclose(force[:, 0], expected, rtol=1e-12)
    np.testing.assert_array_equal(force[:, 0], -force[:, 1])


def test_bonded_pair_swings_as_velocity_verlet_must():
    """x_n = x_0 cos(n phi), cos phi = 1 - (omega dt)^2 / 2, with omega^2 = 2 C for two beads.

    Stretched by 0.2 along a diagonal across the boundary. That is velocity Verlet's exact solution;
    it differs from the continuous period by (omega dt)^2 / 24, 0.1 % here.
    """
    dt, omega, length, edges = 0.01, np.sqrt(2 * 100.0), 0.95, np.array(BOX_3D)
    bonds = (chains(1, 2), 100.0, length)
    system = make_system(BOX_3D, dt=dt, friction=0.0, repulsion=np.zeros((1, 1)), bonds=bonds)
    first, along = np.array([0.1, 0.2, 0.3]), np.array([0.6, 0.8, 0.0]) * (length + 0.2)
    position = np.stack([first, first - along], axis=1) % edges[:, None]
    simulation = make_simulation(system, position, np.zeros((3, 2)))
    phi = np.arccos(1 - (omega * dt) ** 2 / 2)
    for n in range(1, 200):
        simulation.advance(1)
        apart = by_identity(simulation, "position") @ [1, -1]
        apart -= edges * np.round(apart / edges)
        stretch = np.linalg.norm(apart) - length
        assert stretch == pytest.approx(0.2 * np.cos(n * phi), abs=1e-11)
