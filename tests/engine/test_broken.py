"""Starts that no one should make, and runs that break: the right physics, or a clear error."""

from types import SimpleNamespace

import numpy as np
import pytest

from dpd.engine.loop import Checkpoint, run
from dpd.engine.space import wrapped
from dpd.errors import LostRun
from tests.systems import (
    BOX_2D,
    BOX_3D,
    assert_same_place,
    assert_same_state,
    by_identity,
    chains,
    fewer_in_python,
    make_simulation,
    make_system,
    random_beads,
)

BOX = {2: (3.1, 2.5), 3: (2.5, 3.7, 4.0)}
BOTH = pytest.mark.parametrize(
    ("dimension", "skin"), [(3, 0.2), (2, 0.0)], ids=["3D, list", "2D, cells"]
)
pytestmark = pytest.mark.plain


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
        simulation.advance(fewer_in_python(30))
    assert_same_state(inside.state, outside.state)
    assert_same_place(far, position, system.box, 1e-9)


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
    with pytest.raises(LostRun) as caught:
        simulation.advance(5)
    assert caught.value.step == 1
    for part in ("bead 13", " 2 r_c", "step 1 ", "dt 0.04", "lower integrator.dt"):
        assert part in str(caught.value)


def test_not_a_number_is_noticed():
    """Of a run under way; a start with one is refused before."""
    simulation = fast_bead(0.0)
    simulation.state.velocity[1, simulation.state.identity == 13] = np.nan
    with pytest.raises(LostRun, match="bead 13 moved nan"):
        simulation.advance(5)


def doomed(scheme="gw-vv", dt=0.12):
    """A fluid after 10 good steps at dt 0.04 whose step is longer from now on."""
    position, velocity = random_beads(BOX_2D, 40, seed=1)
    calm = make_simulation(make_system(BOX_2D, scheme, dt=0.04), position, velocity)
    calm.advance(10)
    simulation = make_simulation(make_system(BOX_2D, scheme, dt=dt), position, velocity)
    simulation.state = calm.state
    return simulation


@pytest.mark.parametrize(("scheme", "dt"), [("gw-vv", 0.12), ("aboba", 0.17)])
def test_what_went_well_before_a_run_breaks_is_kept(tmp_path, scheme, dt):
    """All sums, also of a scheme that is measured in calls of its own; state and checkpoint."""
    simulation, steps, seen = doomed(scheme, dt), [], []
    before = simulation.state
    with pytest.raises(LostRun) as caught:
        simulation.sample(1000, range(before.step + 1, before.step + 1001), measure=True)
    assert simulation.state is before
    record = SimpleNamespace(
        every=2, needs_forces=True, arrays={}, record=lambda sums: steps.extend(sums.step)
    )
    with pytest.raises(LostRun):
        run(simulation, (before.step, 1000), [record])
    assert steps == list(range(before.step + 2, caught.value.step, 2)) != []
    watch = SimpleNamespace(every=2, arrays={}, sample=lambda there: seen.append(there.state))
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", {})
    with pytest.raises(LostRun):
        run(doomed(scheme, dt), (0, 1000), [watch], checkpoint, every_seconds=0.0)
    assert seen[-1].step < caught.value.step <= seen[-1].step + watch.every
    revived = doomed(scheme, dt)
    assert checkpoint.resume(revived, [watch]) == ""
    assert_same_state(revived.state, seen[-1])
