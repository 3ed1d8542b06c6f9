"""Thermostats: pairs and beads by hand, their noise, and temperatures in equilibrium."""

import numpy as np
import pytest

from tests.engine.cases import FRICTION, MASSES, TABLE
from tests.engine.reference import Reference
from tests.systems import (
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    fewer_in_python,
    make_simulation,
    make_system,
    random_beads,
)

BOX = {2: (5.1, 2.5), 3: (2.5, 3.7, 5.1)}
EXCHANGES = ("shardlow", "aboba", "lowe-andersen")  # the last has the kernels of the first


def test_lowe_draws_as_often_as_asked():
    """In a share gamma dt of the steps, a relative velocity of variance 2 kT along e alone."""
    position = np.array([[1.0, 1.4], [1.0, 1.0], [1.0, 1.0]])
    velocity, drawn = np.array([[0.9, -0.6], [0.2, -0.2], [0.0, 0.0]]), []
    bond = (np.array([[0, 1]], np.uint32), 0.0, 0.4)  # without a force: as below, a kernel less
    for seed in range(1500):
        system = make_system(BOX[3], "lowe-andersen", dt=0.05, repulsion=np.zeros((1, 1)),
                             bonds=bond, friction=6.0, seed=seed)  # fmt: skip
        simulation = make_simulation(system, position, velocity)
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
@pytest.mark.parametrize("scheme", [*EXCHANGES, "gw-vv"])
def test_what_is_measured_belongs_to_where_the_beads_are(scheme, skin=0.2):
    """Virial and energy of every pair and bond at one instant; to measure changes nothing."""
    position, velocity = random_beads(BOX[3], 60)
    bonds = (chains(10, 4), 40.0, 0.7)
    system = make_system(BOX[3], scheme, dt=0.02, skin=skin, bonds=bonds)
    one, other = (make_simulation(system, position, velocity) for _ in range(2))
    for steps in (7, 1, 12):
        sums = one.sample(steps, [one.state.step + steps], measure=True).of(-1)
        other.advance(steps)
        place, speed = by_identity(one, "position"), by_identity(one, "velocity")
        reference = Reference(system, "gw-vv", 0.5, place, speed)
        np.testing.assert_allclose(sums.virial[0], reference.virial[0], rtol=1e-10, atol=1e-9)
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-10)
    assert_same_state(one.state, other.state)
    assert type(one.state.step) is int  # as JSON has it, which shows progress


@pytest.mark.few(1)
@pytest.mark.parametrize("scheme", EXCHANGES)
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


def couples(dimension, scheme, **changes):
    """Two beads half a cutoff apart at each point of a lattice, each of the three pairs of species.

    No bead has a second partner, so that the order in which pairs exchange momentum is no matter.
    """
    edge, points = 2.5, 4
    lattice = np.stack(np.meshgrid(*[np.arange(points) * edge + 1.0] * dimension)).reshape(
        dimension, -1
    )
    rng = np.random.default_rng(3)
    along = rng.normal(size=lattice.shape)
    along *= 0.25 / np.linalg.norm(along, axis=0)
    position = np.stack([lattice + along, lattice - along], axis=2).reshape(dimension, -1)
    velocity = rng.normal(size=position.shape)
    species = (rng.random(position.shape[1]) < 0.5).astype(np.uint8)
    box = (points * edge,) * dimension
    values = {"dt": 0.01, "friction": FRICTION, "masses": MASSES, "seed": 4} | changes
    system = make_system(box, scheme, repulsion=TABLE, **values)
    simulation = make_simulation(system, position, velocity, species)
    return simulation, Reference(system, scheme, 0.5, position, velocity, species)


@pytest.mark.plain
@pytest.mark.parametrize(
    ("scheme", "dimension"),
    [("shardlow", 3), ("lowe-andersen", 3), ("aboba", 3), ("shardlow", 2), ("lowe-andersen", 2)],
)
def test_couples_exchange_beside_the_reference(scheme, dimension):
    """Ten steps agree to 1e-10. In Lowe's a pair of rate 12 is drawn in 12 % of the steps."""
    simulation, reference = couples(dimension, scheme, skin=0.2 if dimension == 2 else 0.0)
    before = reference.velocity.copy()
    for _ in range(fewer_in_python(10)):
        simulation.advance(1)
        reference.step()
        found = by_identity(simulation, "velocity")
        np.testing.assert_allclose(found, reference.velocity, rtol=0, atol=1e-10)
        place = by_identity(simulation, "position")
        assert_same_place(place, reference.position, simulation.system.box, 1e-10)
    i, j = np.triu_indices(before.shape[1], 1)
    near = reference.separation(i, j)[1] < 1.1
    assert np.bincount(np.concatenate([i[near], j[near]])).max() == 1
    assert np.abs(reference.velocity - before).max() > 1
