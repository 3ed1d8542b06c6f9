"""The archive of a long study: verdict table, figures with their numbers, and a manifest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.paths import LONG_STUDY, results_of
from dpd.pipeline.study import read_config, read_paper, read_study
from dpd.report.archive import ARCHIVE, archive, in_few_colours, read_archive
from dpd.report.figures import joined, verdict_table
from dpd.report.kept_runs import runs_to_keep
from dpd.report.manifest import (
    DECIMALS,
    MANIFEST,
    asks_for,
    checksum,
    manifest_of,
    manifest_text,
    new_part,
    runs_made,
    sweep_record,
    theory_record,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from dpd.pipeline.paths import Results
    from dpd.pipeline.study import Paper
    from dpd.report.manifest import Machine

LIMIT = 10_000_000  # bytes of an archive: git keeps every version of it for ever
KINDS = ("png", "nc")  # what is kept of a figure
VERDICTS = "verdicts.csv"


@dataclass(frozen=True)
class Kept:
    """A figure in an archive: its files, its rows of the verdict table, the part that made it."""

    files: Sequence[Path]
    verdicts: pd.DataFrame
    part: str


def keep(study: str, machine: Machine, runs_from: float = math.inf) -> list[Path]:
    """Keep of a study what git is to have of it: all of the long one, little of the others.

    Parameters
    ----------
    study : str
    machine : Machine
    runs_from : float
        Hours, see `archive_whole`.

    Returns
    -------
    list of path
        What was written.

    Raises
    ------
    UserError
        As `dpd.report.archive.archive` and `archive_whole` do.
    """
    read_study(study)  # a name that is none would lead elsewhere
    results = results_of(study)
    if study != LONG_STUDY:
        return archive(study, results)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    return archive_whole(study, results, papers, machine, runs_from)


def archive_whole(
    study: str, results: Results, papers: Sequence[Paper], machine: Machine,
    runs_from: float = math.inf,
) -> list[Path]:  # fmt: skip
    """Keep all of a study that a reader needs, also of one that was stopped before its end.

    A figure is kept once it is drawn. One that is not drawn here, as its runs were made elsewhere,
    stays as the archive has it, while all its sweeps ask for the same runs. The manifest says which
    sweeps are whole, which figures are missing, and what made each.

    Parameters
    ----------
    study : str
    results : dpd.pipeline.paths.Results
        Of the study.
    papers : list of dpd.pipeline.study.Paper
    machine : Machine
    runs_from : float
        Hours. Runs that took as long or longer are kept too, so that the study can go on elsewhere:
        see `dpd.report.kept_runs`.

    Returns
    -------
    list of path
        What was written.

    Raises
    ------
    UserError
        If there is no figure and no run to keep, or the archive would be larger than `LIMIT`. Then
        nothing changes.
    """
    target = ARCHIVE / study
    former = _former(study)
    part, made = new_part(machine)
    records = _records(papers, results, former, part)
    drawn = dict(_drawn(papers, results, part))
    runs = runs_to_keep(target, papers, results, runs_from)
    if not drawn and not runs:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    found = dict(_staying(study, papers, former, records)) | drawn
    asked = [f"{paper.name}/{figure}" for paper in papers for figure in paper.figures]
    figures = {name: found[name] for name in asked if name in found}
    missing = [name for name in asked if name not in found]
    table = joined(kept.verdicts for kept in figures.values())
    contents = {VERDICTS: table.to_csv(index=False).encode()}
    for name, kept in figures.items():
        contents |= {f"{name}{path.suffix}": _in_archive(path) for path in kept.files}
    contents |= runs
    manifest = _manifest(study, figures, missing, records, former["parts"] | {part: made})
    manifest["files"] = {name: checksum(data) for name, data in contents.items()}
    contents[MANIFEST] = manifest_text(manifest).encode()
    _check_size(target, contents)
    _remove_others(target, contents)
    for name, data in contents.items():
        replace_whole(target / name, partial(Path.write_bytes, data=data))
    return [target / name for name in contents]


def _in_archive(path):
    """What is kept of a file: a picture in few colours, anything else as it is."""
    if path.suffix != ".png":
        return path.read_bytes()
    with Image.open(path) as drawn:
        if drawn.mode == "P":  # it is from the archive
            return path.read_bytes()
        return small_png(drawn)


def small_png(picture: Image.Image) -> bytes:
    """A file of a picture as the archive keeps it."""
    kept = BytesIO()
    in_few_colours(picture).save(kept, "png", optimize=True)
    return kept.getvalue()


def _former(study):
    """The manifest of the archive as it is; an empty one where there is none."""
    empty = {"parts": {}, "figures": {}, "sweeps": {}, "calculated": {}}
    return empty | manifest_of(study)


def _records(papers, results, former, part):
    """What is known of each sweep: from its runs here, or from more runs of it elsewhere."""
    found = {"sweeps": {}, "calculated": {}}
    for paper in papers:
        here = {name: sweep_record(paper.name, s, results) for name, s in paper.sweeps.items()}
        theory = {name: theory_record(paper.name, s, results) for name, s in paper.theory.items()}
        for kind, records in (("sweeps", here), ("calculated", theory)):
            before = former[kind].get(paper.name, {})
            found[kind][paper.name] = {
                name: _fuller(record, part, before.get(name)) for name, record in records.items()
            }
    return found


def _fuller(here, part, before):
    """Of two records of a sweep, the one with more runs; with the part that made them."""
    if before and asks_for(before) == asks_for(here) and runs_made(before) > runs_made(here):
        return before
    return here | {"part": part} if runs_made(here) else here


def _drawn(papers, results, part):
    """Name of each figure of which all files are here, and what is kept of it."""
    for paper in papers:
        for figure in paper.figures:
            files = [Path(results.figure(paper.name, figure, kind)) for kind in (*KINDS, "csv")]
            if all(path.is_file() for path in files):
                *kept, verdicts = files
                yield f"{paper.name}/{figure}", Kept(kept, verdict_table(verdicts), part)


def _staying(study, papers, former, records):
    """The same of the former archive, where sweeps are whole and still ask for the same runs."""
    if not former["figures"]:
        return
    table = read_archive(study)
    for paper in papers:
        before, now = _sweeps_of(former, paper), _sweeps_of(records, paper)
        for figure, feeds in paper.figures.items():
            name = f"{paper.name}/{figure}"
            if name not in former["figures"] or feeds.measurements:
                continue
            if all(_still_whole(before.get(sweep), now[sweep]) for sweep in feeds.sweeps):
                rows = table[(table.paper == paper.name) & (table.figure == figure)]
                kept = [ARCHIVE / study / f"{name}.{kind}" for kind in KINDS]
                yield name, Kept(kept, rows, former["figures"][name])


def _sweeps_of(manifest, paper):
    """Records of the sweeps of a paper, simulated and calculated ones."""
    return manifest["sweeps"].get(paper.name, {}) | manifest["calculated"].get(paper.name, {})


def _still_whole(before, now):
    """Whether a sweep was whole, and is what it was."""
    return before is not None and before["whole"] and asks_for(before) == asks_for(now)


def _manifest(study, figures, missing, records, parts):
    """What made an archive, without its files."""
    sweeps = [sweep for some in records["sweeps"].values() for sweep in some.values()]
    theory = [sweep for some in records["calculated"].values() for sweep in some.values()]
    used = {kept.part for kept in figures.values()}
    used |= {record["part"] for record in (*sweeps, *theory) if "part" in record}
    return {
        "study": study,
        "core_hours": round(sum(sweep["core_hours"] for sweep in sweeps), DECIMALS),
        "whole": all(sweep["whole"] for sweep in (*sweeps, *theory)) and not missing,
        "parts": {name: made for name, made in parts.items() if name in used},
        "figures": {name: kept.part for name, kept in figures.items()},
        "figures_missing": missing,
        "sweeps": records["sweeps"],
        "calculated": {paper: some for paper, some in records["calculated"].items() if some},
    }


def _check_size(target, contents):
    """Refuse an archive that git should not carry."""
    size = sum(len(data) for data in contents.values())
    if size > LIMIT:
        largest = max(contents, key=lambda name: len(contents[name]))
        raise UserError(
            f"{target}: the archive would have {size / 1e6:.1f} MB, and at most {LIMIT / 1e6:g} MB "
            f"are allowed, because git keeps every version; the largest file is {largest} with "
            f"{len(contents[largest]) / 1e6:.1f} MB: let that figure keep or draw less"
        )


def _remove_others(target, contents):
    """Remove what an earlier archive of the study had, and this one has not."""
    for path in target.rglob("*"):
        if path.is_file() and str(path.relative_to(target)) not in contents:
            path.unlink()
    for folder in sorted(target.glob("**/"), reverse=True):
        if not any(folder.iterdir()):
            folder.rmdir()
