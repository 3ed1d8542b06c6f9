"""Branched molecules, bonds per pair of species, and angles, in the engine."""

import numpy as np
import pytest

from dpd.engine.bonded import angles_of, bonds_of
from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.queries.stress import force_and_curvature
from dpd.engine.simulation import Simulation
from dpd.observe.common.measured import observables
from dpd.scene.molecules import Molecule
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.engine.reference import Reference
from tests.systems import (
    BOX_2D,
    BOX_3D,
    assert_same_place,
    assert_same_state,
    by_identity,
    fewer_in_python,
    harmonic,
    harmonic_angles,
    make_simulation,
    make_system,
    random_beads,
)

BOXES = pytest.mark.parametrize("box", [BOX_2D, BOX_3D], ids=["2D", "3D"])
STAR = Molecule(("A",) * 6, (-1, 0, 1, 1, 3, 1), 5)  # three arms and a stem on bead 1
SHAKE = 0.15  # r_c, by which beads are off the places that they are bonded at
NUDGE = 1e-5


def joined(kind):
    """Bonds and angles of all molecules of a kind."""
    first = len(kind.beads) * np.arange(kind.count)[:, None, None]
    return tuple(
        (first + inside).reshape(-1, inside.shape[1]).astype(np.uint32)
        for inside in (kind.bonds, kind.triples)
    )


def laws(tabled, members, triples):
    """One law for all bonds and one for all angles, or a table of each."""
    if not tabled:
        return harmonic(60.0, 0.5), harmonic_angles(7.0, 2.0)
    bond = harmonic(np.array([60.0, 20.0, 90.0]), np.array([0.5, 0.0, 0.8]), members[:, 1] % 3)
    angle = harmonic_angles(np.array([7.0, 3.0]), np.array([2.0, np.pi]), triples[:, 2] % 2)
    return bond, angle


def stars(box, tabled, **changes):
    """Stars and single beads, 50 in all: system, positions and velocities."""
    members, triples = joined(STAR)
    bond, angle = laws(tabled, members, triples)
    system = make_system(
        box, seed=12, bond=bond, members=members, angle=angle, angle_members=triples, **changes
    )
    position, velocity = random_beads(box, 50, seed=3)
    rng = np.random.default_rng(7)
    for bead in range(STAR.count * len(STAR.beads)):
        inside = bead % len(STAR.beads)
        if inside:  # at a distance of 0.6 from the bead that it hangs on
            at = position[:, bead - inside + STAR.parents[inside]]
            arm = rng.normal(size=len(box))
            position[:, bead] = at + 0.6 * arm / np.linalg.norm(arm)
    return system, position % np.array(box)[:, None], velocity


@pytest.mark.plain
@pytest.mark.parametrize(
    ("box", "tabled"), [(BOX_3D, False), (BOX_2D, True)], ids=["3D, one law", "2D, tables"]
)
def test_trees_step_beside_the_reference(box, tabled):
    """Twenty steps: places, velocities, forces, virials and energies agree to 1e-9."""
    system, position, velocity = stars(box, tabled)
    simulation = make_simulation(system, position, velocity)
    reference = Reference(system, "gw-vv", 0.5, position, velocity)
    for _ in range(fewer_in_python(20)):
        sums = simulation.advance_measured(1)
        reference.step()
        assert_same_place(by_identity(simulation, "position"), reference.position, box, 1e-9)
        for name in ("velocity", "force"):
            found, expected = by_identity(simulation, name), getattr(reference, name)
            assert np.abs(found - expected).max() < 1e-9 * max(1, np.abs(expected).max())
        assert np.abs(sums.virial - reference.virial).max() < 1e-9 * np.abs(reference.virial).max()
        np.testing.assert_allclose(sums.energy, reference.energy, rtol=1e-9)


def energy_at(system, position):
    """Energy of pairs, bonds and angles, by the reference."""
    reference = Reference(system, "gw-vv", 0.5, position, np.zeros_like(position))
    return sum(reference.energy)


