"""The page of the report, what it says of a workflow's cost, and the sentences of failed jobs."""

import os
import re
from html import unescape
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib import pyplot as plt

import dpd
from dpd.analysis.collect import load
from dpd.analysis.statistics import widening
from dpd.analysis.verdicts import BOUND, COLUMNS, Measured, judge
from dpd.commands.main import main
from dpd.folders import PACKAGE
from dpd.pipeline.paper import Figure, Paper, read_config, read_paper
from dpd.pipeline.paths import commit, errors_in
from dpd.report import style
from dpd.report.archive import ARCHIVE, compared, table_of
from dpd.report.page import write_page
from dpd.report.rows import LEADS, by_name, read_rows, sentences
from dpd.report.run_page import off, quantities
from dpd.report.text import label, typeset
from dpd.runs.result import scene_of
from tests.test_pipeline import SMOKE, copy_repository, snakemake

SURFACTANT = {
    "dimension": 3,
    "box": 6,
    "molecules": [{"architecture": "A B 2", "count": 100}, {"architecture": "W", "density": 1.6}],
    "repulsion": {"A A": 25, "B B": 25, "W W": 25, "A B": 50, "A W": 25, "B W": 80},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"equilibrate": 0, "sample": 400},
}
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
            "verdict": verdict,
            "note": "" if kind == "check" else f"by eye; {BOUND}" if name == "gamma" else "by eye",
        }
        for name, (kind, verdict, value) in rows.items()
    ]  # fmt: skip
    return pd.DataFrame(table, columns=COLUMNS)


