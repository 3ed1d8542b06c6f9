"""Rows of verdict tables as pages show them, and the sentences that hold where they do."""

import csv
import math
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from markupsafe import Markup

from dpd.analysis.verdicts import AGREE, BOUND, COLUMNS, published
from dpd.files import reading
from dpd.folders import ROOT, paper_folder
from dpd.report.text import typeset, with_error

Row = dict[str, Any]
MARKS = {"replicated": "r", "deviates": "d", "not reached at this scale": "n"}
KINDS = ("simulated", "closed form", "check")
LEADS = {"About": "", "Answer": "w", "Holds": "r", "Does not": "d", "Why": "w", "Open": "n"}
WORDS = {"paper", "figure", "quantity", "where", "kind", "limits", "published", "verdict", "note"}
SAME = "the same"  # begins a quantity that differs from the one before it
SENTENCE = re.compile(r"- \*\*(.+?)\.\*\* (.+?) ?<!--(.*?)-->")
NAMED = re.compile(r"\{([\w.]+)\}")


def read_rows(*paths: str | Path) -> list[Row]:
    """Rows of verdict tables, without slow pandas; `UserError` if one is missing, broken or old."""
    rows: list[Row] = []
    for path in paths:
        with (
            reading(path, "table of verdicts", "delete it and let snakemake make it again"),
            open(path, newline="", encoding="utf-8") as file,
        ):
            rows += [
                {k: row[k] if k in WORDS else float(row[k] or "nan") for k in COLUMNS}
                for row in csv.DictReader(file)
            ]
            if not all(row["verdict"] in MARKS for row in rows):
                raise ValueError("a row without its verdict")
    return rows


def verdict_rows(table: Iterable[Row], archived: Iterable[Row] = ()) -> list[Row]:
    """Rows as the page shows them, beside what ``archived`` of a long study has for the same."""
    long_runs = {_key(entry): entry for entry in archived}
    rows: list[Row] = []
    named_last = ""
    for entry in table:
        quantity = entry["quantity"]
        if not quantity.startswith(SAME):
            named_last = quantity
        else:  # in a sorted table it must say of what it is the same
            quantity = f"{quantity.removeprefix(SAME).lstrip(', ')}; otherwise: {named_last}"
        long_one, z, number = long_runs.get(_key(entry)), entry["deviation_sigma"], None
        with suppress(ValueError):  # of a range in words
            number = float(entry["published"])
        text = f"{z:.{2 if abs(abs(z) - AGREE) < 0.05 else 1}f}"  # finer at verdicts
        errors = entry["published_error"], entry["rounding"] / 3**0.5, entry["error"]
        spread = math.hypot(*filter(math.isfinite, errors))
        figure = f"{entry['paper']}-{entry['figure']}"
        rows.append({
            "entry": entry, **{key: entry[key] for key in ("paper", "kind", "value")},
            "id": f"{figure}-{sum(row['figure'] == figure for row in rows) + 1}",
            "figure": figure,
            "mark": MARKS[entry["verdict"]],
            "quantity": typeset(quantity), "note": typeset(entry["note"]),
            "published": typeset(entry["published"] if number is None else f"{number:g}"),
            "allowed": " ".join(
                f"{sign} {entry[key]:.2g}"
                for key, sign in (("published_error", "±"), ("rounding", "rounding"))
                if math.isfinite(entry[key])
            ),
            "limits": entry["limits"] if math.isfinite(entry["rounding"]) or number is None else "",
            "ours": typeset(_ours(entry)),
            "archived": typeset(f"{_ours(long_one)}, {long_one['verdict']}") if long_one else "",
            "z": z,
            "z_text": "" if math.isnan(z) else text.replace("inf", "∞").replace("-", "−"),
            "ratio": entry["value"] / number if number else math.nan,
            "ratio_error": 1.96 * spread / abs(number) if number else math.nan,
            "number": number,
        })  # fmt: skip
    return rows


def _ours(entry):
    return "< " * (BOUND in entry["note"]) + with_error(entry["value"], entry["error"])


def _key(entry):
    """What rows of two studies for the same number have in common."""
    return tuple(entry[key] for key in ("paper", "figure", "quantity", "kind", "published"))


def worst_first(row: Row) -> tuple:
    """What deviates, then what is not reached; published before our own; an infinite z last."""
    size = abs(row["z"]) if math.isfinite(row["z"]) else 0.0
    return "dnr".index(row["mark"]), row["kind"] != "simulated", -size


def count(rows: Iterable[Row]) -> dict[str, int]:
    """How many rows have which verdict, in the order of the page, and how many there are."""
    marks = [row["mark"] for row in rows]
    return {mark: marks.count(mark) for mark in "rdn"} | {"all": len(marks)}


@cache
def citations() -> dict[str, dict[str, str]]:
    """Name, DOI and link of each work that CITATION.cff refers to, by its title."""
    found = {}
    for entry in yaml.safe_load((ROOT / "CITATION.cff").read_text())["references"]:
        names = [author.get("family-names", author.get("name")) for author in entry["authors"]]
        short = " & ".join(names) if len(names) < 3 else f"{names[0]} et al."
        name, doi = f"{entry.get('abbreviation', short)} {entry['year']}", entry.get("doi", "")
        link = f"https://doi.org/{doi}" if doi else entry.get("url", "")
        found[entry["title"]] = {"name": name, "doi": doi, "link": link}
    return found


class Sentence(NamedTuple):
    """What findings.md says in short: of a paper, under one of `LEADS`, or of a figure."""

    key: str  # the lead, or the figure's file
    name: str  # of the figure in words
    text: str
    ours: str  # what stands between asterisks: what comes out here
    verdicts: dict[str, str]  # that it states, by the names in published.yaml
    studies: list[str]  # that it speaks of; of any one if empty

    def holds(self, study: str, found: Mapping[str, Row]) -> bool:
        """Whether it is about a study with these rows, and each has the verdict that it states."""
        quoted = NAMED.findall(self.text + self.ours)
        return (
            (not self.studies or study in self.studies)
            and found.keys() >= {*quoted, *self.verdicts}
            and all(found[name]["verdict"] == verdict for name, verdict in self.verdicts.items())
        )


def sentences(paper: str) -> list[Sentence]:
    """The items of a paper's findings.md that end in a comment: what they state, of which study."""
    path, found = paper_folder(paper) / "findings.md", []
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    for block in re.split(r"\n(?=- |\n)", text):
        if item := SENTENCE.fullmatch(" ".join(block.split())):
            key, _, name = item[1].partition(", ")
            said, _, ours = item[2].partition(" *")
            parts = [part.partition(":") for part in item[3].split(";")]
            stated = {
                name: next(v for v in MARKS if v.startswith(verdict.strip()))
                for verdict, _, names in parts for name in names.split()
            }  # fmt: skip
            only = [s for study, colon, _ in parts if not colon for s in study.split()]
            found.append(Sentence(key, name, said, ours.rstrip("*"), stated, only))
    return found


def by_name(paper: str, rows: Iterable[Row]) -> dict[str, Row]:
    """Rows of a verdict table by the names in published.yaml."""
    found = {(row["paper"], row["figure"], row["quantity"]): row for row in rows}
    given = {name: (paper, e["figure"], e["quantity"]) for name, e in published(paper).items()}
    return {name: found[key] for name, key in given.items() if key in found}


def with_values(text: str, found: Mapping[str, Row]) -> Markup:
    """A sentence with our values where it names them, as ``{alpha}``."""
    return typeset(NAMED.sub(lambda name: _ours(found[name[1]]), text))
