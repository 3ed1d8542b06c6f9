"""Rigid cores, and the pair list that small time steps run on."""

from functools import partial

import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.observe.common.measured import observables
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
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

CORE = (0.3, 100.0, None)
BOX = {2: (5.1, 2.5), 3: (2.5, 3.7, 5.1)}
# dimension, species and bonds, core, skin
SMOOTH_CORE = (0.3, 100.0, 0.1)
VARIANTS = [
    (2, True, CORE, 0.2),
    (2, True, CORE, 0.0),
    (2, True, SMOOTH_CORE, 0.2),
    (3, False, None, 0.2),
]


def beads(dimension, mixed, core, skin, dt=0.01):
    """The same 50 beads for the engine and for the reference."""
    box, species, changes = BOX[dimension], None, {}
    if mixed:
        species = (np.arange(50) % 2).astype(np.uint8)
        table = np.array([[25.0, 40.0], [40.0, 30.0]])
        changes = {"repulsion": table, "bonds": (chains(8, 5), 60.0, 0.7)}
    system = make_system(box, "gw-vv", 0.5, dt=dt, core=core, skin=skin, **changes)
    position, velocity = random_beads(box, 50, seed=8)
    simulation = make_simulation(system, position, velocity, species)
    return simulation, Reference(system, "gw-vv", 0.5, position, velocity, species)


@pytest.mark.few(1)
@pytest.mark.parametrize("variant", VARIANTS, ids=str)
def test_fifty_beads_step_beside_the_reference(variant):
    """Forty steps, several of them with a new list, agree to 1e-9 like those of the cells."""
    simulation, reference = beads(*variant)
    lists = []
    for _ in range(40):
        sums = simulation.advance_measured(1)
        reference.step()
        place = by_identity(simulation, "position")
        assert_same_place(place, reference.position, simulation.system.box, 1e-9)
        scale = max(1, np.abs(reference.force).max())
        assert np.abs(by_identity(simulation, "force") - reference.force).max() < 1e-9 * scale
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * np.abs(reference.virial).max()
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)
        lists.append(
            None if simulation.state.reference is None else simulation.state.reference[0, 0]
        )
    if simulation.system.skin:
        assert 1 < len(set(lists)) < 40


def force_and_energy(core, r):
    """Of two beads at rest with that core, a distance r apart along the first axis."""
    system = make_system((5.0, 5.0), friction=0.0, core=core)
    position = np.array([[1.0, 1.0 + r], [2.0, 2.0]])
    simulation = make_simulation(system, position, np.zeros((2, 2)))
    return by_identity(simulation, "force")[0, 1], simulation.measure().energy[0]


@pytest.mark.thorough
def test_two_beads_meet_at_a_core():
    """F_max below the diameter, a (1 - r) above it, -dU/dr everywhere else than at the jump."""
    pair = partial(force_and_energy, CORE)
    for r in (0.05, 0.2, 0.299, 0.301, 0.5, 0.99):
        expected = 100.0 if r < 0.3 else 25.0 * (1 - r)
        slope = (pair(r + 1e-6)[1] - pair(r - 1e-6)[1]) / 2e-6
        assert pair(r)[0] == pytest.approx(expected, rel=1e-12)
        assert -slope == pytest.approx(expected, rel=1e-6)
    assert pair(1.01) == (0.0, 0.0)


@pytest.mark.thorough
def test_two_beads_meet_at_a_smooth_core():
    """A straight line from F_max at the diameter to a (1 - r) at the end of the width."""
    pair = partial(force_and_energy, SMOOTH_CORE)
    for r in (0.05, 0.299, 0.301, 0.35, 0.399, 0.401, 0.7, 0.99):
        expected = np.interp(r, [0.3, 0.4, 1.0], [100.0, 15.0, 0.0])
        slope = (pair(r + 1e-6)[1] - pair(r - 1e-6)[1]) / 2e-6
        assert pair(r)[0] == pytest.approx(expected, rel=1e-12)
        assert -slope == pytest.approx(expected, rel=1e-6)
    # No jump of the energy anywhere.
    energies = [pair(r)[1] for r in np.linspace(0.29, 0.41, 121)]
    assert np.abs(np.diff(energies)).max() < 0.101


@pytest.mark.thorough
def test_ten_steps_are_three_and_seven_with_a_list():
    """Bit for bit, whether or not the list is made anew at the start of a call."""
    one, other = (beads(*VARIANTS[1])[0] for _ in range(2))
    one.advance(40)
    for steps in (13, 1, 26):
        other.advance(steps)
    assert_same_state(one.state, other.state)
    np.testing.assert_array_equal(one.state.reference, other.state.reference)


SCENE = {
    "dimension": 2,
    "box": [6.0, 6.25],
    "molecules": [{"architecture": "A 4 B", "density": 2}],
    "repulsion": {"A A": 25, "A B": 40, "B B": 30},
    "core": {"radius": 0.15, "force": 100},
    "bond": {"stiffness": 300, "length": 0.3},
    "integrator": {"scheme": "gw-vv", "lambda": 0.65, "dt": 0.002},
    "start": {"relax": {"steps": 200, "dt": 0.001}},
    "steps": {"equilibrate": 500, "sample": 700},
    "observe": [{"thermo": {"every": 50}}],
}


@pytest.mark.thorough
def test_an_interrupted_run_with_a_list_goes_on_to_the_same_bits(tmp_path):
    """The checkpoint keeps the reference that the list follows from."""

    def new():
        scene = Scene(SCENE)
        system = system_of(scene)
        assert system.skin > 0 and system.pair[1:] == (0.3, 100.0, None)
        from dpd.engine.simulation import Simulation

        return Simulation(system, make_start(scene)), observables(scene, system), scene.steps

    whole, seen, steps = new()
    run(whole, steps, seen)

    class Stop(Exception):
        pass

    def stop(step):
        if step >= 800:
            raise Stop

    broken, partly, _ = new()
    with pytest.raises(Stop):
        run(broken, steps, partly, Checkpoint(tmp_path / "c", {}), stop, 0.0)
    again, found, _ = new()
    assert run(again, steps, found, Checkpoint(tmp_path / "c", {})) < sum(steps)
    assert_same_state(whole.state, again.state)
    for name, array in seen[0].arrays.items():
        np.testing.assert_array_equal(found[0].arrays[name], array)


@pytest.mark.parametrize(
    ("dt", "edge", "search", "skin"),
    [
        (0.001, 6.0, "auto", 0.15),
        (0.04, 6.0, "auto", 0.0),
        (0.001, 2.24, "auto", 0.0),
        (0.001, 6.0, "cells", 0.0),
        (0.04, 6.0, "list", 0.15),
    ],
)
def test_the_scene_chooses_its_search(dt, edge, search, skin):
    """A list where beads hardly move and the box holds two reaches of it; or as asked."""
    plain = {key: SCENE[key] for key in ("dimension", "repulsion", "steps", "observe")}
    molecules = [{"architecture": "A", "density": 2}, {"architecture": "B", "density": 2}]
    scene = Scene(
        plain
        | {"box": edge, "molecules": molecules, "pairs": {"search": search}}
        | {"integrator": {"scheme": "gw-vv", "dt": dt}}
    )
    assert system_of(scene).skin == skin