@pytest.mark.few(1)
@BOXES
def test_forces_and_curvature_are_derivatives_of_the_energy(box):
    """Along every coordinate, by small steps; the Laplacian over all of them."""
    system, position, velocity = stars(box, True, friction=0.0)
    simulation = make_simulation(system, position, np.zeros_like(velocity))
    force, middle, laplacian = by_identity(simulation, "force"), energy_at(system, position), 0.0
    for place in np.ndindex(*position.shape):
        energies = []
        for nudge in (-NUDGE, NUDGE):
            moved = position.copy()
            moved[place] += nudge
            energies.append(energy_at(system, moved))
        slope = (energies[1] - energies[0]) / (2 * NUDGE)
        assert force[place] == pytest.approx(-slope, abs=1e-4 * np.abs(force).max())
        laplacian += (energies[0] + energies[1] - 2 * middle) / NUDGE**2
    squares, curvature = force_and_curvature(system, simulation.state)
    assert squares == pytest.approx((force**2).sum(), rel=1e-9)
    assert curvature == pytest.approx(laplacian, rel=1e-3)


def three_beads(angle, rest, stiffness=5.0):
    """A force of three beads with an angle between bonds of length 1 and 0.8 at rest."""
    box = (6.0, 6.0, 6.0)
    arm = np.array([np.cos(angle), np.sin(angle), 0.0])
    position = np.array([[1.0, 0, 0], [0, 0, 0], 0.8 * arm]).T + 3.0
    system = make_system(
        box, repulsion=np.zeros((1, 1)), kT=0.0, bond=harmonic(0.0, 1.0),
        members=np.array([[0, 1], [1, 2]], np.uint32), angle=harmonic_angles(stiffness, rest),
        angle_members=np.array([[0, 1, 2]], np.uint32),
    )  # fmt: skip
    simulation = make_simulation(system, position, np.zeros((3, 3)))
    return by_identity(simulation, "force"), simulation.measure()


@pytest.mark.thorough
@pytest.mark.parametrize("angle", [0.3, 1.2, 2.0, 3.0, np.pi - 1e-6])
def test_force_and_energy_of_one_angle(angle):
    """k (theta - theta_0) over the length of each bond, across it; no torque, no trace."""
    force, sums = three_beads(angle, 2.0)
    turn = 5.0 * (angle - 2.0)
    np.testing.assert_allclose(force[:, 0], [0, turn, 0], atol=1e-9)
    across = np.array([-np.sin(angle), np.cos(angle), 0.0])
    np.testing.assert_allclose(force[:, 2], -turn / 0.8 * across, atol=1e-9)
    np.testing.assert_allclose(force.sum(axis=1), 0, atol=1e-12)
    assert sums.energy[1] == pytest.approx(5.0 * (angle - 2.0) ** 2 / 2)
    np.testing.assert_allclose(sums.virial[0], sums.virial[0].T, atol=1e-9)
    assert np.trace(sums.virial[0]) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("rest", [np.pi, 2.0, 0.0])
@pytest.mark.parametrize("angle", [np.pi, 0.0])
def test_straight_angles_stay_finite(angle, rest):
    """No direction is across them: no force, rather than none that is a number."""
    force, sums = three_beads(angle, rest)
    assert np.isfinite(force).all()
    assert np.abs(force).max() <= 5.0 * np.pi / 0.8 * 2
    if rest == angle:
        np.testing.assert_allclose(force, 0, atol=1e-14)
    assert sums.energy[1] == pytest.approx(5.0 * (angle - rest) ** 2 / 2, abs=1e-12)


