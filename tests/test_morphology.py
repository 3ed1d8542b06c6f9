"""Phases of made-up beads; fields, structure factors, mixing and diffusion of known places."""

import json
from itertools import combinations_with_replacement

import numpy as np
import pytest
import xarray as xr

from dpd.engine.measure import density_waves
from dpd.errors import UserError
from dpd.observe.density_field import grid_shape
from dpd.observe.structure_factor import wave_numbers
from dpd.scene.scene import Scene
from paper_figures.cerius2_1998.phases import Strengths, phase_of, strengths_of
from tests.systems import look
from tests.test_extend import PAGES

LOOKS = 40


def strengths(domain, box, width=0.3, beads=3000, shift=0.02, most=5.0):
    """Of beads that are found where ``domain(position)`` > 0, blurred by ``width``.

    Averaged over independent looks between which the whole crystal moves a little.
    """
    rng = np.random.default_rng(5)
    numbers = wave_numbers(box, most)
    edges = np.array(box)[:, None]
    total = np.zeros(len(numbers))
    for _ in range(LOOKS):
        place = rng.random((len(box), 12 * beads)) * edges
        place = place[:, domain(place) > 0][:, :beads]
        assert place.shape[1] == beads
        place += rng.normal(scale=width, size=place.shape) + shift * rng.normal()
        waves = density_waves(place, box, np.array([0, beads]), numbers)
        total += (waves[:, 0] ** 2).sum(axis=0)
    return Strengths(2 * np.pi * numbers / np.array(box), total / (LOOKS * beads**2))


def layers(vector, share):
    """Layers across a wave vector that fill a share of the volume."""
    return lambda place: np.cos(np.array(vector) @ place) - np.cos(np.pi * share)


def columns(first, second, share):
    """Discs, or columns, on the lattice whose reciprocal vectors are given."""
    first, second = np.array(first), np.array(second)
    spacing = 4 * np.pi / (np.sqrt(3) * np.linalg.norm(first))
    radius = spacing * np.sqrt(share * np.sqrt(3) / (2 * np.pi))
    basis = 2 * np.pi * np.linalg.pinv(np.stack([first, second]))  # columns: lattice vectors

    def domain(place):
        phases = np.stack([first, second]) @ place / (2 * np.pi)
        apart = phases - np.round(phases)
        shifts = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
        distance = [np.linalg.norm(basis @ (apart + s[:, None]), axis=0) for s in shifts]
        return radius - np.min(distance, axis=0)

    return domain


CUBE = (12.0, 12.0, 12.0)
UNIT = 2 * np.pi / 12


@pytest.mark.few(4)
@pytest.mark.parametrize("direction", [(2, 0, 0), (1, 1, 1), (1, -2, 0), (2, 1)])
@pytest.mark.parametrize("share", [0.5, 0.3])
def test_lamellae(direction, share):
    """In any direction, stripes too; those of equal thickness have no second order, but a third."""
    vector = UNIT * np.array(direction)
    phase = phase_of(strengths(layers(vector, share), CUBE[: len(direction)]))
    assert phase.name == "lamellae", phase
    assert phase.spacing == pytest.approx(2 * np.pi / np.linalg.norm(vector))
    one, two, three = phase.orders
    assert [one.ratio, two.ratio, three.ratio] == pytest.approx([1, 2, 3])
    blurred = np.exp(-((0.3 * np.linalg.norm(vector)) ** 2))
    sharp = (np.sin(np.pi * share) / (np.pi * share)) ** 2
    assert one.strength == pytest.approx(sharp * blurred, rel=0.05)
    # In a plane too few wave vectors are as long as the second order to say that it stands out.
    assert two.is_peak == (share == 0.3 and len(direction) == 3)
    assert three.is_peak or share == 0.3


TALL = 24 / np.sqrt(3)  # the edge that a hexagonal lattice has beside one of 12
HEXAGONAL = {
    "columns along z": ((12.0, TALL, 8.0), (2, 0, 0), (1, 2, 0)),
    "columns along x": ((8.0, 12.0, TALL), (0, 2, 0), (0, 1, 2)),
    "discs": ((12.0, TALL), (2, 0), (1, 2)),
    "a cube, which strains the lattice by 12 %": (CUBE, (2, 0, 0), (1, 2, 0)),
}


