"""What figures of the papers make of data whose answers are known."""

import json

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt

from dpd.analysis.collect import load
from dpd.analysis.diffusion import Resampled
from dpd.analysis.verdicts import judge, published
from dpd.errors import UserError
from dpd.report.archive import ARCHIVE
from dpd.report.figures import load_module
from dpd.theory.equation_of_state import BETA, ETA, crgw
from paper_figures.cerius2_1998 import morphology
from paper_figures.crgw_2019 import fig02_mismatch, fig07_solutes, mixtures, shared
from paper_figures.crgw_2019.mixing import chain_potential, monomer_potential
from paper_figures.liu_2008.plateau import plateau
from tests import conftest

PAPER = "liu_2008"
RNG = np.random.default_rng(8)
FLUID = conftest.SCENE | {"box": 10}


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
    assert 0.5 < found.decades < 0.9 < published(PAPER)["level"]["range"][0]
    assert low <= found.low < found.high <= high


@pytest.mark.thorough
@pytest.mark.parametrize("path", sorted(ARCHIVE.glob("paper/*/*.nc")), ids=lambda path: path.stem)
def test_a_figure_is_drawn_where_nothing_is_measured(path, tmp_path):
    """As in runs that are too short; and says what is seen."""
    module, data = load_module(path.parent.name, path.stem), load(path)
    names = [name for name in data if name.endswith("_error") or f"{name}_error" in data]
    data = data.assign({n: data[n].where(False) for n in names if data[n].dtype.kind == "f"})
    module.draw(data).savefig(tmp_path / "drawn.png")
    plt.close("all")
    assert getattr(module, "describe", lambda data: module.TITLE)(data)


def test_a_curve_of_every_length():
    """Palettes begin anew where they end."""
    data = load(ARCHIVE / "paper/nikunen_2007/fig04_chains.nc").isel(chain=np.arange(20) % 8)
    data = data.assign_coords(chain=np.arange(8.0, 28))
    figure = load_module("nikunen_2007", "fig04_chains").draw(data)
    assert len(figure.axes[1].get_legend().get_texts()) == 20


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
    evenly = data.isel(frame=0).sum("eighth")
    assert float(evenly.inside) == float(evenly.volume) == 1.0  # spread evenly, above 0.4
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


SCENE = {
    "dimension": 3, "box": 8, "molecules": [{"architecture": "A 2", "count": 500}],
    "repulsion": {"A A": 25}, "bond": {"stiffness": 500, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.01}, "steps": {"sample": 10},
}  # fmt: skip


def runs(values, coordinates, scene=SCENE):
    """A collected sweep: each value over all axes but replica, with an error of a hundredth."""
    dims = tuple(coordinates)
    shape = tuple(len(labels) for labels in coordinates.values())
    data = xr.Dataset(coords=coordinates)
    for name, value in values.items():
        full = np.broadcast_to(value, shape)[..., None]
        data[name] = ((*dims, "replica"), full.astype(float))
        data[f"{name}_error"] = ((*dims, "replica"), 0.01 * np.abs(full))
        data[f"{name}_spread"] = ((*dims, "replica"), 0.1 * np.abs(full))
    data["scene"] = ((*dims, "replica"), np.full((*shape, 1), json.dumps(scene)))
    return data


def test_mismatches_are_relative_to_the_simulated_pressure():
    """Predictions of 10 and 20 percent more; the worst is found; mean bonds over those asked."""
    axes = {"chain": [2, 8], "density": [3, 5], "bond": [0.4], "repulsion": [20]}
    pressure = np.array([[20.0, 50.0], [10.0, 40.0]])[..., None, None]
    simulated = runs({"pressure": pressure}, axes)
    simulated["bond_mean"] = ((*axes, "replica", "block"), np.full((2, 2, 1, 1, 1, 3), 0.402))
    more = np.array([[1.1, 1.0], [1.2, 1.1]])[..., None, None]
    theory = xr.Dataset(
        {name: (tuple(axes), pressure * more) for name in ("crGW", "rGW", "GW")}, axes
    )
    data = shared.mismatches({"oligomers": simulated, "oligomer_pressures": theory})
    at = data.sel(equation="rGW")
    mean, error = shared.mean_unsigned(at)
    assert mean == pytest.approx(10)
    assert error == pytest.approx(np.hypot(np.hypot(1.1, 1.0), np.hypot(1.2, 1.1)) / 4)
    worst, _, where = shared.largest(at)
    assert worst == pytest.approx(20)
    assert where == "m = 8, rho = 3, l = 0.4, a = 20"
    assert float(data.bond_ratio.max()) == pytest.approx(1.005)


