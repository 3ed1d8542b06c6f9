"""The report: one self-contained page."""

from __future__ import annotations

import base64
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup
from PIL import Image

from dpd.analysis.collect import load
from dpd.analysis.verdicts import KINDS, VERDICTS
from dpd.files import attribute, replace_whole
from dpd.pipeline.paths import Results, commit, library_versions
from dpd.report.figures import joined, read_verdicts, small_png
from dpd.report.text import label, named, rendered, typeset, whole, with_error
from dpd.sources import stage_digest

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import pandas as pd

    from dpd.pipeline.paper import Paper

    Row = dict[str, Any]

DATA_FILES = ("page.html", "page.css")  # read here: they are part of the report's digest
PIXELS = 2  # of a picture in one of the page: 7-point type, at 300 dots per inch, is 15 pixels high
SHORTER = 0.999  # of a time: a number of steps is rounded when a duration becomes one
PLURAL = {"deviates": "deviate"}
TIMES = {"steps", "duration"}  # by which a paper says how long it sampled


def write_page(
    study: str, description: str, papers: Sequence[Paper], folder: str | Path, path: str | Path,
    archived: str | Path | None = None,
) -> None:  # fmt: skip
    """Write the report of a study, from the folder of its results.

    ``archived``: verdict table in the archive of a long study, whose values stand beside those of
    this one.
    """
    results = Results(str(folder))
    table = joined(map(read_verdicts, results.tables_of(papers)))
    rows = verdict_rows(table, None if archived is None else read_verdicts(archived))
    long_study = ""
    if archived is not None and any(row["archived"] for row in rows):
        long_study = Path(archived).parent.name
    names = [paper.name for paper in papers]
    checks = [_checks(paper, results) for paper in papers]
    page = rendered(
        "page.html",
        study=study,
        description=description,
        papers=[_paper(paper, results, rows) for paper in papers],
        rows=rows,
        long_study=long_study,
        counts={kind: counts(rows, kind, names) for kind in KINDS},
        checks=[row for rows in checks for row in rows],
        costs=[c for paper, rows in zip(papers, checks) for c in _costs(paper, results, rows)],
        shorter=[point for paper in papers for point in shorter_points(paper)],
        not_said={paper.name: names for paper in papers if (names := not_said(paper))},
        versions=library_versions(),
        sources={
            stage: stage_digest(stage) for stage in ("simulate", "collect", "figure", "report")
        },
        commit=commit(),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    replace_whole(path, lambda draft: draft.write_text(page, encoding="utf-8"))


# Figures, and what each sweep says of itself.


def _paper(paper, results, rows):
    """A paper's figures, each with its picture, caption and verdicts inside the page."""
    files = {name: Path(results.figure(paper.name, name, "png")) for name in paper.figures}
    return {
        "key": paper.name,
        "name": named(paper.name),
        "title": paper.title,
        "reference": paper.reference,
        "figures": [_figure(path, f"{paper.name}-{name}", rows) for name, path in files.items()],
    }


def _figure(path, name, rows):
    """A figure's picture, what is seen in it, its caption, and the verdicts on its numbers."""
    with Image.open(path) as picture:
        width, height = picture.size
        data = base64.b64encode(small_png(picture)).decode()
    return {
        "id": name,
        "label": label(path.stem),
        "picture": f"data:image/png;base64,{data}",
        "width": width // PIXELS,
        "height": height // PIXELS,
        "seen": attribute(path.with_suffix(".nc"), "seen"),
        "caption": Markup(path.with_suffix(".html").read_text(encoding="utf-8")),
        "rows": [row for row in rows if row["figure"] == name],
    }


def _checks(paper, results):
    """What each sweep says of itself: kT, momentum, speed, memory, cost."""
    rows = []
    for name in paper.sweeps:
        data = load(results.sweep(paper.name, name))
        rows.append({
            "paper": paper.name,
            "sweep": name,
            "runs": data.kT.size,
            "beads": _range(data.beads, "{:.0f}"),
            "steps": _range(data.steps, "{:.0f}"),
            "kT": _range(data.kT, "{:.4f}"),
            "momentum": float(data.momentum_per_bead.max()),
            "rate": float(np.median(data.bead_steps_per_second)) / 1e6,
            "memory": float(data.peak_memory_MiB.max()),
            "seconds": float(data.seconds.sum()),
        })  # fmt: skip
    return rows


def _range(values, pattern):
    low, high = (pattern.format(float(v)) for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _costs(paper, results, checks):
    """Jobs and seconds of each stage, from what its files and sweeps say of themselves."""

    def spent(file, names, *kind):
        return len(names), sum(attribute(file(paper.name, n, *kind), "seconds") for n in names)

    stages = {
        "simulations": (sum(row["runs"] for row in checks), sum(row["seconds"] for row in checks)),
        "sweeps": spent(results.sweep, paper.sweeps),
        "sweeps of theory": spent(results.sweep, paper.theory),
        "measurements": spent(results.measurement, paper.measurements),
        "figures": spent(results.figure, paper.figures, "nc"),
    }
    for stage, (jobs, seconds) in stages.items():
        if jobs:
            yield {"paper": paper.name, "stage": stage, "jobs": jobs, "seconds": seconds}


# Verdicts.


def verdict_rows(table: pd.DataFrame, archived: pd.DataFrame | None = None) -> list[Row]:
    """Rows of a verdict table as text, in its order, with ``id`` and ``figure`` for links.

    Where a row of ``archived``, such a table of a long study, is held against the same published
    value, ``archived`` is what that found and ``archived_verdict`` what it decided.
    """
    seen: Counter[str] = Counter()
    long_runs = {} if archived is None else {_key(e): e for e in archived.to_dict("records")}
    rows = []
    for entry in table.to_dict("records"):
        figure = f"{entry['paper']}-{entry['figure']}"
        seen[figure] += 1
        found = long_runs.get(_key(entry))
        has_limits = np.isfinite(entry["rounding"]) or _number(entry["published"]) is None
        rows.append({
            "id": f"{figure}-{seen[figure]}",
            "paper": entry["paper"],
            "figure": figure,
            "label": label(entry["figure"]),
            "kind": entry["kind"],
            **{name: typeset(_text(entry[name])) for name in ("quantity", "where", "note")},
            **{name: typeset(_small(entry[name]))
               for name in ("published_error", "rounding", "resolution")},
            "published": typeset(_published(entry["published"])),
            "limits": _text(entry["limits"]) if has_limits else "",
            "value": typeset(with_error(entry["value"], entry["error"])),
            "deviation": typeset(_small(entry["deviation_sigma"], "{:.2f}")),
            "verdict": entry["verdict"],
            "archived": typeset(with_error(found["value"], found["error"])) if found else "",
            "archived_verdict": found["verdict"] if found else "",
        })  # fmt: skip
    return rows


def _key(entry):
    """What two studies must have in common for their rows to be of one number."""
    names = (entry[name] for name in ("paper", "figure", "quantity", "kind"))
    return (*names, _published(entry["published"]))


def _number(value):
    try:
        return float(value)
    except ValueError:
        return None


def _published(value):
    """A number, or a range in words."""
    number = _number(value)
    return _text(value) if number is None else f"{number:g}"


def _small(value, pattern="{:.2g}"):
    """A number of two digits, or nothing where there is none."""
    return "" if np.isnan(value) else pattern.format(value).replace("inf", "∞")


def _text(value):
    """A cell of text: pandas has NaN where it is empty."""
    return value if isinstance(value, str) else ""


def counts(rows: Iterable[Row], kind: str, papers: Iterable[str]) -> list[Row]:
    """How many rows of a kind have which verdict: of each paper that has any, and of all.

    ``kind``: of `dpd.analysis.verdicts.KINDS`. The last one is of all papers, its ``paper`` empty.
    """
    chosen = [row for row in rows if row["kind"] == kind]
    found = []
    for paper in (*papers, ""):
        own = [row["verdict"] for row in chosen if paper in ("", row["paper"])]
        verdicts = {name: own.count(name) for name in VERDICTS}
        text = ", ".join(
            f"{number} {name if number == 1 else PLURAL.get(name, name)}"
            for name, number in verdicts.items()
        )
        if own or not paper:
            found.append({"paper": paper, "total": len(own), "verdicts": verdicts, "text": text})
    return found


# How long runs are beside those of the paper.


def shorter_points(paper: Paper) -> list[Row]:
    """Points that are sampled for less time than in the paper, or in a smaller system, as text.

    ``share`` is our time in units of the paper's; times are in tau.
    """
    found = []
    for said in paper.sampling:
        for sweep in said["sweeps"] if TIMES & said.keys() else ():
            for name, scenes in _by_point(paper.sweeps[sweep], said.get("at", {})).items():
                scene = scenes[0]
                ours = sum(scene.steps.sample * scene.dt for scene in scenes)
                steps = said.get("steps", 0) * said.get("dt", scene.dt)  # ours where it gives none
                theirs = said.get("duration", steps) * said.get("runs", 1)
                system, smaller = _system(said, scene)
                if ours < SHORTER * theirs or smaller:
                    at_least = "≥ " if said.get("at_least") else ""
                    found.append({
                        "paper": paper.name,
                        "sweep": sweep,
                        "point": name,
                        "time": whole(ours),
                        "paper_time": at_least + whole(theirs),
                        "share": f"{ours / theirs:.2g}",
                        "system": system,
                        "where": typeset(said["where"]),
                    })  # fmt: skip
    return found


def not_said(paper: Paper) -> list[str]:
    """Sweeps for which the paper does not say how long it sampled."""
    untimed = [said for said in paper.sampling if not TIMES & said.keys()]
    return [name for said in untimed for name in said["sweeps"]]


def _by_point(sweep, at):
    """Scenes of each point that has the labels asked for, by its name, its replicas together."""
    points = {}
    for point in sweep.points:
        place = {axis.name: value for axis, value in zip(sweep.axes[:-1], point.labels)}
        if all(place[axis] in labels for axis, labels in at.items()):
            name = ", ".join(f"{axis.replace('_', ' ')} {value}" for axis, value in place.items())
            points.setdefault(name, []).append(point.scene)
    return points


def _system(said, scene):
    """Our size and the paper's in words, and whether ours is smaller."""
    sizes = {"beads": scene.beads, "molecules": sum(kind.count for kind in scene.molecules)}
    for kind, ours in sizes.items():
        if kind in said:
            theirs = said[kind]
            return f"{ours} of {theirs} {kind}" if ours != theirs else "the same", ours < theirs
    return "not said", False
