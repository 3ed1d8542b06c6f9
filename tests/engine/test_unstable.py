"""A run that breaks says where, and leaves what it had."""

from copy import deepcopy

import numpy as np
import pytest

from dpd.engine.loop import Checkpoint, run
from dpd.engine.simulation import Unstable
from tests.engine.build import (
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
    with pytest.raises(Unstable, match="bead 13 is nowhere"):
        fast_bead(np.nan).advance(5)


@pytest.fixture
def doomed():
    """A fluid that goes well for 10 steps at dt 0.04, and then on at a huge step."""

    def build(dt):
        position, velocity = random_beads(BOX_2D, 40)
        simulation = make_simulation(make_system(BOX_2D, dt=0.04), position, velocity)
        simulation.advance(10)
        broken = make_simulation(make_system(BOX_2D, dt=dt), position, velocity)
        broken.state = deepcopy(simulation.state)
        return broken

    return build


def test_state_stays_as_it_was(doomed):
    """All that a checkpoint holds, even when some steps went well before the bad one."""
    simulation = doomed(DT)
    before = deepcopy(simulation.state)
    with pytest.raises(Unstable) as caught:
        simulation.advance(1000)
    assert caught.value.step > before.step + 3
    assert_same_state(simulation.state, before)


def test_huge_step_breaks_in_the_loop_and_leaves_the_last_checkpoint(doomed, tmp_path):
    """Progress was seen for every stretch but the last, the file holds the last of them."""
    simulation, seen = doomed(DT), []
    keeper = Checkpoint(tmp_path / "run.checkpoint", {})

    class Often:
        every, needs_forces, arrays = 2, False, {}  # noqa: RUF012

        def sample(self, simulation, sums):
            seen.append(deepcopy(simulation.state))

    with pytest.raises(Unstable) as caught:
        run(simulation, (0, 1000), [Often()], keeper, every_seconds=0.0)
    assert seen[-1].step < caught.value.step <= seen[-1].step + 2
    revived = doomed(DT)
    keeper.resume(revived, [])
    assert_same_state(revived.state, seen[-1])
