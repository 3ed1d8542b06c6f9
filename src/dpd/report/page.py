"""The report: one self-contained page."""

from __future__ import annotations

import base64
import io
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup
from PIL import Image

from dpd.analysis.collect import load
from dpd.analysis.verdicts import KINDS
from dpd.files import attribute, replace_whole
from dpd.pipeline.jobs import verdicts_of
from dpd.pipeline.paths import Results
from dpd.report.archive import read_table
from dpd.report.captions import label
from dpd.report.figures import joined_verdicts
from dpd.report.judged import (
    MEANINGS,
    SECTIONS,
    archived_meaning,
    counts,
    figure_id,
    judged_rows,
)
from dpd.report.provenance import commit, library_versions
from dpd.report.sampling import not_said, reached, shorter_points
from dpd.stages import stage_digest
from dpd.start import start_digest, start_is_shared

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.pipeline.study import Paper

TEMPLATE = "page.html"
DATA_FILES = ("page.html", "page.css")  # read here: they are part of the report's digest
PIXELS = 2  # of a picture in one of the page: 7-point type, at 300 dots per inch, is 15 pixels high


def write_page(
    study: str, description: str, papers: Sequence[Paper], folder: str | Path, path: str | Path,
    overhead: str = "", archived: str | Path | None = None,
) -> None:  # fmt: skip
    """Write the report of a study.

    Parameters
    ----------
    study, description : str
    papers : list of dpd.pipeline.study.Paper
    folder : path
        Of the study's results.
    path : path
    overhead : str
        What the workflow cost beside its simulations, see `dpd.report.overhead`.
    archived : path or None
        Verdict table in the archive of a long study, whose values stand beside those of this one.
    """
    results = Results(str(folder))
    table = joined_verdicts(verdicts_of(results, papers))
    rows = judged_rows(table, None if archived is None else read_table(archived))
    long_study = ""
    if archived is not None and any(row.archived for row in rows):
        long_study = Path(archived).parent.name
    names = [paper.name for paper in papers]
    checks = [_checks(paper, results) for paper in papers]
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True
    )
    environment.filters["named"] = _named
    page = environment.get_template(TEMPLATE).render(
        study=study,
        description=description,
        papers=[_paper(paper, results, rows) for paper in papers],
        rows=rows,
        sections=SECTIONS,
        meanings=MEANINGS | (archived_meaning(long_study) if long_study else {}),
        long_study=long_study,
        counts={kind: counts(rows, kind, names) for kind in KINDS},
        checks=[row for rows in checks for row in rows],
        overhead=overhead,
        costs=[c for paper, rows in zip(papers, checks) for c in _costs(paper, results, rows)],
        shorter=[point for paper in papers for point in shorter_points(paper)],
        reached=[sweep for paper in papers for sweep in reached(paper, table, rows)],
        not_said={paper.name: names for paper in papers if (names := not_said(paper))},
        versions=library_versions(),
        sources={
            stage: stage_digest(stage) for stage in ("simulate", "collect", "figure", "report")
        },
        commit=commit(),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    replace_whole(path, lambda draft: draft.write_text(page, encoding="utf-8"))


def _paper(paper, results, rows):
    """A paper's figures, each with its picture, caption and verdicts inside the page."""
    return {
        "key": paper.name,
        "name": _named(paper.name),
        "title": paper.title,
        "reference": paper.reference,
        "figures": [
            _figure(
                Path(results.figure(paper.name, name, "png")), figure_id(paper.name, name), rows
            )
            for name in paper.figures
        ],
    }


def _figure(path, name, rows):
    """A figure's picture, what is seen in it, its caption, and the verdicts on its numbers."""
    with Image.open(path) as picture:
        width, height = picture.size
        data = base64.b64encode(_in_few_colors(picture)).decode()
    return {
        "id": name,
        "label": label(path.stem),
        "picture": f"data:image/png;base64,{data}",
        "width": width // PIXELS,
        "height": height // PIXELS,
        "seen": _seen(path),
        "caption": Markup(path.with_suffix(".html").read_text(encoding="utf-8")),
        "rows": [row for row in rows if row.figure == name],
    }


def _seen(path):
    """What a figure shows, in words; its name where its file says nothing."""
    try:
        return attribute(path.with_suffix(".nc"), "seen")
    except AttributeError:
        return label(path.stem)


def _named(paper):
    """groot_warren_1997 as Groot Warren 1997."""
    return paper.replace("_", " ").title()


def _in_few_colors(picture):
    """A picture as a PNG with a palette, a third as large; the file beside the page has all."""
    few = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    data = io.BytesIO()
    few.save(data, "png")
    return data.getvalue()


def _checks(paper, results):
    """What each sweep says of itself: kT, momentum, speed, memory, cost."""
    rows = []
    for name in paper.sweeps:
        data = load(results.sweep(paper.name, name))
        rows.append({
            "paper": paper.name,
            "sweep": name,
            "runs": data.kT.size,
            "beads": _span(data.beads, "{:.0f}"),
            "steps": _span(data.steps, "{:.0f}"),
            "kT": _span(data.kT, "{:.4f}"),
            "momentum": float(data.momentum_per_bead.max()),
            "rate": float(np.median(data.bead_steps_per_second)) / 1e6,
            "memory": float(data.peak_memory_MiB.max()),
            "seconds": float(data.seconds.sum()),
        })  # fmt: skip
    return rows


def _costs(paper, results, checks):
    """Jobs and seconds of each stage, from what its files and sweeps say of themselves."""
    points = [point for sweep in paper.sweeps.values() for point in sweep.points]
    starts = sorted({start_digest(p.scene) for p in points if start_is_shared(p.scene)})

    def spent(file, names, *kind):
        return len(names), sum(attribute(file(paper.name, n, *kind), "seconds") for n in names)

    stages = {
        "first configurations": spent(results.start, starts),
        "simulations": (sum(row["runs"] for row in checks), sum(row["seconds"] for row in checks)),
        "sweeps": spent(results.sweep, paper.sweeps),
        "sweeps of theory": spent(results.sweep, paper.theory),
        "measurements": spent(results.measurement, paper.measurements),
        "figures": spent(results.figure, paper.figures, "nc"),
    }
    for stage, (jobs, seconds) in stages.items():
        if jobs:
            yield {"paper": paper.name, "stage": stage, "jobs": jobs, "seconds": seconds}


def _span(values, pattern):
    low, high = (pattern.format(float(v)) for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"