@pytest.mark.parametrize("name", HEXAGONAL)
def test_cylinders(name):
    """In a box that fits their lattice, and in one that does not quite."""
    box, first, second = HEXAGONAL[name]
    base = 2 * np.pi / np.array(box)
    domain = columns(base * np.array(first), base * np.array(second), 0.3)
    phase = phase_of(strengths(domain, box, width=0.2, beads=2000))
    assert phase.name == "cylinders", phase
    assert len(phase.first) == 3
    ratios = [order.ratio for order in phase.orders]
    assert ratios == pytest.approx([1, np.sqrt(3), 2, np.sqrt(7)], rel=0.02)
    spacing = np.mean([np.linalg.norm(vector) for vector in phase.first])
    assert phase.spacing == pytest.approx(4 * np.pi / np.sqrt(3) / spacing)


def test_disorder():
    """Beads anywhere: strengths of 1 / N."""
    phase = phase_of(strengths(lambda place: np.ones(place.shape[1]), CUBE))
    assert phase.name == "disordered" and phase.orders == () and np.isnan(phase.spacing)
    assert "0.05" in phase.reason


def test_phases_without_a_rule_have_no_name():
    """Crossed layers, one density wave without higher orders."""
    one, other = layers((2 * UNIT, 0, 0), 0.5), layers((0, 2 * UNIT, 0), 0.5)
    crossed = phase_of(strengths(lambda place: one(place) + other(place), CUBE))
    assert crossed.name == "none" and "2 wave vectors" in crossed.reason
    rng = np.random.default_rng(8)

    def wave(place):
        return 1 + np.cos(2 * UNIT * place[0]) - 2 * rng.random(place.shape[1])

    phase = phase_of(strengths(wave, CUBE, width=0.0, shift=0.0))
    assert phase.name == "none" and "without a peak at 2 or 3 times" in phase.reason


@pytest.mark.parametrize("first", [[(1, 0, 0)], [(1, -1, 0), (0, 1, -1), (1, 0, -1)]])
def test_noise_makes_no_peak_of_higher_order(first):
    """Strong first-order vectors and noise alone, in a small box, where few vectors are alike."""
    rng = np.random.default_rng(2)
    box, looks, runs = (6.3, 6.3, 6.3), 10, 100
    numbers = wave_numbers(box, 4.0)
    strong = [(numbers == sign * np.array(m)).all(axis=1) for m in first for sign in (1, -1)]
    amplitude = np.where(np.any(strong, axis=0), 0.5, 0.0)[:, None]
    vectors = 2 * np.pi * numbers / np.array(box)
    named = 0
    for _ in range(runs):
        real, imaginary = rng.normal(scale=0.03, size=(2, len(numbers), looks))
        squares = (amplitude + real) ** 2 + imaginary**2
        phase = phase_of(Strengths(vectors, squares.mean(axis=1)))
        assert len(phase.first) == len(first)
        named += phase.name != "none"
    assert named <= 0.1 * runs


def test_strengths_of_a_run_and_of_a_sweep():
    """Of the species asked for, from its share of the run on, over N_a."""
    scene = {
        "dimension": 2, "box": 10, "integrator": {"scheme": "gw-vv", "dt": 0.04},
        "molecules": [{"architecture": "A", "count": 200}, {"architecture": "B", "count": 50}],
        "repulsion": {"A A": 25, "A B": 40, "B B": 25}, "steps": {"sample": 100},
    }  # fmt: skip
    blocks = np.arange(4.0)[:, None, None] * np.ones((4, 3, 5))
    blocks[:, 2] *= 10
    data = xr.Dataset({
        "structure_factor_wave": (("block", "species_pair", "wave"), blocks),
        "wave_vector": (("wave", "axis"), np.arange(10.0).reshape(5, 2)),
        "species_pair": ("species_pair", ["A A", "A B", "B B"]),
    })  # fmt: skip
    run = data.assign_attrs(scene=json.dumps(scene))
    np.testing.assert_allclose(strengths_of(run, "A").strength, 2.5 / 200)
    np.testing.assert_allclose(strengths_of(run, "B", after=0).strength, 15 / 50)
    sweep = data.expand_dims(replica=2).assign(scene=("replica", [json.dumps(scene)] * 2))
    found = strengths_of(sweep, "B")
    np.testing.assert_allclose(found.strength, 25 / 50)
    np.testing.assert_allclose(found.vectors, data.wave_vector)


