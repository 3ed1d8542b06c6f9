"""What figures make of data whose answers are known: Groot and Warren, Liu et al., the manual."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.diffusion import Resampled
from dpd.analysis.published import published
from dpd.analysis.verdicts import judge
from dpd.report.figures import load_module
from paper_figures.cerius2_1998 import morphology
from paper_figures.liu_2008.plateau import plateau

PAPER = "liu_2008"
RNG = np.random.default_rng(8)
FLUID = {
    "dimension": 3, "box": 10, "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"sample": 100},
}  # fmt: skip


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


EDGE, CELLS = FLUID["box"], 16


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
    runs = xr.Dataset(
        {
            "density_field": (("replica", "frame", "species", "x", "y", "z"), field),
            "field_time": (("replica", "frame"), 2.0 + 4.0 * np.arange(frames)[None]),
            "scene": ("replica", [json.dumps(FLUID)]),
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


def module(figure):
    """The file of a figure."""
    return load_module("groot_warren_1997", figure)


@pytest.mark.parametrize("apart, verdict", [(0.0, "replicated"), (0.01, "deviates")])
def test_two_kinds_of_noise(apart, verdict):
    """Temperatures that differ by 1 % are told apart, however far from 1 they are."""
    true = np.array([1, 3])[:, None, None] * np.array([1, 1 + apart])[:, None] * np.ones(8)
    along, error = ("scheme", "noise", "dt"), 0.001 * true
    data = xr.Dataset(
        {
            "excess": (along, true - 1 + RNG.normal(0, error)),
            "error": (along, error),
            "degrees": (along, np.full(true.shape, np.inf)),
        },
        {"noise": ["uniform", "gaussian"]},
    )
    found = module("fig01_time_step").between_noises(data)
    limits = published("groot_warren_1997")["noise_difference"]
    assert judge(limits, found).verdict == verdict


def test_best_lambda_is_where_the_temperature_is_right():
    """Zero of a parabola through kT - 1."""
    factor = np.array([0.5, 0.55, 0.6, 0.65, 0.7])
    data = xr.Dataset(
        {
            "at_lambda": ("lambda", -0.4 * (factor - 0.67) + 0.3 * (factor - 0.67) ** 2),
            "at_lambda_error": ("lambda", np.full(5, 0.002)),
        },
        {"lambda": factor},
    )
    temperature = module("text_temperature")
    assert temperature.best_lambda(data).value == pytest.approx(0.67)


def widths_over(chi, power):
    """Interface widths of Eq. 35, where their inverse squares are a line in chi to a power."""
    true = 3.24 / np.sqrt(3 * (chi - 2.39) ** power)
    return xr.Dataset(
        {
            "chi": ("excess", chi),
            "width": ("excess", true * (1 + RNG.normal(scale=0.01, size=6))),
            "width_error": ("excess", 0.01 * true),
            "fitted": ("excess", np.ones(6, dtype=bool)),
        }
    )


def test_width_against_chi():
    """Eq. 35 put in comes out, with errors that hold; points off a line decide nothing."""
    widths, chi = module("text_interface_width"), np.linspace(2.6, 3.9, 6)
    found = [widths.line(widths_over(chi, 1.0), 3, 0.5) for _ in range(100)]
    for name, true in (("amplitude", 3.24), ("critical", 2.39)):
        pulls = [(each[name] - true) / each[f"{name}_error"] for each in found]
        # Errors are widened where points scatter more by chance: a little narrower than 1.
        assert abs(np.mean(pulls)) < 0.4 and 0.6 < np.std(pulls) < 1.2
    refused = [
        sum(
            "straight line" in widths.of_line(widths_over(chi, power), 3, 0.5, "critical").undecided
            for _ in range(100)
        )
        for power in (1.0, 1.3)
    ]
    assert refused[0] <= 6 and refused[1] >= 94
    few = widths.of_line(widths_over(chi, 1.0).isel(excess=slice(4, 6)), 3, 0.5, "critical")
    assert "fewer than three" in few.undecided
