"""What git keeps of studies: verdicts, of the long one figures with numbers; and how two differ."""

import math
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import yaml
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

from dpd import files
from dpd.analysis.collect import load
from dpd.analysis.statistics import COVERAGE, MANY, widening
from dpd.analysis.verdicts import COLUMNS
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.pipeline.paper import Paper, read_config, read_paper, read_study, variant_of
from dpd.pipeline.paths import LONG_STUDY, Results, commit, library_versions, processor, results_of
from dpd.report.figures import call, load_module, verdicts_of
from dpd.report.rows import Row, read_rows
from dpd.report.style import LOOK

ARCHIVE = ROOT / "results" / "archive"
FIGURES = ROOT / "paper_figures"
VERDICTS, MANIFEST, RUNS = "verdicts.csv", "manifest.yaml", "runs.csv"
TOLD = ["beads", "steps", "seconds"]  # of each run
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one.
# `figures` names the entry of `parts` that made each: a figure that is not drawn where that is
# called stays. `minutes`: from the first file to the last, when all figures were made at once.
"""
KEY = ["paper", "figure", "quantity"]
SHOWN = ["z", *KEY, "value", "error", "verdict", "value_b", "error_b", "verdict_b"]
DRAWS = 400  # of two errors, which say how far their values should differ
ROUNDING = 1e-9  # of the square of an error: what is left of one that is systematic
MEANING = """\
z = (a - b) / sqrt(e_a^2 + e_b^2), without what both errors share; its rms beside what their degrees
of freedom predict; flips: verdicts that differ; missing: values that one study alone has."""


def keep(study: str, runs_from: float = math.inf) -> list[Path]:
    """Keep of a study what git is to have of it, as far as made, and name what has changed.

    What was kept before of other figures stays. Of each figure it keeps the verdicts; of the long
    study numbers, pictures, and how long each run took, or the run itself if it took so many hours;
    of others how long all figures took, and of the seed 1 those pictures that git has, as wide as
    before. Raises `UserError`, and nothing changes, if there is no such study or no figure of it.
    """
    read_study(study)  # a name that is none would lead elsewhere
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    return keep_figures(study, results_of(study), papers, runs_from)


def _made_by():
    return {
        "commit": commit(), "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": {"processor": processor(), "cores": os.cpu_count() or 1},
        "versions": library_versions(),
    }  # fmt: skip


def pictures(paper: str) -> list[Path]:
    """Pictures of a paper's figures that git keeps, in the order of their names."""
    return sorted((FIGURES / paper).glob("*.png"))


def small_png(source: Path | BytesIO, width: int | None = None) -> bytes:
    """A picture, perhaps of another width, in 256 colours: a third of the bytes, and alike."""
    written = BytesIO()
    with Image.open(source) as picture:
        width = width or picture.width
        size = width, round(picture.height * width / picture.width)
        resized = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        resized.quantize(256, dither=Image.Dither.NONE).save(written, "png", optimize=True)
    return written.getvalue()


def studies() -> list[str]:
    """Names of the studies that have a table in the archive; of each, that of the seed 1."""
    names = sorted(path.parent.name for path in ARCHIVE.glob(f"*/{VERDICTS}"))
    return [name for name in names if variant_of(name)[0] == name]


def manifest_of(study: str) -> dict[str, Any]:
    """The manifest of an archived study; an empty one where there is none."""
    path = ARCHIVE / study / MANIFEST
    return yaml.safe_load(path.read_text()) if path.is_file() else {}


def runs_of(study: str) -> pd.DataFrame:
    """How long each archived run of a study took, and which part of the study made it."""
    path = ARCHIVE / study / RUNS
    none = pd.DataFrame(columns=["part", *TOLD], index=pd.Index([], name="run"))
    return pd.read_csv(path, index_col=0) if path.is_file() else none


def manifest_text(manifest: dict[str, Any]) -> bytes:
    """A manifest as its file has it."""
    text = yaml.safe_dump(manifest, sort_keys=False, allow_unicode=True, width=100)
    return (HEAD + text).encode()


