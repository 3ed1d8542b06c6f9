"""Density fields, structure factors, mixing and diffusion of beads whose places are known."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from dpd.engine.simulation import Snapshot
from dpd.engine.space import wrapped
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.files import read
from dpd.observe.common.measured import observables
from dpd.observe.density_field import grid_shape
from dpd.observe.structure_factor import wave_numbers
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

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


def state_of(scene, position, step=0):
    """A state with those positions, put inside the box and stored in some other order."""
    order = np.random.default_rng(step).permutation(scene.beads)
    zeros = np.zeros_like(position)
    species = scene.kinds[order] if len(scene.species) > 1 else None
    inside, image = wrapped(position, scene.box)
    identity = order.astype(np.uint32)
    return State(inside[:, order], zeros, None, identity, species, step, image=image)


def look(data, observe, *positions):
    """Arrays of the file after some looks of the one observable at those positions."""
    scene = Scene(data | {"observe": [observe]}, "scene.yaml")
    system = system_of(scene)
    observer, *_ = observables(scene, system)
    for step, position in enumerate(positions):
        observer.sample(Snapshot(system, state_of(scene, position, step)))
    return scene, {name: found[1] for name, found in observer.variables().items()}


# Density fields.


@pytest.mark.parametrize("name", SCENES)
def test_a_field_counts_beads_in_cells(name):
    """As numpy.histogramdd does, to single precision; a frame is the mean of its looks."""
    data = SCENES[name]
    scene = Scene(data)
    positions = [places(scene, seed) for seed in range(6)]
    settings = {"density_field": {"every": 10, "average": 4, "spacing": 0.9}}
    _, found = look(data, settings, *positions)
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
    _, found = look(PLANE, settings, places(Scene(PLANE)))
    assert np.isfinite(found["density_field"][0]).all()
    assert np.isnan(found["density_field"][1:]).all() and len(found["density_field"]) == 3


@pytest.mark.parametrize("name", SCENES)
def test_structure_factors_are_those_of_their_definition(name):
    """Each pair, each wave vector, each shell; from pairs of beads instead of density waves.

    The wave vectors are all of one half up to max.
    """
    data = SCENES[name]
    scene = Scene(data)
    numbers = wave_numbers(scene.box, 3)
    reach = np.stack(np.meshgrid(*[range(-9, 10)] * scene.dimension), axis=-1)
    short = np.linalg.norm(2 * np.pi * reach / np.array(scene.box), axis=-1) <= 3
    both = np.vstack([numbers, -numbers, np.zeros((1, scene.dimension), int)])
    assert sorted(map(tuple, both)) == sorted(map(tuple, reach[short]))
    position = places(scene)
    _, found = look(data, {"structure_factor": {"every": 60, "max": 3}}, position)
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


def distances(scene, position):
    """(beads, beads) array, at nearest images."""
    apart = position[:, :, None] - position[:, None]
    edges = np.array(scene.box)[:, None, None]
    return np.sqrt(((apart - edges * np.round(apart / edges)) ** 2).sum(axis=0))


@pytest.mark.parametrize("name", SCENES)
def test_mixing_and_energies_are_those_of_all_pairs(name):
    """By brute force, for three species: Warren-Cowley order, and a (1 - r)^2 / 2."""
    scene = Scene(SCENES[name])
    positions = [places(scene, seed) for seed in range(3)]
    _, mixing = look(SCENES[name], {"mixing": {"every": 20}}, *positions)
    _, energies = look(SCENES[name], {"pair_energies": {"every": 20}}, *positions)
    assert list(mixing["unlike_pair"]) == ["A B", "A C", "B C"]
    assert list(energies["energy_pair"]) == ["A A", "A B", "A C", "B B", "B C", "C C"]
    np.testing.assert_allclose(mixing["mixing_time"], [0.8, 1.6, 2.4])
    a = np.asarray(scene.repulsion)[scene.kinds][:, scene.kinds]
    beads = [scene.kinds == kind for kind in range(3)]
    for sample, position in enumerate(positions):
        r, order, energy = distances(scene, position), [], []
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


# Diffusion.


def test_diffusion_is_that_from_the_first_sample():
    """Beads that move straight, each species at a speed of its own, across the faces."""
    scene = Scene(PLANE)
    speed = np.array([0.3, -0.2, 0.1])[scene.kinds]
    first = places(scene)
    positions = [first + np.array([[1.0], [0.5]]) * speed * k for k in range(30)]
    _, found = look(PLANE, {"diffusion": {"every": 2}}, *positions)
    time = 0.08 * np.arange(30)
    np.testing.assert_allclose(found["diffusion_time"], time)
    assert np.isnan(found["diffusion_bead"][0]).all()
    counts = np.array([20, 20, 15])
    mean = (np.array([0.3, -0.2, 0.1]) * counts).sum() / counts.sum()
    steps = np.arange(1, 30)[:, None]
    for speeds, name in (([0.3, -0.2, 0.1], "bead"), ([0.05, 0.1], "molecule")):
        expected = 1.25 * ((np.array(speeds) - mean) * steps) ** 2 / (4 * time[1:, None])
        np.testing.assert_allclose(found[f"diffusion_{name}"][1:], expected, rtol=1e-9)


# In runs.

WATCHED = [
    {"density_field": {"every": 7, "average": 4}}, {"structure_factor": {"every": 9}},
    {"mixing": {"every": 5}}, {"diffusion": {"every": 4}},
]  # fmt: skip


def test_threads_and_kills_leave_the_bits(tmp_path):
    """One and two threads, and a run that stops in the middle and goes on."""
    scene = Scene(SOLID | {"observe": WATCHED})
    whole = tmp_path / "whole.nc"
    simulate(scene, whole, make_start(scene))
    expected, _ = read(whole)
    simulate(scene, tmp_path / "two.nc", make_start(scene), Options(threads=2))
    path, done, often = tmp_path / "run.nc", [], Options(every_seconds=0)
    with pytest.raises(UserError, match="stopped at step"):
        simulate(scene, path, make_start(scene), often, done.append, lambda: done[-1] > 30)
    done = []
    simulate(scene, path, make_start(scene), often, done.append)
    assert done[0] > 30  # it went on, and did not begin again
    for found in (read(tmp_path / "two.nc")[0], read(path)[0]):
        assert found.keys() == expected.keys()
        for name, array in expected.items():
            np.testing.assert_array_equal(found[name], array, err_msg=name)


# What is refused.

REFUSED = {
    "frames": (
        {"density_field": {"every": 1, "average": 1, "spacing": 0.01}},
        ["observe.density_field", "60 frames", "5.4e+07", "allowed: <= 10000000"],
    ),
    "waves": (
        {"structure_factor": {"max": 1000}}, ["observe.structure_factor.max", "1000", "vectors"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name, monkeypatch):
    """In one message: key, value, what is allowed."""
    monkeypatch.setattr("dpd.observe.density_field.MOST_CELLS", 10**7)
    observe, parts = REFUSED[name]
    data = PLANE if name != "waves" else PLANE | {"box": 60.0}
    with pytest.raises(UserError) as problem:
        Scene(data | {"observe": [observe]}, "scene.yaml")
    for part in ["scene.yaml", *parts]:
        assert part in str(problem.value)
