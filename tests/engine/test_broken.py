"""Starts that no one should make, and runs that break: the right physics, or a clear error."""

from copy import deepcopy

import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Unstable
from dpd.engine.space import wrapped
from dpd.errors import UserError
from tests.engine.reference import Reference
from tests.systems import (
    BOX_2D,
    BOX_3D,
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    make_simulation,
    make_system,
    random_beads,
)

BOX = {2: (3.1, 2.5), 3: (2.5, 3.7, 4.0)}
BOTH = pytest.mark.parametrize(  # each kind of kernel takes a while to compile
    ("dimension", "skin"), [(3, 0.2), (2, 0.0)], ids=["3D, list", "2D, cells"]
)


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


def fast_bead(velocity):
    """Twenty beads at rest without forces but for bead 13, stored in another order."""
    position, _ = random_beads(BOX_3D, 20)
    order = np.random.default_rng(1).permutation(20)
    moving = np.zeros((3, 20))
    moving[1, order == 13] = velocity
    system = make_system(BOX_3D, repulsion=np.zeros((1, 1)), friction=0.0)
    return make_simulation(system, position, moving, identity=order)


def test_message_names_bead_step_and_remedy():
    simulation = fast_bead(-50.0)
    with pytest.raises(Unstable) as caught:
        simulation.advance(5)
    problem = caught.value
    assert (problem.bead, problem.step) == (13, 1)
    assert problem.distance == pytest.approx(2.0)
    for part in ("bead 13", "2 r_c", "step 1 ", "dt 0.04", "lower integrator.dt"):
        assert part in str(problem)


def test_not_a_number_is_noticed():
    """Of a run under way; a start with one is refused before."""
    simulation = fast_bead(0.0)
    simulation.state.velocity[1, simulation.state.identity == 13] = np.nan
    with pytest.raises(Unstable, match="bead 13 moved nan"):
        simulation.advance(5)


def doomed(scheme="gw-vv", dt=0.12):
    """A fluid after 10 good steps at dt 0.04 whose step is longer from now on."""
    position, velocity = random_beads(BOX_2D, 40, seed=1)
    calm = make_simulation(make_system(BOX_2D, scheme, dt=0.04), position, velocity)
    calm.advance(10)
    simulation = make_simulation(make_system(BOX_2D, scheme, dt=dt), position, velocity)
    simulation.state = calm.state
    return simulation


class Watch:
    """An observer that keeps the states it saw."""

    every = 2

    def __init__(self):
        self.arrays, self.seen = {}, []

    def sample(self, simulation):
        self.seen.append(deepcopy(simulation.state))


def test_run_that_breaks_leaves_its_last_checkpoint(tmp_path):
    """The file holds the state after the last stretch of steps that went well."""
    simulation, watch = doomed(), Watch()
    keeper = Checkpoint(tmp_path / "run.checkpoint", {})
    with pytest.raises(Unstable) as caught:
        run(simulation, (0, 1000), [watch], keeper, every_seconds=0.0)
    last = watch.seen[-1]
    assert last.step < caught.value.step <= last.step + watch.every
    revived = doomed()
    assert keeper.resume(revived, [Watch()]) == ""
    assert_same_state(revived.state, last)


class Record:
    """An observer that keeps the steps of the sums it got."""

    every, needs_forces = 2, True

    def __init__(self):
        self.arrays, self.seen = {}, []

    def record(self, sums):
        self.seen += list(sums.step)


@pytest.mark.few(1)
@pytest.mark.parametrize(("scheme", "dt"), [("gw-vv", 0.12), ("aboba", 0.17)])
def test_sums_before_a_run_breaks_are_kept(scheme, dt):
    """All of them, also of a scheme that is measured in calls of their own; the state as well."""
    simulation, record = doomed(scheme, dt), Record()
    before = simulation.state
    with pytest.raises(Unstable) as caught:
        simulation.sample(1000, range(before.step + 1, before.step + 1001), measure=True)
    assert simulation.state is before
    with pytest.raises(Unstable):
        run(simulation, (before.step, 1000), [record])
    assert record.seen == list(range(before.step + 2, caught.value.step, 2)) != []
