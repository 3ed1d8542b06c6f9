"""Walls and body forces: against the plain engine, finite differences, and exact results."""

import numpy as np
import pytest

from dpd.engine.queries.stress import force_and_curvature
from dpd.engine.simulation import BehindWall
from dpd.physics.body_force import BodyForce
from dpd.physics.walls import Walls
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

GAP = 2.0  # behind each plane: a reach of 1 and the cutoff
PERIODIC = {2: (3.4, 4.1), 3: (2.9, 2.5, 4.1)}  # edges between planes, or of the box
SCHEMES = [("euler", 0.5), ("gw-vv", 0.65), ("verlet-no-acceleration", 0.5), ("dpd-vv", 0.5)]


def between(edges, axes, repulsion, velocity=None):
    """Box and `Walls` for planes at a distance along some axes."""
    dimension = len(edges)
    box = tuple(edge + 2 * GAP * (axis in axes) for axis, edge in enumerate(edges))
    places = [place for axis in axes for place in (GAP, GAP + edges[axis])]
    velocity = np.zeros((2, dimension)) if velocity is None else np.array(velocity)
    return box, Walls(
        repulsion=np.array(repulsion, float),
        axis=np.repeat(np.array(axes, np.int64), 2),
        place=np.array(places),
        inward=np.tile([1.0, -1.0], len(axes)),
        velocity=np.tile(velocity, (len(axes), 1)),
        reach=1.0,
    )


def beads_between(edges, axes, count, seed=9):
    """Places between the planes, and velocities."""
    position, velocity = random_beads(edges, count, seed)
    position[list(axes)] += GAP
    return position, velocity


def mixed_beads(dimension, axes, scheme="gw-vv", prediction=0.65, threads=1, **changes):
    """The same 60 beads, chains among them, between walls, for the engine and the reference."""
    edges = PERIODIC[dimension]
    velocity = [[0.3] * dimension, [-0.2] * dimension]
    for moving in velocity:
        moving[axes[0]] = 0.0
    box, walls = between(edges, axes, [25.0, 60.0], velocity if len(axes) == 1 else None)
    body = BodyForce(np.array([0.4, -0.7]), 0, dimension - 2, 0.5 * edges[dimension - 2])
    species = (np.arange(60) % 2).astype(np.uint8)
    values = {
        "repulsion": np.array([[25.0, 40.0], [40.0, 30.0]]), "bonds": (chains(8, 5), 60.0, 0.7),
        "dt": 0.01, "seed": 5, "walls": walls, "wall_friction": 9.0, "body_force": body,
    }  # fmt: skip
    system = make_system(box, scheme, prediction, **values | changes)
    position, velocity = beads_between(edges, axes, 60)
    simulation = make_simulation(system, position, velocity, species, threads=threads)
    return simulation, Reference(system, scheme, prediction, position, velocity, species)


def assert_beside(simulation, reference, sums):
    """Places, velocities, forces, virials, energies and what walls do agree to 1e-9."""
    place = by_identity(simulation, "position")
    assert_same_place(place, reference.position, simulation.system.box, 1e-9)
    for name in ("velocity", "force"):
        found, expected = by_identity(simulation, name), getattr(reference, name)
        assert np.abs(found - expected).max() < 1e-9 * max(1, np.abs(expected).max())
    assert np.abs(sums.virial - reference.virial).max() < 1e-9 * np.abs(reference.virial).max()
    np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)
    scale = np.abs(reference.at_walls).max()
    assert np.abs(sums.walls - reference.at_walls).max() < 1e-9 * scale


@pytest.mark.plain
@pytest.mark.parametrize("gaussian", [False, True], ids=["uniform", "gaussian"])
@pytest.mark.parametrize("skin", [0.0, 0.2], ids=["cells", "list"])
@pytest.mark.parametrize(("dimension", "axes"), [(2, (1,)), (3, (2,)), (3, (0, 2))])
@pytest.mark.parametrize("scheme, prediction", SCHEMES)
def test_sixty_beads_step_beside_the_reference(scheme, prediction, dimension, axes, skin, gaussian):
    """Twenty steps, with friction on walls, some of which move, and a force in two directions."""
    if (skin and (scheme != "gw-vv" or dimension == 2)) or (dimension == 2 and scheme != "gw-vv"):
        pytest.skip("one scheme with a list, and one in the plane, are enough")
    simulation, reference = mixed_beads(
        dimension, axes, scheme, prediction, skin=skin, gaussian=gaussian
    )
    for _ in range(fewer_in_python(20)):
        sums = simulation.advance_measured(1)
        reference.step()
        assert_beside(simulation, reference, sums)
    assert (sums.walls[:, 1] > 0).all()


@pytest.mark.thorough
def test_smooth_walls_beside_a_langevin_thermostat():
    """Without friction of their own, and with noise on every bead."""
    simulation, reference = mixed_beads(3, (2,), wall_friction=0.0, per_bead=True)
    for _ in range(20):
        sums = simulation.advance_measured(1)
        reference.step()
    assert_beside(simulation, reference, sums)
    assert not sums.walls[:, 2:].any()


