"""Numbers, notation and captions of figures."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml

from dpd.folders import ROOT
from dpd.report.figures import load_module
from dpd.report.text import caption, sweep_line, typeset, with_error
from dpd.scene.scene import Scene
from tests.test_species_tables import PLAIN

NUMBERS = [
    (0.12345, 0.0067, "0.1235 ± 0.0067"),
    (3.21e-6, 4.5e-8, "(3.210 ± 0.045)e-6"),
    (0.0, 0.01, "0.000 ± 0.010"),
    (1.5, 0.0, "1.5"),
    (np.nan, 1.0, "–"),
]


@pytest.mark.parametrize(("value", "error", "text"), NUMBERS)
def test_two_digits_of_the_error(value, error, text):
    """And the value to the same place."""
    assert with_error(value, error) == text


NOTATION = [
    ("a_AA = 25 kT/r_c", "<i>a</i><sub>AA</sub> = 25 <i>kT</i>/<i>r</i><sub>c</sub>"),
    ("rho = 3, sigma = 3", "ρ = 3, σ = 3"),
    ("dt = 0.04", "Δ<i>t</i> = 0.04"),
    ("k = 2 a, exp(-t / tau)", "<i>k</i> = 2 <i>a</i>, exp(−<i>t</i> / τ)"),
    ("R_g ~ N^(1/2)", "<i>R</i><sub>g</sub> ~ <i>N</i><sup>1/2</sup>"),
    ("(3.2 ± 0.4)e-06 and 1e+5", "(3.2 ± 0.4) × 10<sup>−6</sup> and 10<sup>5</sup>"),
    ("4 <l^2> < g_i", "4 ⟨<i>l</i><sup>2</sup>⟩ &lt; <i>g</i><sub>i</sub>"),
    ("(c) a fluid, Secs. I and V C, gw-vv-0.5", "(c) a fluid, Secs. I and V\xa0C, gw-vv-0.5"),
    ("the chain's own & <b>", "the chain&#39;s own &amp; ⟨b⟩"),
    ("`rho = 1e5 - r_c`", "<code>rho = 1e5 - r_c</code>"),
]


@pytest.mark.parametrize("plain, html", NOTATION, ids=[plain for plain, _ in NOTATION])
def test_notation(plain, html):
    """As the field prints it; articles, panels, names and code stay as they are."""
    assert typeset(plain) == html


CHAINS = {
    "dimension": 2, "box": 10, "molecules": [{"architecture": "A 10", "density": 2}],
    "repulsion": {"A A": 25}, "core": {"radius": 0.15, "force": 100},
    "bond": {"stiffness": 300, "length": 0.25},
    "integrator": {"scheme": "gw-vv", "lambda": 0.65, "dt": 0.002},
    "steps": {"equilibrate": 50, "sample": 400},
}  # fmt: skip
BLENDS = PLAIN | {"box": [8, 8, 20], "steps": {"equilibrate": 0, "sample": 400}}


def swept(scene, replicas=1, **axes):
    """What a caption needs of a collected sweep: scenes over axes, some of them keys of a scene."""
    (name, values), *_ = [*axes.items(), ("none", [0])]
    scenes = []
    for value in values:
        changed = {"radius": {"core": scene.get("core", {}) | {"radius": value}}}.get(name, {})
        scenes.append([json.dumps(Scene(scene | changed).data)] * replicas)
    along = (name, "replica")
    return xr.Dataset(
        {"scene": (along, scenes), "kT": (along, np.ones((len(values), replicas)))}, {name: values}
    )


def test_a_line_for_a_sweep():
    """System, forces, dynamics and samples; a swept radius as a range, once."""
    line = sweep_line(swept(CHAINS, replicas=3, radius=[0.0, 0.15, 0.2]))
    for phrase in (
        "200 beads, chains, N = 10, box 10 x 10 r_c^2, rho = 2",
        "a_AA = 25 kT/r_c",
        "r_s = 0 to 0.2 (3 values) r_c, F_max = 100 kT/r_c",
        "spring constant C = 300 kT/r_c^2, rest length 0.25 r_c",
        "sigma = 3 (gamma = 4.5), uniform noise, scheme gw-vv, lambda = 0.65, dt = 0.002",
        "400 steps after 50 of equilibration, 3 replicas",
    ):
        assert phrase in line
    assert "swept" not in line and line.count("values") == 1


def test_names_of_several_letters_stand_apart():
    """In the tables of a scene, and in what a caption makes of them."""
    pairs = ["W1 W1", "W1 tail", "Na+ W1", "tail tail", "tail Na+", "Na+ Na+"]
    scene = BLENDS | {
        "molecules": [{"architecture": name, "density": 1} for name in ("W1", "tail", "Na+")],
        "repulsion": dict(zip(pairs, (25, 40, 25, 25, 40, 25))),
        "mass": {"W1": 2},
        "thermostat": {"gamma": dict.fromkeys(pairs, 4.5) | {"Na+ Na+": 9}},
    }
    line = sweep_line(swept(scene, set=["one"]))
    assert "= 25, a_(Na+ tail) = a_(W1 tail) = 40 kT" in line
    assert "masses m_(Na+) = m_(tail) = 1, m_(W1) = 2" in line
    assert str(typeset("a_(Na+ W1) = 25")) == "<i>a</i><sub>Na+ W1</sub> = 25"
    assert str(typeset("gamma_(W1 W1)")) == "γ<sub>W1 W1</sub>"


def figure_file(**more):
    """A figure's file as a module."""
    return SimpleNamespace(**{"TITLE": "Rates.", "PAPER_SHOWS": "None.", "ERRORS": "Bars."} | more)


def test_a_caption():
    """The paper's number, a line a sweep in the field's notation, errors, warnings, table."""
    said = caption("fig04_rates", figure_file(), {"two_slabs": swept(BLENDS)}, xr.Dataset())
    assert said.startswith("<p><strong>Figure 4 of the paper. Rates.</strong> None.</p>")
    assert "<em>two_slabs</em>: 3840 beads" in said
    assert "<i>a</i><sub>AA</sub> = <i>a</i><sub>BB</sub> = 25" in said
    assert "<code>seed</code>" in said and "<p>Bars.</p>" in said
    frame = pd.DataFrame([("one < two", "1 ± 2")], columns=["set", "rate / %"])
    module = figure_file(
        warnings=lambda numbers: [f"Box {float(numbers.room)} is small."],
        table=lambda numbers: frame,
    )
    said = caption("rates", module, {}, xr.Dataset({"room": 1.5}))
    assert "<strong>Our own figure. Rates.</strong>" in said
    assert "<p><strong>Warning.</strong> Box 1.5 is small.</p>" in said
    assert '<th scope="col">rate / %</th>' in said
    assert '<td data-label="set">one &lt; two</td>' in said


FIGURES = [
    ROOT / "paper_figures" / paper.stem / f"{figure}.py"
    for paper in sorted((ROOT / "config" / "papers").glob("*.yaml"))
    for figure in yaml.safe_load(paper.read_text(encoding="utf-8")).get("figures", {})
]


@pytest.mark.parametrize("path", FIGURES, ids=[f"{p.parent.name}-{p.stem}" for p in FIGURES])
def test_every_figure_is_told_in_words(path):
    """For those who cannot see it; and no type too small for a column."""
    module = load_module(path.parent.name, path.stem)
    assert callable(module.describe)
    sizes = re.findall(r"(?:fontsize|labelsize)=([\d.]+)", path.read_text())
    assert all(float(size) >= 7 for size in sizes)