def table_text(rows: Sequence[Row]) -> bytes:
    """A verdict table as its file has it, but for digits in which processors differ."""
    return pd.DataFrame(rows, columns=COLUMNS).to_csv(index=False, float_format="%.10g").encode()


def keep_figures(
    study: str, results: Results, papers: Sequence[Paper], runs_from: float = math.inf
) -> list[Path]:
    """See `keep`, of some papers whose results are there."""
    target, former, made = ARCHIVE / study, manifest_of(study), _made_by()
    of_long, seed = variant_of(study)[0] == LONG_STUDY, variant_of(study)[2]
    part = f"{made['date']} {made['commit']}"
    parts = former.get("parts", {}) | {part: made}
    before = read_rows(target / VERDICTS) if former else []
    figures, rows = {}, []
    contents: dict[str, bytes] = {}
    every = [(each.name, figure) for each in papers for figure in each.figures]
    drawn = [each for each in every if os.path.isfile(results.figure(*each, "nc"))]
    if not drawn:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    for paper, figure in every:
        name = f"{paper}/{figure}"
        if (paper, figure) in drawn:
            figures[name] = part
            rows += read_rows(results.figure(paper, figure, "csv"))
            picture, shown = Path(results.figure(paper, figure, "png")), FIGURES / f"{name}.png"
            if study == LONG_STUDY:
                contents[f"{name}.png"] = small_png(picture)
                contents[f"{name}.nc"] = Path(results.figure(paper, figure, "nc")).read_bytes()
            elif seed == 1 and shown.is_file():
                with Image.open(shown) as old:
                    contents[str(shown)] = small_png(picture, old.width)
        elif name in former.get("figures", {}):
            figures[name] = former["figures"][name]
            rows += [row for row in before if f"{row['paper']}/{row['figure']}" == name]
    head: dict[str, Any] = {"study": study}
    used = {*figures.values()}
    if of_long:
        runs = runs_of(study)
        for name, path in _runs(papers, results):
            if path.is_file():
                told = files.attributes(path)
                runs.loc[name] = [part, *(round(told[key]) for key in TOLD)]
                if told["seconds"] >= 3600 * runs_from:
                    contents[name] = path.read_bytes()
        contents[RUNS] = runs.sort_index().to_csv().encode()
        used |= {*runs.part}
    elif len(drawn) == len(every):
        written = [each.stat().st_mtime for each in Path(results.folder).rglob("*.*")]
        head["minutes"] = round((max(written) - min(written)) / 60, 1)
    elif "minutes" in former:
        head["minutes"] = former["minutes"]
    head["parts"] = {name: parts[name] for name in parts if name in used}
    manifest = manifest_text(head | {"figures": figures})
    for name in former.get("figures", {}).keys() - figures.keys():
        for kind in ("png", "nc"):
            (target / f"{name}.{kind}").unlink(missing_ok=True)
    return write_changed(target, contents | {VERDICTS: table_text(rows), MANIFEST: manifest})


def write_changed(target: Path, contents: dict[str, bytes]) -> list[Path]:
    """Write files, by their names below a folder or anywhere, and name those that have changed."""
    changed = []
    for name, data in contents.items():
        path = target / name
        if not path.is_file() or path.read_bytes() != data:
            files.replace_whole(path, partial(Path.write_bytes, data=data))
            changed.append(path)
    return changed


@mpl.rc_context(LOOK)
def redraw(study: str) -> list[Path]:
    """Draw and judge archived numbers again, or else `UserError`, and name what has changed."""
    read_study(study)  # a name that is none would lead elsewhere
    target, manifest = ARCHIVE / study, manifest_of(study)
    if study != LONG_STUDY or "figures" not in manifest:
        raise UserError(f"{target / MANIFEST}: no figures are archived there")
    contents, rows = {}, []
    for name in manifest["figures"]:
        paper, figure = name.split("/")
        module, data = load_module(paper, figure), load(target / f"{name}.nc")
        drawn, whole = call(module, "draw", data, Figure), BytesIO()
        drawn.savefig(whole, format="png")
        plt.close(drawn)
        contents[f"{name}.png"] = small_png(whole)
        rows += verdicts_of(module, paper, figure, data).to_dict("records")
    contents[VERDICTS] = table_text(rows)
    return write_changed(target, contents)


