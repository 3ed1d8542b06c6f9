"""What decides the results of each stage: digests of its sources, for Snakemake and for files.

Snakemake compares rules, not the code that they call. A digest of the sources in a rule's
``params`` makes an edited kernel rerun simulations and an edited plot rerun plots only. The files
keep it as well, so that a stage that is called by hand refuses what other sources made.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from dpd.digest import text_digest
from dpd.page import Observable, Start, Term, module_of, names
from dpd.scene.start import start_description
from dpd.sources import file_of, kept, reachable, sources_digest

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.scene.scene import Scene

# The modules with which each stage begins; what they import is found from there.
STAGES = {
    "compile": ("dpd.scene.scene", "dpd.start.common.make"),  # what starts and runs have in common
    "start": (
        "dpd.scene.scene",
        "dpd.scene.start",
        "dpd.start.common.make",
        "dpd.start.common.files",
    ),
    "simulate": ("dpd.scene.scene", "dpd.start.common.make", "dpd.pipeline.simulate"),
    "collect": ("dpd.analysis.collect",),
    "calculate": ("dpd.pipeline.calculate",),
    "derive": ("dpd.analysis.derive", "dpd.pipeline.derived"),
    "figure": ("dpd.report.figures",),
    "report": ("dpd.report.page", "dpd.report.overhead"),
    "measure": ("dpd.benchmark.measure",),
}
# A run uses statistics only to sum up its series, which are in its file, and to warn in words.
NOT_IN_RUNS = frozenset({"dpd.analysis.statistics"})
# Pages that every run needs, and those of which no kernel gets anything.
EVERYWHERE = ("chi", "integrator", "repulsion", "shear", "thermostat")
# Terms of the physics and their pages. A page must hold nothing that a scene without its term uses.
TERMS = {key: module_of(Term, key) for key in names(Term) if key not in EVERYWHERE} | {
    "exchange": "dpd.physics.common.exchange",
    "langevin": "dpd.physics.common.langevin",
    "barostat": "dpd.engine.barostat",
}
# It lists what there is: who imports it does not need all that it names.
LISTS = frozenset({"dpd.engine.state"})


@cache
def stage_digest(stage: str) -> str:
    """Digest of the sources that decide what a stage computes, for any scene.

    Parameters
    ----------
    stage : str
        A key of `STAGES`.

    Returns
    -------
    str
        Twelve hexadecimal digits.
    """
    pages = [module_of(kind, name) for kind in (Observable, Start) for name in names(kind)]
    running = [*pages, *TERMS.values()] if stage in ("simulate", "measure") else []
    without = NOT_IN_RUNS if stage == "simulate" else ()
    return sources_digest(*STAGES[stage], *running, without=without)


def run_sources(scene: Scene) -> str:
    """Digest of the sources of a run, less those of what its scene does without.

    Those are observables and starts that it does not name, and terms of the physics that it lacks.

    Parameters
    ----------
    scene : dpd.scene.scene.Scene

    Returns
    -------
    str
        Twelve hexadecimal digits.
    """
    used = (scene.start, *scene.observe.values(), *scene.terms.values())
    pages = (type(page).__module__ for page in used)
    ours = frozenset(page for page in pages if page.startswith("dpd."))
    terms = frozenset().union(*(terms_of(stage.scene) for stage in scene.stages))
    found = _run_sources(terms, ours)
    own = sorted(scene.page_files.values())
    return text_digest(" ".join([found, *own])) if own else found


def _begins(scene):
    """The module of a scene's start; none if it is one of a user's own."""
    ours = scene.start.key in names(Start)
    return (module_of(Start, scene.start.key),) if ours else ()


@cache
def _run_sources(terms, pages):
    return kept(
        f"run {sorted(terms)} {sorted(pages)}",
        lambda: sources_digest(
            *STAGES["simulate"], *sorted(pages), without=NOT_IN_RUNS | unused_modules(terms)
        ),
    )


def start_sources(scene: Scene) -> str:
    """Digest of the sources that decide a scene's first configuration.

    It is the same for all scenes that share a start.
    """
    start = _begins(scene)
    found = _sources_with("start", start_terms(scene), start)
    own = sorted(scene.page_files.values()) if scene.has_own_forces or not start else []
    return text_digest(" ".join([found, *own])) if own else found


def kernels_name(terms: frozenset[str]) -> str:
    """A name for the kernels of all scenes in which just these terms act, by their sources.

    Where it changes, `run_sources` and `start_sources` of those scenes change as well.

    Parameters
    ----------
    terms : frozenset of str
        Keys of `TERMS`.
    """
    return text_digest(f"{sorted(terms)} {_sources_with('compile', terms, ())}")


@cache
def _sources_with(stage, terms, pages):
    return kept(
        f"{stage} {sorted(terms)} {pages}",
        lambda: sources_digest(
            *STAGES[stage],
            *pages,
            *(TERMS[name] for name in sorted(terms)),
            without=unused_modules(terms),
        ),
    )


def figure_sources(path: Path) -> str:
    """Digest of the sources of a figure: of its file, and of the stage that draws it.

    Parameters
    ----------
    path : Path
        The figure's file.
    """
    return sources_digest(*STAGES["figure"], path)


def terms_of(scene: Scene) -> frozenset[str]:
    """Names in `TERMS` of what acts in a scene."""
    unnamed = {
        "exchange": scene.terms["integrator"].exchanges,
        "langevin": scene.data["thermostat"]["kind"] == "langevin",
        "barostat": "pressure" in scene.data,
    }
    return frozenset(name for name in TERMS if unnamed.get(name, name in scene.data))


def start_terms(scene: Scene) -> frozenset[str]:
    """The same of what acts while its first configuration grows and relaxes."""
    description = start_description(scene)
    forces = {*description.get("forces", {}), *description.get("own", {})}
    return frozenset(forces).intersection(TERMS)


def unused_modules(terms: frozenset[str]) -> frozenset[str]:
    """Modules of terms that are not named, nor imported by one that is.

    Parameters
    ----------
    terms : frozenset of str
        Keys of `TERMS`.

    Returns
    -------
    frozenset of str
    """
    used = tuple(module for name, module in TERMS.items() if name in terms)
    needed = reachable(used, LISTS)
    return frozenset(module for module in TERMS.values() if file_of(module) not in needed)
