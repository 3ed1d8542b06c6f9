"""Pages for people: what a run makes in them is fresh, and what they name is there."""

import re
import shlex
import tomllib
from functools import cache
from pathlib import Path

import pandas as pd
import pytest
import yaml
from PIL import Image
from snakemake.cli import get_argument_parser

from docs import pages as documents
from docs.pages import pages, rendered, run_table
from dpd import __version__
from dpd.analysis.verdicts import COLUMNS
from dpd.commands.main import new_parser
from dpd.folders import PACKAGE, ROOT
from dpd.page import Observable, names
from dpd.pipeline.paper import Figure, Paper, read_config
from dpd.pipeline.paths import Results
from dpd.report import archive
from dpd.scene.scene import Scene

README = (ROOT / "README.md").read_text()
PLACES = "*.md", "docs/*/*.md", "paper_figures/*/*.md", "benchmarks/*.md", "src/dpd/**/*.md"
PAGES = {str(path.relative_to(ROOT)): path for place in PLACES for path in sorted(ROOT.glob(place))}
PAPERS = read_config()["papers"]
SNAKEMAKE = cache(get_argument_parser)  # what it makes of its command line


def test_generated_pages_are_fresh():
    """`python -m dpd readme` has nothing to change."""
    made = pages()
    stale = [str(path) for path, text in made.items() if path.read_text() != text]
    assert not stale, f"{', '.join(stale)}: let `python -m dpd readme` write them"
    of_papers = {ROOT / "paper_figures" / paper / "README.md" for paper in PAPERS}
    assert set(made) == {ROOT / "README.md"} | of_papers


@pytest.mark.parametrize("path", PAGES.values(), ids=PAGES)
def test_links_lead_somewhere(path):
    """To a file or folder of the repository, and to a heading in it."""
    for target in re.findall(r"\]\(([^)\s]+)\)", path.read_text()):
        if target.startswith("https://"):
            continue
        file, _, anchor = target.partition("#")
        there = path.parent / file if file else path
        assert there.exists(), target
        titles = re.findall("^#+ (.+)$", there.read_text(), re.M) if anchor else [""]
        anchors = (re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles)
        assert anchor in anchors, target  # as GitHub makes them


def commands(text, program):
    """Commands of a program in a page: in blocks of code, and between backticks in a line."""
    block = re.compile(r"^```\w*\n(.*?)^```", re.S | re.M)
    found = [line for lines in block.findall(text) for line in lines.splitlines()]
    found += [" ".join(span.split()) for span in re.findall("`([^`]+)`", block.sub("", text))]
    return [line.partition("#")[0] for line in found if f"{line} ".startswith(f"{program} ")]


@pytest.mark.parametrize("path", PAGES.values(), ids=PAGES)
def test_commands_of_dpd_exist(path):
    """Every stage is one, and takes what the page gives it."""
    parser = new_parser([])
    stages = parser._subparsers._group_actions[0].choices
    for command in commands(path.read_text(), "python -m dpd"):
        stage, *arguments = shlex.split(command)[3:]
        if stage == "document" and path.name == "CHANGELOG.md":
            continue  # it is listed there as removed
        assert stage in {*stages, "--help", "STAGE"}, command
        if arguments and stage in stages:
            parser.parse_args([stage, *arguments])


@pytest.mark.parametrize("path", PAGES.values(), ids=PAGES)
def test_commands_of_snakemake_and_make_exist(path):
    """Options, rules, studies and papers; targets of the Makefile."""
    rules = re.findall(
        r"^rule (\w+):", "\n".join(p.read_text() for p in ROOT.glob("rules/*.smk")), re.M
    )
    for command in commands(path.read_text(), "snakemake"):
        found = SNAKEMAKE().parse_args(shlex.split(command)[1:])
        assert set(found.targets) <= set(rules), command
        given = dict(item.split("=", 1) for item in found.config or ())
        read_config({key: yaml.safe_load(value) for key, value in given.items()})
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.M)
    for command in commands(path.read_text(), "make"):
        words = shlex.split(command)[1:]
        assert all(word in targets or re.match("(PYTHON|OPTIONS)=", word) for word in words), (
            command
        )


def test_the_scene_of_the_readme_is_that_of_the_file():
    """In full, so that it can be copied."""
    shown = re.search("```yaml\n(.*?)```", README, re.S)[1]
    whole = (PACKAGE / "scenes" / "fluid.yaml").read_text()
    assert shown == "".join(line for line in whole.splitlines(True) if not line.startswith("#"))


