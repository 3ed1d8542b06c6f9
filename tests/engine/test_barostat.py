"""Constant pressure: the right forces and trials, and the isothermal-isobaric ensemble.

N beads without forces have the places V^N, whatever their momenta, so the volume has the density
V^N exp(-P_0 V / kT), a Gamma distribution of shape N + 1, and the mean of N kT / V is P_0: with a
Langevin thermostat, and also where friction between pairs conserves momentum, which is zero below.
"""

import numpy as np
import pytest
from scipy import stats

from dpd.analysis.statistics import mean_and_error
from dpd.engine import barostat
from dpd.engine.barostat import scaled_box, scaled_state
from dpd.engine.simulation import Simulation
from dpd.engine.state import CONSERVATIVE
from dpd.errors import UserError
from dpd.physics.pressure import Look, Pressure, draw
from tests.engine.cases import simulation_of
from tests.systems import (
    BOX_3D,
    make_simulation,
    make_system,
    random_beads,
)


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
        looks.append(barostat.look_at(system, system.pressure, there.state, edges, there.measure()))
    slope = (looks[2].energy - looks[0].energy) / (looks[2].volume - looks[0].volume)
    assert looks[1].pressure == pytest.approx(-slope, rel=1e-6, abs=1e-6)


def test_detailed_balance_of_a_trial():
    """Delta changes its sign where the trial is turned around, and is that of its parts."""
    law = Pressure(3.0, 2.0, 0.3, (0, 1, 2), 5)
    here, there = Look(33.0, 3.4, 5.0), Look(35.0, 2.7, 4.4)
    change = law.change(here, there, 1.2, 0.2)
    assert change == pytest.approx(-law.change(there, here, 1.2, 0.2), abs=1e-12)
    # Without a drift there and back the proposal drops out.
    still = law._replace(target=3.0)
    one, other = (Look(v, 3.0 - 1.2 / (2 * v), e) for v, e in ((33.0, 5.0), (35.0, 4.4)))
    expected = (4.4 - 5.0 + 3.0 * 2.0) / 1.2 - np.log(35 / 33) / 2
    assert still.change(one, other, 1.2, 0.2) == pytest.approx(expected, abs=1e-12)


def test_random_numbers_of_trials():
    """A function of seed and step: others for others, and standard normal and uniform.

    Means of 4000 are within 4 standard errors.
    """
    assert draw(3, 10) == draw(3, 10)
    assert len({draw(3, 10), draw(3, 20), draw(4, 10)}) == 3
    assert draw(2**63 - 1, 10**12)
    found = np.array([draw(7, 10 * k) for k in range(4000)])
    assert abs(found[:, 0].mean()) < 4 / np.sqrt(4000)
    assert abs(found[:, 0].var() - 1) < 4 * np.sqrt(2 / 4000)
    assert abs(found[:, 1].mean() - 0.5) < 4 / np.sqrt(12 * 4000)
    assert (found[:, 1] > 0).all()
    assert abs(np.corrcoef(found[:-1, 0], found[1:, 0])[0, 1]) < 4 / np.sqrt(4000)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "target, sentence",
    [(1e-3, "empties the box"), (1e5, "is too high for it")],
)
def test_box_that_becomes_too_large_or_too_small(target, sentence):
    """One message, and the state as it was before the call."""
    law = Pressure(target, 0.1, 0.05, (0, 1, 2), 1)
    position, velocity = random_beads(BOX_3D, 50, seed=3)
    simulation = make_simulation(make_system(BOX_3D, pressure=law), position, velocity)
    kept = simulation.state
    with pytest.raises(UserError, match=sentence) as problem:
        simulation.advance(10_000)
    assert f"pressure.target {target:g}" in str(problem.value)
    assert simulation.state is kept


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


