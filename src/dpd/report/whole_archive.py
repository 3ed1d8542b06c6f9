"""The archive of a long study: verdict table, figures with their numbers, and a manifest."""

from __future__ import annotations

import hashlib
import shutil
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from dpd.analysis.collect import reading
from dpd.digest import value_digest
from dpd.errors import UserError
from dpd.files import attribute, attributes, replace_whole
from dpd.pipeline.paths import LONG_STUDY, results_of
from dpd.pipeline.study import read_config, read_paper, read_study
from dpd.report.archive import ARCHIVE, archive
from dpd.report.figures import joined_verdicts
from dpd.report.provenance import commit, library_versions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.pipeline.paths import Results
    from dpd.pipeline.study import Paper

LIMIT = 10_000_000  # bytes of an archive: git keeps every version of it for ever
MANIFEST = "manifest.yaml"
KINDS = ("png", "nc")  # what is kept of a figure
DECIMALS = 3  # of core-hours
HEAD = """\
# Written by `python -m dpd archive`: what made the files beside this one. core_hours is the time of
# the runs alone; commit, machine and versions are those of the day on which the archive was made.
# `runs` is a digest of seed, scene and sources of each run of a sweep. `calculated` has the sweeps
# of theory, with a digest of the arguments of their points.
"""


@dataclass(frozen=True)
class Machine:
    """Where the archive was made: model of the processor, and cores."""

    processor: str
    cores: int


def keep(study: str, machine: Machine) -> list[Path]:
    """Keep of a study what git is to have of it: all of the long one, little of the others.

    Parameters
    ----------
    study : str
    machine : Machine

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
    return archive_whole(study, results, papers, machine)


def archive_whole(
    study: str, results: Results, papers: Sequence[Paper], machine: Machine
) -> list[Path]:
    """Keep all of a study that a reader needs, also of one that was stopped before its end.

    A figure is kept once it is drawn. The manifest says which sweeps are whole and which figures
    are missing.

    Parameters
    ----------
    study : str
    results : dpd.pipeline.paths.Results
        Of the study.
    papers : list of dpd.pipeline.study.Paper
    machine : Machine

    Returns
    -------
    list of path
        What was written.

    Raises
    ------
    UserError
        If no figure is there, or the archive would be larger than `LIMIT`. Then nothing changes.
    """
    target = ARCHIVE / study
    asked = [(paper.name, figure) for paper in papers for figure in paper.figures]
    drawn = [figure for figure in asked if _is_drawn(*figure, results)]
    if not drawn:
        raise UserError(f"{results.folder}: no figure is there to keep; let snakemake make them")
    table = joined_verdicts([results.figure(*figure, "csv") for figure in drawn])
    contents = {"verdicts.csv": table.to_csv(index=False).encode()}
    for paper, name in drawn:
        for kind in KINDS:
            source = Path(results.figure(paper, name, kind))
            contents[f"{paper}/{source.name}"] = source.read_bytes()
    missing = [f"{paper}/{name}" for paper, name in asked if (paper, name) not in drawn]
    manifest = _manifest(study, papers, results, machine, missing) | {
        "files": {name: _checksum(data) for name, data in contents.items()}
    }
    text = HEAD + yaml.safe_dump(manifest, sort_keys=False, allow_unicode=True, width=100)
    contents[MANIFEST] = text.encode()
    _check_size(target, contents)
    _remove_others(target, contents)
    for name, data in contents.items():
        replace_whole(target / name, partial(Path.write_bytes, data=data))
    return [target / name for name in contents]


def read_manifest(study: str) -> dict[str, Any]:
    """The manifest of an archived study.

    Raises
    ------
    UserError
        If there is none.
    """
    path = ARCHIVE / study / MANIFEST
    if not path.is_file():
        raise UserError(f"{path}: there is no such file; 'python -m dpd archive {study}' writes it")
    return yaml.safe_load(path.read_text())


def _is_drawn(paper, figure, results):
    """Whether all files of a figure are there."""
    return all(Path(results.figure(paper, figure, kind)).is_file() for kind in (*KINDS, "csv"))


def _manifest(study, papers, results, machine, missing):
    """What made an archive, without its files."""
    sweeps = {
        paper.name: {name: _sweep(paper.name, s, results) for name, s in paper.sweeps.items()}
        for paper in papers
    }
    calculated = {
        paper.name: {name: _theory(paper.name, s, results) for name, s in paper.theory.items()}
        for paper in papers
    }
    found = [sweep for some in sweeps.values() for sweep in some.values()]
    theory = [sweep for some in calculated.values() for sweep in some.values()]
    return {
        "study": study,
        "commit": commit(),
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": {"processor": machine.processor, "cores": machine.cores},
        "versions": library_versions(),
        "core_hours": round(sum(sweep["core_hours"] for sweep in found), DECIMALS),
        "whole": all(sweep["whole"] for sweep in (*found, *theory)) and not missing,
        "figures_missing": missing,
        "sweeps": sweeps,
        "calculated": {paper: some for paper, some in calculated.items() if some},
    }


def _sweep(paper, sweep, results):
    """What the runs of a sweep say of themselves, of those that are there."""
    runs, hours = [], 0.0
    for point in sweep.points:
        path = Path(results.run(paper, sweep.name, point.name))
        if not path.is_file():
            continue
        with reading(path):
            scene, sources = (str(attribute(path, key)) for key in ("scene_digest", "sources"))
            # A run of another scene is left from before the sweep was edited. What a scene
            # derives from other runs is not known here.
            if sweep.derived or scene == point.scene.digest:
                runs.append([point.name, int(attribute(path, "seed")), scene, sources])
                hours += float(attribute(path, "seconds")) / 3600
    scenes = [point.scene for point in sweep.points]
    return {
        "whole": len(runs) == len(scenes),
        "runs_made": len(runs),
        "runs_planned": len(scenes),
        "core_hours": round(hours, DECIMALS),
        "beads": _span([scene.beads for scene in scenes]),
        "steps_equilibrate": _span([scene.steps.equilibrate for scene in scenes]),
        "steps_sample": _span([scene.steps.sample for scene in scenes]),
        "runs": value_digest(runs) if runs else "none",
    }


def _theory(paper, sweep, results):
    """What the file of a sweep of theory says of itself, if it is there and not of other points."""
    path = Path(results.sweep(paper, sweep.name))
    said = attributes(path) if path.is_file() else {}
    whole = said.get("points") == sweep.digest
    return {
        "whole": whole,
        "calculation": sweep.calculation,
        "points": len(sweep.points),
        "sources": str(said["sources"]) if whole else "none",
        "arguments": sweep.digest,
    }


def _span(numbers):
    """A number, or the least and the largest."""
    low, high = int(min(numbers)), int(max(numbers))
    return low if low == high else [low, high]


def _checksum(data):
    return {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}


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
    """Remove figures that an earlier archive of the study had, and this one has not."""
    for kind in KINDS:
        for path in target.glob(f"*/*.{kind}"):
            if f"{path.parent.name}/{path.name}" not in contents:
                path.unlink()
    for folder in target.glob("*/"):
        if not any(folder.iterdir()):
            shutil.rmtree(folder)
