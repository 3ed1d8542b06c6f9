"""What git keeps of studies, and two studies held against each other.

Kept are tables of verdicts, which README.md and the pages of papers are made from, and of the long
study its figures with their numbers.
"""

from __future__ import annotations

import hashlib
import math
import os
import shutil
from datetime import UTC, datetime
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.paper import SEEDED, read_config, read_paper, read_study
from dpd.pipeline.paths import LONG_STUDY, commit, library_versions, processor, results_of
from dpd.report.figures import (
    call,
    joined,
    load_module,
    read_verdicts,
    small_png,
    verdicts_of,
)  # fmt: skip
from dpd.report.style import LOOK

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from dpd.pipeline.paper import Paper
    from dpd.pipeline.paths import Results

ARCHIVE = ROOT / "results" / "archive"
FIGURES = ROOT / "paper_figures"
VERDICTS, MANIFEST = "verdicts.csv", "manifest.yaml"
LIMIT = 10_000_000  # bytes of an archive: git keeps every version of it for ever
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one, and their checksums.
# `figures` names the entry of `parts` that made each: a figure that is not drawn where that is
# called stays.
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


# Of any study: its table, and pictures beside the files of figures.


def keep(study: str, runs_from: float = math.inf) -> list[Path]:
    """Keep of a study what git is to have of it, and name what was written: the table first.

    Raises `UserError` if there is no such study, and as `keep_table` and `keep_whole` do.
    """
    read_study(study)  # a name that is none would lead elsewhere
    if study != LONG_STUDY:
        return keep_table(study, results_of(study))
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    return keep_whole(study, results_of(study), papers, runs_from)


def keep_table(study: str, results: Results) -> list[Path]:
    """Keep the verdicts of all papers, and draw anew the pictures beside files of figures.

    A new picture is as wide as the old one. Of a study with another seed than 1 the table alone is
    archived. Raises `UserError` if there is no such table, or it was made by an older version.
    """
    source, target = results.verdicts(), ARCHIVE / study / VERDICTS
    table = read_verdicts(source)
    replace_whole(target, lambda draft: shutil.copyfile(source, draft))
    written = [target]
    for paper in [] if SEEDED.fullmatch(study) else sorted(set(table.paper)):
        for archived in pictures(paper):
            drawn = Path(results.figure(paper, archived.stem, "png"))
            if drawn.is_file():
                with Image.open(archived) as old, Image.open(drawn) as new:
                    size = old.width, round(new.height * old.width / new.width)
                    data = small_png(new.convert("RGB").resize(size, Image.Resampling.LANCZOS))
                replace_whole(archived, partial(Path.write_bytes, data=data))
                written.append(archived)
    return written


def pictures(paper: str) -> list[Path]:
    """Pictures of a paper's figures that git keeps, in the order of their names."""
    return sorted((FIGURES / paper).glob("*.png"))


def studies() -> list[str]:
    """Names of the studies that have a table in the archive; of each, that of the seed 1."""
    names = sorted(path.parent.name for path in ARCHIVE.glob(f"*/{VERDICTS}"))
    return [name for name in names if not SEEDED.fullmatch(name)]


def read_archive(study: str) -> pd.DataFrame:
    """The verdict table of a study, refused as in `read_verdicts`."""
    return read_verdicts(ARCHIVE / study / VERDICTS)


# Of the long study: figures with their numbers, and a manifest.


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


