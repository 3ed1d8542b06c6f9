"""The report: one self-contained page."""

import base64
import platform
import re
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup, escape

from dpd.digest import ROOT, stage_digest
from dpd.files import attribute, replace_whole
from dpd.report.figures import joined_verdicts
from dpd.report.text import with_error
from dpd.simulate import start_digest
from dpd.start import start_work

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
    checks = pd.concat([_checks(paper, results) for paper in papers], ignore_index=True)
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True
    )
    environment.filters |= {"number": _number, "pulled": _pulled}
    page = environment.get_template(TEMPLATE).render(
        study=study,
        description=description,
        papers=[_paper(paper, results, paper.name in set(table.paper)) for paper in papers],
        verdicts=table.to_dict("records"),
        counts=table.verdict.value_counts().to_dict(),
        checks=checks.to_dict("records"),
        overhead=overhead,
        costs=[cost for paper in papers for cost in _costs(paper, results)],
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
        picture = base64.b64encode((folder / f"{name}.png").read_bytes()).decode()
        figures.append(
            {
                "name": name,
                "picture": f"data:image/png;base64,{picture}",
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
        data = xr.load_dataset(results / paper.name / "sweeps" / f"{name}.nc", engine="netcdf4")
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
    return pd.DataFrame(rows)


def _costs(paper, results):
    """Jobs and seconds of each stage, from what its files say of themselves."""
    folder = results / paper.name
    points = [point for sweep in paper.sweeps.values() for point in sweep.points]
    starts = sorted({start_digest(p.scene) for p in points if start_work(p.scene)})
    measurements = [folder / "measurements" / f"{name}.nc" for name in paper.measurements]
    sweeps = [folder / "sweeps" / f"{name}.nc" for name in paper.sweeps]
    stages = {
        "first configurations": [folder / "starts" / f"{digest}.nc" for digest in starts],
        "simulations": [
            folder / "runs" / sweep.name / point.name / "run.nc"
            for sweep in paper.sweeps.values()
            for point in sweep.points
        ],
        "sweeps": sweeps,
        "measurements": measurements,
        "figures": [folder / "figures" / f"{name}.nc" for name in paper.figures],
    }
    for stage, paths in stages.items():
        if not paths:
            continue
        seconds = sum(attribute(path, "seconds") for path in paths)
        yield {"paper": paper.name, "stage": stage, "jobs": len(paths), "seconds": seconds}


def _span(values, pattern):
    low, high = (pattern.format(float(v)) for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _number(value, error=None):
    """A number, with its error where it has one; text as it is."""
    return with_error(value, error) if isinstance(value, float | int) else value


def _pulled(row):
    """Published value as printed in the table: with its error where it has one."""
    try:
        value = float(row["published"])
    except ValueError:
        return row["published"]
    error = row["published_error"]
    return f"{value:g}" + (f" ± {error:.2g}" if np.isfinite(error) else "")


def _commit():
    """The commit that the sources stand on, with a mark if they were edited."""
    found = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    return found.stdout.strip() or "not under version control"
