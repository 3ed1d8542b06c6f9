"""A simulation that is run, changed and looked at step by step is the run of its schedule."""

import json
import os

import numpy as np
import pytest

import dpd
from dpd.files import read
from dpd.folders import PACKAGE
from dpd.scene.scene import Scene
from tests.conftest import SCENE
from tests.test_extend import assert_goes_on, assert_same

CHAINS = SCENE | {
    "box": 5,
    "molecules": [{"architecture": "A 3", "density": 2}, {"architecture": "B", "density": 1}],
    "bond": {"stiffness": 20, "length": 0.5},
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "steps": {"equilibrate": 40, "sample": 160},
    "observe": ["thermo", {"configuration": {"every": 50}}, {"rdf": {"range": 2}}],
}
LOOKS = ["thermo", {"configuration": {"every": 50}}]
SCHEDULE = [
    {"step": 0, "set": {"thermostat.kT": 1.2}},
    {"step": 90, "set": {"integrator.dt": 0.02, "repulsion.A B": 50}},
    {"step": 170, "set": {"integrator.scheme": "dpd-vv", "bond.stiffness": 30}},
]


def test_what_was_set_is_the_schedule(tmp_path, monkeypatch):
    """Its scene comes to the same bits, and so does the result made longer."""
    monkeypatch.chdir(tmp_path)
    long = {"rdf": {"range": 2, "every": 300}}  # looks once, later
    observe = [*CHAINS["observe"][:2], long, {"displacement": {"every": 7}}]
    scene = CHAINS | {"observe": observe, "steps": {"equilibrate": 40}}
    sim = dpd.Simulation(scene, progress=False)
    sim.set(kT=1.2)
    with pytest.raises(dpd.UserError, match="nothing is measured yet: step 40 of 40"):
        sim.run(40)
        sim.result()
    for steps in (1, 19, 30):
        sim.run(steps)
    before = sim.positions
    sim.set({"repulsion.A B": 50}, stiffness=30)
    assert np.array_equal(before, sim.positions) and sim.step == 90
    sim.run(60)
    sim.save("run.nc")
    made = json.loads(dpd.load("run.nc").scene)
    assert made["schedule"] == [
        {"step": 0, "set": {"thermostat.kT": 1.2}},
        {"step": 90, "set": {"repulsion.A B": 50, "bond.stiffness": 30}},
    ]
    assert made["steps"] == {"equilibrate": 40, "sample": 110} and "rdf" not in sim.result()
    dpd.run(made, output="again.nc", progress=False)
    assert_same("run.nc", "again.nc")
    np.testing.assert_array_equal(sim.positions.T, read("run.nc")[0]["last_position"])
    with pytest.raises(dpd.UserError, match="is there already; overwrite=True replaces it"):
        sim.save("run.nc")
    sim.set(gamma=9)  # behind the end of what is made longer now
    sim.run(33)
    sim.save("longer.nc")
    sim.save("run.nc", overwrite=True)
    more = json.loads(dpd.load("run.nc").scene)
    dpd.run(more | {"steps": made["steps"]}, output="short.nc", progress=False)
    dpd.extend("short.nc", sample=33, threads=2, progress=False)
    assert_same("short.nc", "longer.nc")


# The force at the end of a step is that of the velocity then, with which a stage begins as well.
EXACT = {"integrator": {"scheme": "dpd-vv", "dt": 0.02}, "observe": LOOKS}
HOTTER = [
    {"step": 90, "set": {"thermostat.kT": 1.0}}, {"step": 120, "set": {"thermostat.kT": 1.1}},
]  # fmt: skip
KINDS = {
    "several values": {"schedule": SCHEDULE},
    "shardlow": {"integrator": {"scheme": "shardlow", "dt": 0.02}, "schedule": HOTTER},
    "pressure": {
        "pressure": {"target": 30, "time": 0.3}, "pairs": {"search": "list"}, "schedule": HOTTER,
    } | EXACT,
    "walls": {"walls": {"axis": "z", "repulsion": 200, "gamma": 4}, "schedule": HOTTER} | EXACT,
    "shear": {
        "shear": {"rate": 0.1}, "schedule": [*HOTTER, {"step": 140, "set": {"shear.rate": 0}}],
    } | EXACT,
}  # fmt: skip


@pytest.mark.few("several values")
@pytest.mark.parametrize("kind", KINDS)
def test_a_schedule_goes_on_where_it_was_stopped(tmp_path, kind):
    """Where values change, and in between."""
    threads = 1 if kind == "shardlow" else 2
    assert_goes_on(tmp_path, CHAINS | KINDS[kind], 140, threads, killed=140)


def test_times_are_those_of_steps_that_were_taken():
    """Of series, of functions, and of the simulation."""
    sim = dpd.Simulation(CHAINS, progress=False)
    sim.run(80)
    sim.set(dt=0.01)
    sim.run(80)
    assert sim.time == pytest.approx(80 * 0.04 + 80 * 0.01) and sim.snapshot().time == sim.time
    run = sim.result()
    steps = 10 * np.arange(1, 13)
    expected = 0.04 * np.minimum(steps, 40) + 0.01 * np.maximum(steps - 40, 0)
    np.testing.assert_allclose(run.time, expected, rtol=1e-12)
    assert sim.snapshot().scene.dt == 0.01


