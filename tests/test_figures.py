"""What figures of Liu et al. 2008, and of the manual of 1998, read off data that are known."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.diffusion import Resampled
from dpd.analysis.published import published
from dpd.report.figures import load_module
from paper_figures.cerius2_1998 import copolymer_melts, morphology
from paper_figures.liu_2008.plateau import plateau

PAPER = "liu_2008"
TIME = np.geomspace(0.1, 100, 60)


def curve(values):
    """A displacement that is the same whatever is left out."""
    rows = np.tile(values, (5, 1))
    return Resampled(TIME, values, rows, rows)


def test_shapes_of_ideal_chains():
    """The measure of how diverse chains are: itself in units of itself; one shape alone is not."""
    figure = load_module(PAPER, "fig04_snapshot")
    ideal = figure._ideal(50)
    assert 0.18 < ideal.std() < 0.24 and 0.5 < ideal.mean() < 0.7
    for shapes, ratio in ((ideal[:400], 1.0), (0 * ideal[:400] + 0.6, 0.0)):
        data = xr.Dataset({"elongation": ("chain", shapes), "position": ("bead", np.zeros(50))})
        names = ("gyration_square", "crossings", "most_crossings", "steps")
        found = figure.measured(data.assign(dict.fromkeys(names, 1.0)))["shape_spread"]
        assert found.value == pytest.approx(ratio, abs=0.1)


def rouse_chain(beads, time):
    """g_i of a middle bead, 4 <l^2> and R_g^2 of an ideal chain in a plane (Doi and Edwards)."""
    modes = np.arange(1, beads)
    rate = 4 * np.sin(np.pi * modes / (2 * beads)) ** 2  # spring, friction and kT are 1
    shape = 2 / beads * np.cos(np.pi * modes * (beads // 2 + 0.5) / beads) ** 2
    inner = 4 * time / beads + 4 * (1 - np.exp(-np.outer(time, rate))) @ (shape / rate)
    return inner, 4 * 2.0, float((2 / rate).sum() / beads)


@pytest.mark.parametrize("beads", [50, 100, 200])
def test_ideal_chains_have_no_plateau(beads):
    """Their slope falls through 8/15, over less time than a plateau has to last."""
    time = np.geomspace(0.01, 1e6, 300)
    inner, low, high = rouse_chain(beads, time)
    rows = np.tile(inner, (5, 1))
    found = plateau(Resampled(time, inner, rows, rows), 8 / 15, 0.03, low, high)
    limit, _ = published(PAPER)["level"]["range"]
    assert 0.5 < found.decades < 0.9 < limit
    assert low <= found.low < found.high <= high


def pressures(exponent):
    """An equation of state of which the excess is a power of the density."""
    rho = np.array([1.0, 2.25, 2.5, 3, 3.5, 4, 4.5, 5, 5.5])
    excess = 3.0 * rho**exponent
    return xr.Dataset(
        {"excess": ("density", excess), "excess_error": ("density", 1e-3 * excess)},
        {"density": rho},
    )


def test_a_parabola_and_what_is_none():
    """No distance for n = 2; more than a symbol's size for n = 2.5, and n itself."""
    figure = load_module(PAPER, "fig05_pressure")
    parabola, steep = figure._fits(pressures(2.0)), figure._fits(pressures(2.5))
    assert parabola["misfit"] == pytest.approx(0.0, abs=1e-12)
    assert parabola["kappa"] == pytest.approx(3.0 / 25.0)
    assert steep["misfit"] > 0.03
    assert steep["exponent"] == pytest.approx(2.5)
    # As the paper's Fig. 5b has it, the ideal term counts: P / rho^2 = 1 / rho + 3 rho^(n - 2).
    rho = np.array([2.25, 2.5, 3, 3.5, 4, 4.5, 5, 5.5])
    for n in (2.0, 2.5):
        scaled = 1 / rho + 3 * rho ** (n - 2)
        spread, error = figure.spread(pressures(n))
        assert spread == pytest.approx((scaled.max() - scaled.min()) / scaled.mean())
        assert 0 < error < 0.002


def test_the_share_at_our_core_and_what_its_error_is_worth():
    """ln share falls by 100 per r_c: an error of 0.01 is a factor of e."""
    figure = load_module(PAPER, "bond_lengths")
    rest = np.array([0.24, 0.25, 0.26, 0.27])
    share = 1e-3 * np.exp(-100 * (rest - 0.25))
    data = xr.Dataset(
        {"share": ("rest_length", share), "share_error": ("rest_length", 1e-3 * share),
         "core": ("set", [0.25]), "core_error": ("set", [0.01])},
        {"rest_length": rest, "set": ["set_1"]}, {"undecided": ""},
    )  # fmt: skip
    found = figure._share(data)
    assert found["share"].value == pytest.approx(-3.0)
    assert found["share"].error == pytest.approx(np.log10(np.e), rel=0.01)
    there = 0.25 - np.log(figure.SHARE / 1e-3) / 100  # of the printed share
    assert found["share_contact"].value == pytest.approx(there / 0.3)


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