@pytest.mark.thorough
def test_walls_alone_have_their_own_noise():
    """A bead at a wall does not share noise with the Langevin thermostat, nor with other walls."""
    alone = {"body_force": None}
    one, other = (
        mixed_beads(3, (2,), per_bead=True, friction=gamma, **alone)[0] for gamma in (9.0, 0.0)
    )
    both, wall = by_identity(one, "force"), by_identity(other, "force")
    smooth, _ = mixed_beads(3, (2,), friction=0.0, wall_friction=0.0, **alone)
    at_walls = by_identity(smooth, "force")
    bath, rough = both - wall, wall - at_walls
    near = np.abs(rough).max(axis=0) > 0
    assert 20 < near.sum() < 60
    correlation = np.corrcoef(bath[:, near].ravel(), rough[:, near].ravel())[0, 1]
    assert abs(correlation) < 4 / np.sqrt(3 * near.sum())


@pytest.mark.few(1)
@pytest.mark.parametrize(("scheme", "skin"), [("gw-vv", 0.0), ("gw-vv", 0.2), ("dpd-vv", 0.0)])
def test_threads_and_calls_change_no_bit(scheme, skin):
    """Of the state, nor of what walls do: 1, 2 and 4 threads; one call, or three."""
    runs = [mixed_beads(3, (2,), scheme, skin=skin, threads=n)[0] for n in (1, 2, 4)]
    sums = [simulation.advance_measured(60) for simulation in runs]
    parts, _ = mixed_beads(3, (2,), scheme, skin=skin)
    for steps in (13, 1):
        parts.advance(steps)
    sums.append(parts.advance_measured(46))
    for simulation, found in zip([*runs, parts], sums):
        assert_same_state(simulation.state, runs[0].state)
        for name in ("virial", "energy", "walls"):
            np.testing.assert_array_equal(getattr(found, name), getattr(sums[0], name))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "scheme", ["euler", "gw-vv", "dpd-vv", "shardlow", "lowe-andersen", "aboba"]
)
def test_a_body_force_adds_its_momentum(scheme):
    """In a periodic box with friction between pairs: force times time, in every scheme."""
    box = (5.1, 4.4)
    position, velocity = random_beads(box, 60)
    body = BodyForce(np.array([0.3]), 1, 1, np.inf)
    system = make_system(box, scheme, body_force=body, dt=0.01)
    simulation = make_simulation(system, position, velocity)
    simulation.advance(50)
    gained = simulation.state.velocity.sum(axis=1)
    np.testing.assert_allclose(gained, [0, 60 * 0.3 * 0.5], atol=1e-10)


def energy_at(system, position, species):
    """Pair, bond and wall energy."""
    simulation = make_simulation(system, position, np.zeros_like(position), species)
    sums = simulation.measure()
    return sums.energy.sum() + sums.walls[:, 0].sum()


