"""Numbers of README.md, from the verdict table of a study that git keeps."""

import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from dpd.analysis.collect import reading
from dpd.analysis.verdicts import (
    CHECK,
    CLOSED_FORM,
    DEVIATES,
    NOT_REACHED,
    REPLICATED,
    SIMULATED,
)
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report.text import published_text, with_error

ARCHIVE = ROOT / "results" / "archive"
BLOCK = re.compile(r"(<!-- begin: (.+?) -->\n).*?(<!-- end -->)", re.S)
VERDICTS = (REPLICATED, DEVIATES, NOT_REACHED)
NEEDED = {"paper", "figure", "quantity", "kind", "published", "published_error", "rounding",
          "value", "error", "deviation_sigma", "verdict"}  # fmt: skip


def archive(study, results):
    """Copy the verdict table of all papers to where git keeps it.

    Parameters
    ----------
    study : str
    results : path
        Folder of the study.

    Returns
    -------
    path
        Of the copy.

    Raises
    ------
    UserError
        If there is no such table, or it was made by an older version.
    """
    source = Path(results) / "verdicts.csv"
    _read(source)
    target = ARCHIVE / study / "verdicts.csv"
    replace_whole(target, lambda draft: shutil.copyfile(source, draft))
    return target


def filled(text, folder=ARCHIVE):
    """A text with its marked blocks made anew.

    A block begins with ``<!-- begin: STUDY counts -->`` or ``<!-- begin: STUDY deviations PAPER
    -->`` and ends with ``<!-- end -->``.

    Parameters
    ----------
    text : str
    folder : path
        With one folder a study, each with its ``verdicts.csv``.

    Returns
    -------
    str

    Raises
    ------
    UserError
        If a block asks for what there is not.
    """

    def made(block):
        return f"{block[1]}{_block(block[2], Path(folder))}\n{block[3]}"

    if text.count("<!-- begin:") != len(BLOCK.findall(text)):
        raise UserError("README.md: a block that begins has no <!-- end -->, or no line of its own")
    return BLOCK.sub(made, text)


def _block(asked, folder):
    study, kind, *papers = asked.split()
    table = _read(folder / study / "verdicts.csv")
    if kind == "counts" and not papers:
        return counts(table)
    if kind == "deviations" and len(papers) == 1 and papers[0] in set(table.paper):
        return deviations(table[table.paper == papers[0]])
    raise UserError(
        f"README.md: <!-- begin: {asked} -->: allowed: '{study} counts', or '{study} deviations' "
        f"and one of {', '.join(sorted(set(table.paper)))}"
    )


def _read(path):
    with reading(path, "table of verdicts"):
        table = pd.read_csv(path)
    if lacking := NEEDED - set(table.columns):
        raise UserError(
            f"{path}: no column {', '.join(sorted(lacking))}; let snakemake make it again"
        )
    return table


def counts(table):
    """Markdown: for each paper how many published numbers have which verdict.

    Parameters
    ----------
    table : pandas.DataFrame
        Of verdicts.
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
            str(paper),
            len(simulated),
            *((simulated.verdict == verdict).sum() for verdict in VERDICTS),
            _share(own[own.kind == CLOSED_FORM]),
            _share(own[own.kind == CHECK]),
        ])  # fmt: skip
    return _markdown(head, rows)


def _share(rows):
    """How many of some rows hold."""
    return f"{(rows.verdict == REPLICATED).sum()} of {len(rows)}" if len(rows) else "none"


def deviations(table):
    """Markdown: every row that deviates, with its published value and ours.

    Parameters
    ----------
    table : pandas.DataFrame
        Verdicts of one paper.
    """
    rows = [
        [
            row["figure"].split("_")[0] if row["figure"].startswith("fig") else row["figure"],
            row["quantity"] + ("" if row["kind"] == SIMULATED else f" ({row['kind']})"),
            published_text(row),
            with_error(row["value"], row["error"]),
            f"{row['deviation_sigma']:.1f}" if np.isfinite(row["deviation_sigma"]) else "",
        ]
        for row in table[table.verdict == DEVIATES].to_dict("records")
    ]
    if not rows:
        return "Nothing deviates."
    return _markdown(["figure", "quantity", "published", "this work", "standard errors"], rows)


def _markdown(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    # A "|" would end a cell.
    cells = [[str(cell).replace("|", "\\|") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