PLANE = {
    "dimension": 2,
    "box": [6.0, 5.0],
    "molecules": [{"architecture": "A B", "count": 20}, {"architecture": "C", "count": 15}],
    "repulsion": {"A A": 25, "B B": 25, "C C": 25, "A B": 40, "A C": 35, "B C": 30},
    "bond": {"stiffness": 10},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 60},
}
SOLID = PLANE | {"dimension": 3, "box": [6.0, 5.0, 4.0]}
SCENES = {"2D": PLANE, "3D": SOLID}


def places(scene, seed=1):
    """Random positions of the scene's beads."""
    rng = np.random.default_rng(seed)
    return rng.random((scene.dimension, scene.beads)) * np.array(scene.box)[:, None]


@pytest.mark.parametrize("name", SCENES)
def test_a_field_counts_beads_in_cells(name):
    """As numpy.histogramdd does, to single precision; a frame is the mean of its looks."""
    data = SCENES[name]
    scene = Scene(data)
    positions = [places(scene, seed) for seed in range(6)]
    settings = {"density_field": {"every": 10, "average": 4, "spacing": 0.9}}
    found = look(data, settings, *positions)
    shape = grid_shape(scene.box, 0.9)
    assert shape == (7, 6, 5)[: scene.dimension]
    assert found["density_field"].shape == (2, 3, *shape)
    assert found["density_field"].dtype == np.float32
    cell = scene.volume / np.prod(shape)
    for frame, looks in ((0, positions[:4]), (1, positions[4:])):
        for kind in range(3):
            beads = np.hstack([place[:, scene.kinds == kind] for place in looks])
            edges = [(0, edge) for edge in scene.box]
            counts, _ = np.histogramdd(beads.T, shape, edges)
            expected = counts / (cell * len(looks))
            np.testing.assert_allclose(found["density_field"][frame, kind], expected, rtol=1e-6)
    # Looks at 10, 20, 30, 40 steps, and at 50 and 60.
    np.testing.assert_allclose(found["field_time"], [25 * 0.04, 55 * 0.04])
    np.testing.assert_allclose(found["field_x"], (np.arange(7) + 0.5) * 6 / 7)


def test_frames_that_a_lost_run_did_not_come_to_are_empty():
    """NaN, not zero."""
    settings = {"density_field": {"every": 10, "average": 2}}
    found = look(PLANE, settings, places(Scene(PLANE)))
    assert np.isfinite(found["density_field"][0]).all()
    assert np.isnan(found["density_field"][1:]).all() and len(found["density_field"]) == 3


@pytest.mark.parametrize("name", SCENES)
def test_structure_factors_are_those_of_their_definition(name):
    """Each pair, each wave vector of one half, each shell; from pairs of beads."""
    data = SCENES[name]
    scene = Scene(data)
    numbers = wave_numbers(scene.box, 3)
    reach = np.stack(np.meshgrid(*[range(-9, 10)] * scene.dimension), axis=-1)
    short = np.linalg.norm(2 * np.pi * reach / np.array(scene.box), axis=-1) <= 3
    both = np.vstack([numbers, -numbers, np.zeros((1, scene.dimension), int)])
    assert sorted(map(tuple, both)) == sorted(map(tuple, reach[short]))
    position = places(scene)
    found = look(data, {"structure_factor": {"every": 60, "max": 3}}, position)
    assert list(found["species_pair"]) == ["A A", "A B", "A C", "B B", "B C", "C C"]
    apart = position[:, :, None] - position[:, None]
    along = np.cos(np.einsum("wk,kij->wij", found["wave_vector"], apart))
    length = np.linalg.norm(found["wave_vector"], axis=1)
    shell = np.rint(length / (2 * np.pi / 6))
    for number, pair in enumerate(found["species_pair"]):
        one, other = (scene.kinds == scene.species.index(kind) for kind in pair.split())
        expected = along[:, one][:, :, other].sum(axis=(1, 2)) / np.sqrt(one.sum() * other.sum())
        np.testing.assert_allclose(found["structure_factor_wave"][0, number], expected, atol=1e-10)
        for k, place in enumerate(np.unique(shell)):
            members = shell == place
            assert found["q_waves"][k] == 2 * members.sum()
            assert found["q"][k] == pytest.approx(length[members].mean())
            assert found["structure_factor"][0, number, k] == pytest.approx(
                expected[members].mean(), abs=1e-10
            )


