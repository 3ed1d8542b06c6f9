"""The report: one self-contained page."""

import base64
import platform
import re
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np
import xarray as xr
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup, escape

from dpd.digest import ROOT, stage_digest
from dpd.files import attribute, replace_whole
from dpd.report.figures import joined_verdicts
from dpd.report.text import published_text, with_error
from dpd.starting import start_digest, start_is_shared

LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")
TEMPLATE = "page.html"


def write_page(study, description, papers, results, path, overhead=""):
    """Write the report of a study.

    Parameters
    ----------
    study, description : str
    papers : list of dpd.study.Paper
    results : path
        Folder of the study.
    path : path
    overhead : str
        What the workflow cost beside its simulations, see `dpd.report.overhead`.
    """
    table = joined_verdicts(papers, results)
    checks = [_checks(paper, results) for paper in papers]
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True
    )
    environment.filters |= {"number": _number, "published": published_text}
    page = environment.get_template(TEMPLATE).render(
        study=study,
        description=description,
        papers=[_paper(paper, results, paper.name in set(table.paper)) for paper in papers],
        verdicts=table.to_dict("records"),
        counts=table.verdict.value_counts().to_dict(),
        checks=[row for rows in checks for row in rows],
        overhead=overhead,
        costs=[c for paper, rows in zip(papers, checks) for c in _costs(paper, results, rows)],
        versions={name: version(name) for name in LIBRARIES}
        | {"Python": platform.python_version()},
        sources={
            stage: stage_digest(stage) for stage in ("simulate", "collect", "figure", "report")
        },
        commit=_commit(),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    replace_whole(path, lambda draft: draft.write_text(page))


def _paper(paper, results, judged):
    """A paper's figures, each with its picture and caption inside the page."""
    folder = results / paper.name / "figures"
    figures = []
    for name in paper.figures:
        picture = (folder / f"{name}.png").read_bytes()
        figures.append(
            {
                "name": name,
                "picture": f"data:image/png;base64,{base64.b64encode(picture).decode()}",
                "width": _png_width(picture) // 2,  # so that text is of one size in all figures
                "caption": _html((folder / f"{name}.md").read_text()),
            }
        )
    return {
        "key": paper.name,
        "name": paper.name.replace("_", " ").title(),
        "judged": judged,
        "title": paper.title,
        "reference": paper.reference,
        "figures": figures,
    }


def _png_width(picture):
    """Pixels, from the head of a PNG file."""
    return int.from_bytes(picture[16:20], "big")


def _html(text):
    """Paragraphs, **strong**, *emphasis* and | tables | of a caption as HTML; all else escaped."""
    return Markup("".join(_block(part) for part in text.strip().split("\n\n")))


def _block(part):
    """One paragraph or table."""
    safe = str(escape(part))
    if safe.startswith("|"):
        head, _, *rows = [line.strip("| ").split(" | ") for line in safe.splitlines()]
        lines = [_row("th", head), *(_row("td", row) for row in rows)]
        return f'<div class="wide"><table>{"".join(lines)}</table></div>'
    safe = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", safe)
    return "<p>" + re.sub(r"(?<!\w)\*(\w+)\*", r"<em>\1</em>", safe) + "</p>"


def _row(kind, cells):
    return f"<tr>{''.join(f'<{kind}>{cell}</{kind}>' for cell in cells)}</tr>"


def _checks(paper, results):
    """What each sweep says of itself: kT, momentum, speed, memory, cost."""
    rows = []
    for name in paper.sweeps:
        path = results / paper.name / "sweeps" / f"{name}.nc"
        with xr.open_dataset(path, engine="netcdf4") as data:
            rows.append({
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
    folder = results / paper.name
    points = [point for sweep in paper.sweeps.values() for point in sweep.points]
    starts = sorted({start_digest(p.scene) for p in points if start_is_shared(p.scene)})
    stages = {
        "first configurations": _files(folder / "starts", starts),
        "simulations": (sum(row["runs"] for row in checks), sum(row["seconds"] for row in checks)),
        "sweeps": _files(folder / "sweeps", paper.sweeps),
        "measurements": _files(folder / "measurements", paper.measurements),
        "figures": _files(folder / "figures", paper.figures),
    }
    for stage, (jobs, seconds) in stages.items():
        if jobs:
            yield {"paper": paper.name, "stage": stage, "jobs": jobs, "seconds": seconds}


def _files(folder, names):
    """How many NetCDF files, and the seconds that they say they took."""
    return len(names), sum(attribute(folder / f"{name}.nc", "seconds") for name in names)


def _span(values, pattern):
    low, high = (pattern.format(float(v)) for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _number(value, error=None):
    """A number, with its error where it has one; text as it is."""
    return with_error(value, error) if isinstance(value, float | int) else value


def _commit():
    """The commit that the sources stand on, with a mark if they were edited."""
    found = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    return found.stdout.strip() or "not under version control"
