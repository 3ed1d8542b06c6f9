"""Relaxation and diffusion of chains for which both are known exactly."""

import numpy as np
import pytest

import dpd
from dpd.analysis.diffusion import Resampled, chain_dynamics, relaxation_time
from paper_figures.nikunen_2007.fig04_chains import straightness

FRICTION, STIFFNESS, CHAINS = 20.0, 2.0, 200
# Beads that feel each other by a spring alone, and a bath: Rouse chains of two beads.
DIMERS = {
    "dimension": 2,
    "box": 20,
    "molecules": [{"architecture": "A 2", "count": CHAINS}],
    "repulsion": {"A A": 0},
    "bond": {"stiffness": STIFFNESS, "length": 0},
    "thermostat": {"kind": "langevin", "kT": 1, "gamma": FRICTION},
    "integrator": {"scheme": "gw-vv", "lambda": 0.5, "dt": 0.02},
    "steps": {"equilibrate": 1000, "sample": 20000},
    "observe": ["thermo", {"end_to_end": {"every": 10}}, {"displacement": {"every": 10}}],
}
LENGTH = {"length": {"set": "molecules.0.architecture", "text": "A {}", "values": [2]}}


@pytest.mark.thorough
def test_dimers_in_a_plane():
    """D = kT / (2 gamma) in two dimensions; R relaxes as a damped oscillator of stiffness 2 k."""
    found = chain_dynamics(dpd.sweep(DIMERS, LENGTH, progress=False)).isel(length=0)
    slow = FRICTION / 2 - np.sqrt(FRICTION**2 / 4 - 2 * STIFFNESS)
    assert found.long_enough == 1
    for value, error, exact in (
        (found.tau, found.tau_error, 1 / slow),
        # Displacements are relative to the centre of mass of all chains.
        (found.diffusion, found.diffusion_error, (1 - 1 / CHAINS) / (2 * FRICTION)),
    ):
        assert 0 < error < 0.1 * exact
        assert float(value) == pytest.approx(exact, abs=4 * float(error))


def correlation(of, share=1.0, points=200):
    """A correlation over lags of up to a share of three tau, the same without any of the data."""
    time = np.linspace(0.01, 3 * share, points)
    value = of(time)
    return Resampled(time, value, np.tile(value, (20, 1)), np.tile(value, (10, 1)))


def rouse(time):
    """Of an ideal chain of many beads; tau is 1."""
    modes = np.arange(1, 400, 2)[:, np.newaxis]
    return (8 / np.pi**2 * np.exp(-time * modes**2) / modes**2).sum(axis=0)


def test_the_relaxation_time_of_ideal_chains():
    """Less than 1 % too small with lags of up to one tau, as the docstring says."""
    for share, low, high in ((1.0, 0.995, 0.997), (1 / 3, 0.989, 0.992)):
        tau, _ = relaxation_time(correlation(rouse, share), 1.0)
        assert low < tau < high
    assert np.isnan(relaxation_time(correlation(rouse, 0.1), 1.0)[0])


def test_how_straight_the_tail_is():
    """1 of an exponential; a stretched one decays faster at first."""
    assert straightness(correlation(lambda t: np.exp(-t)), 1.0)[0] == pytest.approx(1.0)
    assert straightness(correlation(lambda t: np.exp(-(t**0.7))), 1.0)[0] < 0.9
    assert np.isnan(straightness(correlation(rouse, 0.2), 1.0)[0])
