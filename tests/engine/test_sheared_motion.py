"""Steady shear: beside the plain reference, and what must hold in any flow."""

from dataclasses import replace

import numpy as np
import pytest

from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation, Unstable
from dpd.engine.space import nearest
from dpd.jit import COMPILES
from dpd.observe.common.measured import Measured, observables
from dpd.observe.displacement import Displacement
from dpd.physics.shear import Shear
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.engine.reference import Reference, flow_of
from tests.systems import (
    assert_same_state,
    by_identity,
    chains,
    fewer_in_python,
    make_simulation,
    make_system,
    random_beads,
)

# The rows of cells run along the last axis.
BOXES = {
    "2D": ((5.1, 2.2), Shear(2.3, 0, 1)),
    "3D": ((3.1, 3.7, 5.1), Shear(1.3, 0, 1)),
    "3D, gradient along rows": ((3.1, 2.2, 3.7), Shear(-1.3, 0, 2)),
    "3D, flow across layers": ((2.2, 3.1, 3.7), Shear(1.3, 1, 2)),
    "3D, tilt of two": ((9.1, 2.2, 2.2), Shear(4.0, 0, 1)),
}
KINDS = ["one species", "species and bonds", "each bead with a bath"]
# Scheme, lambda, kind of beads, and boxes: each kind of kernel takes a while to compile.
CASES = [
    *[("gw-vv", 0.5, KINDS[1], box) for box in BOXES],
    *[("dpd-vv", 0.5, KINDS[1], box) for box in ("3D", "3D, gradient along rows")],
    ("euler", 0.5, KINDS[0], "3D, flow across layers"),
    ("verlet-no-acceleration", 0.5, KINDS[0], "3D, tilt of two"),
    ("gw-vv", 0.65, KINDS[0], "3D"),
    ("gw-vv", 0.5, KINDS[2], "3D"),
]


def fifty_beads(box, shear, scheme, prediction, kind):
    """The same 50 beads for the engine and for the reference."""
    species, changes = None, {"per_bead": kind == KINDS[2]}
    if kind == KINDS[1]:
        species = (np.arange(50) % 2).astype(np.uint8)
        table = np.array([[25.0, 40.0], [40.0, 30.0]])
        changes = {"repulsion": table, "bonds": (chains(8, 5), 60.0, 0.4)}
    system = make_system(box, scheme, prediction, dt=0.02, seed=12, shear=shear, **changes)
    position, velocity = random_beads(box, 50, seed=3)
    if kind == KINDS[1]:
        for k in range(1, 40):
            if k % 5:  # a bead next to the one before it in its chain
                way = np.sin(k + np.arange(len(box)))
                position[:, k] = position[:, k - 1] + 0.4 * way / np.linalg.norm(way)
        position %= np.array(box)[:, None]
    return (
        make_simulation(system, position, velocity, species),
        Reference(system, scheme, prediction, position, velocity, species),
    )


@pytest.mark.plain
@pytest.mark.parametrize("scheme, prediction, kind, box", CASES)
def test_fifty_beads_step_beside_the_reference(scheme, prediction, box, kind):
    """Sixty steps, in which images slide by more than a whole edge.

    The reference has velocities of the laboratory, which jump where a bead meets an image above.
    Places, which go on through all images, ways by themselves along the flow, velocities about it,
    forces, virials and energies agree to 1e-9.
    """
    simulation, reference = fifty_beads(*BOXES[box], scheme, prediction, kind)
    (edges, shear), tilts, by_itself = BOXES[box], [], 0.0
    for _ in range(fewer_in_python(60)):
        before = reference.position.copy()
        sums = simulation.advance_measured(1)
        reference.step()
        middle = 0.5 * (before + reference.position)
        carried = 0.02 * flow_of(simulation.system, middle)
        by_itself += (reference.position - before - carried)[shear.flow]
        assert np.abs(by_identity(simulation, "peculiar") - by_itself).max() < 1e-9
        assert np.abs(simulation.unfolded - reference.position).max() < 1e-9
        lab = by_identity(simulation, "velocity") + flow_of(reference.system, reference.position)
        assert np.abs(lab - reference.velocity).max() < 1e-9
        force = by_identity(simulation, "force")
        assert np.abs(force - reference.force).max() < 1e-9 * np.abs(reference.force).max()
        scale = np.abs(reference.virial).max()
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * scale
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)
        tilts.append(simulation.box.tilt)
    if not COMPILES:
        return
    assert max(tilts) - min(tilts) > 0.9 * edges[shear.flow] / edges[shear.gradient]
    assert min(np.diff(tilts)) < 0 < max(np.diff(tilts))


