"""Errors that know about correlation, fits, compositions, verdicts."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from emcee.autocorr import integrated_time
from scipy.signal import lfilter

from dpd import files
from dpd.analysis import verdicts
from dpd.analysis.collect import RECORDED, collect, save
from dpd.analysis.interfaces import bulk_fraction, chi_and_error
from dpd.analysis.statistics import (
    block_mean_and_error,
    by_window,
    independent_mean_and_error,
    jackknife_error,
    linear_fit,
    mean_and_error,
    trend,
)
from dpd.analysis.verdicts import Measured, judge
from dpd.digests import run_sources
from dpd.pipeline.sweep import Axis, Point, Sweep
from dpd.scene.scene import Scene

MEMORY = 0.9  # of the autoregressive series below


def correlated(rng, runs, length, memory=MEMORY):
    """Stationary AR(1) series of unit variance and zero mean."""
    start = int(20 / (1 - memory))  # forgotten by then
    noise = rng.normal(size=(runs, length + start)) * np.sqrt(1 - memory**2)
    return lfilter([1], [1, -memory], noise, axis=1)[:, start:]


@pytest.mark.parametrize("memory", [0.5, MEMORY])
def test_correlation_time_against_emcee(memory):
    """emcee sums the same autocorrelation, 1 + 2 sum, up to the first lag of c times that.

    With c of 2.5 that is our window W, which follows from the degrees of freedom, so that each
    series has the same sum. We add what an exponential has beyond it, and multiply by 1 + (2 W + 1)
    / n for the sample's own mean. emcee's own c of 5 is another estimator of the same time: over
    many series the means of both agree within three standard errors of their difference.
    """
    n, runs = 20_000, correlated(np.random.default_rng(6), 60, 20_000, memory)
    ours = by_window(runs.T)
    window = 0.5 * (n / (ours.degrees + 0.5) - 1)
    summed = np.array([integrated_time(x, c=2.5, tol=0)[0] for x in runs]) / 2
    whole = 0.5 + (summed - 0.5) / (1 - np.exp(-window / summed))
    np.testing.assert_allclose(n / ours.times, whole * (1 + (2 * window + 1) / n), rtol=1e-9)
    wider = np.array([integrated_time(x, c=5, tol=0)[0] for x in runs])
    apart = 2 * n / ours.times - wider
    assert abs(apart.mean()) < 3 * apart.std(ddof=1) / np.sqrt(len(runs))


@pytest.mark.parametrize("memory", [0.0, MEMORY])
def test_trends_cover_as_often_as_they_say(memory):
    """Of 400 series with a known slope 95 % of the intervals hold it, white noise or correlated.

    Taken for white, the correlated would be sure of a wrong slope more often than not. The
    spread is that of the noise, not of the slope.
    """
    rng, n, slope = np.random.default_rng(5), 2000, -0.003
    noise = correlated(rng, 400, n) if memory else rng.normal(size=(400, n))
    time = 0.1 * (1 + np.arange(n))
    found = np.array([trend(time, 7 + slope * time + x) for x in noise])
    away = np.abs(found[:, 0] - slope)
    assert 0.91 < np.mean(away < 1.96 * found[:, 1]) < 0.985
    assert found[:, 2].mean() == pytest.approx(1.0, rel=0.05)
    white = found[:, 2] / np.sqrt(((time - time.mean()) ** 2).sum())
    assert np.mean(away < 1.96 * white) == pytest.approx(0.4 if memory else 0.95, abs=0.12)


def made_up_run(folder, seed, dt, kT, **more):
    """A run of 50 samples with a given kT, its path and scene."""
    scene = Scene({
        "dimension": 2, "box": 3, "molecules": [{"architecture": "A", "count": 5}],
        "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": dt},
        "steps": {"sample": 50}, "observe": [{"thermo": {"pressure": False}}], "seed": seed,
    })  # fmt: skip
    variables = {
        "time": (("sample",), dt * np.arange(1, 51), "tau", "time"),
        "kT": (("sample",), kT, "kT", "kinetic temperature"),
        "momentum": (("sample", "axis"), np.zeros((50, 2)), "m r_c / tau", "momentum"),
    }
    attributes = dict.fromkeys(RECORDED, 1) | {
        "scene": "{}", "scene_digest": scene.digest, "sources": run_sources(scene),
        "numpy": "", "numba": "",
    }  # fmt: skip
    path = folder / f"{seed}.nc"
    files.write(path, variables | more, attributes)
    return path, scene


def test_a_sweep_keeps_series_and_their_trends(tmp_path):
    """Of numbers and of tensors, those that it names, run by run; slopes of all, NaN if lost."""
    rng, points, paths, tensors = np.random.default_rng(3), [], [], []
    for seed, slope in enumerate((0.3, np.nan)):
        tensors.append(rng.normal(size=(50, 2, 2)))
        tensor = (("sample", "axis", "axis2"), tensors[-1], "kT / r_c^2", "pressure tensor")
        kT = 1 + slope * 0.04 * np.arange(1, 51)
        path, scene = made_up_run(tmp_path, seed, 0.04, kT, pressure_tensor=tensor)
        paths.append(path)
        points.append(Point(str(seed), (seed,), scene))
    sweep = Sweep("made up", (Axis("replica", (0, 1), "1", "replica"),), tuple(points))
    assert "pressure_tensor_series" not in collect(sweep, paths)
    found = collect(replace(sweep, series=("pressure_tensor",)), paths)
    assert found.pressure_tensor_series.dims == ("replica", "time", "axis", "axis2")
    assert (found.pressure_tensor_series.values == tensors).all()
    assert found.pressure_tensor_series.units == "kT / r_c^2"
    assert "kT_series" not in found
    assert found.kT_trend.values == pytest.approx([0.3, np.nan], nan_ok=True)
    for name in ("kT_trend_error", "kT_spread"):
        assert found[name].values == pytest.approx([0, np.nan], abs=1e-12, nan_ok=True)
    assert (found.kT_trend.units, found.kT_spread.units) == ("kT / tau", "kT")


def test_short_series_do_not_claim_an_error():
    """One sample has a mean and no error; a constant has error 0."""
    assert np.isnan(mean_and_error([3.0])[1])
    assert mean_and_error([3.0] * 1000)[:2] == (3.0, 0.0)
    assert np.isnan(block_mean_and_error([[1.0, 2.0]])[1]).all()
    assert np.isnan(independent_mean_and_error([1.0])[1])


def test_a_run_of_few_correlation_times_has_a_value_and_no_error():
    """A drift across the whole run says so; the column beside it is not touched."""
    drift, noise = np.random.default_rng(8).normal(size=(2, 500))
    drift += np.linspace(0, 10, 500)
    blocks = np.stack([drift, noise], axis=1)
    mean, error = block_mean_and_error(blocks)
    assert np.isfinite(mean).all() and np.isnan(error[0])
    assert error[1] == pytest.approx(1 / np.sqrt(500), rel=0.5)
    assert mean_and_error(drift)[0] == pytest.approx(mean[0])


def test_few_independent_values_take_students_t():
    """Three values: 1.96 of the error is 4.303 of what their scatter gives."""
    values = np.array([1.0, 2.0, 4.0])
    scatter = values.std(ddof=1) / np.sqrt(3)
    assert 1.96 * independent_mean_and_error(values)[1] == pytest.approx(4.3027 * scatter, rel=1e-3)
    left_out = (values.sum() - values) / 2
    assert 1.96 * jackknife_error(left_out) == pytest.approx(4.3027 * scatter, rel=1e-3)


def test_linear_fit_recovers_and_widens():
    """True coefficients within their errors; scatter beyond the errors widens them."""
    rng = np.random.default_rng(3)
    x = np.linspace(1, 5, 40)
    basis = np.stack([x, x**2])
    y = 2 * x - 0.3 * x**2 + rng.normal(scale=0.1, size=40)
    right = linear_fit(basis, y, np.full(40, 0.1))
    assert np.all(np.abs(right.values - [2, -0.3]) < 4 * right.errors)
    assert 0.5 < right.reduced_chi_square < 1.6
    assert 1e-3 < right.p_value < 0.999
    small = linear_fit(basis, y, np.full(40, 0.01))
    np.testing.assert_allclose(small.errors, right.errors, rtol=0.35)
    scatter = linear_fit(basis, y)
    np.testing.assert_allclose(scatter.errors, right.errors, rtol=0.35)
    with pytest.raises(ValueError, match="do not fix"):
        linear_fit(basis[:, :1], y[:1], [0.1])
    for broken in (np.nan, 0.0, np.inf):
        with pytest.raises(ValueError, match="1 of 40 points have no error"):
            linear_fit(basis, y, np.append(np.full(39, 0.1), broken))


@pytest.mark.parametrize(("decay", "height"), [(0.3, 0.2), (0.8, 0.1), (1.1, 0.05)])
def test_tails_of_interfaces_are_taken_off(decay, height):
    """Exponential tails from both interfaces leave the bulk fraction as it is."""
    apart = (np.arange(25) + 0.5) / 5
    tails = height * (np.exp(-(apart - 2) / decay) + np.exp(-(8 - apart) / decay))
    minority = 0.03 + tails
    found = bulk_fraction(3 * np.array([minority, 1 - minority]), apart, widest=1.5)
    assert found == pytest.approx(0.03, abs=1e-4)


def test_chi_carries_the_error():
    """The error of chi is that of the fraction times the slope; no minority, no chi."""
    chi, error = chi_and_error(0.02, 0.001, 2)
    spread = [chi_and_error(0.02 + s, 0.0, 2)[0] for s in (-0.001, 0.001)]
    assert chi == pytest.approx(np.log(49) / 0.96 / 2)
    assert error == pytest.approx((spread[0] - spread[1]) / 2, rel=0.01)
    assert np.isnan(chi_and_error(0.0, 0.0)[0])
    assert np.isnan(chi_and_error(0.6, 0.1)[0])


@pytest.mark.parametrize(
    ("entry", "value", "error", "verdict"),
    [
        ({"value": 1.0, "error": 0.1}, 1.15, 0.1, verdicts.REPLICATED),
        ({"value": 1.0, "error": 0.1}, 1.4, 0.1, verdicts.DEVIATES),
        ({"value": 1.0, "rounding": 0.05}, 1.07, 0.001, verdicts.DEVIATES),
        # Rounding is a bound: its standard deviation, twice 0.029, must not reach beyond it.
        ({"value": 1.0, "rounding": 0.05}, 1.055, 0.001, verdicts.DEVIATES),
        ({"value": 1.0, "rounding": 0.05}, 1.055, 0.003, verdicts.REPLICATED),
        ({"value": 0.1, "error": 0.01}, 0.2, 0.3, verdicts.NOT_REACHED),
        ({"value": 0.533, "rival": 0.5}, 0.53, 0.02, verdicts.NOT_REACHED),
        ({"value": 0.07}, 0.042, 0.025, verdicts.NOT_REACHED),
        ({"value": 0, "rival": 0.02}, 0.0, 0.02, verdicts.NOT_REACHED),
        ({"value": 0}, 1.5, 1.0, verdicts.REPLICATED),
        ({"range": [None, 0]}, -0.1, 0.01, verdicts.REPLICATED),
        ({"range": [0, 1]}, 0.99, 0.01, verdicts.NOT_REACHED),
        ({"range": [0, 1]}, 0.97, 0.01, verdicts.REPLICATED),
        ({"range": [0, 1]}, 1.03, 0.01, verdicts.DEVIATES),
        ({"range": [0, 1]}, 0.5, np.nan, verdicts.NOT_REACHED),
        ({"value": 1.0, "error": 0.1}, np.nan, np.nan, verdicts.NOT_REACHED),
    ],
)
def test_verdicts(entry, value, error, verdict):
    """Two combined standard errors, or the rounding, or the range."""
    assert judge(entry, Measured(value, error)).verdict == verdict


def test_a_bound_has_no_error():
    """It replicates a range that it lies in, and decides nothing else."""
    for value, limits, verdict in (
        (1.0, [None, 2], verdicts.REPLICATED), (3.0, [None, 2], verdicts.NOT_REACHED),
    ):  # fmt: skip
        found = judge({"range": limits}, Measured(value, np.nan, bound=True))
        assert (found.verdict, np.isnan(found.deviation)) == (verdict, True)
    assert judge({"value": 1.0}, Measured(1, np.nan, bound=True)).verdict == verdicts.NOT_REACHED
    short = Measured(1.0, 0.1, undecided="too short")  # a reason overrides the number
    assert judge({"value": 1.0, "error": 0.1}, short).verdict == verdicts.NOT_REACHED


def test_values_keep_their_type_in_files(tmp_path):
    """A coordinate read as integers and joined with others is written as it then is."""
    whole = xr.Dataset({"x": ("excess", [1.0, 2.0])}, {"excess": [8, 9]})
    save(whole, tmp_path / "whole.nc")
    other = xr.Dataset({"x": ("excess", [3.0])}, {"excess": [3.5]})
    joined = xr.concat([xr.load_dataset(tmp_path / "whole.nc"), other], "part", join="outer")
    save(joined, tmp_path / "joined.nc")
    assert 3.5 in xr.load_dataset(tmp_path / "joined.nc").excess
