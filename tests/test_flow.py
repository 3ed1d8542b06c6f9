"""Viscosity, slip, pressure and diffusion, of the standard fluid, which has 0.85, and made-up."""

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.analysis.statistics import mean_and_error
from dpd.analysis.viscosity import (
    shear_components,
    viscosity_of_fluctuations,
    viscosity_of_two_flows,
)
from dpd.scene.scene import Scene
from paper_figures.cerius2_1998.channel import channel_flow
from paper_figures.groot_warren_1997.shared import noise_ratio
from paper_figures.groot_warren_1997.spreading import diffusion_of_labels
from paper_figures.groot_warren_1997.transport_theory import (
    diffusion_constant,
    kinematic_viscosity,
    schmidt_number,
    slowed_by_images,
)
from tests.conftest import SCENE

STRENGTH = 0.03
EDGE, APART = 14.0, 12.0  # of the box with two flows, and of the walls
TWO_FLOWS = SCENE | {
    "box": [6, 6, EDGE],
    "body_force": {"axis": "x", "strength": STRENGTH, "opposite": "z"},
    "steps": {"equilibrate": 2000, "sample": 15_000},
    "observe": ["thermo", {"velocity_profile": {"every": 5, "bin": 0.5}}],
}
CHANNEL = TWO_FLOWS | {
    "box": [5, 5, APART],
    "walls": {"axis": "z", "repulsion": 25, "gamma": 4.5},
    "body_force": {"axis": "x", "strength": STRENGTH},
    "observe": [{"thermo": {"every": 20}}, {"walls": {"every": 2}}, "profile",
                {"velocity_profile": {"every": 5, "bin": 0.25}}],
}  # fmt: skip


@pytest.fixture(scope="module")
def two_flows():
    """Two opposite flows in a periodic box."""
    return dpd.run(TWO_FLOWS, progress=False)


@pytest.fixture(scope="module")
def channel():
    """A flow between rough walls, six times as long.

    The error of its slip is 0.02 to 0.04 in six runs with other seeds; in runs of 15 000 steps it
    is 0.05 to 0.16, as so few samples do not fix an error.
    """
    steps = {"equilibrate": 2000, "sample": 90_000}
    return dpd.run(CHANNEL | {"steps": steps}, progress=False)


def profile(velocity, layer, density=3.0):
    """A dataset as runs have it, with the velocity along the first of three axes."""
    blocks = np.zeros((50, 3, len(layer)))
    blocks[:, 0] = velocity
    return xr.Dataset({
        "layer": ("layer", layer),
        "velocity_profile": (("block", "axis", "layer"), blocks),
        "bead_profile": (("block", "layer"), np.full((50, len(layer)), density)),
    })  # fmt: skip


def in_layers(flow, edges):
    """Mean of a function over each layer, to rounding for a parabola."""
    low, high = edges[:-1], edges[1:]
    return (flow(low) + 4 * flow(0.5 * (low + high)) + flow(high)) / 6


def test_parabolas_are_found_exactly():
    """Of both kinds, with thick layers; a drift of the whole box does not count."""
    edges = np.linspace(0, 12, 13)
    middle = 0.5 * (edges[1:] + edges[:-1])
    one = in_layers(lambda z: 0.3 * z * (6 - z), edges[:7])
    found = viscosity_of_two_flows(profile(np.concatenate([one, -one]) + 0.2, middle), 0.1, 12.0)
    assert found.value == pytest.approx(3 * 0.1 / 0.6, rel=1e-12)
    flow = in_layers(lambda z: 0.02 * (z + 0.7) * (12.7 - z), edges)
    found = channel_flow(profile(flow, middle), 0.1, 12.0)
    assert found.viscosity.value == pytest.approx(3 * 0.1 / 0.04, rel=1e-12)
    assert found.slip.value == pytest.approx(0.02 * 0.7 * 12.7 / (0.02 * 12), rel=1e-12)


def test_errors_are_the_scatter_of_blocks():
    """Profiles with known noise: errors as from the estimates of many such runs, within 25 %."""
    rng, edges = np.random.default_rng(2), np.linspace(0, 12, 25)
    middle = 0.5 * (edges[1:] + edges[:-1])
    flow = in_layers(lambda z: 0.02 * (z + 0.7) * (12.7 - z), edges)
    found = []
    for _ in range(300):
        run = profile(flow + 0.02 * rng.normal(size=(50, 24)), middle)
        found.append([part for value in channel_flow(run, 0.1, 12.0) for part in value])
    eta, eta_error, slip, slip_error = np.array(found).T
    assert np.median(eta_error) == pytest.approx(eta.std(), rel=0.25)
    assert np.median(slip_error) == pytest.approx(slip.std(), rel=0.25)


