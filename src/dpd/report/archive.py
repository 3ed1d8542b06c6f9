"""What git keeps of studies: tables of verdicts, which README.md and the pages of papers are made
from, and of the long study its figures with their numbers.
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

import pandas as pd
import yaml
from matplotlib import pyplot as plt
from PIL import Image

from dpd import files
from dpd.analysis.collect import load, reading
from dpd.digest import ROOT, value_digest
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.paper import read_paper
from dpd.pipeline.paths import LONG_STUDY, results_of
from dpd.pipeline.study import SEEDED, read_config, read_study
from dpd.pipeline.theory import TheorySweep
from dpd.report.figure_file import load_module
from dpd.report.figures import drawing, joined, read_verdicts, verdicts_of
from dpd.report.workflow import commit, library_versions, processor
from dpd.stages import run_sources

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from dpd.pipeline.paper import Paper
    from dpd.pipeline.paths import Results
    from dpd.pipeline.sweep import Point, Sweep
    from dpd.scene.scene import Scene

ARCHIVE = ROOT / "results" / "archive"
FIGURES = ROOT / "paper_figures"
VERDICTS, MANIFEST = "verdicts.csv", "manifest.yaml"
LIMIT = 10_000_000  # bytes of an archive: git keeps every version of it for ever
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one, and their checksums. A
# figure that is not drawn where that is called stays, while its sweeps are whole and ask for the
# same runs; `figures` names the entry of `parts` that made each. core_hours is the time of the runs
# alone; `scenes` and `arguments` are digests of what the points of a sweep simulate or calculate.
"""


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
    """Pictures of a paper's figures that git keeps, in the order of their names.

    Raises `UserError` if a picture has no figure file beside it.
    """
    found = sorted((FIGURES / paper).glob("*.png"))
    for path in found:
        if not path.with_suffix(".py").is_file():
            raise UserError(f"{path}: there is no figure file {path.stem}.py beside this picture")
    return found


