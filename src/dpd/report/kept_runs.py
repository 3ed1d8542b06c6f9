"""Long runs in an archive, so that a study that took days can go on on another machine."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from dpd import files
from dpd.analysis.collect import reading
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.paths import Results, results_of
from dpd.pipeline.study import read_config, read_paper, read_study
from dpd.report.archive import ARCHIVE
from dpd.report.manifest import hours_of
from dpd.stages import run_sources

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from dpd.pipeline.study import Paper
    from dpd.pipeline.sweep import Point


def runs_to_keep(
    target: Path, papers: Sequence[Paper], results: Results, hours: float
) -> dict[str, bytes]:
    """Runs that took long, from here or from the archive as it is.

    Parameters
    ----------
    target : path
        Folder of the archive.
    papers : list of dpd.pipeline.study.Paper
    results : dpd.pipeline.paths.Results
    hours : float
        That a run took at least.

    Returns
    -------
    dict of str to bytes
        Name in the archive, and what is in the file.
    """
    found = {}
    for paper, sweep, point in _points(papers):
        name = _name(paper, sweep, point)
        for path in (Path(results.run(paper, sweep, point.name)), target / name):
            if path.is_file() and _hours(path, point) >= hours:
                found[name] = path.read_bytes()
                break
    return found


def restore(study: str) -> list[Path]:
    """Put the runs that the archive of a study has where Snakemake looks for them.

    Parameters
    ----------
    study : str

    Returns
    -------
    list of path
        What was written. A run that is there already is left as it is.

    Raises
    ------
    UserError
        If there is no such study, its archive has no runs, or one was made by other sources or from
        another scene. Then nothing is written.
    """
    read_study(study)
    papers = [read_paper(name, study) for name in read_config()["papers"]]
    results, wanted = results_of(study), []
    for paper, sweep, point in _points(papers):
        kept = ARCHIVE / study / _name(paper, sweep, point)
        if kept.is_file():
            remedy = f"it cannot be used any more; snakemake makes it anew, after: rm '{kept}'"
            said = files.attributes(kept)
            files.check_digest(kept, said, "scene_digest", point.scene.digest, remedy)
            files.check_digest(kept, said, "sources", run_sources(point.scene), remedy)
            wanted.append((kept, Path(results.run(paper, sweep, point.name))))
    if not wanted:
        raise UserError(
            f"{ARCHIVE / study}: no runs are kept there; 'python -m dpd archive {study} "
            "--runs-from HOURS' keeps those that took as long or longer"
        )
    missing = [(kept, place) for kept, place in wanted if not place.is_file()]
    for kept, place in missing:
        replace_whole(place, partial(Path.write_bytes, data=kept.read_bytes()))
    return [place for _, place in missing]


def _points(papers: Sequence[Paper]) -> Iterator[tuple[str, str, Point]]:
    """Paper, sweep and point of all runs whose scene is known before anything has run."""
    for paper in papers:
        for sweep in paper.sweeps.values():
            if not sweep.derived:
                yield from ((paper.name, sweep.name, point) for point in sweep.points)


def _name(paper, sweep, point):
    """Of a run, in an archive."""
    return f"{paper}/runs/{sweep}/{point.name}.nc"


def _hours(path, point):
    """How long a run took; 0 if it is of another scene."""
    with reading(path):
        same = files.attribute(path, "scene_digest") == point.scene.digest
        return hours_of(path, point.scene) if same else 0.0