@pytest.mark.thorough
def test_two_flows_give_the_common_viscosity(two_flows):
    """0.85 within 0.02 and three standard errors, of which one is below 4 %."""
    found = viscosity_of_two_flows(two_flows, STRENGTH, EDGE)
    assert found.error < 0.04 * found.value
    assert abs(found.value - 0.85) < 0.02 + 3 * found.error


@pytest.mark.thorough
def test_two_flows_heat_and_press_as_a_fluid_at_rest(two_flows):
    """kT and pressure are about the flow, and the pressure is the same along all axes."""
    about, kT = float(two_flows.temperature_profile.mean()), two_flows.kT.attrs
    assert 0.99 < kT["mean"] < 1.06 and abs(kT["mean"] - about) < 0.01 + 4 * kT["error"]
    xx, yy, zz = (mean_and_error(two_flows.pressure_tensor.values[:, k, k]) for k in range(3))
    for other in (yy, zz):
        assert abs(xx[0] - other[0]) < 4 * np.hypot(xx[1], other[1])
    assert abs(two_flows.pressure.attrs["mean"] - 23.75) < 0.1


@pytest.mark.thorough
def test_rough_walls_hold_the_fluid(channel):
    """Viscosity as in the bulk, of a fluid that is a little denser; no slip within 0.15 r_c.

    Each takes up half of the force that drives the flow, 3 * 0.03 * 12 / 2 per area.
    """
    found = channel_flow(channel, STRENGTH, APART)
    assert abs(found.viscosity.value - 0.87) < 0.04 + 3 * found.viscosity.error
    assert abs(found.slip.value) < 0.15 + 3 * found.slip.error
    assert found.slip.error < 0.1
    for wall in (0, 1):
        mean, error, _ = mean_and_error(channel.wall_friction.values[:, wall, 0])
        assert error < 0.07
        assert abs(mean - 3 * STRENGTH * APART / 2) < 4 * error


def test_the_pressure_on_walls_is_that_of_the_bulk():
    """Of a fluid at rest: equal on both, and that of a periodic box of the density in the middle.

    Within four standard errors, and 0.5 % for the error of the density.
    """
    rest = CHANNEL | {"body_force": {"axis": "x", "strength": 0}}
    run = dpd.run(rest | {"steps": {"equilibrate": 500, "sample": 6000}}, progress=False)
    walls = [mean_and_error(run.wall_pressure.values[:, wall])[:2] for wall in (0, 1)]
    means, errors = np.transpose(walls)
    assert abs(means[0] - means[1]) < 4 * np.hypot(*errors)
    middle = (run.z > 3) & (run.z < APART - 3)
    density = float(run.density_profile.mean("block")[0][middle].mean())
    assert 3.05 < density < 3.15
    bulk = TWO_FLOWS | {"box": 6, "observe": [{"thermo": {"every": 5}}]}
    bulk["molecules"] = [{"architecture": "A", "count": round(216 * density)}]
    del bulk["body_force"]
    periodic = dpd.run(bulk | {"steps": {"equilibrate": 500, "sample": 4000}}, progress=False)
    mean, error, _ = mean_and_error(periodic.pressure.values)
    # 1 / (kappa kT) = 16: what a bead more in the bulk box changes is 0.3 %
    off = abs(np.mean(means) - mean)
    assert off < 4 * np.hypot(error, np.hypot(*errors) / 2) + 0.005 * mean


@pytest.mark.thorough
def test_moving_walls_shear_the_fluid():
    """Couette flow: a straight profile between the velocities of the walls, and one stress."""
    walls = CHANNEL["walls"] | {"velocity": [[-1, 0, 0], [1, 0, 0]]}
    scene = CHANNEL | {"walls": walls, "body_force": {"axis": "x", "strength": 0}}
    run = dpd.run(scene, progress=False)
    bulk = (run.layer > 2) & (run.layer < APART - 2)
    flow = run.velocity_profile.mean("block")[0][bulk].values
    slope, middle = np.polyfit(run.layer[bulk] - APART / 2, flow, 1)
    assert abs(middle) < 0.05
    assert 0.9 < slope * APART / 2 < 1.1
    stress = [mean_and_error(run.wall_friction.values[:, wall, 0])[:2] for wall in (0, 1)]
    (low, low_error), (high, high_error) = stress
    assert abs(low + high) < 4 * np.hypot(low_error, high_error)
    eta, error = (low - high) / (2 * slope), np.hypot(low_error, high_error) / (2 * slope)
    assert abs(eta - 0.87) < 0.05 + 3 * error


def test_axes_across_which_the_fluid_changes():
    """Walls first, then that across which a force turns round; a shear's where there are none."""
    data = SCENE | {"box": [6, 9, 6], "observe": ["thermo"]}
    force = {"body_force": {"axis": "x", "strength": 0.1, "opposite": "y"}}
    walls = {"walls": {"axis": "z", "repulsion": 25, "gamma": 5}}
    shear = {"shear": {"rate": 0.1, "gradient": "z"}}
    for change, axes in (
        (force | walls, (2, 1)), (walls, (2,)), (shear, (2,)), (force | shear, (1,)), ({}, (1,)),
    ):  # fmt: skip
        assert Scene(data | change).across == axes


