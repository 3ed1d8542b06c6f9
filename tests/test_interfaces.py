"""Interfaces of slabs: where they are, how wide, and their tension from tensor and profile."""

import json

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.analysis.interfaces import FARTHEST, composition, interface_width, interfaces, slabs
from dpd.analysis.statistics import block_mean_and_error
from dpd.errors import UserError
from dpd.scene.scene import Scene
from paper_figures.groot_warren_1997.fig06_interface import recentred
from paper_figures.groot_warren_1997.slab_tension import slab_tension, tension_of_tensor
from tests.conftest import SCENE

LENGTH, SLICES = 20.0, 100
THICKNESS = LENGTH / SLICES
Z = (np.arange(SLICES) + 0.5) * THICKNESS


def profile(first, second, width, phi, beads=None, seed=0):
    """Densities of A and B with two interfaces of a width and minority fraction phi.

    Averaged over each slice, as beads are counted; with ``beads`` in a slice, noise as of counts.
    """
    fine = (np.arange(SLICES * 20) + 0.5) * THICKNESS / 20
    inside = np.zeros_like(fine)
    for shift in (-LENGTH, 0, LENGTH):
        inside += np.tanh(2 * (fine - first - shift) / width)
        inside -= np.tanh(2 * (fine - second - shift) / width)
    inside = inside.reshape(SLICES, 20).mean(axis=1) / 2
    fraction = phi + (1 - 2 * phi) * inside
    both = 3 * np.stack([fraction, 1 - fraction])
    if beads is None:
        return both
    return np.random.default_rng(seed).poisson(both * beads / 3) * 3 / beads


def test_moving_interfaces_are_followed():
    """Each block's two positions come back, also across the edge of the box."""
    rng = np.random.default_rng(1)
    moved = rng.normal([0.0, LENGTH / 2], 0.4, (20, 2))
    density = np.array([profile(*at, 1.5, 0.04, 400, n) for n, at in enumerate(moved)])
    found = interfaces(density, Z, LENGTH)
    assert np.abs(found - moved).max() < 0.1
    assert np.std(found - moved) < 0.03


def test_moving_interfaces_are_put_back():
    """As if they had never moved; left where they are, they smear the mean."""
    moved = np.random.default_rng(2).normal([0.0, LENGTH / 2], 0.4, (20, 2))
    density = np.array([profile(*at, 1.5, 0.04) for at in moved])
    still = profile(0.0, LENGTH / 2, 1.5, 0.04)
    back = recentred(density, Z, LENGTH, moved)
    assert np.abs(back - still).max() < 0.05  # lines between slices cut corners
    assert np.abs(density.mean(axis=0) - still).max() > 0.15


@pytest.mark.parametrize("width", [0.9, 1.5, 3.0])
def test_width_of_moving_interfaces(width):
    """The width is that of each block, not that of the mean, which the moves have widened."""
    shifts = np.linspace(-0.6, 0.6, 20)
    density = np.array([profile(s, 10 - s, width, 0.02) for s in shifts])
    found, error = interface_width(slabs(density, Z, LENGTH))
    assert found == pytest.approx(width, rel=0.01)
    assert error < 0.01 * width
    smeared = slabs(density.mean(axis=0)[None].repeat(4, axis=0), Z, LENGTH)
    assert interface_width(smeared)[0] > 1.03 * width


def test_composition_does_not_see_slabs_of_unequal_width():
    """Interfaces 1 r_c off, and tails of wide ones, leave the fraction as it is."""
    density = np.array([profile(1.0, 9.5, 2.5, 0.03, 4000, n) for n in range(40)])
    seen = slabs(density, Z, LENGTH)
    found = composition(seen)
    assert abs(found.fraction - 0.03) < 4 * found.error
    assert found.error < 0.001


def test_slabs_that_have_mixed_are_not_settled():
    """However steady the composition is: interfaces that are not found, or a fraction of a half."""
    density = np.array([profile(0.0, 10.0, 1.5, 0.02, 4000, n) for n in range(40)])
    found = composition(slabs(density, Z, LENGTH))
    assert found.settled and not found.mixed
    lost = density.copy()
    lost[7] = profile(4.0, 6.0, 1.5, 0.02)
    even = np.random.default_rng(2).poisson(4000, (40, 2, SLICES)) / 1000.0
    for mixed in (lost, even):
        found = composition(slabs(mixed, Z, LENGTH))
        assert found.mixed and not found.steady and not found.settled
    assert slabs(lost, Z, LENGTH).lost
    assert np.abs(interfaces(even, Z, LENGTH) - [0, 10]).max() <= FARTHEST * LENGTH


