"""Constant pressure: step by step, to the same bits, and with the right forces."""

from dataclasses import replace

import numpy as np
import pytest

from dpd.engine import barostat
from dpd.engine.barostat import MOST_TIMES, stretched_box, stretched_state
from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.jit import COMPILES
from dpd.physics import pressure as pressure_page
from dpd.physics.pressure import Look, Pressure, draw
from tests.engine.reference_pressure import PressedReference
from tests.systems import (
    BOX_3D,
    assert_same_state,
    by_identity,
    chains,
    fewer_in_python,
    make_simulation,
    make_system,
    random_beads,
)

WIDE_2D = (5.1, 2.6)
WIDE_3D = (2.6, 3.7, 5.1)
TABLE = np.array([[25.0, 40.0, 10.0], [40.0, 30.0, 55.0], [10.0, 55.0, 15.0]])
# Of two, three, four and five steps, so that trials are neither every step nor a divisor of ten.
LAWS = {
    "3D": (WIDE_3D, Pressure(8.0, 0.5, 0.1, (0, 1, 2), 3)),
    "3D, z": (WIDE_3D, Pressure(8.0, 0.5, 0.1, (2,), 4)),
    "2D": (WIDE_2D, Pressure(30.0, 0.5, 0.03, (0, 1), 2)),
    "2D, x": (WIDE_2D, Pressure(30.0, 0.5, 0.03, (0,), 5)),
}


def fifty_beads(law, scheme="gw-vv", prediction=0.5, mixed=True, **changes):
    """A system at constant pressure, first places, velocities and species."""
    box, pressure = LAWS[law]
    species = None
    if mixed:
        species = np.random.default_rng(5).integers(0, 3, 50).astype(np.uint8)
        changes |= {"repulsion": TABLE, "bonds": (chains(8, 5), 60.0, 0.7)}
    changes = {"seed": 12, "dt": 0.02, "pressure": pressure} | changes
    system = make_system(box, scheme, prediction, **changes)
    position, velocity = random_beads(box, 50, seed=3)
    if mixed:
        for k in range(1, 40):
            if k % 5:  # a bead next to the one before it in its chain
                position[:, k] = position[:, k - 1] + 0.6 * np.sin(k + np.arange(len(box)))
        position %= np.array(box)[:, None]
    return system, position, velocity, species


BESIDE = [("gw-vv", 0.5, "3D", True)]
BESIDE += [("gw-vv", 0.65, law, mixed) for law in LAWS for mixed in (False, True)]
BESIDE += [("euler", 0.5, "3D", True), ("dpd-vv", 0.5, "3D", True)]
BESIDE += [("verlet-no-acceleration", 0.5, "2D", False)]


@pytest.mark.plain
@pytest.mark.parametrize("scheme, prediction, law, mixed", BESIDE)
def test_fifty_beads_step_beside_the_reference(scheme, prediction, law, mixed):
    """Boxes, places, velocities, forces and sums agree to 1e-9 over 40 steps."""
    system, position, velocity, species = fifty_beads(law, scheme, prediction, mixed)
    simulation = make_simulation(system, position, velocity, species)
    reference = PressedReference(system, scheme, prediction, position, velocity, species)
    for _ in range(fewer_in_python(40)):
        sums = simulation.advance_measured(1)
        reference.step()
        np.testing.assert_allclose(simulation.box, reference.system.box, rtol=1e-11)
        assert np.abs(simulation.unfolded - reference.position).max() < 1e-9
        for name in ("velocity", "force"):
            found, expected = by_identity(simulation, name), getattr(reference, name)
            assert np.abs(found - expected).max() < 1e-9 * max(1, np.abs(expected).max())
        scale = np.abs(reference.virial).max()
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * scale
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)
    assert reference.tried == simulation.state.step // system.pressure.every
    assert reference.accepted > 0 or not COMPILES


