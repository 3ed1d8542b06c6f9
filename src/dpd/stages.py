"""What decides the results of each stage: digests of its sources, for Snakemake and for files.

Snakemake compares rules, not the code that they call. A digest of the sources in a rule's
``params`` makes an edited kernel rerun simulations and an edited plot rerun plots only. The files
keep it as well, so that a stage that is called by hand refuses what other sources made.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from dpd.digest import paper_folder, text_digest, value_digest
from dpd.page import Observable, Start, Term, find, module_of, names
from dpd.scene.reading import NEEDED
from dpd.sources import PACKAGE, cached, file_of, source_of, sources_digest

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.scene.scene import Scene

# The modules with which each stage begins; what they import is found from there.
STAGES = {
    "compile": ("dpd.scene.scene", "dpd.start.common.make"),  # what starts and runs have in common
    "start": ("dpd.scene.scene", "dpd.start.common.files"),
    "simulate": ("dpd.scene.scene", "dpd.start.common.make", "dpd.runs.run"),
    "collect": ("dpd.analysis.collect",),
    "calculate": ("dpd.pipeline.theory",),
    "derive": ("dpd.analysis.structure", "dpd.pipeline.sweep"),
    "figure": ("dpd.report.figures",),
    "report": ("dpd.report.page",),
    "measure": ("benchmarks.measure",),
}
# A run uses statistics only to sum up its series, which are in its file, and to warn in words.
NOT_IN_RUNS = frozenset({PACKAGE / "analysis" / "statistics.py"})


@cache
def stage_digest(stage: str) -> str:
    """Digest of the sources that decide what a stage, a key of `STAGES`, computes for any scene."""
    pages = [module_of(kind, name) for kind in (Observable, Start, Term) for name in names(kind)]
    running = pages if stage in ("simulate", "measure") else []
    without = NOT_IN_RUNS if stage == "simulate" else frozenset()
    return sources_digest(*STAGES[stage], *running, without=without)


def run_sources(scene: Scene) -> str:
    """Digest of the sources of a run: of its rooms, and of the pages that its scene uses."""
    pages = {type(page).__module__ for page in (scene.start, *scene.observe.values())}
    return _digest_of("simulate", pages.union(*(_terms(stage.scene) for stage in scene.stages)))


def start_sources(scene: Scene) -> str:
    """Digest of the sources that decide a scene's first configuration.

    It is the same for all scenes that share a start.
    """
    return _digest_of("start", {type(scene.start).__module__} | _terms_of_start(scene))


def kernels_name(scene: Scene, of_start: bool = False) -> str:
    """A name for the kernels of all scenes in which the same terms act, by their sources.

    Where it changes, `run_sources` and `start_sources` of those scenes change as well.
    ``of_start``: what acts while its first configuration grows and relaxes counts.
    """
    terms = _terms_of_start(scene) if of_start else _terms(scene, of_kernels=True)
    return _digest_of("compile", terms)


def figure_sources(path: Path) -> str:
    """Digest of the sources of a figure: of its file, of the stage that draws it, of captions."""
    captions = {key: find(Term, key).caption for key in names(Term)}  # no part of a run's sources
    return f"{sources_digest(*STAGES['figure'], path)} {value_digest(captions)}"


def calculations_file(paper: str) -> Path:
    """The file of a paper with what its sweeps of theory calculate."""
    return paper_folder(paper) / "calculations.py"


def calculation_sources(paper: str) -> str:
    """Digest of the sources of a paper's calculations, and of the stage that makes them."""
    return sources_digest(*STAGES["calculate"], calculations_file(paper))


def _terms(scene, of_kernels=False):
    """Modules of all that acts in a scene, or of what its kernels know."""
    terms = [term for term in scene.terms.values() if term.in_kernels or not of_kernels]
    return {type(term).__module__ for term in terms}


def _terms_of_start(scene):
    """The same while its first configuration is made: friction is that of pairs."""
    acting = scene.start_terms.values() if scene.start.acts else ()
    return {type(term).__module__ for term in (*map(scene.terms.get, NEEDED), *acting)}


def _digest_of(stage, pages):
    """Of the sources of a stage, with those of some pages; a user's by their modules' names."""
    ours = frozenset(page for page in pages if page.startswith("dpd."))
    own = sorted(page.rpartition("_")[2] for page in pages - ours)
    found = _of_ours(stage, ours)
    return text_digest(" ".join([found, *own])) if own else found


@cache
def _of_ours(stage, pages):
    return cached(
        f"{stage} {sorted(pages)}",
        lambda: sources_digest(*STAGES[stage], *sorted(pages), without=unused(pages) | NOT_IN_RUNS),
    )


def unused(pages: frozenset[str]) -> frozenset[Path]:
    """Files of terms other than those of what acts in a scene, and than those that they import."""
    acting = {path for page in pages if (path := file_of(page))}
    acting = acting.union(*(source_of(path).imports for path in acting))
    return frozenset(Term.folder / f"{key}.py" for key in names(Term)) - acting
