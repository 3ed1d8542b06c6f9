"""Scheme auto: what it promises of kT and pressure holds, or it promises nothing."""

import signal
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import yaml

from dpd import files
from dpd.analysis.statistics import mean_and_error
from dpd.errors import UserError
from dpd.runs import auto as probing
from dpd.runs import run as running
from dpd.runs.auto import Probe, settle, thermostat_time
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start
from tests.conftest import SCENE


def scene_of(dimension, density, a, gamma, tolerance=0.03, beads=400):
    """A fluid that leaves its scheme to us."""
    return Scene(
        {
            "dimension": dimension,
            "box": round((beads / density) ** (1 / dimension), 3),
            "molecules": [{"architecture": "A", "count": beads}],
            "repulsion": {"A A": a},
            "thermostat": {"gamma": gamma},
            "integrator": {"scheme": "auto", "tolerance": tolerance},
            "steps": {"sample": 1000},
        },
        "my.yaml",
    )


def test_a_fluid_settles_and_says_what_was_found():
    """Scheme and step are named then; the same scene leads to the same; its start stays."""
    scene = scene_of(3, 3, 25, 4.5)
    state = make_start(scene)
    before = state.position.copy()
    settled, again = settle(scene, state), settle(scene, state)
    assert settled.chosen == again.chosen and settled.digest == again.digest
    assert not settled.is_auto and settle(settled, state) is settled
    for part in (f"dt {settled.dt:g}", "kT is within", "asked for: 3 %"):
        assert part in settled.chosen["said"]
    np.testing.assert_array_equal(state.position, before)


@pytest.mark.parametrize("guess", [0.12, 1.0])
def test_a_step_that_heats_or_blows_up_is_made_shorter(guess):
    """It ends at a step whose kT is right, in a run with other noise."""
    scene = scene_of(3, 3, 25, 4.5)
    scene.terms["integrator"].named.__dict__["dt"] = guess
    settled = settle(scene, make_start(scene))
    assert settled.dt <= 0.08
    other = Scene(settled.data | {"seed": 77})
    probe = Probe(other, make_start(other), settled.dt)
    probe.run(400.0)
    assert np.mean(probe.kT[len(probe.kT) // 4 :]) == pytest.approx(1, abs=0.03)


def test_nothing_is_promised_that_cannot_be_shown(monkeypatch):
    """Where the thermostat is too slow for a probe: a sentence with what it needs."""
    monkeypatch.setattr(probing, "LEAST_WORK", 1e7)
    scene = scene_of(3, 3, 25, 0.01, tolerance=0.01)
    with pytest.raises(UserError, match=r"my.yaml: integrator.tolerance.* could not show"):
        settle(scene, make_start(scene))


AUTO = SCENE | {"integrator": {"scheme": "auto", "tolerance": 0.05}}


def test_a_run_that_goes_on_keeps_its_step(folder, dpd, monkeypatch):
    """It does not look for one again, which may take a tenth of the run; a new tolerance does."""
    scene = AUTO | {"steps": {"sample": 3000}}
    Path("scene.yaml").write_text(yaml.safe_dump(scene))
    looked, rested = [], Mock(side_effect=probing.at_rest)

    def look_for(*given):
        looked.append(settle(*given))
        return looked[-1]

    monkeypatch.setattr(probing, "settle", look_for)
    monkeypatch.setattr(probing, "at_rest", rested)
    stop = nullcontext(lambda: signal.SIGTERM * bool(looked))
    monkeypatch.setattr(running, "stop_on", lambda signals: stop)
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 143
    monkeypatch.setattr(running, "stop_on", lambda signals: nullcontext(lambda: 0))
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    assert len(looked) == 2 and rested.call_count == 1
    attributes = files.read("run.nc")[1]
    assert attributes["chosen"] == looked[0].chosen["said"]
    assert attributes["scene_digest"] == looked[0].digest


def test_the_thermostat_time_is_that_of_a_hot_start():
    """Twice as hot, without repulsion: the excess falls by e in that time."""
    scene = scene_of(3, 3, 0, 1.0, beads=4000)
    _, pushes = probing.at_rest(scene, make_start(scene), 0.01)
    assert pushes == pytest.approx(3 * 2 * np.pi / 30, rel=0.03)
    state = make_start(scene)
    state.velocity *= np.sqrt(2)
    probe, time = Probe(scene, state, 0.01), thermostat_time(scene, pushes)
    probe.run(time)
    assert probe.kT[-1] - 1 == pytest.approx(np.exp(-len(probe.kT) * 0.1 / time), abs=0.08)


@pytest.mark.few(1)
@pytest.mark.parametrize("system", [(2, 0.5, 100, 4.5), (3, 3, 25, 0.05), (3, 3, 25, 4.5)], ids=str)
def test_promises_hold(system):
    """In a longer run with other noise kT is within the tolerance, and so is the pressure."""
    scene = scene_of(*system, tolerance=0.02, beads=1000)
    try:
        settled = settle(scene, make_start(scene))
    except UserError as problem:
        assert "could not show" in str(problem)
        return
    dt = settled.data["integrator"]["dt"]
    scene = Scene(settled.data | {"seed": 77})
    probes = [Probe(scene, make_start(scene), step) for step in (dt, dt / 4)]
    found = []
    for probe in probes:
        probe.run(600.0)
        quarter = len(probe.kT) // 4
        found.append([mean_and_error(s[quarter:])[:2] for s in (probe.kT, probe.excess)])
    (kT, kT_error), (excess, error) = found[0]
    _, (exact, exact_error) = found[1]
    assert abs(kT - 1) < 0.02 + 3 * kT_error
    pressure = scene.density + exact
    off = scene.density * (kT - 1) + excess - exact
    sigma = np.hypot(scene.density * kT_error, np.hypot(error, exact_error))
    assert abs(off) < 0.02 * pressure + 3 * sigma
