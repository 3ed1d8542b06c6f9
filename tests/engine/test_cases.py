"""Every kind of system: beside the plain reference, and what holds for all of them."""

from dataclasses import replace

import numpy as np
import pytest

from dpd.engine.stress import at_beads, force_and_curvature
from dpd.jit import COMPILES
from tests.engine.cases import CASES, SPLIT, beside, simulation_of
from tests.engine.reference import flow_of
from tests.systems import assert_same_state, by_identity, fewer_in_python, unfolded_places

NUDGE = 3e-5  # r_c: few pairs cross the cutoff, and rounding is small in second differences
# With few kernels, which tests below and in other files share.
FEW = (
    "gw-vv", "lambda 0.65, gaussian", "dpd-vv, 2D, list", "core, list", "bath, list",
    "by species, dpd-vv, list", "trees, 2D, tables", "walls", "shear, 2D", "pressure", "many-body",
)  # fmt: skip


@pytest.mark.plain
@pytest.mark.few(*FEW)
@pytest.mark.parametrize("name", CASES)
def test_steps_beside_the_reference(name):
    """Forty steps: boxes, places, velocities, forces, virials, energies, walls agree to 1e-9.

    Sums in another order differ by 1e-14 of a force, which the motion multiplies; a wrong term in
    an equation shows in the first digits. The reference has velocities of the laboratory.
    """
    simulation, reference = beside(name)
    system, by_itself, lists, tilts = simulation.system, 0.0, set(), []
    for _ in range(fewer_in_python(40)):
        before = reference.position.copy()
        sums = simulation.sample(1, [simulation.state.step + 1], measure=True).of(-1)
        reference.step()
        assert np.abs(unfolded_places(simulation) - reference.position).max() < 1e-9
        velocity = by_identity(simulation, "velocity") + flow_of(system, reference.position)
        assert np.abs(velocity - reference.velocity).max() < 1e-9
        force, scale = reference.force / reference.mass, max(1, np.abs(reference.force).max())
        assert np.abs(by_identity(simulation, "force") - force).max() < 1e-9 * scale
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * np.abs(reference.virial).max()
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)
        np.testing.assert_allclose(simulation.box, reference.system.box, rtol=1e-11)
        if system.walls is not None:
            largest = np.abs(reference.at_walls).max()
            assert np.abs(sums.walls - reference.at_walls).max() < 1e-9 * largest
        if system.shear is not None:
            carried = system.dt * flow_of(system, 0.5 * (before + reference.position))
            by_itself += (reference.position - before - carried)[system.shear.flow]
            assert np.abs(by_identity(simulation, "peculiar") - by_itself).max() < 1e-9
            tilts.append(simulation.box.tilt)
        if system.skin:
            lists.add(simulation.state.reference[0, 0])
    if COMPILES:
        assert not system.skin or 1 < len(lists) < 40 or system.dt < 0.01
        assert system.pressure is None or 0 < reference.accepted <= reference.tried == \
            simulation.state.step // system.pressure.every  # fmt: skip
        assert system.shear is None or min(np.diff(tilts)) < 0 < max(np.diff(tilts)) or \
            "many-body" in name  # fmt: skip


@pytest.mark.plain
@pytest.mark.few(*FEW[:-3], "shear, 2D", "aboba")
@pytest.mark.parametrize("name", CASES | SPLIT)
def test_threads_and_calls_change_no_bit(name):
    """One call measured at its end, or three; one thread, or two or four of them."""
    one, many = simulation_of(name), []
    parts = (13, 1, 26) if COMPILES else (2, 1, 1)
    first = one.sample(sum(parts), [sum(parts)], measure=True).of(-1)
    for threads in (1,) if name in SPLIT or not COMPILES else (1, 2, 4):
        simulation = simulation_of(name, threads)
        for steps in parts[:-1]:
            simulation.advance(steps)
        sums = simulation.sample(parts[-1], [sum(parts)], measure=True).of(-1)
        many.append((simulation, sums))
    for simulation, sums in many:
        assert_same_state(simulation.state, one.state)
        assert simulation.box == one.box
        for name in ("image", "reference", "peculiar"):
            np.testing.assert_array_equal(getattr(simulation.state, name), getattr(one.state, name))
        for name in ("virial", "energy", "walls", "moments"):
            np.testing.assert_array_equal(getattr(sums, name), getattr(first, name))


@pytest.mark.few("gw-vv", "dpd-vv, 2D, list", "many-body")
@pytest.mark.parametrize("name", [
    "gw-vv", "gw-vv, 2D", "dpd-vv", "dpd-vv, 2D, list", "core, list", "by species",
    "by species, dpd-vv, list", "trees", "pressure", "many-body", *SPLIT])  # fmt: skip
def test_momentum_is_conserved_to_rounding(name):
    """Pair forces near 100, each rounded by 1e-14 and taken times dt; a force alone adds 1."""
    simulation = simulation_of(name)
    before = simulation.system.momenta(simulation.state).sum(axis=1)
    simulation.advance(500)
    after = simulation.system.momenta(simulation.state).sum(axis=1)
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-10)
    assert np.mean(simulation.state.velocity**2) > 0.2


@pytest.mark.few("gw-vv", "trees, 2D, tables", "walls")
@pytest.mark.parametrize("name", [
    "gw-vv", "gw-vv, 2D", "trees", "trees, 2D, tables", "walls", "walls, 2D",
    "walls, list, gaussian", "many-body", "many-body, 2D, list", "shear", "shear, 2D",
    "shear, gradient along rows", "shear, flow across layers", "shear, tilt of two"])  # fmt: skip
def test_forces_and_curvature_are_derivatives_of_the_energy(name):
    """Of pairs, bonds, angles and walls, along every coordinate, by the plain reference."""
    nothing = {"body_force": None, "wall_friction": 0.0} if "walls" in name else {}
    short = {"dt": 0.01} if "shear" in name else {}  # no bond grows as long as half the box
    simulation, reference = beside(name, friction=1e-20, **nothing, **short)
    for _ in range(11 if "shear" in name else 0):
        simulation.advance(1)
        reference.step()
    place, force = reference.position.copy(), by_identity(simulation, "force").copy()

    def energy(at, nudge):
        reference.position = place.copy()
        reference.position[at] += nudge
        reference.evaluate(reference.velocity)
        walls = 0.0 if reference.at_walls is None else reference.at_walls[:, 0].sum()
        return sum(reference.energy) + walls

    laplacian, middle = 0.0, energy((0, 0), 0.0)
    for at in np.ndindex(*place.shape):
        low, high = energy(at, -NUDGE), energy(at, NUDGE)
        assert force[at] == pytest.approx((low - high) / (2 * NUDGE), abs=2e-5 * abs(force).max())
        laplacian += (low + high - 2 * middle) / NUDGE**2
    held = at_beads(replace(simulation.system, box=simulation.box), simulation.state)
    np.testing.assert_allclose(held.force.T, force, atol=1e-9)
    assert held.energy.sum() == pytest.approx(energy((0, 0), 0.0))
    beads = reference.virial_of_beads
    np.testing.assert_allclose(held.virial, (beads + beads.swapaxes(1, 2)) / 2, atol=1e-9)
    if "shear" not in name:
        squares, curvature = force_and_curvature(simulation.system, simulation.state)
        assert squares == pytest.approx((force**2).sum(), rel=1e-9)
        assert curvature == pytest.approx(laplacian, rel=1e-3)
