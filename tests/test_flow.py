"""Viscosity, slip and pressure from flows of the standard fluid: density 3, a 25, gamma 4.5.

Its viscosity is about 0.85, a common value, which our runs under shear find too. The runs here take
some seconds each.
"""

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.analysis.statistics import mean_and_error
from dpd.analysis.viscosity import channel_flow, viscosity_of_two_flows
from dpd.scene.scene import Scene
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
