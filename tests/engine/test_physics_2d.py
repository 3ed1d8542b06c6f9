"""The standard fluid in two dimensions: its pressure between two limits that are known.

a 25, gamma 4.5, no core. Standard errors know about correlation in time (Sokal's window);
they are themselves uncertain by some 10 %.
"""

from functools import cache

import numpy as np
import pytest

from dpd import files
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.observe.common.measured import observables
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from dpd.theory.equation_of_state import second_virial

A = 25.0


def fluid(edge, density, dt, duration, **changes):
    """A scene of the fluid in a square, with a quarter of its duration to equilibrate before."""
    return Scene({
        "dimension": 2,
        "box": edge,
        "molecules": [{"architecture": "A", "density": density}],
        "repulsion": {"A A": A},
        "integrator": {"scheme": "gw-vv", "lambda": 0.5, "dt": dt},
        "duration": {"equilibrate": duration / 4, "sample": duration},
        "observe": [{"thermo": {"every": round(0.2 / dt)}}],
    } | changes, "my.yaml")  # fmt: skip


def excess_and_temperature(edge, density, dt, duration, seed=1):
    """Series of excess pressure over a rho^2, and of kT."""
    scene = fluid(edge, density, dt, duration, seed=seed)
    system = system_of(scene)
    watched = observables(scene, system)
    run(Simulation(system, make_start(scene)), scene.steps, watched)
    variables = watched[0].variables()
    return variables["excess_conservative"][1] / (A * scene.density**2), variables["kT"][1]


@cache
def virials():
    """B2 and B3 of the repulsion: integrals of the Mayer function on a grid, by Fourier.

    B2 = -1/2 int f, B3 = -1/3 int int f(r) f(r') f(|r - r'|), without wrapping in a box of
    4 r_c; the function is smooth but for its edge, where it starts as (1 - r)^2.
    """
    x = np.arange(-256, 256) / 128
    r = np.hypot(x, x[:, None])
    f = np.expm1(-A / 2 * np.maximum(1 - r, 0) ** 2)
    area = 1 / 128**2
    waves = np.fft.fft2(np.fft.ifftshift(f))
    folded = np.fft.fftshift(np.fft.ifft2(waves**2).real) * area
    return -f.sum() * area / 2, -(f * folded).sum() * area / 3


def test_virials_of_the_grid():
    """B2 is the theory's closed form, 0.03636 a, to 1e-5; for B3 there is only this."""
    assert virials()[0] == pytest.approx(second_virial(A, dimension=2), rel=1e-5)
    assert second_virial(A, dimension=2) / A == pytest.approx(0.03636, abs=5e-6)
    # Hard discs have B3 = 0.782 B2^2, softer ones less.
    assert 0.6 < virials()[1] / virials()[0] ** 2 < 0.782


def test_pressure_of_a_dilute_fluid():
    """At rho 0.1 the virials give it within 4 standard errors, from 16 runs, and 0.5 %.

    So much a fourth virial like that of hard discs would add. Beads meet so rarely that a
    run's temperature takes 60 tau to forget where it was: each is compared at the kT that it
    had. Of n beads at rest as a whole, n - 1 have a temperature and each has n - 1 partners.
    """
    missed, n = [], 160
    for seed in range(16):
        pressure, kT = excess_and_temperature(40, 0.1, 0.01, 150, seed)
        kT = kT.mean() * n / (n - 1)
        assert abs(kT - 1) < 0.2
        second = second_virial(A, dimension=2, kT=kT) * (n - 1) / n
        missed.append(pressure.mean() / (kT * (second + virials()[1] * 0.1) / A) - 1)
    error = np.std(missed, ddof=1) / 4
    assert error < 0.01
    assert abs(np.mean(missed)) < 4 * error + 0.005


def test_an_unstable_run_is_recorded_or_fails(tmp_path):
    """The file has the step at which it broke, 41, and NaN for what was not sampled from there;
    unless that is asked for there is none, and the message names the scene. No checkpoint stays.
    """
    relaxed = {"start": {"relax": {"steps": 200, "dt": 0.02}}, "duration": {}}
    sampled = {"steps": {"sample": 60}, "observe": [{"thermo": {"every": 1}}]}
    data = fluid(6, 3, 0.12, 1).data | relaxed | sampled
    path, options = tmp_path / "run.nc", Options(every_seconds=0.0)
    scene = Scene(data, "my.yaml")
    with pytest.raises(UserError, match=r"my\.yaml: the run blew up"):
        simulate(scene, path, make_start(scene), options)
    assert not path.exists()
    scene = Scene(data | {"unstable": "record"}, "my.yaml")
    simulate(scene, path, make_start(scene), options)
    variables, attributes = files.read(path)
    sampled = int(attributes["lost_step"]) - 1
    assert 0 < sampled < 59
    for name in ("kT", "excess_conservative", "pair_energy"):
        assert variables[name].shape == (60,)
        assert np.isfinite(variables[name][:sampled]).all()
        assert np.isnan(variables[name][sampled:]).all()
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
