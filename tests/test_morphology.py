"""Phases of made-up beads: named where their peaks say so, and not where they do not."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.morphology import Strengths, phase_of, strengths_of
from dpd.engine.queries.pairs import density_waves
from dpd.observe.structure_factor import wave_numbers

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
    assert two.is_peak == (share == 0.3) and (three.is_peak or share == 0.3)


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
