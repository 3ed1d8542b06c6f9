"""Outcomes of runs, edges of stability, power laws, and the figures made of them."""

import numpy as np
import pytest

from paper_figures.benchmark.drift import (
    FAR,
    LOST,
    OFF,
    STABLE,
    crossing,
    edge,
    outcome,
    power_law,
)


def test_blown_up_runs_have_a_time_and_no_temperature():
    """The first replica to break counts, whatever the others' kT; step 0 would break too."""
    kT = np.array([[[1.0, np.nan, 1.0]], [[1.0, 1.0, 1.03]]])
    lost = np.array([[[-1, 400, 90]], [[-1, -1, -1]]])
    found = outcome(kT, np.full(kT.shape, 1e-4), lost, np.array([0.05]))
    assert found.kind.tolist() == [[LOST], [STABLE]]
    assert found.sure.all()
    assert found.lost[0, 0] == pytest.approx(4.5)
    assert np.isnan(found.excess[0, 0])
    assert found.excess[1, 0] == pytest.approx(0.01)
    assert found.error[1, 0] == pytest.approx(1e-4 / np.sqrt(3))


@pytest.mark.parametrize(
    ("kind", "unsure", "expected"),
    [
        ([STABLE, STABLE, OFF, FAR], [], (0.02, 0.04)),
        ([STABLE, OFF, STABLE, LOST], [], (0.01, 0.02)),
        ([STABLE, STABLE, STABLE, STABLE], [], (0.08, np.nan)),
        ([FAR, FAR, LOST, LOST], [], (np.nan, 0.01)),
        ([STABLE, OFF, STABLE, OFF], [1, 3], (0.04, 0.08)),
        ([STABLE, OFF, STABLE, OFF], [3], (0.01, 0.02)),
        ([OFF, OFF, OFF, LOST], [0, 1], (np.nan, 0.01)),
    ],
)
def test_the_edge_lies_where_stability_first_ends(kind, unsure, expected):
    """Where a larger step is stable a sure failure ends it, and an unsure one only at the end."""
    found = edge(np.array([0.01, 0.02, 0.04, 0.08]), kind, ~np.isin(range(4), unsure))
    assert found == pytest.approx(expected, nan_ok=True)


def test_the_step_at_which_heat_reaches_a_tenth():
    """Exact for heat that is a power of dt; anywhere between where the next run blew up."""
    dt = np.array([0.01, 0.02, 0.04, 0.08])
    heat = 80 * dt**2
    value, error = crossing(dt, heat, np.full(4, 1e-9))
    assert value == pytest.approx(np.sqrt(0.1 / 80))
    assert error == pytest.approx(0.05)
    assert crossing(dt, -heat, np.full(4, 1e-9))[0] == pytest.approx(value)
    lost = np.where(dt > 0.03, np.nan, heat)
    assert crossing(dt, lost, np.full(4, 1e-9)) == pytest.approx(
        (np.sqrt(0.02 * 0.04), np.log(2) / np.sqrt(12))
    )
    assert np.isnan(crossing(dt[:2], heat[:2], np.full(2, 1e-9))).all()
    assert np.isnan(crossing(dt, heat + 1, np.full(4, 1e-9))).all()


def test_power_laws_cover_the_true_exponent():
    """Of 400 fits with honest errors 95 % hold it; points that are no number are left out."""
    rng = np.random.default_rng(2)
    x = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])
    error = np.full(6, 0.1)
    exponents = []
    for _ in range(400):
        y = 3 * x**-0.5 * np.exp(rng.normal(scale=error))
        y[2] = np.nan
        exponents.append(power_law(x, y, error)[1:3])
    value, spread = np.array(exponents).T
    assert 0.92 < np.mean(np.abs(value + 0.5) < 1.96 * spread) < 0.99
    exact = power_law(x, 3 * x**-0.5, error)
    assert (exact.factor, exact.exponent, exact.points) == pytest.approx((3, -0.5, 6))
    assert exact.holds