def ideal_gas(law, samples, apart, box=(3.5, 3.5, 3.5), beads=BEADS, **changes):
    """Volumes of beads without repulsion so long apart, and their kinetic energies."""
    position, velocity = random_beads(box, beads, seed=8)
    changes = {"repulsion": np.zeros((1, 1)), "dt": 0.02, "seed": 5} | changes
    system = make_system(box, "dpd-vv", pressure=law, **changes)
    simulation = make_simulation(system, position, velocity)
    volume, kinetic = np.empty(samples), np.empty(samples)
    simulation.advance(round(5 * apart / system.dt))
    for k in range(samples):
        simulation.advance(round(apart / system.dt))
        volume[k], kinetic[k] = simulation.volume, (simulation.state.velocity**2).sum()
    return volume, kinetic


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
    volume, kinetic = ideal_gas(law, 200, 8 * time / min(estimate, 1.0))
    expected = stats.gamma(BEADS + 1, scale=1 / TARGET)
    assert stats.kstest(volume, expected.cdf).pvalue > 1e-3
    assert abs(volume.mean() - expected.mean()) < SURE * expected.std() / np.sqrt(200)
    free = 3 * (BEADS - 1)
    assert abs(kinetic.mean() / free - 1) < SURE * np.sqrt(2 / free / 200) + 0.005


@pytest.mark.thorough
@pytest.mark.parametrize("bath", [True, False])
def test_volumes_of_few_beads(bath):
    """Shape N + 1, in a bath that takes momentum and without: the mean of 15 beads is 7 % larger
    than that of shape N, which it has not.

    In the dilute gas without a bath, the kinetic energy changes slowly, and with it the volume: the
    error knows about that.
    """
    target = 0.25
    law = Pressure(target, 0.5, 1 / target, (0, 1, 2), 5)
    volume, _ = ideal_gas(law, 900, 1.5, box=(4.0, 4.0, 4.0), beads=15, per_bead=bath)
    expected, (mean, error, _) = stats.gamma(16, scale=1 / target), mean_and_error(volume)
    assert abs(mean - expected.mean()) < SURE * error
    assert error < 0.3 / target  # of the 1 / target between the shapes


def series(system, steps, every):
    """Volumes, pressures and temperatures of 192 beads of the standard fluid."""
    position, velocity = random_beads(system.box, 192, seed=2)
    simulation = make_simulation(system, position, velocity)
    simulation.advance(400)
    rows = []
    for _ in range(steps // every):
        sums = simulation.advance_measured(every)
        kinetic = (simulation.state.velocity**2).sum()
        virial = np.trace(sums.virial[CONSERVATIVE])
        pressure = (kinetic + virial) / (3 * simulation.volume)
        rows.append((simulation.volume, pressure, kinetic / (3 * 191)))
    return np.array(rows).T


def mean_in_parts(values, parts=20):
    """Mean, and its standard error from the means of so many parts of a series."""
    means = np.array([part.mean() for part in np.array_split(values, parts)])
    return means.mean(), means.std(ddof=1) / np.sqrt(parts)


def agree(one, other):
    """Whether two means agree within their errors; 20 parts know theirs to 16 %."""
    return abs(one[0] - other[0]) < 1.2 * SURE * np.hypot(one[1], other[1])


@pytest.mark.thorough
def test_the_standard_fluid_at_its_own_pressure():
    """rho 3, a 25: the pressure at constant volume gives back density and temperature.

    The variance of the volume is kT <V> kappa, with kappa = 1 / (rho dp/drho) from the equation
    of state p = rho kT + 0.101 a rho^2 of Groot and Warren (1997, Eq. 14); known to 12 % here.
    """
    box = (4.0, 4.0, 4.0)
    fluid = {"scheme": "gw-vv", "prediction": 0.65, "dt": 0.04, "seed": 4}
    _, pressure, kT = series(make_system(box, **fluid), 12_000, 5)
    held = mean_in_parts(pressure)
    assert abs(held[0] - 23.7) < 0.4
    law = Pressure(held[0], 0.5, 0.02, (0, 1, 2), 3)
    volume, found, kT_held = series(make_system(box, pressure=law, **fluid), 24_000, 5)
    compressibility = 1 / (3 * (1 + 2 * 0.101 * 25 * 3))
    mean, error = mean_in_parts(volume)
    # The pressure that is held is itself known with an error, which moves the volume.
    assert abs(mean - 64) < 1.2 * SURE * np.hypot(error, 64 * compressibility * held[1])
    assert abs(mean_in_parts(found)[0] - held[0]) < 1.2 * SURE * mean_in_parts(found)[1]
    assert agree(mean_in_parts(kT), mean_in_parts(kT_held))
    spread, unsure = mean_in_parts((volume - volume.mean()) ** 2)
    expected = 64 * compressibility
    assert unsure < 0.12 * expected
    assert abs(spread - expected) < 1.2 * SURE * unsure