def test_the_constants_of_the_bonds_come_back():
    """Of pressures that are those of the equation, whatever constants the prediction had."""
    axes = {"chain": [2, 8], "density": [3, 6], "bond": [0.3, 0.5], "repulsion": [10, 40]}
    m, rho, length, a = np.meshgrid(*axes.values(), indexing="ij")
    pressure = crgw(rho / m, a, m, length)
    simulated = runs({"pressure": pressure}, axes)
    simulated["bond_mean"] = ((*axes, "replica", "block"), np.ones((2, 2, 2, 2, 1, 3)))
    theory = xr.Dataset({name: (tuple(axes), pressure) for name in shared.LOOKS}, axes)
    data = fig02_mismatch.compute({"oligomers": simulated, "oligomer_pressures": theory})
    found = fig02_mismatch.measured(data)
    for name, constant in {"eta": ETA, "beta": BETA}.items():
        assert found[name].value == pytest.approx(constant, rel=1e-6)
        assert found[name].systematic < 1e-6  # as nothing is left
        assert found[name].by_sampling > 0.01


def held(values, coordinates):
    """Runs at a constant pressure, at which the enthalpy is constant as well."""
    data, noise = runs(values, coordinates), np.random.default_rng(3).normal(size=200)
    change = (data.volume / 100).expand_dims(time=np.arange(200.0), axis=-1) * (
        noise - noise.mean()
    )
    data["volume_series"] = data.volume + change
    data["pair_energy_series"] = data.pair_energy - shared.TARGET * change
    return data


def test_excess_properties_vanish_for_ideal_mixing():
    """A volume linear in the mole fraction, and a pressure that is off by 5 percent at one end.

    Where energy and volume change against each other, the error of the enthalpy knows it.
    """
    both, shares = {"equation": ["crGW", "rGW"]}, [0.25, 0.5]
    sweeps = {}
    for ensemble in ("", "_npt"):
        for name, volume in (("vh1", 300.0), ("vh2", 500.0)):
            values = {"pressure": 41.89, "volume": volume, "pair_energy": 2 * volume}
            sweeps[name + ensemble] = (held if ensemble else runs)(values, both)
        volume = 500.0 - 200.0 * np.array(shares)[:, None] * np.ones((1, 2))
        values = {"pressure": 41.89 * 1.05, "volume": volume, "pair_energy": 2 * volume}
        sweeps["vh1_vh2" + ensemble] = (held if ensemble else runs)(
            values, {"share": shares} | both
        )
    data = mixtures.mixture(sweeps, "vh1", "vh2")
    assert list(data.share.values) == [0, 0.25, 0.5, 1]
    for name in mixtures.EXCESSES:
        np.testing.assert_allclose(data[name], 0, atol=1e-9)
    errors = data.sel(share=0.5)
    assert (errors.energy_error > 0).all() and (errors.volume_error > 0).all()
    assert (errors.enthalpy_error < 1e-6 * errors.energy_error).all()
    assert mixtures.most(data, "pressure_off", "rGW")[0] == pytest.approx(5)


def solute(potential, coupling):
    """Runs of a solute whose energy with the solvent follows from a potential of a."""
    step = 1e-4
    slope = np.array([(potential(a + step) - potential(a - step)) / (2 * step) for a in coupling])
    scene = SCENE | {
        "molecules": [{"architecture": "W", "count": 1000}, {"architecture": "S 2", "count": 5},
                      {"architecture": "M", "count": 10}],
        "repulsion": {f"{i} {j}": 20 for i, j in ("WW", "SW", "MW", "SS", "MM", "MS")},
    }  # fmt: skip
    energy = np.array(coupling) * slope
    block = np.repeat(energy[:, None, None], 4, axis=2)
    pairs = np.stack([5 * block, 10 * block], axis=-1)
    return xr.Dataset(
        {
            "energy_of_pair": (("coupling", "replica", "block", "energy_pair"), pairs),
            "scene": (("coupling", "replica"), np.full((len(coupling), 1), json.dumps(scene))),
        },
        {"coupling": coupling, "energy_pair": ["S W", "M W"]},
    )


def test_a_potential_is_integrated_from_its_derivative():
    """Those of Eqs. 30 and 34 come back; other points than those of Gauss are refused."""
    nodes = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2
    for potential in (
        lambda a: monomer_potential(a, 4.0),
        lambda a: chain_potential(a, 4.0, 2, 0.4),
    ):
        sweep = solute(potential, 20 * nodes)
        found, _ = fig07_solutes._potential(sweep, "S W", 5, 20.0)
        assert found == pytest.approx(float(potential(20.0)), rel=1e-3)
        found, _ = fig07_solutes._potential(sweep, "W M", 10, 20.0)
        assert found == pytest.approx(float(potential(20.0)), rel=1e-3)
    with pytest.raises(UserError, match="not the points after Gauss"):
        fig07_solutes._potential(sweep, "S W", 5, 21.0)
