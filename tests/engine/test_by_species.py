"""Friction that differs between pairs of species, and masses: step by step, and in equilibrium."""

import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.observe.common.measured import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
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
REPULSION = np.array([[25.0, 40.0], [40.0, 30.0]])
FRICTION = np.array([[4.5, 12.0], [12.0, 0.5]])
MASSES = np.array([0.5, 3.0])
BONDS = (chains(8, 5), 60.0, 0.7)


def mixed(box, count, scheme, **changes):
    """Beads of two species, chains among them, for the engine and for the reference."""
    species = (np.arange(count) % 2).astype(np.uint8)
    values = {"dt": 0.01, "seed": 6, "friction": FRICTION, "masses": MASSES} | changes
    system = make_system(box, scheme, repulsion=REPULSION, bonds=BONDS, **values)
    position, velocity = random_beads(box, count, seed=10)
    simulation = make_simulation(system, position, velocity, species)
    return simulation, Reference(system, scheme, 0.5, position, velocity, species)


def assert_beside(simulation, reference):
    """Places, velocities and forces over masses agree to 1e-9."""
    place = by_identity(simulation, "position")
    assert_same_place(place, reference.position, simulation.system.box, 1e-9)
    velocity, force = (by_identity(simulation, name) for name in ("velocity", "force"))
    np.testing.assert_allclose(velocity, reference.velocity, rtol=0, atol=1e-9)
    expected = reference.force / reference.mass
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.plain
@pytest.mark.parametrize(
    ("scheme", "dimension", "changes"),
    [
        ("gw-vv", 3, {}),
        ("gw-vv", 2, {"skin": 0.2, "gaussian": True}),
        ("euler", 3, {"dt": 0.002}),
        ("verlet-no-acceleration", 3, {}),
        ("dpd-vv", 3, {"skin": 0.2}),
        ("dpd-vv", 2, {"gaussian": True}),
        ("gw-vv", 2, {"per_bead": True, "friction": np.diag(FRICTION)}),
        ("dpd-vv", 3, {"per_bead": True, "friction": np.diag(FRICTION)}),
    ],
)
def test_fifty_beads_step_beside_the_reference(scheme, dimension, changes):
    """Thirty steps agree to 1e-9, and so do virials and energies."""
    simulation, reference = mixed(BOX[dimension], 50, scheme, **changes)
    for _ in range(fewer_in_python(30)):
        sums = simulation.advance_measured(1)
        reference.step()
        assert_beside(simulation, reference)
        largest = np.abs(reference.virial).max()
        np.testing.assert_allclose(sums.virial, reference.virial, rtol=0, atol=1e-9 * largest)
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)


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
    system = make_system(box, scheme, repulsion=REPULSION, **values)
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


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["gw-vv", "shardlow"])
def test_equal_values_are_one_value(scheme):
    """A table of 4.5 and masses of 1 give what the number gives, to rounding."""
    ends = []
    for changes in ({"friction": np.full((2, 2), 4.5), "masses": np.ones(2)},
                    {"friction": 4.5, "masses": None}):  # fmt: skip
        simulation, _ = mixed(BOX[3], 50, scheme, **changes)
        simulation.advance(20)
        ends.append(by_identity(simulation, "velocity"))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-10)


@pytest.mark.thorough
def test_one_species_has_its_mass():
    """Beads of mass 4 move as the reference says; a pair alone as beads of 1 in half the time."""
    position, velocity = random_beads(BOX[3], 40)
    system = make_system(BOX[3], masses=np.array([4.0]), friction=np.array([[9.0]]), dt=0.02)
    simulation = make_simulation(system, position, velocity)
    reference = Reference(system, "gw-vv", 0.5, position, velocity)
    for _ in range(20):
        simulation.advance(1)
        reference.step()
    assert_beside(simulation, reference)
    assert reference.mass.min() == 4


@pytest.mark.few(1)
@pytest.mark.parametrize("scheme", ["gw-vv", "dpd-vv"])
def test_threads_give_the_same_bits(scheme):
    """One, two and four."""
    box, count = (6.0, 5.0, 4.0), 360
    position, velocity = random_beads(box, count)
    species = (np.arange(count) % 2).astype(np.uint8)
    system = make_system(
        box, scheme, repulsion=REPULSION, friction=FRICTION, masses=MASSES, bonds=BONDS, dt=0.01
    )
    ends = []
    for threads in (1, 2, 4):
        simulation = make_simulation(system, position, velocity, species, threads=threads)
        simulation.advance(25)
        ends.append(simulation.state)
    assert_same_state(ends[0], ends[1])
    assert_same_state(ends[0], ends[2])


SCENE = {
    "dimension": 3,
    "box": [2.5, 3.0, 3.5],
    "molecules": [{"architecture": "A 3 B", "count": 12}, {"architecture": "B", "count": 20}],
    "repulsion": {"A A": 25, "A B": 40, "B B": 30},
    "bond": {"stiffness": 20, "length": 0.4},
    "thermostat": {"gamma": {"A A": 4.5, "A B": 12, "B B": 0.5}},
    "mass": {"A": 0.5, "B": 3},
    "steps": {"equilibrate": 520, "sample": 100},
    "observe": [{"thermo": {"every": 10}}, {"displacement": {"every": 10}}],
}


