"""What a run says of itself: pressures as in its file, and a word where kT is not right."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from dpd.errors import UserError
from dpd.files import read
from dpd.report.text import caption
from dpd.runs.result import temperature_warning
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start
from tests.conftest import SCENE

FLUID = SCENE | {
    "box": 5,
    "steps": {"equilibrate": 200, "sample": 600},
    "observe": [{"thermo": {"every": 2}}],
}


def run(tmp_path, change):
    """Summary, variables, attributes, and what was said."""
    scene, said = Scene(FLUID | change), []
    found = simulate(scene, tmp_path / "run.nc", make_start(scene), Options(say=said.append))
    return found, *read(tmp_path / "run.nc"), [sentence for sentence in said if sentence]


@pytest.mark.parametrize("change", [{}, {"thermostat": {"gamma": 0}}], ids=str)
def test_the_printed_pressures_are_those_of_the_file(tmp_path, change):
    """With the kinetic part that was measured, whatever the thermostat was asked for."""
    found, variables, _, _ = run(tmp_path, change)
    pressure = float(variables["pressure"].mean())
    assert found["pressure (conservative virial)"] == pytest.approx(pressure, rel=1e-12)
    tensor = variables["pressure_tensor_all"].mean(axis=0)
    assert found["pressure (virial of all forces)"] == pytest.approx(np.trace(tensor) / 3)
    kinetic = 3 * variables["kT"].mean()  # N kT / V
    excess = variables["excess_conservative"].mean()
    assert pressure == pytest.approx(kinetic + excess, rel=1e-9)


def test_a_hot_run_says_so(tmp_path):
    """On the screen and in the file: how hot, and why."""
    hot = {"thermostat": {"gamma": 50}}
    _, variables, attributes, said = run(tmp_path, hot)
    mean = variables["kT"][150:].mean()
    assert mean > 1.3
    assert attributes["warning"] == said[0]
    for part in (f"kT is {mean:.4g}", "instead of 1", "dt may be too large"):
        assert part in said[0]


@pytest.mark.parametrize("change", [{}, {"start": {"kT": 10}, "steps": {"sample": 4000}}])
def test_a_good_run_says_nothing(tmp_path, change):
    """Nor one that was hot at first."""
    _, _, attributes, said = run(tmp_path, change)
    assert "warning" not in attributes and not said


@pytest.mark.parametrize(
    ("mean", "spread", "warned"),
    [(1.04, 0.01, False), (1.06, 0.01, True), (0.94, 0.01, True), (1.2, 3.0, False)],
)
def test_a_warning_needs_five_percent_and_four_errors(mean, spread, warned):
    """Of independent samples."""
    kT = mean + spread * np.random.default_rng(1).normal(size=800)
    assert bool(temperature_warning(Scene(FLUID), {"kT": kT})) == warned
    kT[-1] = np.nan
    assert not temperature_warning(Scene(FLUID), {"kT": kT})


FLOW = {"body_force": {"axis": "x", "strength": 0.1, "opposite": "z"}}
CAUSES = {
    "dt": ({}, 1.3, "instead of 1 .*: dt may be too large for this scene"),
    "no friction": ({"thermostat": {"gamma": 0}}, 1.3, r"every gamma is 0\) nothing holds it$"),
    "hot flow": (FLOW, 1.1, "the flow heats the fluid, or dt may be"),
    "cold flow": (FLOW, 0.9, ": dt may be too large"),
}


@pytest.mark.parametrize("name", CAUSES)
def test_a_warning_names_what_can_be_the_cause(name):
    """And nothing that can be ruled out."""
    change, mean, words = CAUSES[name]
    kT = mean + 0.01 * np.random.default_rng(1).normal(size=800)
    assert re.search(words, temperature_warning(Scene(FLUID | change), {"kT": kT}))


def test_what_would_heat_without_end_is_refused():
    """A force that does work for ever, where no friction takes up heat; walls' friction does."""
    force = {"axis": "x", "strength": 0.1}
    cold = FLUID | {"thermostat": {"gamma": 0}}
    with pytest.raises(UserError, match="body_force: nothing takes up the heat"):
        Scene(cold | {"body_force": force | {"opposite": "z"}})
    bath = {"thermostat": {"kind": "langevin", "gamma": {"A": 0}}}
    with pytest.raises(UserError, match="body_force: along x nothing brakes the beads"):
        Scene(FLUID | bath | {"body_force": force})
    walls = {"axis": "z", "repulsion": 25}
    Scene(cold | {"body_force": force, "walls": walls | {"gamma": 4.5}})
    Scene(cold | {"body_force": force | {"axis": "z"}, "walls": walls})
    Scene(cold | {"body_force": {"axis": "x", "strength": 0, "opposite": "z"}})


def test_a_caption_shows_what_runs_warned_of():
    """A sentence for each sweep with warnings; none for measurements, nor for good runs."""
    texts = np.array([["", "kT is 1.2"], ["", "kT is 1.3"]], dtype=object)
    about = {"description": "Runs."}
    bad = xr.Dataset({"warning": (("dt", "replica"), texts)}, attrs=about)
    good = xr.Dataset({"warning": (("dt",), np.array(["", ""], dtype=object))}, attrs=about)
    sources = {"hot": bad, "fine": good, "timing": xr.Dataset(attrs=about)}
    said = caption("rates", SimpleNamespace(TITLE="", PAPER_SHOWS=""), sources, xr.Dataset())
    found = re.findall("</strong> (.*warn.*)</p>", said)
    assert found == ["2 of 4 runs of hot warn; the first: <i>kT</i> is 1.2."]
