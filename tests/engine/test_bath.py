"""The Langevin thermostat: friction and noise on every bead on its own.

Beads without repulsion are independent of each other, so that standard errors come from the
scatter between beads.
"""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from dpd.engine.simulation import Simulation
from dpd.engine.state import State
from dpd.jit import COMPILES
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of
from tests.engine.reference import Reference
from tests.systems import (
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    every_second,
    fewer_in_python,
    make_simulation,
    make_system,
    random_beads,
)

BOX = {2: (5.1, 2.5), 3: (2.5, 3.7, 5.1)}
SCHEMES = [("gw-vv", 0.65), ("euler", 0.5), ("verlet-no-acceleration", 0.5), ("dpd-vv", 0.5)]
GAMMA, DT = 2.0, 0.01


def mixed_beads(dimension, skin, scheme="gw-vv", prediction=0.65, gaussian=False, dt=0.01):
    """The same 50 beads, chains among them, for the engine and for the reference."""
    box = BOX[dimension]
    species = (np.arange(50) % 2).astype(np.uint8)
    table = np.array([[25.0, 40.0], [40.0, 30.0]])
    system = make_system(
        box, scheme, prediction, repulsion=table, bonds=(chains(8, 5), 60.0, 0.7), dt=dt,
        skin=skin, per_bead=True, gaussian=gaussian, seed=5,
    )  # fmt: skip
    position, velocity = random_beads(box, 50, seed=9)
    simulation = make_simulation(system, position, velocity, species)
    return simulation, Reference(system, scheme, prediction, position, velocity, species)


@pytest.mark.plain
@pytest.mark.parametrize("gaussian", [False, True], ids=["uniform", "gaussian"])
@pytest.mark.parametrize("scheme, dimension, skin", every_second(SCHEMES, [3, 2], [0.0, 0.2]))
def test_fifty_beads_step_beside_the_reference(scheme, dimension, skin, gaussian):
    """Twenty steps agree to 1e-9, like those with friction between pairs."""
    scheme, prediction = scheme
    simulation, reference = mixed_beads(dimension, skin, scheme, prediction, gaussian)
    for _ in range(fewer_in_python(20)):
        sums = simulation.advance_measured(1)
        reference.step()
        place = by_identity(simulation, "position")
        assert_same_place(place, reference.position, simulation.system.box, 1e-9)
        for name in ("velocity", "force"):
            found, expected = by_identity(simulation, name), getattr(reference, name)
            assert np.abs(found - expected).max() < 1e-9 * max(1, np.abs(expected).max())
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * np.abs(reference.virial).max()
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("dimension", [2, 3])
def test_cells_and_list_agree(dimension):
    """After 20 steps, a few of them with a new list, but for the order of sums: to 1e-11."""
    cells, listed = (mixed_beads(dimension, skin)[0] for skin in (0.0, 0.2))
    for simulation in (cells, listed):
        simulation.advance(20)
    places = [by_identity(simulation, "position") for simulation in (cells, listed)]
    assert_same_place(*places, cells.system.box, 1e-11)
    velocities = [by_identity(simulation, "velocity") for simulation in (cells, listed)]
    np.testing.assert_allclose(*velocities, rtol=0, atol=1e-10)


@pytest.mark.plain
@pytest.mark.parametrize("skin", [0.0, 0.2], ids=["cells", "list"])
@pytest.mark.parametrize("gaussian", [False, True], ids=["uniform", "gaussian"])
def test_forty_steps_are_three_calls(skin, gaussian):
    """Bit for bit: the noise follows from the step and the bead, not from the call."""
    one, other = (mixed_beads(3, skin, gaussian=gaussian)[0] for _ in range(2))
    parts = (13, 1, 26) if COMPILES else (2, 1, 1)
    one.advance(sum(parts))
    for steps in parts:
        other.advance(steps)
    assert_same_state(one.state, other.state)


