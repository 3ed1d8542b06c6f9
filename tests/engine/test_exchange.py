"""Schemes that let pairs exchange momentum: step by step, and in equilibrium."""

import numpy as np
import pytest

from tests.engine.reference import Reference, pair_noise
from tests.systems import (
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    every_second,
    make_simulation,
    make_system,
    random_beads,
)

SPLIT = ("shardlow", "aboba", "lowe-andersen")  # the last has the kernels of the first
BOX = {2: (3.1, 2.5), 3: (2.5, 3.7, 4.0)}
SEARCHES = pytest.mark.parametrize("skin", [0.0, 0.2], ids=["cells", "list"])
SCHEMES = pytest.mark.parametrize("scheme", SPLIT)


def noise_of(low, high, seed, step, gaussian):
    """The engine's noise of one pair at a step."""
    return pair_noise(np.array([low]), np.array([high]), seed, step, gaussian)[0]


def pair_in_motion(scheme, dt, **changes):
    """Two beads without repulsion, 0.4 apart along x."""
    position = np.array([[1.0, 1.4], [1.0, 1.0], [1.0, 1.0]])
    velocity = np.array([[0.9, -0.6], [0.2, -0.2], [0.0, 0.0]])
    bond = (np.array([[0, 1]], np.uint32), 0.0, 0.4)  # without a force: as below, a kernel less
    system = make_system(BOX[3], scheme, dt=dt, repulsion=np.array([[0.0]]), bonds=bond, **changes)
    return make_simulation(system, position, velocity), position, velocity


def test_shardlow_of_one_pair():
    """Velocity Verlet, then the two half steps as Nikunen et al. 2003 write them."""
    dt = 0.03
    simulation, position, velocity = pair_in_motion("shardlow", dt)
    simulation.advance(1)
    r = position[:, 0] - position[:, 1] + dt * (velocity[:, 0] - velocity[:, 1])
    distance = np.linalg.norm(r)
    e, w = r / distance, 1 - distance
    friction, sigma = 4.5 * w**2, np.sqrt(2 * 4.5)
    push = 0.5 * sigma * w * e * noise_of(0, 1, 1, 1, False) * np.sqrt(dt)
    v = velocity.copy()
    drag = 0.5 * friction * ((v[:, 0] - v[:, 1]) @ e) * e * dt
    v[:, 0] += push - drag
    v[:, 1] -= push - drag
    along = (v[:, 0] - v[:, 1]) @ e
    implicit = 0.5 * friction * dt / (1 + friction * dt) * (along * e + 2 * push)
    v[:, 0] += push - implicit
    v[:, 1] -= push - implicit
    np.testing.assert_allclose(by_identity(simulation, "velocity"), v, atol=1e-12)


def test_exact_exchange_of_one_pair():
    """Half a drift, the Ornstein-Uhlenbeck step, half a drift."""
    dt = 0.03
    simulation, position, velocity = pair_in_motion("aboba", dt)
    simulation.advance(1)
    middle = position + 0.5 * dt * velocity
    r = middle[:, 0] - middle[:, 1]
    distance = np.linalg.norm(r)
    e, rate = r / distance, 2 * 4.5 * (1 - distance) ** 2
    u = (velocity[:, 0] - velocity[:, 1]) @ e
    decay = np.exp(-rate * dt)
    drawn = np.sqrt(2 * (1 - decay**2)) * noise_of(0, 1, 1, 1, True)
    kick = 0.5 * (u * decay + drawn - u) * e
    v = velocity + np.stack([kick, -kick], axis=1)
    np.testing.assert_allclose(by_identity(simulation, "velocity"), v, atol=1e-12)
    expected = middle + 0.5 * dt * v
    np.testing.assert_allclose(by_identity(simulation, "position"), expected, atol=1e-12)


def test_lowe_draws_as_often_as_asked():
    """In a share gamma dt of the steps, a relative velocity of variance 2 kT along e alone."""
    drawn = []
    for seed in range(1500):
        simulation, _, velocity = pair_in_motion("lowe-andersen", 0.05, friction=6.0, seed=seed)
        simulation.advance(1)
        now = by_identity(simulation, "velocity")
        np.testing.assert_allclose(now.sum(axis=1), velocity.sum(axis=1), atol=1e-12)
        if np.abs(now - velocity).max() > 1e-12:
            r = by_identity(simulation, "position") @ [1, -1]
            drawn.append((now @ [1, -1]) @ r / np.linalg.norm(r))
    share = len(drawn) / 1500
    assert abs(share - 0.3) < 4 * np.sqrt(0.3 * 0.7 / 1500)
    assert abs(np.var(drawn) / 2 - 1) < 4 * np.sqrt(2 / len(drawn))


