"""Numbers of README.md that a run makes: from the archived verdict table, and nowhere else."""

import re

import pandas as pd
import pytest

from dpd.analysis.verdicts import COLUMNS
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.pipeline.study import read_config
from dpd.report import readme

README = (ROOT / "README.md").read_text()


def row(quantity, verdict, **more):
    """A row of a verdict table."""
    given = {
        "paper": "one", "figure": "fig02_radial", "quantity": quantity, "kind": "simulated",
        "published": "0.5", "published_error": float("nan"), "rounding": float("nan"),
        "value": 0.52, "error": 0.004, "deviation_sigma": 5.0, "verdict": verdict,
    }  # fmt: skip
    return given | more


@pytest.fixture
def archived(tmp_path):
    """A folder with a small verdict table of a study."""
    table = pd.DataFrame([
        row("peak", "deviates", rounding=0.005),
        row("a | b", "deviates", published_error=0.01, kind="check", figure="slope"),
        row("slope", "deviates", published="> 0.6"),
        row("depth", "replicated"),
        row("limit", "replicated", kind="closed form"),
        row("time", "not reached at this scale", paper="two"),
    ])  # fmt: skip
    (tmp_path / "fast").mkdir()
    table.to_csv(tmp_path / "fast" / "verdicts.csv", index=False)
    return tmp_path


def test_tables_of_the_readme_are_those_of_the_archive():
    """`python -m dpd readme -o README.md` has nothing to change."""
    assert readme.filled(README) == README
    asked = re.findall("<!-- begin: (.+?) -->", README)
    assert asked == ["quick counts", *(f"quick deviations {p}" for p in read_config()["papers"])]


def test_the_archive_has_all_papers():
    """It is the table of a whole study."""
    table = pd.read_csv(readme.ARCHIVE / "quick" / "verdicts.csv")
    assert set(table.paper) == set(read_config()["papers"])


def test_the_columns_of_the_verdict_table_are_named():
    """All, in their order."""
    assert f"`{','.join(COLUMNS)}`" in README


def test_findings_outside_the_tables_quote_no_measurement():
    """Prose that a run cannot contradict by other noise: no value with an error."""
    section = README.split("## What the quick study finds")[1].split("\n## ")[0]
    prose = readme.BLOCK.sub("", section)
    assert len(prose) > 1000
    assert not re.search(r"\+-|±|\d %", prose)


def test_counts(archived):
    """By paper and verdict; closed forms and own checks apart."""
    text = readme.filled("<!-- begin: fast counts -->\nold\n<!-- end -->\n", archived)
    lines = text.splitlines()
    assert lines[0] == "<!-- begin: fast counts -->" and lines[-1] == "<!-- end -->"
    assert "| one | 3 | 1 | 2 | 0 | 1 of 1 | 0 of 1 |" in lines
    assert "| two | 1 | 0 | 0 | 1 | none | none |" in lines and "old" not in lines


def test_deviations(archived):
    """Published value with what it is sure of, ours with its error; a paper without any."""
    block = "text\n<!-- begin: fast deviations {} -->\n<!-- end -->\nmore"
    lines = readme.filled(block.format("one"), archived).splitlines()
    assert "| fig02 | peak | 0.5, rounded by 0.005 | 0.5200 ± 0.0040 | 5.0 |" in lines
    assert "| slope | a \\| b (check) | 0.5 ± 0.01 | 0.5200 ± 0.0040 | 5.0 |" in lines
    assert "| fig02 | slope | > 0.6 | 0.5200 ± 0.0040 | 5.0 |" in lines
    assert lines[0] == "text" and lines[-1] == "more"
    assert "Nothing deviates." in readme.filled(block.format("two"), archived)


@pytest.mark.parametrize(
    "text, words",
    [
        ("<!-- begin: fast deviations three -->\n<!-- end -->", "allowed: 'fast counts'"),
        ("<!-- begin: fast sums -->\n<!-- end -->", "one of one, two"),
        ("<!-- begin: slow counts -->\n<!-- end -->", "no such file"),
        ("<!-- begin: fast counts -->\n", "no <!-- end -->"),
    ],
)
def test_blocks_that_cannot_be_filled(archived, text, words):
    """A sentence, not half a table."""
    with pytest.raises(UserError, match=words):
        readme.filled(text, archived)


def test_the_archive_takes_whole_tables_only(archived, tmp_path, monkeypatch):
    """A table of an older version is refused, and what is kept stays."""
    monkeypatch.setattr(readme, "ARCHIVE", tmp_path / "archive")
    kept = readme.archive("fast", archived / "fast")
    before = kept.read_bytes()
    assert kept == tmp_path / "archive" / "fast" / "verdicts.csv"
    pd.read_csv(kept).drop(columns="kind").to_csv(archived / "fast" / "verdicts.csv", index=False)
    with pytest.raises(UserError, match="no column kind"):
        readme.archive("fast", archived / "fast")
    assert kept.read_bytes() == before
