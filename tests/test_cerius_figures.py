"""Figures of the manual of 1998, on made-up numbers."""

import json

import numpy as np
import pytest
import xarray as xr

from paper_figures.cerius2_1998 import copolymer_melts, morphology, viscosity

EDGE, CELLS = 10.0, 16


def ball(radius):
    """Density of A: 3 in a ball in the middle of the box, 0 outside."""
    place = (np.arange(CELLS) + 0.5) * EDGE / CELLS - EDGE / 2
    apart = np.sqrt(sum(part**2 for part in np.meshgrid(place, place, place, indexing="ij")))
    return np.where(apart < radius, 3.0, 0.0)


@pytest.fixture
def triblock():
    """Runs in which A is spread evenly at first and in a ball afterwards."""
    frames, radius = 40, 3.5
    late = ball(radius)
    field = np.zeros((1, frames, 2, CELLS, CELLS, CELLS), np.float32)
    field[:, :, 0] = late
    field[:, 0, 0] = late.mean()
    scene = {
        "dimension": 3, "box": EDGE, "molecules": [{"architecture": "A", "density": 3}],
        "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
        "steps": {"sample": 10},
    }  # fmt: skip
    runs = xr.Dataset(
        {
            "density_field": (("replica", "frame", "species", "x", "y", "z"), field),
            "field_time": (("replica", "frame"), 2.0 + 4.0 * np.arange(frames)[None]),
            "scene": ("replica", [json.dumps(scene)]),
        },
        {"species": ["A", "W"]},
    )
    return {"triblock": runs}


def test_where_a_resides(triblock):
    """A is in the ball, and the surface of the smoothed density stands a little out from it."""
    data = morphology.compute(triblock)
    assert list(data.shown_time.values[[0, -1]]) == [2.0, 158.0]
    assert float(data.inside[0]) == float(data.volume[0]) == 1.0  # evenly spread, above 0.4
    found = morphology.measured(data)
    least, most = (1 / float((ball(radius) > 0).mean()) for radius in (4.5, 3.5))
    assert least < found["resides"].value < most


def test_vectors_of_a_lattice():
    """Multiples of one vector; sums of three at 60 degrees; none without a lattice."""
    vectors = np.array([[1, 0, 0], [3, 0, 0], [0, 2, 0], [1, 1, 0], [1, -2, 0], [0.5, 0, 0]])
    along = copolymer_melts.on_lattice(vectors, vectors[:1])
    assert along.tolist() == [True, True, False, False, False, False]
    root = np.sqrt(3) / 2
    first = np.array([[1, 0, 0], [0.5, root, 0], [0.5, -root, 0]])
    others = np.array([[0, 2 * root, 0], [2, 0, 0], [2.5, root, 0], [0, root, 0], [1, 0, 1]])
    found = copolymer_melts.on_lattice(others, first)
    assert found.tolist() == [True, True, True, False, False]
    assert not copolymer_melts.on_lattice(others, np.empty((0, 0))).any()


ETA, FORCE, BLOCKS = 0.8, 0.02, 30


def scene_of(box, **more):
    """Of the standard fluid, as JSON."""
    return json.dumps({
        "dimension": 3, "box": box, "molecules": [{"architecture": "A", "density": 3}],
        "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
        "steps": {"sample": 10}, **more,
    })  # fmt: skip


def flow(z, profile, scene):
    """A run with this velocity along x, up to noise, at density 3."""
    rng = np.random.default_rng(3)
    velocity = rng.normal(scale=0.002, size=(1, BLOCKS, 3, len(z)))
    velocity[:, :, 0] += profile
    return xr.Dataset(
        {
            "velocity_profile": (("replica", "block", "axis", "layer"), velocity),
            "bead_profile": (("replica", "block", "layer"), np.full((1, BLOCKS, len(z)), 3.0)),
            "scene": ("replica", [scene]),
        },
        {"layer": z},
    )


def at_rest(steps):
    """A run whose stress is noise of each step, as strong as belongs to the viscosity."""
    variance = 2 * ETA / (5**3 * 0.04)
    noise = np.random.default_rng(4).normal(scale=np.sqrt(variance), size=(1, steps, 3, 3))
    tensor = (noise + noise.swapaxes(2, 3)) / np.sqrt(2)  # and so twice that on the diagonal
    return xr.Dataset({
        "pressure_tensor_all_series": (("replica", "time", "axis", "axis_2"), tensor),
        "kT": ("replica", [1.0]), "scene": ("replica", [scene_of(5)]),
    })  # fmt: skip


@pytest.fixture
def flows():
    """A fluid at rest, shear, two opposite flows, and channels with slip lengths of 0.5 and 0.1."""
    rates = np.array([0.2, 0.4])
    stress = {"units": "kT / r_c^3"}
    shear = xr.Dataset(
        {
            "shear_stress": (("rate", "replica"), ETA * rates[:, None], stress),
            "shear_stress_error": (("rate", "replica"), np.full((2, 1), 0.004), stress),
            "kT": (("rate", "replica"), np.ones((2, 1))),
            "scene": (("rate", "replica"), [[scene_of(10, shear={"rate": r})] for r in rates]),
        },
        {"rate": rates},
    )
    z = (np.arange(40) + 0.5) / 2
    bend = 3 * FORCE / (2 * ETA)
    up = np.where(z < 10, z * (10 - z), -(z - 10) * (20 - z))
    body = {"axis": "x", "strength": FORCE}
    two = flow(z, bend * up, scene_of([7, 7, 20], body_force=body | {"opposite": "z"}))
    z = np.arange(-0.375, 10.4, 0.25)
    walls = {"axis": "z", "repulsion": 25, "gamma": 5}
    channel = [
        flow(
            z, bend * (z * (10 - z) + 10 * slip), scene_of([8, 8, 10], body_force=body, walls=walls)
        )
        for slip in (0.5, 0.1)
    ]
    channels = xr.concat(channel, xr.DataArray([2.0, 15.0], dims="gamma", name="gamma"))
    return {"at_rest": at_rest(20000), "shear": shear, "two_flows": two, "channel": channels}


def test_viscosity_and_slip_of_known_flows(flows):
    """All ways give the viscosity that the profiles were made with, and the slip lengths."""
    data = viscosity.compute(flows)
    found = viscosity.measured(data)
    assert float(data.rest_eta) == pytest.approx(ETA, abs=4 * float(data.rest_eta_error))
    for name in ("viscosity_shear", "viscosity_two_flows", "viscosity_walls"):
        assert found[name].value * float(data.rest_eta) == pytest.approx(ETA, abs=0.002)
        assert 0 < found[name].error < 0.05
    assert found["newtonian"].value == pytest.approx(1)
    assert data.slip.values == pytest.approx([0.5, 0.1], abs=0.1)
    assert data.two_curve.values == pytest.approx(data.two_u.values, abs=0.01)
    assert data.wall_curve.values == pytest.approx(data.wall_u.values, abs=0.02)