@pytest.mark.few(1)
@pytest.mark.parametrize("scheme, dimension, skin", every_second(SPLIT, [3, 2], [0.0, 0.2]))
def test_momentum_is_kept_and_calls_may_be_split(scheme, dimension, skin):
    """To rounding; and forty steps are thirteen, one and twenty-six, bit for bit."""
    position, velocity = random_beads(BOX[dimension], 60)
    bonds = (chains(10, 4), 40.0, 0.7)
    system = make_system(BOX[dimension], scheme, dt=0.01, skin=skin, bonds=bonds)
    one, other = (make_simulation(system, position, velocity) for _ in range(2))
    one.advance(40)
    for steps in (13, 1, 26):
        other.advance(steps)
    assert_same_state(one.state, other.state)
    assert np.abs(one.state.velocity.sum(axis=1)).max() < 1e-12


@pytest.mark.thorough
@SCHEMES
def test_cells_and_list_exchange_alike(scheme):
    """The order of pairs differs, which one step of exchanges shows at second order only."""
    position, velocity = random_beads(BOX[3], 60)
    ends = []
    for skin in (0.0, 0.2):
        bonds = (chains(10, 4), 40.0, 0.7)  # as above: other beads need another kernel
        system = make_system(BOX[3], scheme, dt=1e-4, skin=skin, bonds=bonds)
        simulation = make_simulation(system, position, velocity)
        simulation.advance(1)
        ends.append(by_identity(simulation, "velocity"))
    moved = np.abs(ends[0] - velocity).max()
    assert np.abs(ends[0] - ends[1]).max() < 0.05 * moved


@pytest.mark.few(1)
@SEARCHES
@pytest.mark.parametrize("scheme", [*SPLIT, "gw-vv"])
def test_what_is_measured_belongs_to_where_the_beads_are(scheme, skin):
    """Virial and energy of every pair and bond at one instant; to measure changes nothing."""
    position, velocity = random_beads(BOX[3], 60)
    bonds = (chains(10, 4), 40.0, 0.7)
    system = make_system(BOX[3], scheme, dt=0.02, skin=skin, bonds=bonds)
    one, other = (make_simulation(system, position, velocity) for _ in range(2))
    for steps in (7, 1, 12):
        sums = one.advance_measured(steps)
        other.advance(steps)
        place, speed = by_identity(one, "position"), by_identity(one, "velocity")
        reference = Reference(system, "gw-vv", 0.5, place, speed)
        np.testing.assert_allclose(sums.virial[0], reference.virial[0], rtol=1e-10, atol=1e-9)
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-10)
    assert_same_state(one.state, other.state)


@pytest.mark.thorough
@SCHEMES
def test_without_friction_it_is_velocity_verlet(scheme):
    """gw-vv without friction, to rounding; for aboba, its other half: energy is kept as well."""
    position, velocity = random_beads(BOX[3], 60)
    system = make_system(BOX[3], scheme, dt=0.002, friction=0.0)
    simulation = make_simulation(system, position, velocity)
    plain = make_simulation(make_system(BOX[3], dt=0.002, friction=0.0), position, velocity)
    for one in (simulation, plain):
        one.advance(100)
    within = 1e-4 if scheme == "aboba" else 1e-9
    found, expected = (by_identity(one, "position") for one in (simulation, plain))
    assert_same_place(found, expected, BOX[3], within)


@pytest.mark.few(1)
@SCHEMES
@pytest.mark.parametrize("friction, dt", [(4.5, 0.05), (40.5, 0.02)])
def test_temperature_of_free_beads_is_exact(scheme, friction, dt):
    """Without repulsion nothing but the exchange touches velocities: kT is 1, whatever dt.

    Shardlow's step and those drawn anew keep the distribution; so does the exact one.
    """
    rng = np.random.default_rng(5)
    position = rng.random((3, 648)) * 6.0
    velocity = rng.normal(size=(3, 648))
    velocity -= velocity.mean(axis=1, keepdims=True)
    if scheme == "lowe-andersen":
        friction = min(friction, 0.5 / dt)
    system = make_system((6.0,) * 3, scheme, dt=dt, friction=friction, gaussian=True,
                         repulsion=np.array([[0.0]]))  # fmt: skip
    simulation = make_simulation(system, position, velocity)
    simulation.advance(300)
    kT = []
    for _ in range(400):
        simulation.advance(10)
        kT.append((simulation.state.velocity**2).sum() / (3 * 647))
    blocks = np.array(kT).reshape(20, 20).mean(axis=1)
    assert abs(blocks.mean() - 1) < 4 * blocks.std(ddof=1) / np.sqrt(20)