def test_what_is_set_acts():
    """kT follows; and what is set to what it is changes no more than last bits."""
    scene = CHAINS | {"integrator": {"scheme": "dpd-vv", "dt": 0.04}}
    plain, same, hot = (dpd.Simulation(scene, progress=False) for _ in range(3))
    for sim in (plain, same, hot):
        sim.run(30)
    same.set(kT=1)
    hot.set(kT=4)
    for sim in (plain, same, hot):
        sim.run(20)
    np.testing.assert_allclose(same.velocities, plain.velocities, atol=1e-9)
    assert not np.array_equal(same.velocities, hot.velocities)
    hot.run(500)
    assert hot.result().kT[-80:].mean() == pytest.approx(4, rel=0.1)
    assert hot.kT == pytest.approx((hot.velocities**2).sum() / (3 * 373), rel=1e-6)


def test_ramps_are_schedules():
    """From one value to the other over the sampling, or before it; the heat of a ramp is in kT."""
    ramp = {
        "thermostat": {"kT": {"from": 1, "to": 2}},
        "integrator": {"scheme": "dpd-vv", "dt": 0.02},
        "repulsion": {"A A": {"from": 5, "to": 25, "over": "equilibrate"}, "A B": 30, "B B": 25},
    }
    scene = Scene(CHAINS | ramp | {"steps": {"equilibrate": 400, "sample": 8000}})
    made = scene.data["schedule"]
    assert made[0] == {"step": 0, "set": {"repulsion.A A": 5.1}} and len(made) == 201
    assert {"step": 400, "set": {"thermostat.kT": 1.005}} in made
    run = dpd.run(scene, progress=False)
    kT = run.kT.values.reshape(8, -1).mean(axis=1)
    np.testing.assert_allclose(kT, 1 + (np.arange(8) + 0.5) / 8, atol=0.06)


def test_rest_after_shear():
    """Images stay as far slid as they are, and the stress of the flow goes, when told to."""
    looks = [{"thermo": {"every": 1}}, {"velocity_profile": {"every": 1}}]
    scene = CHAINS | EXACT | {"shear": {"rate": 0.25}, "observe": looks}
    sim = dpd.Simulation(scene, progress=False)
    sim.run(9999, until=lambda snapshot: snapshot.step > 1036, every=20)
    tilt = sim.snapshot().lattice.tilt
    sim.set({"shear.rate": 0})
    sim.run(1000)
    assert sim.snapshot().lattice.tilt == pytest.approx(tilt, abs=1e-12) and tilt != 0
    flow = (run := sim.result()).velocity_profile.mean("block")[0]
    assert np.polyfit(run.layer, flow, 1)[0] == pytest.approx(0.25 * 1040 / 2040, abs=0.04)
    stress = run.pressure_tensor[:, 0, 1].values
    assert stress[:1000].mean() < -0.15 and abs(stress[1200:].mean()) < 0.1


def test_shipped_scenes_that_change():
    """3 kT / 2 a spring while it is heated; stress of dumbbells as exp(-t / 4) after their flow."""
    hot = dpd.run(PACKAGE / "scenes" / "heating.yaml", progress=False)
    for name, at_1 in (("kT", 1), ("bond_energy", 375)):
        found = hot[name].values.reshape(8, -1).mean(axis=1)
        np.testing.assert_allclose(found, at_1 * (1 + (np.arange(8) + 0.5) / 8), rtol=0.025)
    run = dpd.run(PACKAGE / "scenes" / "rest_after_shear.yaml", progress=False)
    stress = -run.pressure_tensor[:, 0, 1] * 32 * 20 * 20 / 250
    assert stress.sel(time=slice(40, 160)).mean() == pytest.approx(1, abs=0.15)
    falls = 4 / 12 * (1 - np.exp(-12 / 4))
    assert stress.sel(time=slice(160, 172)).mean() == pytest.approx(falls, abs=0.2)


WRONG = {
    "no key": ({"boxx": 4}, "'boxx' cannot change while the system runs; allowed: bond, integ"),
    "a setting": ({"integrator.dtt": 1}, "unknown key 'dtt'; allowed: .* did you mean 'dt'"),
    "what slides": ({"shear.gradient": "z"}, "'shear' cannot become this while the system runs"),
    "what begins": ({"body_force.strength": 1}, "'body_force' would begin or cease to act"),
    "the pace": ({"integrator.dt": 0.02}, "'displacement' needs steps of one length while it"),
}
SYSTEMS = {
    "what slides": {"shear": {"rate": 0.1}, "observe": []},
    "what begins": {"body_force": {"axis": "x", "strength": 0, "opposite": "z"}},
    "the pace": {"observe": [{"displacement": {"every": 20}}]},
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_refused(what):
    """Before anything is changed, and by a scene as well."""
    scene, (settings, said) = CHAINS | SYSTEMS.get(what, {}), WRONG[what]
    with pytest.raises(dpd.UserError, match=said):
        Scene(scene | {"schedule": [{"step": 60, "set": settings}]})


def test_calls_that_are_refused(tmp_path, monkeypatch):
    """In one sentence; then the simulation is as it was."""
    monkeypatch.chdir(tmp_path)
    sim = dpd.Simulation({key: CHAINS[key] for key in CHAINS if key != "steps"}, progress=False)
    for call, said in (
        (lambda: sim.set(dd=1), "set: 'dd' cannot change here; allowed: "),
        (lambda: sim.set(kT=1, gamm=2), "did you mean 'gamma'"),
        (lambda: dpd.Simulation(CHAINS | {"observe": ["trajectory"]}), "writes a file beside"),
    ):
        with pytest.raises(dpd.UserError, match=said):
            call()
    sim.run(30)
    assert sim.result().kT.size == 3 and "schedule" not in json.loads(sim.result().scene)
    assert not os.listdir()
