"""Captions, numbers and pages of the report."""

import json
import os
import re
from html.parser import HTMLParser
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from docutils.core import publish_parts
from jinja2 import Environment
from matplotlib import pyplot as plt

from dpd import files
from dpd.analysis.verdicts import COLUMNS
from dpd.digest import ROOT
from dpd.report import overhead, style
from dpd.report.captions import caption, label, span, sweep_line
from dpd.report.judged import counts, judged_rows
from dpd.report.notation import typeset
from dpd.report.page import write_page
from dpd.report.text import with_error
from dpd.scene import Scene
from dpd.study import Figure, Paper

NUMBERS = [
    (0.12345, 0.0067, "0.1235 ± 0.0067"),
    (123.4, 5.6, "123.4 ± 5.6"),
    (12345.0, 678.0, "12345 ± 678"),
    (3.21e-6, 4.5e-8, "(3.210 ± 0.045)e-6"),
    (2.5e8, 1.0e7, "(2.50 ± 0.10)e8"),
    (0.0, 0.01, "0.000 ± 0.010"),
    (1.5, np.nan, "1.5"),
    (1.5, 0.0, "1.5"),
    (np.nan, 1.0, "–"),
]


@pytest.mark.parametrize("value, error, text", NUMBERS, ids=[text for _, _, text in NUMBERS])
def test_two_digits_of_the_error(value, error, text):
    """And the value to the same place."""
    assert with_error(value, error) == text


NOTATION = [
    ("a_AA = 25 kT/r_c", "<i>a</i><sub>AA</sub> = 25 <i>kT</i>/<i>r</i><sub>c</sub>"),
    ("rho = 3, sigma = 3", "ρ = 3, σ = 3"),
    ("N = 10, C = 2", "<i>N</i> = 10, <i>C</i> = 2"),
    ("F_max = 100", "<i>F</i><sub>max</sub> = 100"),
    ("dt = 0.04", "Δ<i>t</i> = 0.04"),
    ("10 x 10 x 10 r_c^3", "10 × 10 × 10 <i>r</i><sub>c</sub><sup>3</sup>"),
    ("R_g ~ N^(1/2)", "<i>R</i><sub>g</sub> ~ <i>N</i><sup>1/2</sup>"),
    ("p - rho kT = alpha a rho^2", "<i>p</i> − ρ <i>kT</i> = α <i>a</i> ρ<sup>2</sup>"),
    ("chi / Delta a >= -0.3 +- 0.1", "χ / Δ<i>a</i> ≥ −0.3 ± 0.1"),
    ("(3.2 ± 0.4)e-06 and 1e+5", "(3.2 ± 0.4) × 10<sup>−6</sup> and 10<sup>5</sup>"),
    ("4 <l^2> < g_i", "4 ⟨<i>l</i><sup>2</sup>⟩ &lt; <i>g</i><sub>i</sub>"),
    ("(c) a fluid, Sec. III C, e.g. gw-vv-0.5", "(c) a fluid, Sec.\xa0III\xa0C, e.g. gw-vv-0.5"),
    ("the chain's own & <b>", "the chain&#39;s own &amp; ⟨b⟩"),
    ("`rho = 1e5 - r_c`", "<code>rho = 1e5 - r_c</code>"),
]


@pytest.mark.parametrize("plain, html", NOTATION, ids=[plain for plain, _ in NOTATION])
def test_notation(plain, html):
    """As the field prints it; articles, panels, names and code stay as they are."""
    assert typeset(plain) == html


def test_values_as_text():
    """Few numbers one by one, many as a range with their number, names all."""
    assert span([25.0, 25.0]) == "25"
    assert span([30.0, 25.0]) == "25 and 30"
    assert span([0.1, 2, 5.5, 1]) == "0.1 to 5.5 (4 values)"
    assert span([100_000]) == "100\N{NARROW NO-BREAK SPACE}000"
    assert span(["uniform", "gaussian"]) == "uniform, gaussian"


CHAINS = {
    "dimension": 2,
    "box": 10,
    "molecules": [{"architecture": "A 10", "density": 2}],
    "repulsion": {"A A": 25},
    "core": {"radius": 0.15, "force": 100},
    "bond": {"stiffness": 300, "length": 0.25},
    "integrator": {"scheme": "gw-vv", "lambda": 0.65, "dt": 0.002},
    "steps": {"equilibrate": 50, "sample": 400},
}
BLENDS = {
    "dimension": 3,
    "box": [8, 8, 20],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 37},
    "integrator": {"scheme": "dpd-vv", "dt": 0.04},
    "steps": {"equilibrate": 0, "sample": 400},
}


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
    line = str(sweep_line(swept(CHAINS, replicas=3, radius=[0.0, 0.15, 0.2])))
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