@pytest.mark.thorough
def test_reference_tries_in_vain_as_well():
    """A compressibility that is far too large: some trials count and some do not, in both."""
    system, position, velocity, species = fifty_beads("3D")
    system = replace(system, pressure=system.pressure._replace(compressibility=0.4))
    simulation = make_simulation(system, position, velocity, species)
    reference = PressedReference(system, "gw-vv", 0.5, position, velocity, species)
    for _ in range(60):
        simulation.advance(1)
        reference.step()
        np.testing.assert_allclose(simulation.box, reference.system.box, rtol=1e-10)
    assert 3 <= reference.accepted <= reference.tried - 3


SYSTEMS = {
    "cells": {},
    "list": {"skin": 0.2, "dt": 0.002},
    "langevin": {"per_bead": True},
    "gaussian": {"gaussian": True},
}


def other(scheme, threads=1, **changes):
    system, position, velocity, species = fifty_beads("3D", scheme, **changes)
    return make_simulation(system, position, velocity, species, threads=threads)


@pytest.mark.few(1)
@pytest.mark.parametrize("changes", SYSTEMS.values(), ids=SYSTEMS)
@pytest.mark.parametrize("scheme", ["gw-vv", "dpd-vv"])
def test_threads_and_calls_do_not_matter(scheme, changes):
    """To the last bit; trials lie between steps, wherever calls end."""
    one, two, four = (other(scheme, threads, **changes) for threads in (1, 2, 4))
    first = one.advance_measured(60)
    for steps in (1, 2, 4, 11, 30, 11, 1):
        last = two.advance_measured(steps)
    four.advance(59)
    four.advance(1)
    for simulation in (two, four):
        assert simulation.box == one.box != WIDE_3D
        assert_same_state(one.state, simulation.state)
    np.testing.assert_array_equal(first.virial, last.virial)
    np.testing.assert_array_equal(first.energy, last.energy)


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["shardlow", "lowe-andersen", "aboba"])
def test_calls_do_not_matter_where_momentum_is_exchanged(scheme):
    one, two = other(scheme), other(scheme)
    first = one.advance_measured(61)
    for steps in (2, 30, 29):
        last = two.advance_measured(steps)
    assert one.box == two.box != WIDE_3D
    assert_same_state(one.state, two.state)
    np.testing.assert_array_equal(first.virial, last.virial)


@pytest.mark.few(1)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("core", [None, (0.4, 200.0, 0.2)], ids=["soft", "core"])
def test_pressure_is_minus_the_derivative_of_the_energy(law, core):
    """-dH/dV at fixed scaled places and momenta, by central differences of 1e-6 of V.

    Their error is 1e-12 of the third derivative and 1e-10 of the energy over the step.
    """
    system, position, velocity, species = fifty_beads(law, core=core)
    simulation = make_simulation(system, position, velocity, species)
    box, volume = simulation.box, simulation.volume
    looks = []
    for times in (1 - 1e-6, 1.0, 1 + 1e-6):
        edges = stretched_box(box, system.pressure.axes, times)
        assert np.prod(edges) == pytest.approx(times * volume, rel=1e-14)
        there = Simulation(system, stretched_state(system, simulation.state, box, edges))
        looks.append(barostat.look_at(system, system.pressure, there.state, edges, there.measure()))
    slope = (looks[2].energy - looks[0].energy) / (looks[2].volume - looks[0].volume)
    assert looks[1].pressure == pytest.approx(-slope, rel=1e-6, abs=1e-6)


def test_one_axis_alone_is_stretched():
    """The others keep their bits."""
    system, position, velocity, species = fifty_beads("3D, z")
    simulation = make_simulation(system, position, velocity, species)
    simulation.advance(40)
    assert simulation.box[:2] == WIDE_3D[:2]
    assert simulation.box[2] != WIDE_3D[2]


def test_momentum_stays_at_zero():
    """Scaled with the velocities; 2400 additions of numbers of order 1, rounded by 2e-16."""
    system, position, velocity, species = fifty_beads("3D")
    simulation = make_simulation(system, position, velocity, species)
    simulation.advance(300)
    assert np.abs(simulation.state.velocity.sum(axis=1)).max() < 1e-11


