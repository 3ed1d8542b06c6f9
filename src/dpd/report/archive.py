"""What git keeps of studies: verdicts, of the long one figures with numbers; and how two differ."""

import hashlib
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
from dpd.pipeline.paper import SEEDED, Paper, read_config, read_paper, read_study
from dpd.pipeline.paths import LONG_STUDY, Results, commit, library_versions, processor, results_of
from dpd.report.figures import call, load_module, verdicts_of
from dpd.report.rows import Row, read_rows
from dpd.report.style import LOOK

ARCHIVE = ROOT / "results" / "archive"
FIGURES = ROOT / "paper_figures"
VERDICTS, MANIFEST = "verdicts.csv", "manifest.yaml"
LIMIT = 10_000_000  # bytes of an archive: git keeps every version of it for ever
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one, and their checksums.
# `figures` names the entry of `parts` that made each: a figure that is not drawn where that is
# called stays. `minutes`: from the first file of the study to its last.
"""
KEY = ["paper", "figure", "quantity"]
DRAWS = 400  # of two errors, which say how far their values should differ
WORST = 10  # rows that are listed
ROUNDING = 1e-9  # of the square of an error: what is left of one that is systematic
MEANING = (
    "z = (a - b) / sqrt(e_a^2 + e_b^2), e being half a 95 % interval over 1.96 without the "
    "systematic part that both\nstudies share; then what the degrees of freedom (df) predict for "
    "its rms; flips: verdicts that differ; missing: values\nthat one study alone has, which have "
    "no verdict."
)


def keep(study: str, runs_from: float = math.inf) -> list[Path]:
    """Keep of a study what git is to have of it, and name what has changed.

    Of the long one see `keep_whole`; of others the verdicts, how long it took and, of the seed 1,
    pictures as wide as before. Raises `UserError` if there is no such study, or it has no verdicts.
    """
    read_study(study)  # a name that is none would lead elsewhere
    results = results_of(study)
    if study == LONG_STUDY:
        every = [read_paper(name, study) for name in read_config()["papers"]]
        return keep_whole(study, results, every, runs_from)
    source = Path(results.verdicts())
    papers = sorted({row["paper"] for row in read_rows(source)})
    written = [each.stat().st_mtime for each in Path(results.folder).rglob("*.*")]
    took = {"minutes": round((max(written) - min(written)) / 60, 1)}  # where it was made at once
    table = {VERDICTS: source.read_bytes()}
    manifest = manifest_text({"study": study} | took | _made_by() | {"files": {}}, table)
    contents = {f"{study}/{VERDICTS}": table[VERDICTS], f"{study}/{MANIFEST}": manifest.encode()}
    for paper in [] if SEEDED.fullmatch(study) else papers:
        for archived in pictures(paper):
            drawn = Path(results.figure(paper, archived.stem, "png"))
            if drawn.is_file():
                with Image.open(archived) as old:
                    contents[str(archived)] = small_png(drawn, old.width)
    return write_changed(ARCHIVE, contents)


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
    return [name for name in names if not SEEDED.fullmatch(name)]


def manifest_of(study: str) -> dict[str, Any]:
    """The manifest of an archived study; an empty one where there is none."""
    path = ARCHIVE / study / MANIFEST
    return yaml.safe_load(path.read_text()) if path.is_file() else {}


def manifest_text(manifest: dict[str, Any], contents: dict[str, bytes]) -> str:
    """A manifest as it is written, with size and checksum of some new files."""
    manifest["files"] |= {
        name: {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        for name, data in contents.items()
    }
    return HEAD + yaml.safe_dump(manifest, sort_keys=False, allow_unicode=True, width=100)


def table_text(rows: Sequence[Row]) -> bytes:
    """A verdict table as its file has it."""
    return pd.DataFrame(rows, columns=COLUMNS).to_csv(index=False).encode()


def keep_whole(
    study: str, results: Results, papers: Sequence[Paper], runs_from: float = math.inf
) -> list[Path]:
    """Keep figures and numbers as far as made, else those of before; and runs of that many hours.

    Raises `UserError`, and nothing changes, if nothing is there, or it would be above `LIMIT`.
    """
    target, former, made = ARCHIVE / study, manifest_of(study), _made_by()
    part = f"{made['date']} {made['commit']}"
    parts = former.get("parts", {}) | {part: made}
    figures, rows, drawn = {}, [], False
    before = read_rows(target / VERDICTS) if former else []
    contents: dict[str, bytes] = {}
    for paper, figure in [(each.name, figure) for each in papers for figure in each.figures]:
        name = f"{paper}/{figure}"
        picture, numbers, table = (
            Path(results.figure(paper, figure, kind)) for kind in ("png", "nc", "csv")
        )
        if picture.is_file() and numbers.is_file() and table.is_file():
            drawn, figures[name] = True, part
            contents |= {f"{name}.png": small_png(picture), f"{name}.nc": numbers.read_bytes()}
            rows += read_rows(table)
        elif name in former.get("figures", {}):
            figures[name] = former["figures"][name]
            kept = [f"{name}.png", f"{name}.nc"]
            contents |= {each: (target / each).read_bytes() for each in kept}
            rows += [row for row in before if f"{row['paper']}/{row['figure']}" == name]
    runs = dict(_long_runs(target, papers, results, runs_from))
    if not drawn and not runs:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    contents = {VERDICTS: table_text(rows)} | contents | runs
    manifest = {
        "study": study,
        "parts": {name: parts[name] for name in parts if name in figures.values()},
        "figures": figures, "files": {},
    }  # fmt: skip
    contents[MANIFEST] = manifest_text(manifest, contents).encode()
    if (size := sum(map(len, contents.values()))) > LIMIT:
        largest = max(contents, key=lambda name: len(contents[name]))
        raise UserError(
            f"{target}: it would have {size / 1e6:.1f} MB, and {LIMIT / 1e6:g} MB are allowed; the "
            f"largest file is {largest}: let that figure keep or draw less"
        )
    for path in target.rglob("*"):
        if path.is_file() and str(path.relative_to(target)) not in contents:
            path.unlink()
    return write_changed(target, contents)


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
    if "figures" not in manifest:
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
    contents[MANIFEST] = manifest_text(manifest, contents).encode()
    return write_changed(target, contents)


def _runs(papers, results):
    """Of each run of some papers its name in an archive and its place in the results."""
    for paper in papers:
        for sweep in paper.sweeps.values():
            for point in sweep.points:
                name = f"{paper.name}/runs/{sweep.name}/{point.name}.nc"
                yield name, Path(results.run(paper.name, sweep.name, point.name))


def _long_runs(target, papers, results, hours):
    """Name in the archive and content of runs that took long, from here or from the archive."""
    for name, path in _runs(papers, results) if hours < math.inf else ():
        for place in (path, target / name):
            if place.is_file() and files.attributes(place).get("seconds", 0) >= 3600 * hours:
                yield name, place.read_bytes()
                break


def restore(study: str) -> list[Path]:
    """Put archived runs where Snakemake looks, and name them; `UserError` if there is none."""
    read_study(study)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    every = [(ARCHIVE / study / name, path) for name, path in _runs(papers, results_of(study))]
    archived = [(source, path) for source, path in every if source.is_file()]
    if not archived:
        raise UserError(
            f"{ARCHIVE / study}: no runs are archived there; 'python -m dpd archive {study} "
            "--runs-from HOURS' keeps those that took as long or longer"
        )
    missing = {str(path): source.read_bytes() for source, path in archived if not path.is_file()}
    return write_changed(Path(), missing)


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
        ("largest |z|", rows.loc[rows.z.abs().nlargest(WORST).index]),
        ("verdicts that differ", rows[rows.flip]),
        ("values that one study lacks", rows[rows.missing]),
    ):
        lines += ["", f"{title}:"]
        for row in part.to_dict("records"):
            values = (
                f"{row[f'value{s}']:.5g} ± {row[f'error{s}']:.2g} (df "
                f"{row[f'degrees{s}']:.3g}, {row[f'verdict{s}'].split()[0]})"
                for s in ("", "_b")
            )
            name = f"{row['paper']} {row['figure']}: {row['quantity']}"
            lines.append(f"  z {row['z']:5.2f}  {name}: {' and '.join(values)}")
    return "\n".join(lines)