def test_a_line_names_axes_that_do_not_show():
    """Two species; an axis of names; a scheme whose lambda is not chosen."""
    line = sweep_line(swept(BLENDS, set=["one", "other"]))
    assert "3840 beads, monomers of A and B, box 8 x 8 x 20 r_c^3, rho = 3" in line.system
    assert line.forces == "a_AA = a_BB = 25, a_AB = 37 kT/r_c"
    assert "lambda" not in line.dynamics and line.sampling.endswith("one replica")
    assert line.swept == "swept: set one, other"


def test_a_line_on_a_run_without_friction_or_equilibration():
    """What is not there is called so."""
    line = sweep_line(swept(BLENDS | {"thermostat": {"gamma": 0}}))
    assert line.dynamics.startswith("no thermostat, scheme dpd-vv")
    assert line.sampling == "400 steps without equilibration, one replica"


def figure_file(**more):
    """A figure's file as a module."""
    return SimpleNamespace(**{"TITLE": "Rates.", "PAPER_SHOWS": "None.", "ERRORS": "Bars."} | more)


def test_a_caption():
    """The paper's number, a line a sweep in the field's notation, where the seeds are, errors."""
    said = caption("fig04_rates", figure_file(), {"two_slabs": swept(BLENDS)}, xr.Dataset())
    assert said.startswith("<p><strong>Figure 4 of the paper. Rates.</strong> None.</p>")
    assert "<em>two_slabs</em>: 3840 beads" in said
    assert "<i>a</i><sub>AA</sub> = <i>a</i><sub>BB</sub> = 25" in said
    assert "<code>seed</code>" in said and "<p>Bars.</p>" in said


def test_warnings_and_table_of_a_figure():
    """They follow the caption, and nothing is left to the browser's mercy."""
    frame = pd.DataFrame([("x < y", "1 ± 2")], columns=["set", "rate / %"])
    module = figure_file(
        warnings=lambda numbers: [f"Box {float(numbers.room)} is small."],
        table=lambda numbers: frame,
    )
    said = caption("rates", module, {}, xr.Dataset({"room": 1.5}))
    assert "<strong>Our own figure. Rates.</strong>" in said
    assert "<p><strong>Warning.</strong> Box 1.5 is small.</p>" in said
    assert '<th scope="col">rate / %</th>' in said
    assert '<td data-label="set">x &lt; y</td>' in said


def test_a_figure_without_either():
    """Most have no warnings and no table; a figure without runs has no seeds."""
    said = caption("rates", figure_file(), {}, xr.Dataset())
    assert said == "<p><strong>Our own figure. Rates.</strong> None.</p>\n<p>Bars.</p>\n"


def test_the_caption_in_the_report_of_snakemake(tmp_path):
    """Its template reads the caption that the rule wrote; docutils leaves the HTML alone."""
    text = caption("fig04_rates", figure_file(), {"slabs": swept(BLENDS)}, xr.Dataset())
    (tmp_path / "fig04_rates.html").write_text(text, encoding="utf-8")
    template = (ROOT / "paper_figures" / "caption.rst").read_text(encoding="utf-8")
    job = SimpleNamespace(output=SimpleNamespace(caption=tmp_path / "fig04_rates.html"))
    result = SimpleNamespace(path=tmp_path / "fig04_rates.png")
    rendered = Environment(trim_blocks=True, lstrip_blocks=True).from_string(template)
    rst = rendered.render(snakemake=job, files=[result])
    assert text.strip() in publish_parts(rst, writer="html")["body"]


# A page -----------------------------------------------------------------------------------------

VERDICTS = {  # figure of the first paper, kind, verdict, value
    "alpha": ("fig02_shapes", "simulated", "replicated", 0.1),
    "beta < 2": ("fig02_shapes", "simulated", "deviates", 2.5),
    "gamma": ("fig02_shapes", "closed form", "replicated", 1.0),
    "kappa": ("drift", "simulated", "not reached at this scale", np.nan),
    "lambda": ("drift", "check", "deviates", 3.0),
}


def verdict_table(paper, figure, rows):
    """As `dpd.analysis.verdicts.rows` makes it."""
    table = [
        {
            "paper": paper, "figure": figure, "quantity": name, "where": "Sec. I", "kind": kind,
            "limits": "ours", "published": "< 2", "published_error": np.nan, "rounding": 0.05,
            "value": value, "error": 0.01, "deviation_sigma": np.nan, "resolution": 0.02,
            "verdict": verdict, "note": "" if kind == "check" else "by eye",
        }
        for name, (kind, verdict, value) in rows.items()
    ]  # fmt: skip
    return pd.DataFrame(table, columns=COLUMNS)