@pytest.mark.thorough
def test_free_beads_move_as_without_flow():
    """Without forces a bead moves in a straight line of the laboratory, through any image."""
    box, rate, dt, steps = (3.0, 2.5), -0.7, 0.05, 400
    system = make_system(
        box, friction=0.0, repulsion=np.zeros((1, 1)), dt=dt, shear=Shear(rate, 0, 1)
    )
    position, velocity = random_beads(box, 30, seed=2)
    velocity *= 0.25  # about the flow it grows with time
    lab = velocity + flow_of(system, position)
    simulation = make_simulation(system, position, velocity)
    simulation.advance(steps)
    there = position + steps * dt * lab
    apart = by_identity(simulation, "position") - there
    assert np.abs(nearest(apart, simulation.box)).max() < 1e-11
    about = lab - flow_of(system, there)
    assert np.abs(by_identity(simulation, "velocity") - about).max() < 1e-11


@pytest.mark.thorough
def test_a_fast_flow_is_not_a_run_that_blows_up():
    """At the top the flow takes beads along by 0.96 r_c a step; they may move another 0.99."""
    box = (30.0, 24.0)
    system = make_system(
        box, friction=0.0, repulsion=np.zeros((1, 1)), dt=0.04, shear=Shear(1.0, 0, 1)
    )
    position = np.array([[1.0, 2.0], [23.9, 12.0]])
    make_simulation(system, position, np.array([[24.7, 0.0], [0.0, 0.0]])).advance(20)
    with pytest.raises(Unstable, match="bead 1 moved 1 r_c"):
        make_simulation(system, position, np.array([[0.0, 25.1], [0.0, 0.0]])).advance(1)


def bonded(box, shear, seed=7, **changes):
    """Chains of two species in a flow, moved to a tilt."""
    system = make_system(
        box, repulsion=np.array([[25.0, 40.0], [40.0, 30.0]]), bonds=(chains(8, 5), 20.0, 0.4),
        shear=shear, **changes,
    )  # fmt: skip
    position, velocity = random_beads(box, 120, seed)
    for k in range(1, 40):
        if k % 5:
            way = np.sin(k + np.arange(len(box)))
            position[:, k] = position[:, k - 1] + 0.4 * way / np.linalg.norm(way)
    return make_simulation(system, position, velocity, (np.arange(120) % 2).astype(np.uint8))


@pytest.mark.thorough
@pytest.mark.parametrize("box", BOXES)
def test_the_force_is_the_slope_of_the_energy(box):
    """Of pairs and bonds across images that have slid, by differences over 2e-5 r_c."""
    simulation = bonded(*BOXES[box], friction=0.0, dt=0.01)
    simulation.advance(31)
    assert abs(simulation.box.tilt) > 0.05
    force, state = simulation.state.force, simulation.state
    near_faces = np.argsort(state.position[simulation.system.shear.gradient])[[0, 1, 2, -2, -1]]
    for bead in near_faces:
        for axis in range(len(state.position)):
            energies = []
            for nudge in (1e-5, -1e-5):
                kept = state.position[axis, bead]
                state.position[axis, bead] += nudge
                energies.append(simulation.measure().energy.sum())
                state.position[axis, bead] = kept
            slope = (energies[0] - energies[1]) / 2e-5
            assert -slope == pytest.approx(force[axis, bead], rel=1e-4, abs=1e-3)


@pytest.mark.thorough
def test_work_of_the_flow_becomes_energy():
    """Without thermostat: energy about the flow grows by minus rate times V P_xy.

    Over 4 tau, the work by the trapezoidal rule; at dt 0.004 they differ by 3e-5 of the work.
    """
    rate, dt, box = 0.9, 0.004, (4.0, 3.5, 3.0)
    calm = bonded(box, Shear(rate, 0, 1), dt=0.01)
    calm.advance(200)
    system = replace(calm.system, friction=0.0, dt=dt)
    calm.state.force, calm.state.slid, calm.state.step = None, calm.box.slid, 0
    simulation = Simulation(system, calm.state)
    powers, energies = [], []
    for _ in range(round(4.0 / dt)):
        sums = simulation.advance_measured(1)
        u = simulation.state.velocity
        powers.append(-rate * (u[0] @ u[1] + sums.virial[0, 0, 1]))
        energies.append(0.5 * np.sum(u**2) + sums.energy.sum())
    work = dt * (np.sum(powers) - 0.5 * (powers[0] + powers[-1]))
    assert work > 50
    assert energies[-1] - energies[0] == pytest.approx(work, rel=5e-4)


@pytest.mark.few(1)
@pytest.mark.parametrize(("scheme", "box"), [("gw-vv", "2D"), ("dpd-vv", "3D")])
def test_threads_do_not_change_a_bit(scheme, box):
    """Nor does it when steps are done in several calls, or measured."""
    (edges, shear), states, sums = BOXES[box], [], []
    edges = tuple(3 * edge for edge in edges)
    for threads, calls in ((1, (40,)), (2, (40,)), (4, (13, 1, 26)), (1, (1,) * 40)):
        system = make_system(
            edges, scheme, dt=0.02, repulsion=np.array([[25.0, 40.0], [40.0, 30.0]]),
            bonds=(chains(20, 10), 30.0, 0.4), shear=shear,
        )  # fmt: skip
        start = *random_beads(edges, 600, seed=5), (np.arange(600) % 2).astype(np.uint8)
        simulation = make_simulation(system, *start, threads=threads)
        for steps in calls[:-1]:
            simulation.advance(steps)
        sums.append(simulation.advance_measured(calls[-1]))
        states.append(simulation.state)
    for state, found in zip(states[1:], sums[1:]):
        assert_same_state(state, states[0])
        np.testing.assert_array_equal(found.virial, sums[0].virial)
        np.testing.assert_array_equal(found.energy, sums[0].energy)


