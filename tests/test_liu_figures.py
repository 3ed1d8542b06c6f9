"""Numbers that the figures of Liu et al. 2008 read off their runs, on curves that are known."""

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.resampling import Resampled
from dpd.report.figures import load_module
from paper_figures.liu_2008.shared import too_small

PAPER = "liu_2008"
TIME = np.geomspace(0.1, 100, 60)


def curve(values):
    """A displacement that is the same whatever is left out."""
    rows = np.tile(values, (5, 1))
    return Resampled(TIME, values, rows, rows)


def test_elongation_of_rods_and_rings():
    """1 and 0; a rod along a diagonal is still a rod."""
    along = np.linspace(-1, 1, 50)
    angle = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    chains = np.stack([[along, along], [np.cos(angle), np.sin(angle)]], axis=1)
    found = load_module(PAPER, "fig04_snapshot").elongations(chains)
    assert found == pytest.approx([1.0, 0.0], abs=1e-12)


def test_where_a_chain_goes_over_to_free_diffusion():
    """g_i = t + t^(1/2) and g_cm = t: the ratio is 2 at t = 1, whatever the grid."""
    figure = load_module(PAPER, "fig06_displacement")
    inner, centre = curve(TIME + TIME**0.5), curve(TIME)
    assert figure._meeting(inner, centre)[0] == pytest.approx(1.0, rel=2e-3)
    assert np.isnan(figure._meeting(curve(10 * TIME), centre)[0])


def test_how_far_early_displacements_are_apart():
    """3 % where they are so; what happens later than the shortest chain's size does not count."""
    figure = load_module(PAPER, "fig06_displacement")
    short = np.where(TIME < 10, 1.03, 2.0) * TIME
    apart, error = figure._apart_early({20: curve(short), 100: curve(TIME)}, 5.0)
    assert apart == pytest.approx(0.03)
    assert error == pytest.approx(0.0, abs=1e-12)


def test_drift_of_the_closest_contact():
    """First bins drawn evenly over a decade's logarithm fall; fixed ones do not."""
    figure = load_module(PAPER, "fig02_radial_distribution")
    r = np.arange(0.005, 1.0, 0.01)
    first = np.random.default_rng(1).integers(20, 40, size=50)
    falling = (np.arange(len(r)) >= first[:, None]).astype(float)
    slope, error = figure._drift(r, falling)
    assert slope < -3 * error < 0
    assert figure._drift(r, np.tile(falling[:1], (50, 1))) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert np.isnan(figure._drift(r, falling[:20])[0])


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
    assert steep["misfit"] > 0.03 and steep["plateau"] > 0.2
    assert steep["exponent"] == pytest.approx(2.5)


def test_the_share_at_our_core_and_what_one_bin_is_worth():
    """ln share falls by 100 per r_c: one bin is a factor of e."""
    figure = load_module(PAPER, "bond_lengths")
    rest = np.array([0.24, 0.25, 0.26, 0.27])
    share = 1e-3 * np.exp(-100 * (rest - 0.25))
    data = xr.Dataset(
        {"share": ("rest_length", share), "share_error": ("rest_length", 1e-3 * share),
         "core": ("set", [0.25])},
        {"rest_length": rest, "set": ["set_1"]}, {"bin": 0.01, "undecided": ""},
    )  # fmt: skip
    found = figure._share(data)
    assert found.value == pytest.approx(-3.0)
    assert found.error == pytest.approx(np.log10(np.e), rel=0.01)


@pytest.mark.parametrize(
    ("duration", "edge", "enough"), [(1e4, 100, True), (1e4, 40, False), (1400, 100, False)]
)
def test_claims_on_long_runs_wait_for_long_runs(duration, edge, enough):
    """Both the time and the box must be there."""
    reason = too_small(xr.Dataset({"duration": duration, "box_edge": edge}))
    assert (reason == "") == enough