def test_the_scene_chooses_its_thermostat():
    """Friction between pairs unless it says otherwise."""
    scene = {
        "dimension": 2,
        "box": 4,
        "molecules": [{"architecture": "A", "density": 2}],
        "repulsion": {"A A": 25},
        "integrator": {"scheme": "gw-vv", "dt": 0.01},
        "steps": {"sample": 10},
    }
    assert not system_of(Scene(scene)).per_bead
    system = system_of(Scene(scene | {"thermostat": {"kind": "langevin", "gamma": 1.5}}))
    assert system.per_bead
    assert system.friction == 1.5


def noise_of_beads(box, beads, steps, gaussian=False):
    """(steps, dimension, beads) numbers of unit variance: forces on free beads at rest."""
    position = random_beads(box, beads)[0]
    system = make_system(
        box, repulsion=np.zeros((1, 1)), friction=GAMMA, kT=1.5, dt=DT, per_bead=True,
        gaussian=gaussian,
    )  # fmt: skip
    found = []
    for step in range(steps):
        identity = np.arange(beads, dtype=np.uint32)
        state = State(position.copy(), np.zeros_like(position), None, identity, None, step)
        found.append(by_identity(Simulation(system, state), "force"))
    return np.array(found) / np.sqrt(2 * GAMMA * 1.5 / DT)


@pytest.mark.few(1)
@pytest.mark.parametrize("gaussian", [False, True], ids=["uniform", "gaussian"])
@pytest.mark.parametrize("dimension", [3, 2])
def test_noise_of_axes_beads_and_steps_is_uncorrelated(dimension, gaussian):
    """Each correlation of 400 products stays below 6 of its standard errors, 0.3.

    One of them would go beyond with a chance of 2e-9, one of all 40000 with 1e-4. Mean and
    variance are those of 120000 numbers or more within 5 standard errors.
    """
    theta = noise_of_beads(BOX[dimension], 90, 400, gaussian)
    fourth = 3.0 if gaussian else 1.8
    assert abs(theta.mean()) < 5 / np.sqrt(theta.size)
    assert abs(np.mean(theta**2) - 1) < 5 * np.sqrt((fourth - 1) / theta.size)
    assert abs(np.mean(theta**4) - fourth) < 0.1
    series = theta.reshape(400, -1)
    same_step = series.T @ series / 400
    np.fill_diagonal(same_step, 0)
    next_step = series[1:].T @ series[:-1] / 399
    assert max(np.abs(same_step).max(), np.abs(next_step).max()) < 6 / np.sqrt(399)


def scheme_correlation(steps):
    """<v(0) v(t)> of a free bead along an axis after some steps of gw-vv, lambda 1/2.

    Without other forces a step takes (v, f) to M (v, f) + b zeta: a linear recursion whose
    stationary covariance C is known at any time step, and M^n C with it.
    """
    half = DT / 2
    following = np.array([-GAMMA, -GAMMA * 0.5 * DT])
    matrix = np.array([np.array([1.0, half]) + half * following, following])
    kick = np.sqrt(2 * GAMMA / DT) * np.array([half, 1.0])
    covariance = solve_discrete_lyapunov(matrix, np.outer(kick, kick))
    return (np.linalg.matrix_power(matrix, steps) @ covariance)[0, 0]


def free_run(dimension, prediction, dt, samples, every, beads=2000):
    """(samples, dimension, beads) velocities and unwrapped places after 5 / gamma."""
    edge = (5 * beads) ** (1 / dimension)
    box = (edge,) * dimension
    system = make_system(
        box, "gw-vv", prediction, repulsion=np.zeros((1, 1)), friction=GAMMA, dt=dt,
        per_bead=True, seed=3,
    )  # fmt: skip
    simulation = make_simulation(system, *random_beads(box, beads, seed=2))
    simulation.advance(round(5 / GAMMA / dt))
    place = last = by_identity(simulation, "position")
    velocities, places = [], []
    for _ in range(samples):
        simulation.advance(every)
        now = by_identity(simulation, "position")
        place = place + (now - last) - edge * np.round((now - last) / edge)
        last = now
        velocities.append(by_identity(simulation, "velocity"))
        places.append(place)
    return np.array(velocities), np.array(places)


