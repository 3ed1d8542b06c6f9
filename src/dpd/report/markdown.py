"""Tables of verdicts as Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.analysis.verdicts import (
    CHECK,
    CLOSED_FORM,
    DEVIATES,
    NOT_REACHED,
    REPLICATED,
    SIMULATED,
)
from dpd.report.captions import label
from dpd.report.notation import typeset
from dpd.report.text import published_text, with_error

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    import pandas as pd

VERDICTS = (REPLICATED, DEVIATES, NOT_REACHED)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table.

    Parameters
    ----------
    head : list of str
    rows : list of list
    """
    lines = [head, ["---"] * len(head), *rows]
    # A "|" would end a cell.
    cells = [[str(cell).replace("|", "\\|") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def key_table(rows: Iterable[tuple[str, ...]]) -> str:
    """A table of settings, from the rows of `dpd.report.keys`."""
    head = "key", "allowed", "unit", "default", "meaning"
    return markdown_table(head, ((f"`{key}`", *rest) for key, *rest in rows))


def counts(table: pd.DataFrame, link: Callable[[str], str] = str) -> str:
    """For each paper how many published numbers have which verdict.

    Parameters
    ----------
    table : pandas.DataFrame
        Of verdicts.
    link : callable
        What stands for a paper, from its name.
    """
    head = [
        "paper",
        "held against simulation",
        *VERDICTS,
        "closed forms that hold",
        "own checks that hold",
    ]
    rows = []
    for paper, own in table.groupby("paper", sort=True):
        simulated = own[own.kind == SIMULATED]
        rows.append([
            link(str(paper)),
            len(simulated),
            *_numbers(simulated),
            _share(own[own.kind == CLOSED_FORM]),
            _share(own[own.kind == CHECK]),
        ])  # fmt: skip
    return markdown_table(head, rows)


def _numbers(rows):
    """How many rows have each verdict."""
    return [int((rows.verdict == verdict).sum()) for verdict in VERDICTS]


def _share(rows):
    """How many of some rows hold."""
    return f"{(rows.verdict == REPLICATED).sum()} of {len(rows)}" if len(rows) else "none"


def deviations(table: pd.DataFrame) -> str:
    """Every row that deviates, with its published value and ours.

    Parameters
    ----------
    table : pandas.DataFrame
        Verdicts of one paper.
    """
    rows = [
        [
            label(row["figure"]),
            typeset(row["quantity"]) + ("" if row["kind"] == SIMULATED else f" ({row['kind']})"),
            typeset(published_text(row)),
            typeset(with_error(row["value"], row["error"])),
            f"{row['deviation_sigma']:.1f}" if np.isfinite(row["deviation_sigma"]) else "",
        ]
        for row in table[table.verdict == DEVIATES].to_dict("records")
    ]
    if not rows:
        return "Nothing deviates."
    return markdown_table(["figure", "quantity", "published", "this work", "standard errors"], rows)


def figure_counts(table: pd.DataFrame, titles: Mapping[str, str]) -> str:
    """For each figure of a paper what it shows, and how many of its numbers have which verdict.

    Parameters
    ----------
    table : pandas.DataFrame
        Verdicts of one paper; own checks count as well.
    titles : dict of str to str
        Figure to the first sentence of its caption, in the order of the table.
    """
    rows = [
        [f"[{label(name)}]({name}.py)", typeset(title), *_numbers(table[table.figure == name])]
        for name, title in titles.items()
    ]
    return markdown_table(["figure", "what it shows", *VERDICTS], rows)
