"""What a study makes beside its runs, and from which files.

Snakemake's rules ask for it, and what looks at a study from outside.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.scene.start import start_digest, start_is_shared
from dpd.stages import kernels_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from dpd.pipeline.paths import Results
    from dpd.pipeline.study import Figure, Paper
    from dpd.pipeline.sweep import Point, Sweep


def waiting_for_starts(paper: Paper) -> dict[str, list[tuple[str, Point]]]:
    """Digest of each start to the (name of a sweep, point) pairs that need it, in order."""
    waiting: dict[str, list[tuple[str, Point]]] = {}
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            if start_is_shared(point.scene):
                waiting.setdefault(start_digest(point.scene), []).append((sweep.name, point))
    return waiting


def kernels_for(paper: Paper) -> list[str]:
    """Names of the kernels of all runs, and of starts that are shared."""
    scenes = [point.scene for sweep in paper.sweeps.values() for point in sweep.points]
    shared = (scene for scene in scenes if start_is_shared(scene))
    of_runs = {kernels_name(scene) for scene in scenes}
    return sorted(of_runs.union(kernels_name(scene, of_start=True) for scene in shared))


def derived_from(results: Results, paper: str, sweep: Sweep) -> list[str]:
    """The sweeps that measure values for a sweep."""
    sources = {rule.source for rule in sweep.derived}
    return [results.sweep(paper, source) for source in sorted(sources)]


def data_of_figure(results: Results, paper: str, figure: Figure) -> list[str]:
    """Sweeps and measurements that feed a figure."""
    return [results.sweep(paper, name) for name in figure.sweeps] + [
        results.measurement(paper, name) for name in figure.measurements
    ]


def verdicts_of(results: Results, papers: Iterable[Paper]) -> list[str]:
    """Verdict tables of all figures of some papers."""
    return [results.figure(paper.name, f, "csv") for paper in papers for f in paper.figures]


def page_sources(results: Results, papers: Iterable[Paper]) -> list[str]:
    """All that a page on some papers is made from."""
    papers = list(papers)
    files = verdicts_of(results, papers)
    for paper in papers:
        for figure in paper.figures:
            files += [results.figure(paper.name, figure, kind) for kind in ("png", "html", "nc")]
        files += [results.sweep(paper.name, sweep) for sweep in (*paper.sweeps, *paper.theory)]
        files += [results.measurement(paper.name, name) for name in paper.measurements]
    return files
