"""Starts that no one should make: each gives the right physics or a clear error."""

import numpy as np
import pytest

from dpd.engine.space import wrapped
from dpd.errors import UserError
from tests.engine.reference import Reference
from tests.systems import (
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    make_simulation,
    make_system,
    random_beads,
)

BOX = {2: (3.1, 2.5), 3: (2.5, 3.7, 4.0)}
SEARCHES = pytest.mark.parametrize("skin", [0.0, 0.2], ids=["cells", "list"])
DIMENSIONS = pytest.mark.parametrize("dimension", [2, 3])
BOTH = pytest.mark.parametrize(  # each kind of kernel takes a while to compile
    ("dimension", "skin"), [(3, 0.2), (2, 0.0)], ids=["3D, list", "2D, cells"]
)
CROWD = 3000


def at_one_point(dimension, count):
    """Beads in the middle of the box, with random velocities."""
    _, velocity = random_beads(BOX[dimension], count)
    middle = np.array(BOX[dimension])[:, None] / 2
    return np.repeat(middle, count, axis=1), velocity


@pytest.mark.few(1)
@BOTH
def test_all_beads_on_one_point(dimension, skin):
    """No direction to push in, so no force; then they part as the reference's beads do."""
    position, velocity = at_one_point(dimension, 40)
    system = make_system(BOX[dimension], dt=0.01, skin=skin)
    simulation = make_simulation(system, position, velocity)
    np.testing.assert_allclose(by_identity(simulation, "force"), 0.0, atol=1e-9)
    with np.errstate(invalid="ignore"):
        reference = Reference(system, "gw-vv", 0.5, position, velocity)
    assert not np.isfinite(reference.force).all()  # 0 / 0 in the equations as written
    reference.force[:] = 0.0
    for _ in range(40):
        simulation.advance(1)
        reference.step()
    place = by_identity(simulation, "position")
    assert_same_place(place, reference.position, system.box, 1e-8)


@pytest.mark.few(1)
@SEARCHES
def test_a_crowd_on_one_point(skin):
    """Thousands of beads in one cell, a step short enough for their friction: momentum stays."""
    position, velocity = at_one_point(3, CROWD)
    simulation = make_simulation(make_system(BOX[3], dt=1e-5, skin=skin), position, velocity)
    simulation.advance(5)
    assert np.isfinite(simulation.state.position).all()
    assert np.abs(simulation.state.velocity.sum(axis=1)).max() < 1e-9 * CROWD


@pytest.mark.few(1)
@BOTH
def test_two_beads_at_one_place(dimension, skin):
    """At rest they stay, bonded or not; a third beside them is pushed by both alike."""
    position = np.full((dimension, 3), 1.0)
    position[0, 2] = 1.5
    still = np.zeros((dimension, 3))
    for bonds in (None, (np.array([[0, 1]], np.uint32), 100.0, 0.5)):
        system = make_system(BOX[dimension], kT=0.0, skin=skin, bonds=bonds)
        force = by_identity(make_simulation(system, position, still), "force")
        expected = np.zeros((dimension, 3))
        expected[0] = [-12.5, -12.5, 25.0]
        np.testing.assert_allclose(force, expected, atol=1e-9)


@pytest.mark.few(1)
@BOTH
def test_a_bond_of_half_the_box(dimension, skin):
    """Either image is right: the pull has its size, both ends feel it, momentum stays."""
    box = BOX[dimension]
    position = np.zeros((dimension, 2))
    position[0] = [0.25, 0.25 + box[0] / 2]
    bonds = (np.array([[0, 1]], np.uint32), 10.0, 0.5)
    system = make_system(box, kT=0.0, skin=skin, bonds=bonds, dt=0.001)
    simulation = make_simulation(system, position, np.zeros((dimension, 2)))
    force = by_identity(simulation, "force")
    pull = 10.0 * (box[0] / 2 - 0.5)
    np.testing.assert_allclose(np.abs(force[0]), pull, rtol=1e-12)
    simulation.advance(100)
    np.testing.assert_allclose(simulation.state.velocity.sum(axis=1), 0.0, atol=1e-12)


@BOTH
def test_one_bead_alone(dimension, skin):
    """It flies straight through the box, meets nobody, and has no virial."""
    velocity = np.full((dimension, 1), 0.7)
    system = make_system(BOX[dimension], skin=skin)
    simulation = make_simulation(system, np.ones((dimension, 1)), velocity)
    sums = simulation.advance_measured(300)
    straight, _ = wrapped(1.0 + 300 * system.dt * velocity, system.box)
    assert_same_place(simulation.state.position, straight, system.box, 1e-12)
    np.testing.assert_array_equal(simulation.state.velocity, velocity)
    assert not sums.virial.any() and not sums.energy.any()


@pytest.mark.thorough
def test_a_species_without_beads():
    """A table with more species than there are beads of changes nothing."""
    position, velocity = random_beads(BOX[3], 60)
    table = np.full((3, 3), 25.0)
    first = np.zeros(60, np.uint8)
    one = make_simulation(make_system(BOX[3]), position, velocity)
    other = make_simulation(make_system(BOX[3], repulsion=table), position, velocity, first)
    for simulation in (one, other):
        simulation.advance(50)
    for name in ("position", "velocity", "force"):
        np.testing.assert_allclose(by_identity(one, name), by_identity(other, name), rtol=1e-9)


@pytest.mark.few(1)
@BOTH
def test_coordinates_far_outside_the_box(dimension, skin):
    """They are those of their image inside, to what is left of their digits."""
    system = make_system(BOX[dimension], skin=skin, bonds=(chains(10, 4), 40.0, 0.7), dt=0.01)
    position, velocity = random_beads(BOX[dimension], 60)
    boxes = np.random.default_rng(2).integers(-1000, 1000, position.shape)
    far = position + boxes * np.array(BOX[dimension])[:, None]
    inside = make_simulation(system, wrapped(far, system.box)[0], velocity)
    outside = make_simulation(system, far, velocity)
    for simulation in (inside, outside):
        simulation.advance(30)
    assert_same_state(inside.state, outside.state)
    assert_same_place(far, position, system.box, 1e-9)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["position", "velocity"])
def test_beads_that_are_nowhere(name, value):
    """Named with their number, before anything moves."""
    start = dict(zip(("position", "velocity"), random_beads(BOX[3], 20)))
    start[name][1, 7] = value
    with pytest.raises(UserError, match=f"bead 7 .*{name}"):
        make_simulation(make_system(BOX[3]), **start)


@pytest.mark.few(3)
@DIMENSIONS
@pytest.mark.parametrize("edge", [2.0, 2.3, 3.0, 4.0])
def test_boxes_of_two_to_four_cutoffs(dimension, edge):
    """Each pair once at its nearest image, as in the reference."""
    box = (edge,) * dimension
    system = make_system(box, dt=0.01)
    position, velocity = random_beads(box, 40, seed=3)
    simulation = make_simulation(system, position, velocity)
    reference = Reference(system, "gw-vv", 0.5, position, velocity)
    for _ in range(20):
        simulation.advance(1)
        reference.step()
    assert_same_place(by_identity(simulation, "position"), reference.position, box, 1e-9)