@pytest.fixture(scope="module", params=[3, 2])
def free(request):
    """15 tau of free beads at dt 0.01, every 5 steps."""
    return free_run(request.param, 0.5, DT, 300, 5)


def over_beads(values):
    """Mean and standard error over independent beads and axes, the last two axes."""
    flat = values.reshape(-1, values.shape[-2] * values.shape[-1])
    return flat.mean(axis=1), flat.std(axis=1, ddof=1) / np.sqrt(flat.shape[1])


@pytest.mark.few(1)
def test_temperature_at_a_small_step(free):
    """kT is 1 within 4 standard errors, each below 0.5 %; with lambda 1/2 it is so exactly."""
    mean, error = over_beads(np.mean(free[0] ** 2, axis=0))
    assert error[0] < 0.005
    assert abs(mean[0] - 1) < 4 * error[0]


@pytest.mark.few(1)
@pytest.mark.parametrize(("prediction", "expected"), [(0.5, 1.0), (0.65, 1 / 1.06)])
def test_temperature_at_a_large_step(prediction, expected):
    """kT / (1 + (lambda - 1/2) gamma dt), at gamma dt 0.4, within 4 standard errors.

    The stationary variance of the recursion that gw-vv is without other forces.
    """
    mean, error = over_beads(np.mean(free_run(3, prediction, 0.2, 100, 5)[0] ** 2, axis=0))
    assert error[0] < 0.005
    assert abs(mean[0] - expected) < 4 * error[0]


@pytest.mark.few(1)
def test_velocity_forgets_itself_at_the_rate_gamma(free):
    """What the scheme makes of exp(-gamma t) within 4 standard errors, for eight times.

    It differs from the exponential by gamma dt / 2, 1 %: the noise of a step counts half
    before it and half after.
    """
    velocity = free[0]
    for lag in (1, 2, 4, 6, 10, 14, 20, 40):
        mean, error = over_beads(np.mean(velocity[lag:] * velocity[:-lag], axis=0))
        expected = scheme_correlation(5 * lag)
        assert abs(expected - np.exp(-GAMMA * 5 * lag * DT)) < 0.01
        assert error[0] < 0.005
        assert abs(mean[0] - expected) < 4 * error[0]


@pytest.mark.few(1)
def test_free_diffusion(free):
    """<x^2> = 2 D (t - (1 - e^(-gamma t)) / gamma) with D = kT / gamma (Ornstein 1930).

    Within 4 standard errors, below 2 %, and 0.5 % for the scheme.
    """
    places = free[1]
    for lag in (2, 10, 40, 160):
        t = 5 * lag * DT
        expected = 2 / GAMMA * (t - (1 - np.exp(-GAMMA * t)) / GAMMA)
        mean, error = over_beads(np.mean((places[lag:] - places[:-lag]) ** 2, axis=0))
        assert error[0] < 0.02 * expected
        assert abs(mean[0] - expected) < 0.005 * expected + 4 * error[0]


def test_momentum_is_not_conserved():
    """That of a fluid has the variance n kT: pair forces cancel, bath forces do not.

    500 looks 0.5 tau apart along two axes, at gamma 4.5 with a correlation of 0.1 from one
    to the next: a standard error of 4.5 %.
    """
    box, beads = (6.0, 6.0), 72
    system = make_system(box, "gw-vv", 0.5, dt=0.02, per_bead=True)
    simulation = make_simulation(system, *random_beads(box, beads))
    simulation.advance(100)
    squares = []
    for _ in range(500):
        simulation.advance(25)
        squares.append(simulation.state.velocity.sum(axis=1) ** 2)
    assert abs(np.mean(squares) / beads - 1) < 4 * 0.045 + 0.02