def test_beads_at_the_same_place_feel_no_angle():
    """A bond without a length has no direction."""
    members = np.array([[0, 1], [1, 2]], np.uint32)
    system = make_system(
        BOX_3D, bond=harmonic(10.0, 0.0), members=members, angle=harmonic_angles(5.0, 2.0),
        angle_members=np.array([[0, 1, 2]], np.uint32), kT=0.0, repulsion=np.zeros((1, 1)),
    )  # fmt: skip
    simulation = make_simulation(system, np.full((3, 3), 1.5), np.zeros((3, 3)))
    simulation.advance(5)
    np.testing.assert_array_equal(simulation.state.position, 1.5)


def test_batches_keep_molecules_with_their_angles_together():
    """Every angle is in the batch of its bonds, and no bead is in two batches."""
    kind = Molecule(STAR.beads, STAR.parents, 400)
    members, triples = joined(kind)
    shuffled = np.random.default_rng(1).permutation(len(triples))
    bond, angle = laws(True, members, triples[shuffled])
    system = make_system(
        BOX_3D, bond=bond, members=members, angle=angle, angle_members=triples[shuffled]
    )
    bonds = bonds_of(system)
    angles = angles_of(system, bonds)
    assert len(bonds.batch) == len(angles.batch) > 2
    assert angles.batch[0] == 0
    assert angles.batch[-1] == len(triples)
    seen = set()
    for batch in range(len(bonds.batch) - 1):
        of_bonds = set(bonds.members[bonds.batch[batch] : bonds.batch[batch + 1]].ravel())
        of_angles = set(angles.members[angles.batch[batch] : angles.batch[batch + 1]].ravel())
        assert of_angles <= of_bonds
        assert not of_bonds & seen
        seen |= of_bonds
    np.testing.assert_array_equal(angles.law.number, angles.members[:, 2] % 2)


SCENE = {
    "dimension": 3,
    "box": [7, 8, 9],
    "molecules": [
        {"architecture": "A 3 (B 2) (C 4 (D)) A 3", "count": 60},
        {"architecture": "A B A", "count": 40},
        {"architecture": "D", "count": 100},
    ],
    "repulsion": {f"{one} {other}": 25 for one in "ABCD" for other in "ABCD" if one <= other},
    "bond": {
        "A A": {"stiffness": 50, "length": 0.5}, "B A": {"stiffness": 60},
        "B B": {"stiffness": 40, "length": 0.3}, "A C": {"stiffness": 50, "length": 0.7},
        "C C": {"stiffness": 50}, "D C": {"stiffness": 20},
    },
    "angle": {
        "A A A": {"stiffness": 5}, "B A A": {"stiffness": 4, "angle": 90},
        "A B A": {"stiffness": 3, "angle": 120},
    },
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"sample": 100},
}  # fmt: skip


@pytest.mark.thorough
def test_any_number_of_threads_makes_the_same_bits():
    """With tables and angles, in several batches."""
    scene = Scene(SCENE | {"pairs": {"search": "list"}})
    system, start = system_of(scene), make_start(scene)
    assert len(bonds_of(system).batch) > 2
    found = []
    for threads in (1, 2, 4):
        simulation = make_simulation(
            system, start.position, start.velocity, start.species, threads=threads
        )
        sums = simulation.advance_measured(40)
        found.append((simulation, sums))
    for simulation, sums in found[1:]:
        assert_same_state(simulation.state, found[0][0].state)
        np.testing.assert_array_equal(sums.virial, found[0][1].virial)
        np.testing.assert_array_equal(sums.energy, found[0][1].energy)


class Interrupted(Exception):
    """What stops a run from outside."""


