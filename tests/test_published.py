"""Published numbers stand in published.yaml alone, and a figure shows those that redraw it."""

import ast

import pytest

from dpd.analysis import verdicts
from dpd.analysis.verdicts import Number, shown_by
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.pipeline.paper import read_paper
from tests.conftest import python

FILES = sorted((ROOT / "paper_figures").glob("*/*.py"))
PAPERS = sorted({path.parent.name for path in FILES})


def precise(values):
    """Those of three digits and more, whose equality is no chance."""
    numbers = {abs(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool)}
    return {v for v in numbers if len(f"{v:g}".partition("e")[0].replace(".", "").strip("0")) > 2}


@pytest.mark.parametrize("paper", PAPERS)
def test_no_figure_file_repeats_a_published_number(paper):
    """It reads it from published.yaml."""
    entries = verdicts.published(paper).values()
    keys = ("value", "rival", "error", "rounding")
    known = precise(entry.get(key) for entry in entries for key in keys)
    for path in (path for path in FILES if path.parent.name == paper):
        nodes = ast.walk(ast.parse(path.read_text()))
        again = precise(node.value for node in nodes if isinstance(node, ast.Constant)) & known
        assert not again, f"{path.name}: read {sorted(again)} from published.yaml"


@pytest.mark.parametrize("paper", PAPERS)
def test_figures_of_published_numbers_exist(paper):
    """Those that measure a number and those that show it, once each."""
    figures = read_paper(paper, "quick").figures
    for name, entry in verdicts.published(paper).items():
        assert {entry["figure"], *entry.get("shown_in", ())} <= set(figures), name
        assert entry["figure"] not in entry.get("shown_in", ()), name


@pytest.fixture
def made_up(monkeypatch):
    """Three numbers, of which ``line`` measures one and shows another."""
    entries = {
        "own": {"figure": "line", "value": 0.286, "error": 0.002},
        "lent": {"figure": "other", "shown_in": ["line"], "range": [None, 2]},
        "foreign": {"figure": "other", "value": 1},
    }
    monkeypatch.setattr(verdicts, "published", {"mine": entries}.get)


def test_a_figure_shows_what_redraws_it(made_up):
    """By name, as a record; any other is refused with what to do."""
    shown = shown_by("/anywhere/mine/line.py")
    assert list(shown) == ["own", "lent"]
    assert shown["own"] == Number(value=0.286, error=0.002)
    assert str(shown["own"]) == "0.286 ± 0.002"
    assert shown["lent"].high == 2 and shown["lent"].low != shown["lent"].low
    with pytest.raises(
        UserError, match=r"mine/published\.yaml: line shows 'foreign', .*: \[line\]'"
    ):
        shown["foreign"]


def test_figures_import_what_they_share_from_any_folder(tmp_path):
    """Also from one that has a package of the same name."""
    (tmp_path / "paper_figures").mkdir()
    (tmp_path / "paper_figures" / "__init__.py").write_text("raise ImportError('the wrong one')")
    load = "from dpd.report.figures import load_module; load_module('benchmark', 'scaling')"
    done = python("-c", load, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