SLABS = SCENE | {
    "box": [5, 5, 16],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "A B": 45, "B B": 25},
    "start": {"method": "slabs"},
    "steps": {"equilibrate": 1000, "sample": 8000},  # 2000 samples, 40 in each block
    "observe": [
        {"thermo": {"every": 4}}, {"profile": {"every": 10}},
        {"stress_profile": {"every": 4, "bin": 0.25}},
    ],
}  # fmt: skip
ONE = {"molecules": [{"architecture": "A", "density": 3}], "repulsion": {"A A": 25}}


@pytest.fixture(scope="module")
def slab_run():
    """Two slabs that hardly mix."""
    return dpd.run(SLABS, progress=False)


def test_tensor_and_profile_agree(slab_run):
    """To rounding, as they look at the same samples; and the bulks are isotropic."""
    found = slab_tension(slab_run)
    of_tensor, of_profile = found.of_tensor, found.of_profile
    assert found.best == of_tensor == tension_of_tensor(slab_run)
    assert of_profile.value == pytest.approx(of_tensor.value, rel=1e-10)
    assert of_profile.error == pytest.approx(of_tensor.error, rel=0.5)
    # Groot and Warren 1997 fit their single beads of density 3, chi = 0.286 * 20, by this.
    chi = 0.286 * 20
    published = 0.75 * 3 * chi**0.26 * (1 - 2.36 / chi) ** 1.5
    assert abs(of_tensor.value - published) < 4 * of_tensor.error
    assert of_tensor.error < 0.1 * of_tensor.value
    for part in found.bulks:
        assert 0 < part.error < 0.2
        assert abs(part.value) < 4 * part.error
    mean, error = block_mean_and_error(slab_run.normal_pressure_profile.values)
    assert np.abs(mean - mean.mean()).max() < 5 * error.max()  # the same everywhere
    tangential, _ = block_mean_and_error(slab_run.tangential_pressure_profile.values)
    assert np.abs(tangential - mean.mean()).max() > 10 * error.max()


def made_up(missing=(0.0, 0.0), drift=0.0, **changes):
    """A run with a given p_N - p_T at interfaces and in bulks, and slabs whose minority grows."""
    profiles = [{"profile": {"every": 10}}, {"stress_profile": {"bin": 0.5}}]
    scene = Scene(SLABS | {"box": [5, 5, 20], "observe": profiles} | changes)
    rng, place = np.random.default_rng(3), (np.arange(40) + 0.5) * 0.5
    near = np.minimum(np.abs((place + 10) % 20 - 10), np.abs(place - 10)) < 1.5
    normal = np.where(near, *missing) + rng.normal(0, 1e-3, (50, 40))
    density = [profile(0, 10, 1.5, 0.02 + drift * n, 4000, n) for n in range(50)]
    return xr.Dataset(
        {
            "density_profile": (("block", "species", "z"), density),
            "normal_pressure_profile": (("block", "slice"), 20 + normal),
            "tangential_pressure_profile": (("block", "slice"), np.full((50, 40), 20.0)),
        },
        {"z": (np.arange(100) + 0.5) * 0.2, "slice": place},
        {"scene": json.dumps(scene.data)},
    )


def test_profile_and_bulks_of_what_was_made_up():
    """Tension 1.2 from 6 r_c with 0.4; bulks that are off, and slabs that dissolve, are seen."""
    found = slab_tension(made_up((0.4, 0.0)))
    assert found.of_profile.value == pytest.approx(0.4 * 6 / 2, abs=4e-3)
    assert max(abs(part.value) for part in found.bulks) < 1e-3
    off, dissolving = slab_tension(made_up((0.4, 0.1))), slab_tension(made_up(drift=5e-4))
    assert all(part.value == pytest.approx(0.1, abs=1e-3) for part in off.bulks)
    assert found.settled and not dissolving.settled


def test_what_is_missing_is_said():
    """Observables, walls, species, a box that changes."""
    for change, said in (
        ({"observe": [{"stress_profile": {}}]}, "observe 'profile' and 'stress_profile'"),
        (ONE, "1 species"),
        ({"walls": {"axis": "z", "repulsion": 25}}, "without walls"),
        ({"pressure": {"target": 23, "axes": "z", "time": 1}}, "without walls"),
    ):
        with pytest.raises(UserError, match=said):
            slab_tension(made_up(**change))
