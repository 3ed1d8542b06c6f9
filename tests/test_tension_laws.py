"""Laws of tension put into made-up data come out again, with errors that hold."""

import json

import numpy as np
import pytest
import xarray as xr

from dpd.scene.scene import Scene
from paper_figures.groot_warren_1997.fig10_scale_factors import with_slope
from paper_figures.groot_warren_1997.tension_laws import collapse, tension_law
from paper_figures.groot_warren_1997.tension_sweeps import sweep_tension
from tests.test_interfaces import made_up

RNG = np.random.default_rng(24)
CHI, LENGTH = (part.ravel() for part in np.meshgrid([1.2, 1.5, 2.0, 2.6], [2, 3, 5, 8, 12]))
TRUE = {"prefactor": 0.6, "alpha": 0.45, "critical": 2.1, "mu": 1.4}
NOISE = 0.02


def law(chi, length):
    """What is put in."""
    return (
        TRUE["prefactor"] * chi ** TRUE["alpha"]
        * (1 - TRUE["critical"] / (chi * length)) ** TRUE["mu"]
    )  # fmt: skip


def noisy(exact):
    """Tensions with an error, and that error."""
    error = NOISE * exact
    return exact + error * RNG.normal(size=exact.shape), error


def assert_pulls(pulls):
    """Without bias and of size 1; a little narrower, as errors are widened where points scatter."""
    assert np.abs(pulls.mean(axis=0)).max() < 0.55
    assert ((pulls.std(axis=0) > 0.6) & (pulls.std(axis=0) < 1.3)).all()


@pytest.mark.few(1)
@pytest.mark.parametrize("held", [{}, {"mu": TRUE["mu"]}, {"critical": 2.1, "alpha": 0.45}])
def test_a_law_comes_out(held):
    """All that is not held, without bias, and with errors of the right size."""
    fits = [tension_law(CHI, LENGTH, *noisy(law(CHI, LENGTH)), **held) for _ in range(30)]
    for name, value in held.items():
        assert getattr(fits[0], name) == (value, 0.0)
    pulls = np.array([
        [(getattr(fit, name).value - true) / getattr(fit, name).error
         for name, true in TRUE.items() if getattr(fit, name).error > 0]
        for fit in fits
    ])  # fmt: skip
    assert pulls.shape[1] == len(TRUE) - len(held)
    assert_pulls(pulls)
    assert fits[0].points == 20
    assert fits[0].at(CHI, LENGTH) == pytest.approx(law(CHI, LENGTH), rel=0.1)


def test_points_that_cannot_be_fitted_are_left_out():
    """Without an error, or below a held critical point; and too few are none."""
    value, error = noisy(law(CHI, LENGTH))
    error[3] = np.nan
    found = tension_law(CHI, LENGTH, value, error, critical=3.0, mu=1.5)
    assert found.points == ((CHI * LENGTH > 3.0) & np.isfinite(error)).sum()
    assert found.degrees == found.points - 2  # a height and alpha
    few = tension_law(CHI[:2], LENGTH[:2], value[:2], error[:2], mu=1.5)
    assert np.isnan(few.alpha.value) and few.mu == (1.5, 0.0)
    assert np.isnan(tension_law([], [], [], [], mu=1.5).prefactor.value)


@pytest.mark.thorough
def test_groups_fall_on_one_curve():
    """Heights, critical point and exponent of groups that differ in height."""
    heights = np.array([0.8, 1.0, 1.3])
    group, chi_n = (part.ravel() for part in np.meshgrid([0, 1, 2], [2.6, 3.2, 4, 6, 9, 15]))
    exact = heights[group] * (1 - 2 / chi_n) ** 1.5
    fits = [collapse(group, chi_n, *noisy(exact), groups=3) for _ in range(30)]
    found = np.array([[*fit.prefactors, fit.critical, fit.mu] for fit in fits])
    assert_pulls((found[..., 0] - [*heights, 2.0, 1.5]) / found[..., 1])


def test_a_sweep_of_slabs():
    """Tension of each point, replicas taken together, and which have settled."""
    runs = [made_up((0.4, 0.0)), made_up((0.4, 0.0), drift=5e-4)]
    points = []
    for run in runs:
        scene = Scene(json.loads(run.attrs["scene"]))
        part = run.drop_attrs().assign(scene=json.dumps(scene.data))
        points.append(xr.concat([part, part], "replica"))
    sweep = xr.concat(points, xr.DataArray([7.0, 8.0], dims="excess", name="excess"))
    found = sweep_tension(sweep)
    assert found.tension.values == pytest.approx([1.2, 1.2], abs=0.01)
    assert found.settled.values.tolist() == [1, 0]
    assert found.density.values == pytest.approx(3)
    assert found.excess_repulsion.values == pytest.approx(20)
    assert found.beads.values.tolist() == [1, 1]
    one = sweep_tension(sweep.isel(replica=[0]))
    assert found.tension_error.values == pytest.approx(one.tension_error.values / np.sqrt(2))


def test_a_law_that_is_not_that_of_the_points_is_unlikely():
    """With the right law p is spread evenly from 0 to 1; with a wrong one it is nearly 0."""

    def p_value(**held):
        return tension_law(CHI, LENGTH, *noisy(law(CHI, LENGTH)), mu=TRUE["mu"], **held).p_value

    assert 0.3 < np.mean([p_value() for _ in range(30)]) < 0.7
    assert p_value(alpha=3.0) < 1e-3


def test_the_power_of_chi_from_runs_of_equal_chi_n():
    """It is found whatever the dependence on chi N; runs that share theirs with none go out."""
    chi, beads = (part.ravel() for part in np.meshgrid([1.0, 1.5, 2.0], [3, 4, 6, 8]))
    scaled, error = noisy(0.6 * chi**0.4 * np.tanh(0.1 * chi * beads))
    runs = xr.Dataset(
        {"chi": ("run", chi), "beads": ("run", beads), "segregation": ("run", chi * beads)}
        | {"scaled": ("run", scaled), "scaled_error": ("run", error)}
    )
    for name in ("scaled", "scaled_error"):
        runs[name].attrs["long_name"] = name
    found = with_slope(runs)
    assert found.segregation.values.tolist() == [6, 6, 8, 6, 12, 8, 12]
    assert float(found.slope) == pytest.approx(0.4, abs=4 * float(found.slope_error))
    assert 0 < float(found.slope_error) < 0.05
    alone = with_slope(runs.isel(run=[0, 1]))
    assert alone.sizes["run"] == 0 and np.isnan(alone.slope)