def put_figure(folder, paper, figure, rows, seen=None):
    """The files of a figure."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn, _ = style.panels()
    drawn.savefig(folder / f"{figure}.png", dpi=30)
    plt.close(drawn)
    attributes = {"seconds": 1.0} | ({"seen": seen} if seen else {})
    xr.Dataset(attrs=attributes).to_netcdf(folder / f"{figure}.nc", engine="netcdf4")
    (folder / f"{figure}.html").write_text(f"<p>Caption of {paper} {figure}.</p>")
    verdict_table(paper, figure, rows).to_csv(folder / f"{figure}.csv", index=False)


class Page(HTMLParser):
    """What a page holds: ids, links, images, headings, and tags by name with attributes."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.inside, self.links = [], [], {}
        self.feed(text)

    def handle_starttag(self, tag, given):
        given = dict(given)
        self.tags.append((tag, given))
        if tag in ("tr", "figure") and "id" in given:
            self.inside.append((tag, given["id"]))
        elif tag == "a" and self.inside:
            self.links.setdefault(self.inside[-1][1], []).append(given["href"][1:])

    def handle_endtag(self, tag):
        if self.inside and self.inside[-1][0] == tag:
            self.inside.pop()

    def all(self, tag, key=None):
        """Attributes of all tags of a name; or one attribute of each."""
        found = [given for name, given in self.tags if name == tag]
        return [given.get(key) for given in found] if key else found


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    """A page on two papers with figures of one name, and one with nothing at all."""
    results = tmp_path_factory.mktemp("study")
    figures = {"fig02_shapes": Figure((), ()), "drift": Figure((), ())}
    one = Paper("one_1997", "One & other", "J. One 1", {}, (), figures)
    two = Paper("two_2008", "Two", "J. Two 2", {}, (), {"fig02_shapes": Figure((), ())})
    empty = Paper("three_2019", "Three", "J. Three 3", {}, (), {})
    for figure in figures:
        rows = {name: rest for name, (at, *rest) in VERDICTS.items() if at == figure}
        put_figure(results / one.name / "figures", one.name, figure, rows, 'A "line" <rises>.')
    rows = {"delta": ("simulated", "replicated", 1.0)}
    put_figure(results / two.name / "figures", two.name, "fig02_shapes", rows)  # without `seen`
    write_page("quick", "Short.", [one, two, empty], results, results / "report.html")
    return (results / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    """The same, read."""
    return Page(text)


def test_ids_are_unique_and_links_lead_somewhere(page):
    """Two papers have a figure of one name here."""
    ids = [given["id"] for _, given in page.tags if "id" in given]
    assert len(set(ids)) == len(ids)
    assert {"one_1997-fig02_shapes", "two_2008-fig02_shapes"} <= set(ids)
    targets = page.all("a", "href")
    assert len(targets) > 10 and {target[1:] for target in targets} <= set(ids)


def test_rows_and_figures_link_to_each_other(page):
    """Each row to its figure, and that back to all of its rows."""
    rows = [given["id"] for given in page.all("tr") if "id" in given]
    assert len(rows) == len(VERDICTS) + 1
    figures = page.all("figure", "id")
    for row in rows:
        (figure,) = page.links[row]
        assert figure in figures and row in page.links[figure]
    assert sum(len(page.links.get(figure, [])) for figure in figures) == len(rows)


def test_figures_are_told_in_words(page):
    """What is seen, escaped; the figure's name where its file says nothing; sizes for all."""
    images = page.all("img")
    assert [image["alt"] for image in images] == ['A "line" <rises>.'] * 2 + ["Figure 2"]
    assert all(int(image["width"]) > 0 and int(image["height"]) > 0 for image in images)


def test_only_simulated_numbers_are_counted(text):
    """Formulas and checks of our own are counted apart."""
    assert (
        "Of 4 published numbers and claims that were held against simulation: "
        "2 replicated, 1 deviates, 1 not reached at this scale." in text
    )
    for place, name, verdicts in (
        ("closed-forms", "closed forms", "1 replicated, 0 deviate, 0 not reached"),
        ("checks-of-our-own", "checks of our own", "0 replicated, 1 deviates, 0 not reached"),
    ):
        assert f'Counted apart: 1 <a href="#{place}">{name}</a> ({verdicts}' in text


def test_counts_of_papers():
    """Of each paper that has rows of a kind, then of all."""
    table = verdict_table("p", "f", {name: rest for name, (_, *rest) in VERDICTS.items()})
    found = counts(judged_rows(table), "simulated", ["o", "p"])
    assert [(count.paper, count.total) for count in found] == [("p", 3), ("", 3)]
    assert found[0].verdicts == {"replicated": 1, "deviates": 1, "not reached at this scale": 1}
    (check, total) = counts(judged_rows(table), "check", ["o", "p"])
    assert check.total == total.total == 1 and total.verdicts["deviates"] == 1


def test_a_row_in_full(text):
    """Every column; quantities in notation; nothing where there is nothing to say."""
    row = text[text.index('<tr id="one_1997-fig02_shapes-2"') :]
    row = row[: row.index("</tr>")]
    for column, value in (
        ("Where", "Sec.\xa0I"), ("Published", "&lt; 2"), ("Standard error", ""),
        ("Rounding", "0.05"), ("Limits", "ours"), ("This work", "2.500 ± 0.010"), ("Deviation", ""),
        ("Resolution", "0.02"), ("Verdict", "deviates"), ("Note", "by eye"),
    ):  # fmt: skip
        assert re.search(rf'<td data-label="{column}"[^>]*>{value}</td>', row), column
    assert '<th scope="row">β &lt; 2</th>' in row
    assert not re.search(r">\s*(nan|None)\s*<", text)


def test_a_page_can_be_walked_through(page, text):
    """Language, a way past the head, headings without gaps, and what each table and cell is."""
    assert page.all("html", "lang") == ["en"]
    assert page.all("a")[0]["href"] == "#content" and "content" in page.all("main", "id")
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h\d", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert len(page.all("table")) == len(page.all("caption")) >= 5
    assert set(page.all("th", "scope")) == {"row", "col"}
    assert any(given.get("name") == "description" for given in page.all("meta"))
    assert "One &amp; other" in text and not re.search(r"""(src|href)=["']?(https?:)?//""", text)


def test_a_page_on_nothing(tmp_path):
    """A paper without figures, sweeps or published numbers."""
    empty = Paper("three_2019", "Three", "J. Three 3", {}, (), {})
    write_page("quick", "Short.", [empty], tmp_path, tmp_path / "report.html")
    assert 'id="verdicts"' not in (tmp_path / "report.html").read_text(encoding="utf-8")


def luminance(color):
    """WCAG 2, relative luminance."""
    parts = (int(color[at : at + 2], 16) / 255 for at in (1, 3, 5))
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return np.dot(linear, (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_contrast(text, scheme):
    """WCAG AA: 4.5 for text, on the page and on the heads of tables."""
    block = re.findall(r":root \{(.*?)\}", text, re.S)[scheme]
    colors = dict(re.findall(r"--(\w+): (#\w{6})", block))
    for ground in ("page", "band"):
        for ink in ("text", "soft", "link", "good", "bad", "open"):
            low, high = sorted(luminance(colors[name]) for name in (ground, ink))
            assert (high + 0.05) / (low + 0.05) >= 4.5, (ground, ink)


def test_labels_of_figures():
    """The paper's number, or a name of our own."""
    assert label("fig04_scaled_pressure") == "Figure 4"
    assert label("bond_lengths") == "Own figure: bond lengths"


def test_what_a_workflow_costs_beside_its_simulations(tmp_path, monkeypatch):
    """Runs, starts and measurements since it began, of all papers, and nothing older."""
    monkeypatch.setattr(overhead.time, "time", lambda: 1110.0)
    for number, name in enumerate(("a/runs/s/p/run.nc", "a/starts/0.nc", "b/runs/s/p/run.nc")):
        files.write(tmp_path / name, {}, {"seconds": 50.0 + number})
        os.utime(tmp_path / name, (1005.0, 1005.0))
    said = overhead.overhead(tmp_path, 1000.0, 2)
    assert said.startswith("simulation 153 s (runs and starts: 3), wall clock 110 s on 2 cores")
    assert ": 44% more" in said
    os.utime(tmp_path / "b/runs/s/p/run.nc", (999.0, 999.0))
    assert overhead.overhead(tmp_path, 1000.0, 2).startswith(
        "simulation 101 s (runs and starts: 2)"
    )
    assert ": 116% more" in overhead.overhead(tmp_path, 1000.0, 4)  # no faster than one run
    assert overhead.overhead(tmp_path, 1006.0, 2) == ""
    # Nothing runs beside a measurement: it takes all cores.
    files.write(tmp_path / "b/measurements/m.nc", {}, {"seconds": 40.0})
    said = overhead.overhead(tmp_path, 1000.0, 2)
    assert "measurements 40 s on all cores" in said and ": 21% more" in said
