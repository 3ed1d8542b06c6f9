"""The verdict tables of the report: rows as text, their links, and counts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from dpd.analysis.verdicts import CHECK, CLOSED_FORM, DEVIATES, NOT_REACHED, REPLICATED, SIMULATED
from dpd.report.captions import label
from dpd.report.notation import typeset
from dpd.report.text import with_error

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

VERDICTS = (REPLICATED, DEVIATES, NOT_REACHED)
PLURAL = {DEVIATES: "deviate"}


@dataclass(frozen=True)
class Section:
    """Where the rows of a kind stand: its name and heading, and why they count apart."""

    kind: str
    name: str
    title: str
    apart: str = ""


# The headline counts the rows of the first alone.
SECTIONS = (
    Section(
        SIMULATED, "published numbers", "Published numbers and claims, held against simulation"
    ),
    Section(
        CLOSED_FORM, "closed forms", "Closed forms: published numbers, held against a formula",
        "Nothing is simulated for these, so the headline does not count them.",
    ),
    Section(
        CHECK, "checks of our own", "Checks of our own",
        "The papers print no such numbers, so the headline does not count them.",
    ),
)  # fmt: skip
# What the words of the tables mean, said once above them.
MEANINGS = {
    "Published": "the paper's number, or the range that its claim allows.",
    "Standard error": (
        "the one that the paper prints, or the one of the reference in our own checks."
    ),
    "Rounding": 'half of the last printed digit, or of what a word like "about" allows.',
    "Limits": (
        "who set the range or the rounding: the text, or we, where the text has words alone."
    ),
    "This work": (
        "our number ± one standard error. Error bars in figures are 95 % intervals, 1.96 standard "
        "errors."
    ),
    "Deviation": (
        "in combined standard errors of both numbers, rounding included; of a range: how far "
        "beyond its limit."
    ),
    "Resolution": (
        "the smallest difference that this run would have called a deviation: two combined "
        "standard errors."
    ),
    "Replicated": (
        "the difference is within two combined standard errors, or within the rounding; or our 95 "
        "% interval lies inside the range."
    ),
    "Deviates": "the difference is larger; or our 95 % interval lies outside the range.",
    "Not reached at this scale": (
        "this run cannot decide, for the reason in the note. More sampling or longer chains might, "
        "unless the points do not follow the law whose number this is: then the number depends on "
        "which of them are fitted."
    ),
}


def archived_meaning(study: str) -> dict[str, str]:
    """The word for the column of a long study, with its meaning."""
    return {
        "Long runs": (
            f"what the study {study} found, which is kept in results/archive/{study}: its number ± "
            "one standard error, and its verdict. Where the system is the same, both are one "
            "run for some time, so they are not independent."
        )
    }


@dataclass(frozen=True)
class Row:
    """A row of the verdict table, as text.

    ``id`` is where links to the row lead, ``figure`` where those to its figure do, and
    ``label`` is what the figure is called. ``archived`` is what a long study found, and
    ``archived_verdict`` what it decided; both are empty where there is no such row.
    """

    id: str
    paper: str
    figure: str
    label: str
    kind: str
    quantity: str
    where: str
    published: str
    published_error: str
    rounding: str
    limits: str
    value: str
    deviation: str
    resolution: str
    verdict: str
    note: str
    archived: str = ""
    archived_verdict: str = ""

    @property
    def style(self) -> str:
        """The verdict's first word: its class in the style sheet."""
        return self.verdict.split()[0]

    @property
    def archived_style(self) -> str:
        """The same of the archived verdict."""
        return self.archived_verdict.split()[0]


@dataclass(frozen=True)
class Count:
    """How many rows of a kind a paper has, or all papers have, and their verdicts in order."""

    paper: str
    total: int
    verdicts: dict

    def __str__(self):
        """The verdicts in words."""
        return ", ".join(
            f"{number} {PLURAL.get(name, name) if number != 1 else name}"
            for name, number in self.verdicts.items()
        )


def figure_id(paper: str, figure: str) -> str:
    """Where links to a figure lead."""
    return f"{paper}-{figure}"


def judged_rows(table: pd.DataFrame, archived: pd.DataFrame | None = None) -> list[Row]:
    """Rows of the joined verdict table, in its order.

    Parameters
    ----------
    table : pandas.DataFrame
        See `dpd.report.figures.joined_verdicts`.
    archived : pandas.DataFrame or None
        Such a table of a long study. A row of it is shown where it is held against the same
        published value.

    Returns
    -------
    list of Row
    """
    rows: list[Row] = []
    seen: dict[str, int] = {}
    long_runs = {} if archived is None else {_key(e): e for e in archived.to_dict("records")}
    for entry in table.to_dict("records"):
        figure = figure_id(entry["paper"], entry["figure"])
        seen[figure] = seen.get(figure, 0) + 1
        row = _row(entry, f"{figure}-{seen[figure]}", figure)
        if (found := long_runs.get(_key(entry))) is not None:
            value = typeset(with_error(found["value"], found["error"]))
            row = replace(row, archived=value, archived_verdict=found["verdict"])
        rows.append(row)
    return rows


def _key(entry):
    """What two studies must have in common for their rows to be of one number."""
    names = (entry[name] for name in ("paper", "figure", "quantity", "kind"))
    return (*names, _published(entry["published"]))


def _row(entry, name, figure):
    return Row(
        id=name,
        paper=entry["paper"],
        figure=figure,
        label=label(entry["figure"]),
        kind=entry["kind"],
        quantity=typeset(entry["quantity"]),
        where=typeset(_text(entry["where"])),
        published=typeset(_published(entry["published"])),
        published_error=typeset(_small(entry["published_error"])),
        rounding=typeset(_small(entry["rounding"])),
        limits=_text(entry["limits"]) if _has_limits(entry) else "",
        value=typeset(with_error(entry["value"], entry["error"])),
        deviation=typeset(_small(entry["deviation_sigma"], "{:.2f}")),
        resolution=typeset(_small(entry["resolution"])),
        verdict=entry["verdict"],
        note=typeset(_text(entry["note"])),
    )


def _has_limits(entry):
    """Whether anybody set limits: a range, or a rounding."""
    return np.isfinite(entry["rounding"]) or not _is_number(entry["published"])


def _is_number(value):
    try:
        float(value)
    except ValueError:
        return False
    return True


def _published(value):
    """A number, or a range in words."""
    return f"{float(value):g}" if _is_number(value) else _text(value)


def _small(value, pattern="{:.2g}"):
    """A number of two digits, or nothing where there is none."""
    return "" if np.isnan(value) else pattern.format(value).replace("inf", "∞")


def _text(value):
    """A cell of text: pandas has NaN where it is empty."""
    return value if isinstance(value, str) else ""


def counts(rows: Iterable[Row], kind: str, papers: Iterable[str]) -> list[Count]:
    """Counts of one kind: of each paper that has such rows, and of all.

    Parameters
    ----------
    rows : list of Row
    kind : str
        Simulated, closed form or check, see `dpd.analysis.verdicts.KINDS`.
    papers : list of str

    Returns
    -------
    list of Count
        The last one is of all papers, its ``paper`` empty.
    """
    chosen = [row for row in rows if row.kind == kind]
    found = [_count(paper, [row for row in chosen if row.paper == paper]) for paper in papers]
    return [count for count in found if count.total] + [_count("", chosen)]


def _count(paper, rows):
    verdicts = {name: sum(row.verdict == name for row in rows) for name in VERDICTS}
    return Count(paper, len(rows), verdicts)
