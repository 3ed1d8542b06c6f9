"""Constant pressure: the right forces and trials, and the isothermal-isobaric ensemble.

N beads without forces have the places V^N, so the volume has the density V^N exp(-P_0 V / kT), a
Gamma distribution of shape N + 1; also where friction between pairs conserves momentum.
"""

import numpy as np
import pytest
from scipy import stats

from dpd.engine import barostat
from dpd.engine.barostat import scaled_box, scaled_state
from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.physics.pressure import Pressure
from tests.engine.cases import simulation_of
from tests.systems import make_simulation, make_system, random_beads


@pytest.mark.few(1)
@pytest.mark.parametrize("core", [None, (0.4, 200.0, 0.2)], ids=["soft", "core"])
@pytest.mark.parametrize("name", ["pressure", "pressure along z", "pressure along x, 2D"])
def test_pressure_is_minus_the_derivative_of_the_energy(name, core):
    """-dH/dV at fixed scaled places and momenta, by central differences of 1e-6 of V.

    Their error is 1e-12 of the third derivative and 1e-10 of the energy over the step.
    """
    simulation = simulation_of(name, core=core)
    system, box, volume = simulation.system, simulation.box, simulation.volume
    looks = []
    for times in (1 - 1e-6, 1.0, 1 + 1e-6):
        edges = scaled_box(box, system.pressure.axes, times)
        assert np.prod(edges) == pytest.approx(times * volume, rel=1e-14)
        there = Simulation(system, scaled_state(system, simulation.state, box, edges))
        sums = there.measure().of(-1)
        looks.append(barostat.look_at(system, system.pressure, there.state, edges, sums))
    slope = (looks[2].energy - looks[0].energy) / (looks[2].volume - looks[0].volume)
    assert looks[1].pressure == pytest.approx(-slope, rel=1e-6, abs=1e-6)


def test_start_in_a_box_that_is_too_small():
    """Of the state, not of the system."""
    simulation = simulation_of("pressure")
    small = scaled_state(simulation.system, simulation.state, simulation.box, (2.6, 3.7, 1.9))
    with pytest.raises(UserError, match=r"the box is 2\.6 x 3\.7 x 1\.9"):
        Simulation(simulation.system, small)


# Dense enough for friction between pairs to forget a kinetic energy in 0.4 tau.
BEADS = 40
TARGET = 1.0
SURE = 3.5  # standard errors: one test in two thousand fails without cause


# Relaxation time, steps between trials, and the estimate of the compressibility over 1 / P_0,
# which would be right. Trials over as much as 0.4 of the relaxation time.
TRIALS = {
    "short steps": (0.5, 3, 1.0),
    "long steps": (0.5, 10, 1.0),
    "slow, too soft": (1.0, 10, 2.0),
    "too stiff": (0.5, 5, 0.5),
}


@pytest.mark.thorough
@pytest.mark.parametrize("time, every, estimate", TRIALS.values(), ids=TRIALS)
def test_volumes_of_an_ideal_gas(time, every, estimate):
    """A Gamma distribution, whatever the trials: by Kolmogorov and Smirnov, 1 in 1000.

    Samples lie 8 relaxation times apart: of long trials many do not count, and after 4 of them
    27 % of the memory is left.
    """
    law = Pressure(TARGET, time, estimate / TARGET, (0, 1, 2), every)
    box, free = (3.5, 3.5, 3.5), {"repulsion": np.zeros((1, 1)), "dt": 0.02, "seed": 5}
    simulation = make_simulation(
        make_system(box, "dpd-vv", pressure=law, **free), *random_beads(box, BEADS, seed=8)
    )
    volume, kinetic, apart = np.empty(200), np.empty(200), 8 * time / min(estimate, 1.0) / 0.02
    simulation.advance(round(5 * apart))
    for k in range(200):
        simulation.advance(round(apart))
        volume[k], kinetic[k] = simulation.volume, (simulation.state.velocity**2).sum()
    expected = stats.gamma(BEADS + 1, scale=1 / TARGET)
    assert stats.kstest(volume, expected.cdf).pvalue > 1e-3
    assert abs(volume.mean() - expected.mean()) < SURE * expected.std() / np.sqrt(200)
    free = 3 * (BEADS - 1)
    assert abs(kinetic.mean() / free - 1) < SURE * np.sqrt(2 / free / 200) + 0.005