def keep_whole(
    study: str, results: Results, papers: Sequence[Paper], runs_from: float = math.inf
) -> list[Path]:
    """Keep all of a study that a reader needs, also of one that was stopped before its end.

    A figure that is not drawn here stays in the archive as it is, while the study asks for it.
    ``runs_from``: hours; runs that took as long or longer are archived too, for `restore`. Returns
    what was written. Raises `UserError` if there is no figure and no run to keep, or the archive
    would be larger than `LIMIT`; then nothing changes.
    """
    target, former = ARCHIVE / study, manifest_of(study)
    made = {
        "commit": commit(), "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": {"processor": processor(), "cores": os.cpu_count() or 1},
        "versions": library_versions(),
    }  # fmt: skip
    part = f"{made['date']} {made['commit']}"
    parts = former.get("parts", {}) | {part: made}
    figures, missing, tables, drawn = {}, [], [], False
    contents: dict[str, bytes] = {}
    asked = [(each.name, figure) for each in papers for figure in each.figures]
    for paper, figure in asked:
        name = f"{paper}/{figure}"
        here = [Path(results.figure(paper, figure, kind)) for kind in ("png", "nc", "csv")]
        if all(path.is_file() for path in here):
            drawn, figures[name] = True, part
            with Image.open(here[0]) as picture:
                contents[f"{name}.png"] = small_png(picture)
            contents[f"{name}.nc"] = here[1].read_bytes()
            tables.append(read_verdicts(here[2]))
        elif name in former.get("figures", {}):
            figures[name] = former["figures"][name]
            kept = [f"{name}.png", f"{name}.nc"]
            contents |= {each: (target / each).read_bytes() for each in kept}
            table = read_archive(study)
            tables.append(table[(table.paper == paper) & (table.figure == figure)])
        else:
            missing.append(name)
    runs = dict(_long_runs(target, papers, results, runs_from))
    if not drawn and not runs:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    contents = {VERDICTS: joined(tables).to_csv(index=False).encode()} | contents | runs
    manifest = {
        "study": study,
        "parts": {name: parts[name] for name in parts if name in figures.values()},
        "figures": figures,
        "figures_missing": missing,
        "files": {},
    }
    contents[MANIFEST] = manifest_text(manifest, contents).encode()
    size = sum(map(len, contents.values()))
    if size > LIMIT:
        largest = max(contents, key=lambda name: len(contents[name]))
        raise UserError(
            f"{target}: the archive would have {size / 1e6:.1f} MB, and at most {LIMIT / 1e6:g} MB "
            f"are allowed, because git keeps every version; the largest file is {largest} with "
            f"{len(contents[largest]) / 1e6:.1f} MB: let that figure keep or draw less"
        )
    for path in target.rglob("*"):
        if path.is_file() and str(path.relative_to(target)) not in contents:
            path.unlink()
    return write_changed(target, contents)


def write_changed(target: Path, contents: dict[str, bytes]) -> list[Path]:
    """Write files into an archive, and name those that have changed."""
    changed = []
    for name, data in contents.items():
        path = target / name
        if not path.is_file() or path.read_bytes() != data:
            replace_whole(path, partial(Path.write_bytes, data=data))
            changed.append(path)
    return changed


@mpl.rc_context(LOOK)
def redraw(study: str) -> list[Path]:
    """Draw and judge again what an archive keeps the numbers of, and name what has changed.

    After an edit of a figure file or of a published number. What those files calculate from sweeps
    stays as it was.

    Raises `UserError` if there is no such study, its archive keeps no figures, or a figure file
    does not understand the numbers; then nothing changes.
    """
    read_study(study)  # a name that is none would lead elsewhere
    target, manifest = ARCHIVE / study, manifest_of(study)
    if not manifest:
        raise UserError(f"{target / MANIFEST}: missing; no figures are archived")
    contents, tables = {}, []
    for name in manifest["figures"]:
        paper, figure = name.split("/")
        module, data = load_module(paper, figure), load(target / f"{name}.nc")
        drawn, whole = call(module, "draw", data, Figure), BytesIO()
        drawn.savefig(whole, format="png")
        plt.close(drawn)
        with Image.open(whole) as picture:
            contents[f"{name}.png"] = small_png(picture)
        tables.append(verdicts_of(module, paper, figure, data))
    contents[VERDICTS] = joined(tables).to_csv(index=False).encode()
    contents[MANIFEST] = manifest_text(manifest, contents).encode()
    return write_changed(target, contents)


# Long runs, so that a study that took days can go on on another machine.


def _runs(papers: Sequence[Paper], results: Results) -> Iterator[tuple[str, Path]]:
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
            if place.is_file():
                seconds = float(files.attributes(place).get("seconds", 0))
                if seconds >= 3600 * hours:
                    yield name, place.read_bytes()
                    break


