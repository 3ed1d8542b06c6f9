"""A run that breaks says where, and leaves what it had."""

from copy import deepcopy

import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Unstable
from tests.systems import (
    BOX_2D,
    BOX_3D,
    assert_same_state,
    make_simulation,
    make_system,
    random_beads,
)


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


def test_limit_is_the_cutoff():
    """24.9 times dt 0.04 is 0.996 r_c, 25.1 times is 1.004."""
    fast_bead(24.9).advance(5)
    with pytest.raises(Unstable):
        fast_bead(25.1).advance(5)


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


def test_state_stays_as_it_was():
    """All that a checkpoint holds, though some steps went well before the bad one."""
    simulation = doomed()
    before = deepcopy(simulation.state)
    with pytest.raises(Unstable) as caught:
        simulation.advance(1000)
    assert caught.value.step > before.step + 3
    assert_same_state(simulation.state, before)


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