def test_the_python_of_the_readme_asks_for_what_the_scene_observes():
    """Every variable that it names is one of the scene's observables."""
    code = re.search("```python\n(.*?)```", README, re.S)[1]
    asked = set(re.findall(r"(?<!\")\brun\.(\w+)", code))
    observed = Scene.read(PACKAGE / "scenes" / "fluid.yaml").observe
    rows = run_table()
    assert asked and asked <= {variable for name, variable, *_ in rows if name in observed}
    assert {name for name, *_ in rows} == {*names(Observable)} - {"trajectory"}


def test_the_ratios_of_the_readme_are_those_of_the_benchmark():
    """Speed beside LAMMPS is measured once and told twice."""
    table = (ROOT / "benchmarks" / "README.md").read_text()
    ratios = re.findall(r"^\| W\d: .* \| ([\d.]+) \|$", table, re.M)
    first, last = ", ".join(ratios[:-1]), ratios[-1]
    assert len(ratios) == 4 and f"{first} and {last} times" in " ".join(README.split())


def test_the_citation_is_of_this_version():
    """One version in three files, the owner being the package; one license and authors."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    newest = re.search(r"^## \[(.+)\] - (.+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert found["version"] == __version__ == newest[1]
    assert str(found["date-released"]) == newest[2]
    assert found["license"] == project["license"] == "BSD-3-Clause"
    assert found["authors"] == project["authors"]


def row(quantity, verdict, **more):
    """A row of a verdict table."""
    given = {
        "paper": "one", "figure": "fig02_radial", "quantity": quantity, "kind": "simulated",
        "published": "0.5", "published_error": float("nan"), "rounding": float("nan"),
        "value": 0.52, "error": 0.004, "deviation_sigma": 5.0, "verdict": verdict,
    }  # fmt: skip
    return given | more


TABLE = pd.DataFrame([
    row("peak", "deviates", rounding=0.005),
    row("a | b", "deviates", published_error=0.01, kind="check", figure="slope"),
    row("rate", "deviates", published="> 0.6"),
    row("depth", "replicated"),
    row("limit", "replicated", kind="closed form"),
    row("time", "not reached at this scale", paper="two"),
], columns=COLUMNS)  # fmt: skip


@pytest.fixture
def archived(tmp_path, monkeypatch):
    """An archive with a small verdict table of a study, and no pictures."""
    (tmp_path / "fast").mkdir()
    TABLE.to_csv(tmp_path / "fast" / "verdicts.csv", index=False)
    monkeypatch.setattr(archive, "ARCHIVE", tmp_path)
    monkeypatch.setattr(archive, "FIGURES", tmp_path / "figures")
    return tmp_path


def test_counts_and_deviations(archived):
    """By paper and verdict, closed forms and own checks apart; values with their errors."""
    lines = documents.filled("<!-- begin: fast counts -->\nold\n<!-- end -->\n").splitlines()
    assert lines[0] == "<!-- begin: fast counts -->" and lines[-1] == "<!-- end -->"
    link = "[one](paper_figures/one/README.md)"
    assert f"| {link} | 3 | 1 | 2 | 0 | 1 of 1 | 0 of 1 |" in lines and "old" not in lines
    rows = documents.rows_of_archive("fast")
    lines = rendered("verdicts.md.j2", rows=rows).splitlines()
    assert "| Figure 2 | peak | 0.5 rounding 0.005 | 0.5200 ± 0.0040 | 5.0 |" in lines


def test_the_archive_draws_kept_pictures_anew(archived, tmp_path, monkeypatch):
    """Those beside a figure file, as wide as before; no others."""
    results, kept = Results(str(tmp_path / "results")), tmp_path / "figures" / "one"
    kept.mkdir(parents=True)
    for name in ("slope", "other"):
        drawn = {kind: Path(results.figure("one", name, kind)) for kind in ("nc", "csv", "png")}
        drawn["nc"].parent.mkdir(parents=True, exist_ok=True)
        drawn["nc"].touch()
        TABLE[TABLE.figure == name].to_csv(drawn["csv"], index=False)
        Image.new("RGB", (200, 100), "red").save(drawn["png"])
    Image.new("RGB", (80, 80), "white").save(kept / "slope.png")
    (kept / "slope.py").touch()
    paper = Paper("one", "", "", {}, (), {"slope": Figure(), "other": Figure()})
    assert kept / "slope.png" in archive.keep_figures("fast", results, [paper])
    assert archive.pictures("one") == [kept / "slope.png"]
    with Image.open(kept / "slope.png") as picture:
        assert picture.size == (80, 40) and picture.convert("RGB").getpixel((5, 5)) == (255, 0, 0)