def restore(study: str) -> list[Path]:
    """Put the runs that the archive of a study has where Snakemake looks for them.

    Result: what was written; a run that is there already is left as it is. Collecting refuses one
    of other sources or another scene. Raises `UserError` if there is no such study, or its archive
    has no runs.
    """
    read_study(study)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    every = [(ARCHIVE / study / name, path) for name, path in _runs(papers, results_of(study))]
    archived = [(source, path) for source, path in every if source.is_file()]
    if not archived:
        raise UserError(
            f"{ARCHIVE / study}: no runs are archived there; 'python -m dpd archive {study} "
            "--runs-from HOURS' keeps those that took as long or longer"
        )
    missing = [(source, path) for source, path in archived if not path.is_file()]
    for source, path in missing:
        replace_whole(path, partial(Path.write_bytes, data=source.read_bytes()))
    return [path for _, path in missing]


# Two studies: whether their error bars say how far they differ.


def table_of(name: str | Path) -> pd.DataFrame:
    """The verdicts of a study: of its figures as far as they are drawn, or of one table.

    ``name``: of a verdict table, a folder of results or of an archive, or a study. Raises
    `UserError` if there are no verdicts.
    """
    places = (Path(name), Path(results_of(str(name)).folder), ARCHIVE / str(name))
    for place in places:
        drawn = [place] if place.is_file() else sorted(place.glob("*/figures/*.csv"))
        if files := drawn or sorted(place.glob("verdicts.csv")):
            return joined(map(read_verdicts, files))
    raise UserError(
        f"{name}: no verdicts there; name a folder below results or results/archive, or a table "
        "verdicts.csv"
    )


def compared(one: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Rows that two verdict tables share, with columns of both, those of the second with ``_b``.

    ``z`` is the difference over the combined error without its systematic part, half a 95 %
    interval over 1.96, and ``likely_z`` the mean square that the degrees of freedom let expect;
    they are NaN where a row has no such error. ``flip`` is whether the verdicts differ, of rows
    with both values; ``missing`` is whether one study alone has the value.
    """
    both = one.merge(other, on=KEY, suffixes=("", "_b"), validate="one_to_one")
    there = both[["value", "value_b"]].notna().sum(axis=1)
    errors, shared, degrees = (
        both[[name, f"{name}_b"]].to_numpy(float) for name in ("error", "systematic", "degrees")
    )
    squares = errors**2 - np.nan_to_num(shared) ** 2
    known = (squares > ROUNDING * errors**2).all(axis=1)
    both["z"] = (both.value - both.value_b) / np.sqrt(np.where(known, squares.sum(axis=1), np.nan))
    both["likely_z"] = [_mean_square(pair) if k else np.nan for pair, k in zip(degrees, known)]
    both["missing"] = there == 1
    both["flip"] = (there == 2) & (both.verdict != both.verdict_b)
    return both


def _mean_square(degrees: np.ndarray) -> float:
    """Of z, of values whose errors have so many degrees of freedom; Student's t makes it < 1."""
    many = np.minimum(np.nan_to_num(degrees, nan=np.inf), MANY)
    drawn = np.random.default_rng(1).chisquare(many, (DRAWS, 2)) / many
    return float(np.mean(2 / (widening(many) ** 2 * drawn).sum(axis=1)))


def as_text(rows: pd.DataFrame) -> str:
    """What `compared` found, per paper and in all, then the rows that differ most."""
    parts = {**dict(list(rows.groupby("paper"))), "all": rows}
    table = pd.DataFrame({name: _summary(part) for name, part in parts.items()}).T
    lines = [table.to_string(), "", MEANING]
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


def _summary(rows):
    """One line of the table."""
    z = rows.z.dropna()
    rms, likely = np.sqrt((z**2).mean()), np.sqrt(rows.likely_z.mean())
    return {
        "rows": len(rows),
        "with z": len(z),
        "rms z": f"{rms:.2f} of {likely:.2f}",
        ">1.96": f"{(z.abs() > COVERAGE).mean():.1%}",
        "flips": rows.flip.sum(),
        "missing": rows.missing.sum(),
    }