def put_figure(folder, paper, figure, rows, seen="A line."):
    """The files of a figure."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn, _ = style.panels()
    about = {"Title": f"{paper}, {label(figure)}: A title.", "Description": seen}
    drawn.savefig(folder / f"{figure}.png", dpi=30, metadata=about)
    plt.close(drawn)
    attributes = {"seconds": 1.0, "seen": seen}
    xr.Dataset(attrs=attributes).to_netcdf(folder / f"{figure}.nc", engine="netcdf4")
    (folder / f"{figure}.html").write_text(f"<p>Caption of {paper} {figure}.</p>")
    verdict_table(paper, figure, rows).to_csv(folder / f"{figure}.csv", index=False)


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    """A page on two papers with figures of one name, and one with nothing at all."""
    results = tmp_path_factory.mktemp("study")
    figures = {"fig02_shapes": Figure(), "drift": Figure()}
    one = Paper("one_1997", "One & other", "J. One 1", {}, (), figures)
    two = Paper("two_2008", "Two", "J. Two 2", {}, (), {"fig02_shapes": Figure()})
    empty = Paper("three_2019", "Three", "J. Three 3", {}, (), {})
    for figure in figures:
        rows = {name: rest for name, (at, *rest) in VERDICTS.items() if at == figure}
        put_figure(results / one.name / "figures", one.name, figure, rows, 'A "line" <rises>.')
    rows = {"delta": ("simulated", "replicated", 1.0)}
    put_figure(results / two.name / "figures", two.name, "fig02_shapes", rows)
    write_page("quick", "Short.", [one, two, empty], results, results / "report.html")
    return (results / "report.html").read_text(encoding="utf-8")


def test_rows_and_figures_link_to_each_other(text):
    """Each row to its figure, and that back to all of its rows; two have one name here."""
    ids = re.findall(r'\sid="([^"]+)"', text)
    assert len(set(ids)) == len(ids) and set(re.findall(r'href="#([^"]+)"', text)) <= set(ids)
    assert set(re.findall(r'data-to="([^"]+)"', text)) <= set(ids)
    parts = text.split('<article class="figure" id="')[1:]
    figures = {part.split('"')[0]: part.split("</article>")[0] for part in parts}
    rows = [part.split("</tr>")[0] for part in text.split('<tr id="')[1:]]
    assert len(rows) == len(VERDICTS) + 1 and len(figures) == 3
    for row in rows:
        (figure,) = re.findall(r'<a href="#([^"]+)"', row)
        assert f'href="#{row.split(chr(34))[0]}"' in figures[figure]
    pictures = re.findall(r'<button[^>]*><img [^>]*width="[1-9]\d*" [^>]*alt="([^"]+)"', text)
    assert list(map(unescape, pictures)) == ['A "line" <rises>.'] * 2 + ["A line."]
    linked = re.findall(r'<a class="thumb" href="#([^"]+)"', text)
    assert linked == list(figures) and text.index('class="thumb"') < text.index("<article")


def test_only_simulated_numbers_are_counted(text):
    """One mark each; formulas and checks of our own are counted apart."""
    assert "Of 4 published numbers" in text
    for mark, number in (("r", 2), ("d", 1), ("n", 1)):
        assert re.search(rf'#m-{mark}"/></svg><b>{number}</b>', text)
        assert len(re.findall(f'm-{mark} s11 go"', text)) == number
    assert "that a formula gives (1 of 1 hold) and checks of our own (0 of 1 hold)" in text


def test_a_row_in_full(text):
    """Every column; quantities in notation; deviations first, whatever order figures have."""
    rows = re.findall(r'<tr id="([^"]+)" data-mark="(.)"', text)
    assert "".join(mark for _, mark in rows) == "ddnrrr"
    assert rows[0][0] == "one_1997-fig02_shapes-2"
    row = text[text.index('<tr id="one_1997-fig02_shapes-2"') :]
    row = row[: row.index("</tr>")]
    for column, value in (
        ("paper", '<a href="#one_1997-fig02_shapes">One 1997, Fig. 2</a>'), ("where", "Sec.\xa0I"),
        ("pub", "&lt; 2 <small>rounding 0.05</small>"), ("limits", "ours"), ("z", ""),
        ("ours", "2.500 ± 0.010"), ("res", "0.02"), ("long", ""), ("note", "by eye"),
    ):  # fmt: skip
        assert re.search(rf'<td class="c-{column}"[^>]*>{re.escape(value)}</td>', row), column
    assert '<th scope="row">β &lt; 2</th>' in row
    assert len(re.findall(r'<td class="c-ours"[^>]*>&lt; 1.000 ± 0.010</td>', text)) == 1  # a bound
    assert not re.search(r">\s*(nan|None)\s*<", text)


def test_the_page_is_small_and_fetches_nothing(text):
    """Templates, styles and scripts of few lines; all that a browser loads is inside."""
    room = PACKAGE / "report"
    lines = {path.name: path.read_text().count("\n") for path in room.iterdir() if path.is_file()}
    assert sum(lines[name] for name in lines if name.endswith(".html")) <= 400
    script = text.split("<script>")[1].split("</script>")[0]
    assert lines["page.css"] <= 300 and script.count("\n") <= 62
    assert not re.search(r"""(src=|url\(|import )["']?(?!data:|#)\w*:?//""", text)
    assert len(text) < 200_000


def test_a_page_of_a_study_that_runs(tmp_path):
    """It says how far the study is; what is not made has an empty frame."""
    paper = read_paper("example", "smoke", only=[])
    write_page("smoke", "Short.", [paper], tmp_path, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    points = len(read_paper("example", "smoke").sweeps["pressure"].points)
    assert f"0 of 1 figures are made, 0 of {points} runs done" in page
    assert '<p class="blank">Not made yet.</p>' in page


def test_the_page_of_a_run(tmp_path, monkeypatch):
    """A panel for all that was measured, and what is off."""
    monkeypatch.chdir(tmp_path)
    observe = ["thermo", "rdf", "chains", "displacement", {"profile": {"every": 10}}]
    dpd.run(SURFACTANT | {"observe": observe}, output="run.nc")
    assert main(["report", "run.nc"]) == 0
    page = Path("run.html").read_text(encoding="utf-8")
    run = load("run.nc")
    for name in ("kT", "pressure", "rdf", "density_profile", "msd_centre", "gyration_square"):
        assert str(typeset(run[name].long_name)) in page, name
    assert page.count("data:image/png") > 6 and not re.search(r"(src|href)=.?http", page)
    assert main(["report", "run.nc"]) == 1  # it is there

    scene = scene_of("run.nc", run.attrs)
    still, n = run[["kT", "time"]].drop_attrs(deep=False).assign_attrs(lost_step=-1), len(run.kT)
    still["kT"].values[:] = 1 + np.random.default_rng(1).normal(0, 0.01, n)
    assert not list(off(still, [*quantities(still, scene)]))
    still["kT"].values += 0.05
    assert "and 1 is set" in " ".join(off(still, [*quantities(still, scene)]))
    still["kT"].values[n // 2 :] -= 0.05
    assert "halves of the run differ" in " ".join(off(still, [*quantities(still, scene)]))


@pytest.mark.parametrize("paper", read_config()["papers"])
def test_what_findings_say_is_what_was_found(paper):
    """Of the long study where that has all that a sentence states, else of the quick one."""
    rows = {study: by_name(paper, read_rows(f"{ARCHIVE}/{study}/verdicts.csv"))
            for study in ("paper", "quick")}  # fmt: skip
    said = {each.key: each for each in sentences(paper)}
    figures = list(read_paper(paper, "quick", only=[]).figures)
    assert list(said) == [key for key in LEADS if key in said] + figures
    for key, sentence in said.items():
        long_one = rows["paper"].keys() >= sentence.verdicts.keys() and rows["paper"]
        study = "paper" if long_one or sentence.studies else "quick"
        assert sentence.verdicts.keys() <= rows[study].keys(), key
        for name, verdict in sentence.verdicts.items():
            assert rows[study][name]["verdict"] == verdict, f"{key}: {name}"
        assert sentence.holds(study, rows[study]), key
        others = {name: {"verdict": "replicated"} for name in sentence.verdicts}
        if "deviates" in sentence.verdicts.values():
            assert not sentence.holds(study, rows[study] | others)


def test_a_page_without_git(monkeypatch, tmp_path):
    """It says so, and does not fail."""
    assert "git not found" not in commit()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit() == "unknown: git not found"


@pytest.mark.thorough
def test_studies_with_true_errors_agree(tmp_path, capsys):
    """`dpd compare` finds of two what it predicts; a mistaken error shows."""
    rng, rows, degrees = np.random.default_rng(3), 2000, 8.0
    truth = rng.normal(0, 2, rows)

    def study(name, mistake=1.0):
        value = rng.normal(truth, 1)
        error = mistake * widening(degrees) * np.sqrt(rng.chisquare(degrees, rows) / degrees)
        table = pd.DataFrame({"value": value, "error": error, "degrees": degrees})
        found = [judge({"range": [None, 1]}, Measured(*each)).verdict for each in zip(value, error)]
        table = table.assign(paper="one", figure="fig", quantity=range(rows), published="< 1",
                             verdict=found, kind="simulated")  # fmt: skip
        table.loc[0, "value" if name == "a" else "note"] = np.nan
        table.reindex(columns=COLUMNS).to_csv(tmp_path / name, index=False)
        return table_of(tmp_path / name)

    one, other = study("a"), study("b")
    found = compared(one, other)
    assert found.missing.sum() == 1 and not found.flip[0]
    expected = np.sqrt(degrees / (degrees - 1)) / widening(degrees)  # of t's with 16 degrees
    assert np.sqrt((found.z**2).mean()) == pytest.approx(expected, abs=0.05)
    assert np.sqrt(found.likely_z.mean()) == pytest.approx(expected, abs=0.03)
    # A part of the errors that both studies share does not make them differ.
    shared = [each.assign(error=np.hypot(each.error, 3), systematic=3.0) for each in (one, other)]
    assert np.allclose(compared(*shared).z, found.z, equal_nan=True)
    assert np.sqrt((compared(one, study("c", 1.5)).z ** 2).mean()) < 0.85 * expected
    assert main(["compare", *map(str, (tmp_path / "a", tmp_path / "b"))]) == 0
    assert re.search("that one study lacks:\n.*\n.*NaN +one +fig +0 +NaN", capsys.readouterr().out)
    assert main(["compare", "none", str(tmp_path / "a")]) == 1


def log(path, text, when):
    """A log that was written at some time."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode())
    os.utime(path, (when, when))


def test_sentences_of_this_workflow_are_found_once(tmp_path):
    """With the path of the log; those of older logs, and other lines, are not."""
    log(tmp_path / "old.log", "error: long ago\n", 999)
    log(tmp_path / "a" / "one.log", "warning: kT\nerror: no room\nthe end\n", 1000)
    log(tmp_path / "b" / "two.log", "error: no room\nerror: no start\n", 1001)
    log(tmp_path / "b" / "three.made", "error: no log\n", 1001)
    log(tmp_path / "good.log", "no error: at all\n", 1001)
    assert errors_in(tmp_path, 1000) == {
        "error: no room": tmp_path / "a" / "one.log",
        "error: no start": tmp_path / "b" / "two.log",
    }
    assert errors_in(tmp_path, 1002) == errors_in(tmp_path / "none") == {}


@pytest.mark.thorough
def test_a_workflow_ends_with_them(tmp_path):
    """Below all that Snakemake says."""
    folder = copy_repository(tmp_path / "copy")
    place = folder / "results" / "smoke" / "groot_warren_1997" / "runs" / "fluid" / "replica=0"
    (place / "run.checkpoint").mkdir(parents=True)
    done = snakemake(folder, str(place.parent.relative_to(folder) / "0.made"), *SMOKE)
    assert done.returncode != 0
    last = done.stderr.rstrip().splitlines()[-1]
    assert last.startswith("error: ") and "run.checkpoint" in last
    assert last.endswith("(results/smoke/logs/groot_warren_1997/runs/fluid/0.log)")