def _runs(papers, results):
    """Of each run of some papers its name in an archive and its place in the results."""
    for paper in papers:
        for sweep in paper.sweeps.values():
            for point in sweep.points:
                name = f"{paper.name}/runs/{sweep.name}/{point.name}.nc"
                yield name, Path(results.run(paper.name, sweep.name, point.name))


def restore(study: str) -> list[Path]:
    """Put archived runs that are missing where Snakemake looks, and name them."""
    read_study(study)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    every = [(ARCHIVE / study / name, path) for name, path in _runs(papers, results_of(study))]
    missing = [(source, path) for source, path in every if source.is_file() and not path.is_file()]
    return write_changed(Path(), {str(path): source.read_bytes() for source, path in missing})


def table_of(name: str | Path) -> pd.DataFrame:
    """The verdicts of a study by name, folder, archive or table; `UserError` if there are none."""
    for place in (Path(name), Path(results_of(str(name)).folder), ARCHIVE / str(name)):
        drawn = [place] if place.is_file() else sorted(place.glob("*/figures/*.csv"))
        if found := drawn or sorted(place.glob("verdicts.csv")):
            return pd.DataFrame(read_rows(*found), columns=COLUMNS)
    raise UserError(
        f"{name}: no verdicts there; name a folder below results or results/archive, or a table "
        "verdicts.csv"
    )


def compared(one: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Rows that two verdict tables share, with columns of both, those of the second with ``_b``.

    ``z``, ``flip`` and ``missing`` as in `MEANING`; ``likely_z`` is the mean square of z that the
    degrees of freedom let expect. Both are NaN where a row has no error but a systematic one.
    """
    both = one.merge(other, on=KEY, suffixes=("", "_b"), validate="one_to_one")
    there = both[["value", "value_b"]].notna().sum(axis=1)
    errors, shared, degrees = (
        both[[name, f"{name}_b"]].to_numpy(float) for name in ("error", "systematic", "degrees")
    )
    squares = errors**2 - np.nan_to_num(shared) ** 2
    known = (squares > ROUNDING * errors**2).all(axis=1)
    both["z"] = (both.value - both.value_b) / np.sqrt(np.where(known, squares.sum(axis=1), np.nan))
    # Of values whose errors have so many degrees of freedom; Student's t makes it less than one.
    many = np.minimum(np.nan_to_num(degrees, nan=np.inf), MANY)
    drawn = np.random.default_rng(1).chisquare(many, (DRAWS, *many.shape)) / many
    likely = np.mean(2 / (widening(many) ** 2 * drawn).sum(axis=2), axis=0)
    both["likely_z"] = np.where(known, likely, np.nan)
    both["missing"] = there == 1
    both["flip"] = (there == 2) & (both.verdict != both.verdict_b)
    return both


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """What `compared` found, per paper and in all."""
    table = {}
    for name, part in (*rows.groupby("paper"), ("all", rows)):
        z = part.z.dropna()
        rms, likely = np.sqrt((z**2).mean()), np.sqrt(part.likely_z.mean())
        table[name] = {
            "rows": len(part), "with z": len(z), "rms z": f"{rms:.2f} of {likely:.2f}",
            ">1.96": f"{(z.abs() > COVERAGE).mean():.1%}", "flips": part.flip.sum(),
            "missing": part.missing.sum(),
        }  # fmt: skip
    return pd.DataFrame(table).T


def as_text(rows: pd.DataFrame) -> str:
    """The summary, then the rows that differ most."""
    lines = [summary(rows).to_string(), "", MEANING]
    for title, part in (
        ("largest |z|", rows.loc[rows.z.abs().nlargest(10).index]),
        ("verdicts that differ", rows[rows.flip]),
        ("values that one study lacks", rows[rows.missing]),
    ):
        shown = part[SHOWN].to_string(index=False, float_format="{:.4g}".format)
        lines += ["", f"{title}:", shown if len(part) else "none"]
    return "\n".join(lines)