@pytest.mark.parametrize("name", SCENES)
def test_mixing_and_energies_are_those_of_all_pairs(name):
    """By brute force, for three species: Warren-Cowley order, and a (1 - r)^2 / 2."""
    data = SCENES[name] | {"pages": [PAGES["pair_energies"]]}
    scene = Scene(data)
    positions = [places(scene, seed) for seed in range(3)]
    mixing = look(data, {"mixing": {"every": 20}}, *positions)
    energies = look(data, {"pair_energies": {"every": 20}}, *positions)
    assert list(mixing["unlike_pair"]) == ["A B", "A C", "B C"]
    assert list(energies["energy_pair"]) == ["A A", "A B", "A C", "B B", "B C", "C C"]
    np.testing.assert_allclose(mixing["mixing_time"], [0.8, 1.6, 2.4])
    a, edges = scene.repulsion[scene.kinds][:, scene.kinds], np.array(scene.box)[:, None, None]
    beads = [scene.kinds == kind for kind in range(3)]
    for sample, position in enumerate(positions):
        apart, order, energy = position[:, :, None] - position[:, None], [], []
        r = np.sqrt(((apart - edges * np.round(apart / edges)) ** 2).sum(axis=0))
        np.fill_diagonal(r, 1.0)
        for i, j in combinations_with_replacement(range(3), 2):
            of_both, once = r[beads[i]][:, beads[j]], 2 if i == j else 1
            within = a[beads[i]][:, beads[j]] * np.maximum(1 - of_both, 0) ** 2 / 2
            energy.append(within.sum() / once)
            if i != j:
                share = 2 * of_both.size / (scene.beads * (scene.beads - 1))
                order.append(1 - (of_both < 1).sum() / ((r < 1).sum() / 2) / share)
        np.testing.assert_allclose(mixing["short_range_order"][sample], order, atol=1e-12)
        np.testing.assert_allclose(energies["energy_of_pair"][sample], energy, rtol=1e-9)


def test_diffusion_is_that_from_the_first_sample():
    """Beads that move straight, each species at a speed of its own, across the faces."""
    scene = Scene(PLANE)
    speed = np.array([0.3, -0.2, 0.1])[scene.kinds]
    first = places(scene)
    positions = [first + np.array([[1.0], [0.5]]) * speed * k for k in range(30)]
    found = look(PLANE, {"diffusion": {"every": 2}}, *positions)
    time = 0.08 * np.arange(30)
    np.testing.assert_allclose(found["diffusion_time"], time)
    assert np.isnan(found["diffusion_bead"][0]).all()
    counts = np.array([20, 20, 15])
    mean = (np.array([0.3, -0.2, 0.1]) * counts).sum() / counts.sum()
    steps = np.arange(1, 30)[:, None]
    for speeds, name in (([0.3, -0.2, 0.1], "bead"), ([0.05, 0.1], "molecule")):
        expected = 1.25 * ((np.array(speeds) - mean) * steps) ** 2 / (4 * time[1:, None])
        np.testing.assert_allclose(found[f"diffusion_{name}"][1:], expected, rtol=1e-9)


def test_what_is_refused(monkeypatch):
    """In one message: key, value, what is allowed."""
    monkeypatch.setattr("dpd.observe.density_field.MOST_CELLS", 10**7)
    frames = {"density_field": {"every": 1, "average": 1, "spacing": 0.01}}
    waves = {"structure_factor": {"max": 1000}}
    for change, said in (
        ({"observe": [frames]}, r"density_field.*60 frames.*5\.4e\+07.*allowed: <= 10000000"),
        ({"observe": [waves], "box": 60.0}, r"observe\.structure_factor\.max.*1000.*vectors"),
    ):
        with pytest.raises(UserError, match=rf"scene\.yaml: .*{said}"):
            Scene(PLANE | change, "scene.yaml")