SCENE = {
    "dimension": 3,
    "box": [4.0, 5.0, 4.5],
    "molecules": [{"architecture": "A 3 B", "count": 40}, {"architecture": "B", "count": 80}],
    "repulsion": {"A A": 25, "A B": 40, "B B": 30},
    "bond": {"stiffness": 30, "length": 0.4},
    "integrator": {"scheme": "dpd-vv", "dt": 0.03},
    "shear": {"rate": 0.4},
    "steps": {"equilibrate": 520, "sample": 200},
    "observe": [
        {"thermo": {"every": 5}},
        {"rdf": {"every": 20, "range": 2}},
        {"profile": {"every": 20}},
        {"bonds": {"every": 20}},
        {"chains": {"every": 20}},
        {"end_to_end": {"every": 5}},
        {"displacement": {"every": 5}},
        {"configuration": {"every": 200}},
    ],
}


@pytest.mark.thorough
def test_an_interrupted_run_goes_on_to_the_same_bits(tmp_path):
    """State and all observables; how far images have slid follows from the step."""

    class Stop(Exception):
        pass

    def stop(step):
        if step >= 600:
            raise Stop

    def new(threads):
        scene = Scene(SCENE)
        system = system_of(scene)
        simulation = Simulation(system, make_start(scene), threads)
        return simulation, scene.steps, observables(scene, system)

    whole, steps, seen = new(1)
    run(whole, steps, seen)
    broken, _, partly = new(2)
    with pytest.raises(Stop):
        run(broken, steps, partly, Checkpoint(tmp_path / "c", {}), stop, 0.0)
    again, _, found = new(3)
    assert run(again, steps, found, Checkpoint(tmp_path / "c", {})) < 200
    assert_same_state(whole.state, again.state)
    for one, other in zip(seen, found):
        for name, array in one.arrays.items():
            np.testing.assert_array_equal(other.arrays[name], array, err_msg=name)


@pytest.mark.thorough
def test_displacement_is_that_about_the_flow():
    """Free beads: along the flow the integral of u_x = u_x(0) - g u_y t, which is exact here."""
    rate, dt, every = 0.6, 0.02, 5
    scene = Scene({
        "dimension": 2,
        "box": [4.0, 3.0],
        "molecules": [{"architecture": "A", "count": 12}],
        "repulsion": {"A A": 0},
        "thermostat": {"gamma": 0},
        "integrator": {"scheme": "gw-vv", "dt": dt},
        "shear": {"rate": rate},
        "steps": {"sample": 400},
        "observe": [{"displacement": {"every": every}}],
    })  # fmt: skip
    system = system_of(scene)
    simulation = Simulation(system, make_start(scene))
    watch = Measured(Displacement(every=every), scene, system)
    simulation.advance(every)
    watch.sample(simulation)
    x, y = by_identity(simulation, "velocity").copy()
    for _ in range(40):
        simulation.advance(every)
        watch.sample(simulation)
    t = 40 * every * dt
    expected = np.stack([x * t - rate * y * t**2 / 2, y * t])
    place = np.stack([by_identity(simulation, "peculiar"), simulation.unfolded[1]])
    np.testing.assert_allclose(place - watch.arrays["begun"], expected, rtol=0, atol=1e-10)


@pytest.mark.thorough
def test_langevin_holds_kT_about_the_flow():
    """An ideal gas in a fast flow, within 5 standard errors of 4000 beads: kT along y and z.

    Along the flow -g u_y drives a bead: from du_x/dt = -g u_y - gamma u_x + noise follow
    <u_x u_y> = -g kT / (2 gamma) and <u_x^2> = kT (1 + (g / gamma)^2 / 2), 20 errors from kT.
    """
    rate, gamma, beads = 2.0, 2.0, 4000
    system = make_system(
        (12.0, 12.0, 12.0), friction=gamma, repulsion=np.zeros((1, 1)), dt=0.01, gaussian=True,
        per_bead=True, shear=Shear(rate, 0, 1),
    )  # fmt: skip
    simulation = make_simulation(system, *random_beads(system.box, beads, seed=9))
    simulation.advance(400)
    u = simulation.state.velocity
    expected = np.array([1 + (rate / gamma) ** 2 / 2, 1.0, 1.0])
    error = np.sqrt(2 / beads) * expected
    assert (np.abs((u**2).mean(axis=1) - expected) < 5 * error).all()
    cross = -rate / (2 * gamma)
    assert abs((u[0] * u[1]).mean() - cross) < 5 * np.sqrt((expected[0] + cross**2) / beads)