@pytest.mark.thorough
@pytest.mark.parametrize(("dimension", "axes"), [(2, (1,)), (3, (0, 2))])
def test_the_force_is_minus_the_gradient_of_the_energy(dimension, axes):
    """Of pairs, bonds and walls together, by differences over 2e-5 r_c."""
    simulation, _ = mixed_beads(dimension, axes, friction=0.0, wall_friction=0.0, body_force=None)
    system = simulation.system
    species = by_identity(simulation, "species")
    position, force = by_identity(simulation, "position"), by_identity(simulation, "force")
    for bead in range(0, 60, 7):
        for axis in range(dimension):
            energies = []
            for nudge in (1e-5, -1e-5):
                moved = position.copy()
                moved[axis, bead] += nudge
                energies.append(energy_at(system, moved, species))
            slope = (energies[0] - energies[1]) / 2e-5
            assert force[axis, bead] == pytest.approx(-slope, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("z", [-0.7, -0.1, 0.2, 0.6, 0.95, 1.3])
def test_the_page_of_walls_is_consistent(z):
    """Force and curvature are slopes, also behind the plane; friction weighs at most 1."""
    _, page = between((3, 3), (0,), [25.0])
    slope = (page.energy(25.0, z + 1e-5) - page.energy(25.0, z - 1e-5)) / 2e-5
    assert page.force(25.0, z) == pytest.approx(-slope, rel=1e-6, abs=1e-8)
    slope = (page.force(25.0, z + 1e-5) - page.force(25.0, z - 1e-5)) / 2e-5
    assert page.curvature(25.0, z) == pytest.approx(-slope, rel=1e-6)
    assert page.weight(z) == pytest.approx(min(1, max(0, 1 - z)))


@pytest.mark.thorough
def test_energy_is_conserved_without_friction():
    """Of beads that bounce between walls: total energy drifts by less than 1e-3 kT a bead."""
    edges = (3.0, 3.0, 4.0)
    box, walls = between(edges, (2,), [25.0])
    system = make_system(box, friction=0.0, dt=0.002, walls=walls)
    position, velocity = beads_between(edges, (2,), 100)
    simulation = make_simulation(system, position, velocity)
    totals = []
    for _ in range(20):
        sums = simulation.advance_measured(100)
        kinetic = 0.5 * (simulation.state.velocity**2).sum()
        totals.append(kinetic + sums.energy.sum() + sums.walls[:, 0].sum())
    assert np.ptp(totals) < 1e-3 * 100


def free_beads(steps, every, wall_friction):
    """Samples of 2000 beads without repulsion between walls: pressures, v^2, density in between."""
    edges = (5.0, 5.0, 6.0)
    box, walls = between(edges, (2,), [25.0])
    system = make_system(
        box, repulsion=np.zeros((1, 1)), friction=0.0, dt=0.01, walls=walls,
        wall_friction=wall_friction,
    )  # fmt: skip
    position, velocity = beads_between((5.0, 5.0, 4.0), (2,), 2000)
    position[2] += 1.0  # out of reach of the walls, so that no energy of theirs heats the beads
    simulation = make_simulation(system, position, velocity)
    simulation.advance(4000)
    pressures, squares = [], []
    for _ in range(steps // every):
        sums = simulation.advance_measured(every)
        pressures.append(sums.walls[:, 1] / 25.0)
        squares.append((simulation.state.velocity**2).mean(axis=1))
    return np.array(pressures), np.array(squares)


@pytest.mark.thorough
def test_an_ideal_gas_presses_with_density_times_kT():
    """On both walls, within four standard errors of 200 samples, 0.5 %.

    Of N beads between soft walls, N / (A Z) per volume are out of reach of both, with
    Z = L - 2 + 2 sqrt(pi / (2 a)) the integral of exp(-u(z)); their pressure is that times kT.
    The walls alone hold the temperature.
    """
    pressures, squares = free_beads(20_000, 100, wall_friction=9.0)
    exact = 2000 / (25 * (6 - 2 + 2 * np.sqrt(np.pi / 50)))
    error = pressures.std(axis=0) / np.sqrt(len(pressures))
    assert (np.abs(pressures.mean(axis=0) - exact) < 4 * error).all()
    assert (error < 0.01 * exact).all()
    assert np.abs(squares.mean(axis=0) - 1).max() < 0.05


def test_a_bead_that_gets_far_behind_a_wall_is_an_error():
    """And the state stays as it was, whoever of the threads finds it."""
    edges = (3.0, 3.0, 4.0)
    box, walls = between(edges, (2,), [1.0])
    position, velocity = beads_between(edges, (2,), 30)
    velocity[2, 7] = 3.0
    said = []
    for threads in (1, 2):
        system = make_system(box, walls=walls, kT=0.0, friction=1e-9, repulsion=np.zeros((1, 1)))
        simulation = make_simulation(system, position, velocity, threads=threads)
        before = simulation.state
        with pytest.raises(BehindWall, match=r"behind a wall at step \d+ .*walls.repulsion") as it:
            simulation.advance(400)
        assert simulation.state is before
        said.append(str(it.value))
    assert said[0] == said[1] and "bead 7 " in said[0]


def test_no_bead_passes_the_gap_unseen():
    """Even at the fastest that a step allows."""
    edges = (3.0, 3.0, 4.0)
    box, walls = between(edges, (2,), [1e-3])
    system = make_system(
        box, walls=walls, kT=0.0, friction=1e-9, repulsion=np.zeros((1, 1)), dt=0.01
    )
    for place in np.linspace(0.1, 3.9, 60):
        position = np.array([[1.0], [1.0], [GAP + place]])
        simulation = make_simulation(system, position, np.array([[0.0], [0.0], [99.9]]))
        with pytest.raises(BehindWall):
            simulation.advance(30)


@pytest.mark.thorough
def test_configurational_temperature_knows_walls():
    """Squared force and curvature are those of the potential with walls, by the plain engine."""
    simulation, _ = mixed_beads(
        3, (0, 2), friction=0.0, wall_friction=0.0, body_force=None, bonds=None
    )
    force = by_identity(simulation, "force")
    found = force_and_curvature(simulation.system, simulation.state)
    assert found[0] == pytest.approx((force**2).sum(), rel=1e-9)
    bare = force_and_curvature(make_system(simulation.system.box, repulsion=np.array(
        [[25.0, 40.0], [40.0, 30.0]])), simulation.state)  # fmt: skip
    place, species = by_identity(simulation, "position"), by_identity(simulation, "species")
    walls, more = simulation.system.walls, 0.0
    for axis, inward, plane in zip(walls.axis, walls.inward, walls.place):
        more += walls.repulsion[species][inward * (place[axis] - plane) < 1].sum()
    assert found[1] - bare[1] == pytest.approx(more, rel=1e-9)