def small_png(picture: Image.Image) -> bytes:
    """A file of a picture in 256 colours: it takes a third of the room and looks the same."""
    written = BytesIO()
    few = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    few.save(written, "png", optimize=True)
    return written.getvalue()


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

    ``runs_from``: hours; runs that took as long or longer are archived too, for `restore`. Returns
    what was written. Raises `UserError` if there is no figure and no run to keep, or the archive
    would be larger than `LIMIT`; then nothing changes.
    """
    target = ARCHIVE / study
    former = {"parts": {}, "figures": {}, "sweeps": {}, "calculated": {}} | manifest_of(study)
    made = {
        "commit": commit(), "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": {"processor": processor(), "cores": os.cpu_count() or 1},
        "versions": library_versions(),
    }  # fmt: skip
    part = f"{made['date']} {made['commit']}"
    contents: dict[str, bytes] = {}
    figures: dict[str, str] = {}
    tables = []
    drawn = False
    for name, new, archived, table in _figures(study, papers, results, former, part):
        drawn |= bool(new)
        figures[name] = new or former["figures"][name]
        contents |= archived
        tables.append(table)
    asked = [f"{paper.name}/{figure}" for paper in papers for figure in paper.figures]
    missing = [name for name in asked if name not in figures]
    runs = dict(_long_runs(target, papers, results, runs_from))
    if not drawn and not runs:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    contents = {VERDICTS: joined(tables).to_csv(index=False).encode()} | contents | runs
    records = {kind: _records(kind, papers, results, former[kind]) for kind in RECORDS}
    every = [one for kind in records.values() for some in kind.values() for one in some.values()]
    parts = former["parts"] | {part: made}
    manifest = {
        "study": study,
        "core_hours": round(sum(one.get("core_hours", 0) for one in every), 3),
        "whole": all(one["whole"] for one in every) and not missing,
        "parts": {name: parts[name] for name in parts if name in figures.values()},
        "figures": figures,
        "figures_missing": missing,
        **records,
        "files": {},
    }  # fmt: skip
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
    for folder in sorted(target.glob("**/"), reverse=True):
        if not any(folder.iterdir()):
            folder.rmdir()
    return write_changed(target, contents)


def _figures(study, papers, results, former, part):
    """Name, part, files and verdicts of each figure that is drawn here, or stays in its part."""
    table = read_archive(study) if former["figures"] else None
    for paper in papers:
        before = former["sweeps"].get(paper.name, {}) | former["calculated"].get(paper.name, {})
        for figure, feeds in paper.figures.items():
            name = f"{paper.name}/{figure}"
            png, numbers, verdicts = (
                Path(results.figure(paper.name, figure, kind)) for kind in ("png", "nc", "csv")
            )
            if png.is_file() and numbers.is_file() and verdicts.is_file():
                with Image.open(png) as picture:
                    small = small_png(picture)
                archived = {f"{name}.png": small, f"{name}.nc": numbers.read_bytes()}
                yield name, part, archived, read_verdicts(verdicts)
            elif name in former["figures"] and not feeds.measurements:
                sweeps = paper.sweeps | paper.theory
                records = [(before.get(each, {}), sweeps[each]) for each in feeds.sweeps]
                if all(record.get("whole") and _same(record, each) for record, each in records):
                    names = [f"{name}.png", f"{name}.nc"]
                    archived = {each: (ARCHIVE / study / each).read_bytes() for each in names}
                    rows = table[(table.paper == paper.name) & (table.figure == figure)]
                    yield name, "", archived, rows


def write_changed(target: Path, contents: dict[str, bytes]) -> list[Path]:
    """Write files into an archive, and name those that have changed."""
    changed = [
        target / name
        for name, data in contents.items()
        if not (target / name).is_file() or (target / name).read_bytes() != data
    ]
    for path in changed:
        data = contents[str(path.relative_to(target))]
        replace_whole(path, partial(Path.write_bytes, data=data))
    return changed


def _asks(sweep: Sweep | TheorySweep) -> str:
    """Digest of what the points of a sweep simulate or calculate."""
    if isinstance(sweep, TheorySweep):
        return sweep.digest
    return value_digest([[point.name, sweep.planned_digest(point)] for point in sweep.points])


def _same(record, sweep):
    """Whether a record is of what a sweep asks for."""
    return _asks(sweep) in (record.get("scenes"), record.get("arguments"))


def _records(kind, papers, results, former):
    """What is known of each sweep: from its runs here, or from more runs of it elsewhere."""
    found = {}
    for paper in papers:
        for name, sweep in (paper.sweeps if kind == "sweeps" else paper.theory).items():
            record, here = RECORDS[kind](paper.name, sweep, results)
            before = former.get(paper.name, {}).get(name)
            if before and _same(before, sweep) and before.get("runs_made", before["whole"]) > here:
                record = before
            found.setdefault(paper.name, {})[name] = record
    return found


def _sweep_record(paper, sweep, results):
    """What is known of a sweep, and how many of its runs are here."""
    hours = []
    for point in sweep.points:
        path = Path(results.run(paper, sweep.name, point.name))
        # A run of another scene is left from before the sweep was edited. What a scene derives from
        # other runs is not known here.
        if path.is_file():
            with reading(path):
                same = str(files.attribute(path, "scene_digest")) == point.scene.digest
                if sweep.derived or same:
                    hours.append(hours_of(path, point.scene))
    record = {
        "whole": len(hours) == len(sweep.points),
        "runs_made": len(hours),
        "runs_planned": len(sweep.points),
        "core_hours": round(sum(hours), 3),
        "scenes": _asks(sweep),
    }
    return record, len(hours)


def _theory_record(paper, sweep, results):
    """The same of a sweep of theory, whose file is not that of other points."""
    path = Path(results.sweep(paper, sweep.name))
    said = files.attributes(path) if path.is_file() else {}
    whole = said.get("points") == sweep.digest
    record = {"whole": whole, "points": len(sweep.points), "arguments": _asks(sweep)}
    return record, whole


RECORDS = {"sweeps": _sweep_record, "calculated": _theory_record}


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
        drawn, whole = drawing(module, data), BytesIO()
        drawn.savefig(whole, format="png")
        plt.close(drawn)
        with Image.open(whole) as picture:
            contents[f"{name}.png"] = small_png(picture)
        tables.append(verdicts_of(module, paper, figure, data))
    contents[VERDICTS] = joined(tables).to_csv(index=False).encode()
    contents[MANIFEST] = manifest_text(manifest, contents).encode()
    return write_changed(target, contents)


# Long runs, so that a study that took days can go on on another machine.


def hours_of(path: Path, scene: Scene) -> float:
    """How long a run took; of one that was stopped and went on, all its steps at its last rate."""
    said = files.attributes(path)
    since_it_went_on = float(said["seconds"])
    if int(said["lost_step"]) >= 0:
        return since_it_went_on / 3600
    return max(since_it_went_on, scene.work / float(said["bead_steps_per_second"])) / 3600


def _points(papers: Sequence[Paper]) -> Iterator[tuple[str, str, Point, str]]:
    """Paper, sweep, point, and name in an archive, of runs whose scene is known before any."""
    for paper in papers:
        for sweep in paper.sweeps.values():
            for point in () if sweep.derived else sweep.points:
                name = f"{paper.name}/runs/{sweep.name}/{point.name}.nc"
                yield paper.name, sweep.name, point, name


def _long_runs(target, papers, results, hours):
    """Name in the archive and content of runs that took long, from here or from the archive."""
    for paper, sweep, point, name in _points(papers) if hours < math.inf else ():
        for path in (Path(results.run(paper, sweep, point.name)), target / name):
            if path.is_file():
                with reading(path):
                    same = files.attribute(path, "scene_digest") == point.scene.digest
                if same and hours_of(path, point.scene) >= hours:
                    yield name, path.read_bytes()
                    break


def restore(study: str) -> list[Path]:
    """Put the runs that the archive of a study has where Snakemake looks for them.

    Result: what was written; a run that is there already is left as it is. Raises `UserError` if
    there is no such study, its archive has no runs, or one was made by other sources or from
    another scene; then nothing is written.
    """
    read_study(study)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    results, wanted = results_of(study), []
    for paper, sweep, point, name in _points(papers):
        archived = ARCHIVE / study / name
        if archived.is_file():
            remedy = f"it cannot be used any more; snakemake makes it anew, after: rm '{archived}'"
            said = files.attributes(archived)
            files.check_digest(archived, said, "scene_digest", point.scene.digest, remedy)
            files.check_digest(archived, said, "sources", run_sources(point.scene), remedy)
            wanted.append((archived, Path(results.run(paper, sweep, point.name))))
    if not wanted:
        raise UserError(
            f"{ARCHIVE / study}: no runs are archived there; 'python -m dpd archive {study} "
            "--runs-from HOURS' keeps those that took as long or longer"
        )
    missing = [(archived, place) for archived, place in wanted if not place.is_file()]
    for archived, place in missing:
        replace_whole(place, partial(Path.write_bytes, data=archived.read_bytes()))
    return [place for _, place in missing]