@pytest.mark.few("gw-vv")
@pytest.mark.parametrize("scheme", ["gw-vv", "dpd-vv"])
def test_an_interrupted_run_goes_on_to_the_same_bits(tmp_path, scheme):
    """Force over mass is what the checkpoint keeps."""

    class Stop(Exception):
        pass

    def stop(step):
        if step >= 560:
            raise Stop

    def new():
        scene = Scene(SCENE | {"integrator": {"scheme": scheme, "dt": 0.01}})
        system = system_of(scene)
        return Simulation(system, make_start(scene)), scene.steps, observables(scene, system)

    whole, steps, seen = new()
    run(whole, steps, seen)
    broken, _, partly = new()
    with pytest.raises(Stop):
        run(broken, steps, partly, Checkpoint(tmp_path / "c", {}), stop, 0.0)
    again, _, found = new()
    assert run(again, steps, found, Checkpoint(tmp_path / "c", {})) == 620 - 550
    assert_same_state(whole.state, again.state)
    for one, other in zip(seen, found):
        for name, array in one.arrays.items():
            np.testing.assert_array_equal(other.arrays[name], array)


@pytest.mark.few(1)
@pytest.mark.parametrize("scheme", ["gw-vv", "dpd-vv", "shardlow"])
def test_momentum_is_conserved_to_rounding(scheme):
    """sum of m v, with forces near 100 and masses of 3."""
    simulation, _ = mixed(BOX[3], 50, scheme)
    system = simulation.system
    before = system.momenta(simulation.state).sum(axis=1)
    simulation.advance(500)
    after = system.momenta(simulation.state).sum(axis=1)
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-10)
    assert np.abs(simulation.state.velocity.sum(axis=1) - before).max() > 0.1


class Temperatures:
    """An observer that keeps <m v^2> / 3 of each species."""

    def __init__(self, masses, every):
        self.masses, self.every, self.arrays, self.seen = masses, every, {}, []

    def sample(self, simulation):
        state = simulation.state
        squares = (state.velocity**2).mean(axis=0)
        self.seen.append([
            m * squares[state.species == kind].mean() for kind, m in enumerate(self.masses)
        ])  # fmt: skip


def mixture(scheme, dt, masses, gamma):
    """60 tau of A and B at rho 3 that only masses and frictions tell apart."""
    scene = Scene({
        "dimension": 3,
        "box": 6,
        "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
        "repulsion": {"A A": 25, "A B": 25, "B B": 25},
        "thermostat": {"gamma": gamma},
        "mass": masses,
        "integrator": {"scheme": scheme, "dt": dt},
        "duration": {"equilibrate": 15, "sample": 60},
        "observe": [{"thermo": {"every": 10}}, {"rdf": {"every": 100, "range": 2, "bin": 0.2}}],
    })  # fmt: skip
    system = system_of(scene)
    watched = observables(scene, system)
    temperatures = Temperatures(scene.masses, 10)
    run(Simulation(system, make_start(scene)), scene.steps, [*watched, temperatures])
    found = {}
    for observer in watched:
        found |= {name: variable[1] for name, variable in observer.variables().items()}
    return found | {"of species": np.array(temperatures.seen)}


def mean_and_error(series, blocks=20):
    """Mean over time, and its standard error from blocks of 3 tau."""
    length = len(series) // blocks
    parts = series[: blocks * length].reshape(blocks, length, *series.shape[1:]).mean(axis=1)
    return parts.mean(axis=0), parts.std(axis=0, ddof=1) / np.sqrt(blocks)


EQUAL, UNEQUAL = {"A": 1, "B": 1}, {"A": 1, "B": 5}
TABLE = {"A A": 4.5, "A B": 9, "B B": 2}


@pytest.fixture(scope="module", params=["dpd-vv", "shardlow"])
def heavy_and_light(request):
    """Beads of masses 1 and 5 with three frictions, and the same system with masses of 1."""
    return mixture(request.param, 0.01, UNEQUAL, TABLE), mixture(request.param, 0.01, EQUAL, TABLE)


@pytest.mark.thorough
def test_each_species_has_the_temperature(heavy_and_light):
    """<m v^2> / 3 is 1 for each within 5 standard errors (below 1 %) and 0.5 % for the scheme."""
    for found in heavy_and_light:
        mean, error = mean_and_error(found["of species"])
        assert (error < 0.01).all()
        assert (np.abs(mean - 1) < 0.005 + 5 * error).all()
        mean, error = mean_and_error(found["kT"])
        assert abs(mean - 1) < 0.005 + 5 * error


@pytest.mark.thorough
def test_structure_does_not_depend_on_masses(heavy_and_light):
    """Pressure and g(r) of both systems are the same within 5 standard errors of the difference.

    Errors of the pressure are below 0.1 %, those of g(r) beyond its core below 1 %.
    """
    for name, largest in (("excess_conservative", 0.001 * 23), ("rdf", 0.01)):
        (one, error), (other, more) = (mean_and_error(found[name]) for found in heavy_and_light)
        assert np.max(np.hypot(error, more)) < 2 * largest
        assert np.all(np.abs(one - other) < 5 * np.hypot(error, more) + 1e-12)


@pytest.mark.thorough
def test_kinetic_pressure_is_that_of_momenta(heavy_and_light):
    """The trace of the pressure tensor is rho kT and the excess; momentum is that at the start."""
    found = heavy_and_light[0]
    expected = 3 * found["kT"] + found["excess_conservative"]
    np.testing.assert_allclose(found["pressure"], expected, rtol=1e-12)
    assert np.abs(found["momentum"]).max() < 1e-9
