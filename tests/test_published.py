"""Published numbers stand in published.yaml alone, and a figure shows those that redraw it."""

import io
import re
import subprocess
import sys
import tokenize
from decimal import Decimal

import pytest
import yaml

from dpd.analysis import published
from dpd.analysis.published import Number, entries_of, shown_by
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.pipeline.paper import read_paper

FILES = sorted((ROOT / "paper_figures").glob("*/*.py"))
PAPERS = sorted({path.parent.name for path in FILES})
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[+-]?\d+)?(?!\w)", re.IGNORECASE)
DIGITS = 3  # from which on two equal numbers are no chance


def significant(text):
    """How many digits a number has as it is written; trailing zeros count after a point alone."""
    mantissa = re.split("e", text, flags=re.IGNORECASE)[0]
    digits = mantissa.replace(".", "").lstrip("0")
    return len(digits if "." in mantissa else digits.rstrip("0"))


def precise(text):
    """The numbers in a text that are written with enough digits, without their signs."""
    return {Decimal(found) for found in NUMBER.findall(text) if significant(found) >= DIGITS}


def published_numbers(paper):
    """The same of a paper's values, errors, roundings, rivals and ranges; not of limits of ours."""
    path, found = published.published_file(paper), set()
    text = path.read_text() if path.is_file() else ""
    for entry in (yaml.load(text, yaml.BaseLoader) or {}).values():
        entry = entry.get("<<", {}) | entry
        names = ["value", "rival"]
        ends = ()
        if entry.get("limits") != "ours":
            names, ends = [*names, "error", "rounding"], entry.get("range", ())
        for number in (*(entry.get(name, "") for name in names), *ends):
            found |= precise(number.lstrip("+-"))
    return found


def repeated(source, numbers):
    """Numbers of a set that stand in Python code or its strings; comments may say them."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return precise(" ".join(t.string for t in tokens if t.type != tokenize.COMMENT)) & numbers


@pytest.mark.few(12)
@pytest.mark.parametrize("path", FILES, ids=[f"{p.parent.name}-{p.stem}" for p in FILES])
def test_no_figure_file_repeats_a_published_number(path):
    """It reads it from published.yaml."""
    again = repeated(path.read_text(), published_numbers(path.parent.name))
    assert not again, f"{path.name}: read {sorted(map(str, again))} from published.yaml"


@pytest.mark.parametrize("paper", PAPERS)
def test_figures_of_published_numbers_exist(paper):
    """Those that measure a number and those that show it, once each."""
    figures = read_paper(paper, "quick").figures
    for name, entry in published.published(paper).items():
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
    monkeypatch.setattr(published, "published", {"mine": entries}.get)


def test_a_figure_shows_what_redraws_it(made_up):
    """By name, as a record; any other is refused with what to do."""
    shown = shown_by("/anywhere/mine/line.py")
    assert list(shown) == list(entries_of("mine", "line")) == ["own", "lent"]
    assert shown["own"] == Number(value=0.286, error=0.002)
    assert str(shown["own"]) == "0.286 ± 0.002"
    assert shown["lent"].high == 2 and shown["lent"].low != shown["lent"].low
    with pytest.raises(
        UserError, match=r"mine/published\.yaml: foreign: line shows it; write 'shown_in: \[line\]'"
    ):
        shown["foreign"]
    with pytest.raises(UserError, match=r"'owm', which is not there; .*did you mean 'own'"):
        shown["owm"]


def test_figures_import_what_they_share_from_any_folder(tmp_path):
    """Also from one that has a package of the same name."""
    (tmp_path / "paper_figures").mkdir()
    (tmp_path / "paper_figures" / "__init__.py").write_text("raise ImportError('the wrong one')")
    load = "from dpd.report.figure_file import load_module; load_module('benchmark', 'scaling')"
    done = subprocess.run(
        [sys.executable, "-c", load], cwd=tmp_path, env={"PYTHONPATH": str(ROOT / "src")},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