@pytest.mark.thorough
def test_a_drift_is_no_pressure_and_stays():
    """The same volumes as at rest, to rounding; the centre of mass goes on as fast as before."""
    system, position, velocity, species = fifty_beads("3D", masses=np.array([1.0, 2.5, 0.5]))
    drift = np.array([[2.0], [-1.0], [0.5]])
    rest, drifting = (
        make_simulation(system, position, along, species) for along in (velocity, velocity + drift)
    )
    together = barostat.drift(system, drifting.state)
    for simulation in (rest, drifting):
        simulation.advance(system.pressure.every)
    assert rest.box != WIDE_3D
    np.testing.assert_allclose(drifting.box, rest.box, rtol=1e-12)
    np.testing.assert_allclose(barostat.drift(system, drifting.state), together, rtol=1e-12)


def test_detailed_balance_of_a_trial():
    """Delta changes its sign where the trial is turned around, and is that of its parts."""
    law = Pressure(3.0, 2.0, 0.3, (0, 1, 2), 5)
    here, there = Look(33.0, 3.4, 5.0), Look(35.0, 2.7, 4.4)
    change = law.change(here, there, 1.2, 0.2)
    assert change == pytest.approx(-law.change(there, here, 1.2, 0.2), abs=1e-12)
    # Without a drift there and back the proposal drops out.
    still = law._replace(target=3.0)
    one, other = (Look(v, 3.0 - 1.2 / (2 * v), e) for v, e in ((33.0, 5.0), (35.0, 4.4)))
    expected = (4.4 - 5.0 + 3.0 * 2.0) / 1.2 - np.log(35 / 33) / 2
    assert still.change(one, other, 1.2, 0.2) == pytest.approx(expected, abs=1e-12)


def test_random_numbers_of_trials():
    """A function of seed and step: others for others, and standard normal and uniform.

    Means of 4000 are within 4 standard errors.
    """
    assert draw(3, 10) == draw(3, 10)
    assert len({draw(3, 10), draw(3, 20), draw(4, 10)}) == 3
    assert draw(2**63 - 1, 10**12)
    found = np.array([draw(7, 10 * k) for k in range(4000)])
    assert abs(found[:, 0].mean()) < 4 / np.sqrt(4000)
    assert abs(found[:, 0].var() - 1) < 4 * np.sqrt(2 / 4000)
    assert abs(found[:, 1].mean() - 0.5) < 4 / np.sqrt(12 * 4000)
    assert (found[:, 1] > 0).all()
    assert abs(np.corrcoef(found[:-1, 0], found[1:, 0])[0, 1]) < 4 / np.sqrt(4000)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "target, sentence",
    [(1e-3, "empties the box"), (1e5, "is too high for it")],
)
def test_box_that_becomes_too_large_or_too_small(target, sentence):
    """One message, and the state as it was before the call."""
    law = Pressure(target, 0.1, 0.05, (0, 1, 2), 1)
    position, velocity = random_beads(BOX_3D, 50, seed=3)
    simulation = make_simulation(make_system(BOX_3D, pressure=law), position, velocity)
    kept = simulation.state
    with pytest.raises(UserError, match=sentence) as problem:
        simulation.advance(10_000)
    assert f"pressure.target {target:g}" in str(problem.value)
    assert simulation.state is kept


def test_start_in_a_box_that_is_too_small():
    """Of the state, not of the system."""
    system, position, velocity, species = fifty_beads("3D")
    state = make_simulation(system, position, velocity, species).state
    with pytest.raises(UserError, match=r"the box is 2\.6 x 3\.7 x 1\.9"):
        Simulation(system, stretched_state(system, state, WIDE_3D, (2.6, 3.7, 1.9)))


def test_scene_and_engine_have_the_same_limit():
    """The scene may not import the engine."""
    assert pressure_page.MOST_TIMES == MOST_TIMES