RNG = np.random.default_rng(42)
DT, VOLUME, KT = 0.04, 125.0, 1.02


def tensors(steps, spread, memory=0.0):
    """Pressure tensors of an isotropic fluid whose shear stresses scatter by ``spread``.

    Each step remembers the share ``memory`` of the one before.
    """
    fresh = RNG.normal(size=(steps, 3, 3)) * spread
    fresh[:, [0, 1, 2], [0, 1, 2]] *= np.sqrt(2)
    for a, b in ((0, 1), (0, 2), (1, 2)):
        fresh[:, b, a] = fresh[:, a, b]
    found = np.empty_like(fresh)
    found[0] = fresh[0]
    for n in range(1, steps):
        found[n] = memory * found[n - 1] + np.sqrt(1 - memory**2) * fresh[n]
    return found + 20 * np.eye(3)


def test_components_have_one_variance():
    """Five that do not depend on each other, and none of the mean pressure."""
    parts = shear_components(tensors(20000, 0.3))
    assert np.cov(parts.T) == pytest.approx(0.09 * np.eye(5), abs=0.004)
    assert np.abs(parts.mean(axis=0)).max() < 0.02


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_viscosity_of_known_noise(memory):
    """s^2 dt V / (2 kT) of white noise, and more by (1 + m) / (1 - m) with a memory m."""
    exact = 0.3**2 * DT * VOLUME / (2 * KT) * (1 + memory) / (1 - memory)
    found = [
        viscosity_of_fluctuations(tensors(20000, 0.3, memory), DT, VOLUME, KT, 1.2)
        for _ in range(6)
    ]
    for each in found:
        assert 0 < each.error < 0.15 * exact
        assert abs(each.value - exact) < 4.5 * each.error
    mean = np.mean([each.value for each in found])
    assert mean == pytest.approx(exact, rel=0.06)


def test_ratio_of_noises():
    """Of means: what is correlated counts with its sum, what is not with its root."""
    white = RNG.normal(size=(40000, 5))
    slow = np.repeat(RNG.normal(size=(4000, 5)), 10, axis=0)
    found = noise_ratio(slow, white, 100)
    assert found.value == pytest.approx(np.sqrt(10), abs=4 * found.error)
    assert 0 < found.error < 0.2
    assert noise_ratio(2 * white, white, 1).value == pytest.approx(2)


def test_labels_spread():
    """The wave's decay gives D, whatever else is in the profile; errors come from the runs."""
    z = np.arange(14) + 0.5
    time, q = np.linspace(0.4, 40, 50), 2 * np.pi / 14
    wave = 1.9 * np.exp(-0.3 * q**2 * time)[:, None] * np.sin(q * z)
    wave = wave + 0.3 * np.exp(-2.7 * q**2 * time)[:, None] * np.sin(3 * q * z)
    both = np.stack([1.5 + wave / 2, 1.5 - wave / 2], axis=1)
    exact = diffusion_of_labels(both[None], z, time, 14.0)
    assert exact.diffusion.value == pytest.approx(0.3, rel=1e-6)
    assert np.isnan(exact.diffusion.error)
    assert exact.height == pytest.approx(1.9)
    runs = both + 0.05 * RNG.normal(size=(8, *both.shape))
    found = diffusion_of_labels(runs, z, time, 14.0)
    assert 0 < found.diffusion.error < 0.02
    assert abs(found.diffusion.value - 0.3) < 4 * found.diffusion.error
    assert found.wave.shape == (8, 50)


def test_theory_of_the_paper():
    """Groot and Warren 1997, Sec. VII, at gamma 6.75 and density 3."""
    assert float(diffusion_constant(6.75, 3)) == pytest.approx(0.354, abs=5e-4)
    assert float(kinematic_viscosity(6.75, 3)) == pytest.approx(0.258, abs=5e-4)
    assert float(schmidt_number(6.75, 3)) == pytest.approx(0.728, abs=5e-4)
    gamma = np.array([1.0, 20.0])
    eq_37 = 0.5 + (2 * np.pi * gamma * 3) ** 2 / 70875
    assert schmidt_number(gamma, 3) == pytest.approx(eq_37)


def test_images_slow_a_bead_less_in_a_larger_box():
    """As one over the edge, and over the density times the sum of nu and D."""
    one = float(slowed_by_images(10, 3, 0.2, 0.1))
    assert one == pytest.approx(2.837297 / (6 * np.pi * 9))
    assert slowed_by_images(20, 1.5, 0.05, 0.25, 2.0) == pytest.approx(2 * one)