@pytest.mark.thorough
def test_an_interrupted_run_goes_on_to_the_same_bits(tmp_path):
    """State and all that was observed of trees."""
    names = ("thermo", "chains", "end_points", "bond_lengths", "end_to_end", "trace")
    scene = Scene(SCENE | {"observe": [{name: {"every": 10}} for name in names]})
    system = system_of(scene)

    def new_run():
        return Simulation(system, make_start(scene)), observables(scene, system)

    def interrupt(step):
        if step >= 50:
            raise Interrupted

    checkpoint = Checkpoint(tmp_path / "run.checkpoint", {"scene": "this"})
    whole, parts = new_run(), new_run()
    run(whole[0], scene.steps, whole[1])
    with pytest.raises(Interrupted):
        run(parts[0], scene.steps, parts[1], checkpoint, interrupt, every_seconds=0.0)
    again = new_run()
    assert 0 < run(again[0], scene.steps, again[1], checkpoint) < scene.steps.sample
    assert_same_state(again[0].state, whole[0].state)
    for one, other in zip(again[1], whole[1], strict=True):
        for name, array in other.arrays.items():
            np.testing.assert_array_equal(one.arrays[name], array, err_msg=name)


@pytest.mark.thorough
def test_a_table_of_equal_laws_is_one_law():
    """To rounding, after twenty steps."""
    plain = {"bond": {"stiffness": 50, "length": 0.5}, "angle": {"stiffness": 5, "angle": 150}}
    scene = Scene(SCENE | plain)
    pairs = {tuple(sorted(key.split())) for key in SCENE["bond"]}
    triples = ("AAA", "BAA", "ABB", "CAA", "BAC", "ACC", "CCC", "CCD", "ABA")
    table = {
        "bond": {" ".join(pair): plain["bond"] for pair in pairs},
        "angle": {" ".join(triple): plain["angle"] for triple in triples},
    }
    one, other = system_of(scene), system_of(Scene(SCENE | table))
    np.testing.assert_array_equal(one.angle_members, other.angle_members)
    start = make_start(scene)
    ends = []
    for system in (one, other):
        simulation = make_simulation(system, start.position, start.velocity, start.species)
        simulation.advance(20)
        ends.append(by_identity(simulation, "position"))
    assert_same_place(*ends, scene.box, 1e-9)


@pytest.mark.thorough
def test_equipartition_of_an_angle():
    """<(theta - theta_0)^2> = kT / k for a stiff angle in two dimensions, without a weight.

    1000 free molecules for 40 samples: the mean square is known to 1 % for independent ones, and
    the tolerance of 6 % is six standard errors or, with the correlation of samples, more than
    four.
    """
    scene = Scene({
        "dimension": 2, "box": 60, "molecules": [{"architecture": "A 3", "count": 1000}],
        "repulsion": {"A A": 0}, "bond": {"stiffness": 100, "length": 1.0},
        "angle": {"stiffness": 30, "angle": 120},
        "integrator": {"scheme": "gw-vv", "dt": 0.01}, "steps": {"sample": 100},
    })  # fmt: skip
    simulation = make_simulation(system_of(scene), *_placed(scene))
    simulation.advance(600)
    squares = []
    for _ in range(40):
        simulation.advance(25)
        x = by_identity(simulation, "position").reshape(2, -1, 3)
        to_i, to_k = x[:, :, 0] - x[:, :, 1], x[:, :, 2] - x[:, :, 1]
        to_i -= 60 * np.round(to_i / 60)
        to_k -= 60 * np.round(to_k / 60)
        cosine = (to_i * to_k).sum(axis=0)
        sine = np.abs(to_i[0] * to_k[1] - to_i[1] * to_k[0])
        squares.append(((np.arctan2(sine, cosine) - np.deg2rad(120)) ** 2).mean())
    assert np.mean(squares) == pytest.approx(1 / 30, rel=0.06)


def _placed(scene):
    """Molecules at rest in their bonds and angles, anywhere."""
    rng = np.random.default_rng(2)
    turn = rng.random(1000) * 2 * np.pi
    middle = rng.random((2, 1000)) * 60
    arms = [np.stack([np.cos(turn + a), np.sin(turn + a)]) for a in (0.0, np.deg2rad(120))]
    x = np.stack([middle + arms[0], middle, middle + arms[1]], axis=2).reshape(2, -1) % 60
    velocity = rng.normal(size=x.shape)
    return x, velocity
