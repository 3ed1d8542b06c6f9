"""Relaxation and diffusion of chains for which both are known exactly."""

import numpy as np
import pytest

import dpd
from dpd.analysis.relaxation import chain_dynamics

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
    "seed": 1,
}
LENGTH = {"length": {"set": "molecules.0.architecture", "text": "A {}", "values": [2]}}


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
