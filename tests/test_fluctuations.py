"""Viscosity of a fluid at rest, from a stress whose fluctuations are known."""

import numpy as np
import pytest

from dpd.analysis.viscosity import shear_components, viscosity_of_fluctuations
from paper_figures.groot_warren_1997.shared import noise_ratio

DT, VOLUME, KT = 0.04, 50.0, 1.3


def fluid(eta_of_noise, eta_of_memory, memory, steps, seed=1):
    """The pressure tensor of a made-up fluid: noise of each step, and a part that is remembered.

    The spread of the integral of an exponential memory, of variance s^2 and time m, grows by
    2 s^2 m in a unit of time, that of noise of variance s^2 in steps of dt by s^2 dt.
    """
    rng = np.random.default_rng(seed)
    keep = np.exp(-DT / memory)
    # The sum over lags of keep^|lag| is (1 + keep) / (1 - keep).
    variance = 2 * eta_of_memory * KT / VOLUME / DT * (1 - keep) / (1 + keep)
    slow = np.empty((steps, 6))
    slow[0] = rng.normal(size=6) * np.sqrt(variance)
    kicks = rng.normal(size=(steps, 6)) * np.sqrt(variance * (1 - keep**2))
    for k in range(1, steps):
        slow[k] = keep * slow[k - 1] + kicks[k]
    noise = rng.normal(size=(steps, 6)) * np.sqrt(2 * eta_of_noise * KT / VOLUME / DT)
    xy, xz, yz, xx, yy, zz = (slow + noise).T
    # A diagonal component less the mean of all three has 4 / 3 of the variance of one off it.
    return np.array([[25 + np.sqrt(2) * xx, xy, xz], [xy, 25 + np.sqrt(2) * yy, yz],
                     [xz, yz, 25 + np.sqrt(2) * zz]]).transpose(2, 0, 1)  # fmt: skip


def test_all_components_have_the_variance_of_one_off_the_diagonal():
    """And none sees the mean pressure."""
    tensor = fluid(0.5, 0.3, 0.2, 40000)
    found = shear_components(tensor)
    assert found.mean(axis=0) == pytest.approx(np.zeros(5), abs=0.02 * found.std())
    assert found.var(axis=0) == pytest.approx(np.full(5, tensor[:, 0, 1].var()), rel=0.05)


@pytest.mark.parametrize("parts", [(0.8, 0.0), (0.1, 0.6)])
def test_the_viscosity_comes_out_with_its_error(parts):
    """Deviations over their errors are spread as they should be."""
    eta, off = sum(parts), []
    for seed in range(12):
        found = viscosity_of_fluctuations(fluid(*parts, 0.2, 12000, seed), DT, VOLUME, KT, 1.0)
        assert found.error < 0.15 * eta
        off.append((found.value - eta) / found.error)
    assert abs(np.mean(off)) < 4 / np.sqrt(len(off)) and 0.5 < np.std(off) < 1.8


def test_friction_and_noise_count():
    """Without the noise of each step the viscosity would be smaller."""
    whole = viscosity_of_fluctuations(fluid(0.5, 0.3, 0.2, 40000), DT, VOLUME, KT, 1.0)
    remembered = viscosity_of_fluctuations(fluid(0.0, 0.3, 0.2, 40000), DT, VOLUME, KT, 1.0)
    assert whole.value - remembered.value == pytest.approx(0.5, abs=4 * whole.error)


def test_a_short_run_is_refused():
    """Its parts would be shorter than the memory."""
    with pytest.raises(ValueError, match="225 are needed"):
        viscosity_of_fluctuations(fluid(0.5, 0.3, 0.2, 4000), DT, VOLUME, KT, 1.0)


def test_noise_of_one_series_over_that_of_another():
    """Of means over parts."""
    rng = np.random.default_rng(3)
    one, other = rng.normal(size=(20000, 2)), rng.normal(size=20000)
    found = noise_ratio(3 * one, other, 50)
    assert found.value == pytest.approx(3, abs=4 * found.error) and found.error < 0.3
