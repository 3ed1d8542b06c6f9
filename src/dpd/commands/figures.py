"""Stages of the pipeline that show what was found: figures, verdicts, report, pages."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.arguments import positive
from dpd.commands.options import add_data, data_of
from dpd.digest import ROOT
from dpd.errors import UserError

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare these stages."""
    figure = stages.add(
        "figure", _figure, "make a figure", "study", "paper", "figure", output="folder"
    )
    add_data(figure)
    figure.add_argument(
        "--traceback", type=Path, metavar="FILE",
        help="where to keep the whole traceback if the figure's file raises something",
    )  # fmt: skip
    stages.add(
        "verdicts", _verdicts, "join the verdict tables of figures", "tables", output="table.csv"
    )
    compare = stages.add(
        "compare", _compare, "say whether two studies differ as their error bars predict"
    )  # fmt: skip
    for name in ("one", "other"):
        compare.add_argument(
            name, help="a study, a folder of its results or archive, or a verdict table"
        )
    report = stages.add(
        "report", _report, "write the report", "study", "papers", output="report.html"
    )
    report.add_argument(
        "--results", type=Path, required=True, metavar="FOLDER", help="results of the study"
    )
    report.add_argument("--archived", type=Path, metavar="FILE", help="verdicts of a long study")
    stages.add(
        "schemes", _schemes, "write automatic.yaml, for scheme auto, from the benchmark",
        "study", output="automatic.yaml",
    )  # fmt: skip
    archive = stages.add("archive", _archive, "keep in git what a study has found", "study")
    archive.add_argument(
        "--runs-from", type=positive, default=math.inf, metavar="HOURS",
        help="also keep runs of the long study that took so long or longer, for `restore`",
    )  # fmt: skip
    stages.add("restore", _restore, "take runs of the long study from the archive", "study")
    stages.add(
        "redraw", _redraw, "draw and judge archived figures again, from their numbers", "study"
    )
    stages.add(
        "readme", _readme, "write README.md's tables, the pages in config and those of papers"
    )


def _figure(options: Namespace) -> None:
    from dpd.files import replace_whole
    from dpd.pipeline.study import read_paper
    from dpd.report.figure_file import BrokenFigure
    from dpd.report.figures import make_figure

    paper = read_paper(options.paper, options.study, only=[])
    if options.figure not in paper.figures:
        from dpd.errors import suggestion

        raise UserError(
            f"figure: {options.figure!r} is not in config/papers/{options.paper}.yaml; "
            f"{suggestion(options.figure, paper.figures)}"
        )
    figure = paper.figures[options.figure]
    sources = data_of(options, (*figure.sweeps, *figure.measurements))
    try:
        make_figure(options.paper, options.figure, sources, options.output)
    except BrokenFigure as problem:
        if options.traceback is None:
            raise UserError(f"{problem}; --traceback FILE keeps the whole traceback") from None
        text = problem.whole_traceback()
        replace_whole(options.traceback, lambda draft: draft.write_text(text))
        raise UserError(f"{problem}; the whole traceback is in {options.traceback}") from None


def _verdicts(options: Namespace) -> None:
    from dpd.files import replace_whole
    from dpd.report.figures import joined_verdicts

    table = joined_verdicts(options.tables)
    replace_whole(options.output, lambda draft: table.to_csv(draft, index=False))


def _compare(options: Namespace) -> None:
    from dpd.report.compare import as_text, compared, table_of

    one, other = table_of(options.one), table_of(options.other)
    print(as_text(compared(one, other), one, other))


def _report(options: Namespace) -> None:
    from dpd.pipeline.study import read_paper, read_study
    from dpd.report.page import write_page
    from dpd.report.workflow import overhead

    papers = [read_paper(name, options.study) for name in options.papers]
    description = read_study(options.study).description
    # Set by the Snakefile: a parameter that differs every time would make the page again.
    begun, cores = (os.environ.get(f"DPD_{name}") for name in ("BEGUN", "CORES"))
    cost = overhead(options.results, float(begun), int(cores)) if begun and cores else ""
    write_page(
        options.study, description, papers, options.results, options.output, cost, options.archived
    )


def _schemes(options: Namespace) -> None:
    from dpd.files import replace_whole
    from dpd.pipeline.paths import results_of

    figures = Path(results_of(options.study).figures("benchmark"))
    sys.path.insert(0, str(ROOT))  # the benchmark's own, as its figures are
    from paper_figures.benchmark.recommended import recommendations

    text = recommendations(figures)
    replace_whole(options.output, lambda draft: draft.write_text(text))


def _archive(options: Namespace) -> None:
    from dpd.report.archive import keep

    for path in keep(options.study, options.runs_from):
        print(f"kept: {path}")
    print("now: python -m dpd readme")


def _restore(options: Namespace) -> None:
    from dpd.report.archive import restore

    paths = restore(options.study)
    for path in paths:
        print(f"restored: {path}")
    if not paths:
        print("nothing to do: all runs that the archive keeps are there")


def _redraw(options: Namespace) -> None:
    from dpd.report.archive import redraw

    for path in redraw(options.study):
        print(f"changed: {path}")
    print("now: python -m dpd readme")


def _readme(options: Namespace) -> None:
    from dpd.report.documents import write_pages

    for path in write_pages():
        print(f"written: {path}")
