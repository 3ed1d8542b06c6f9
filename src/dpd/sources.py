"""Digests of source files: of some modules and of all that they import, and of a user's pages.

Nothing is imported here to find that out: files are parsed. What counts of a file is its syntax
tree without comments, docstrings, type hints of functions, descriptions of settings, what a page
refuses and line numbers, so that a wording changes no digest. The folder of Numba's compiled
kernels is named after such a digest as well: from the same tree it compiles the same code.

Snakemake compares rules, not the code that they call. A digest of the sources in a rule's
``params`` makes an edited kernel rerun simulations and an edited plot rerun plots only. The files
keep it as well, so that a stage that is called by hand refuses what other sources made.
"""

from __future__ import annotations

import ast
import hashlib
import os
import re
from contextlib import suppress
from functools import cache
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.digest import (
    PACKAGE,
    PAPERS_DIR,
    ROOT,
    cache_folder,
    paper_folder,
    text_digest,
    value_digest,
)  # fmt: skip
from dpd.page import NEEDED, Observable, Start, Term, find, module_of, names

if TYPE_CHECKING:
    from collections.abc import Callable


# The packages that are followed, with their folders: `dpd` itself, the figures of papers, and of a
# clone the benchmarks.
HOMES: dict[str, tuple[Path, ...]] = {
    "dpd": (PACKAGE,), "paper_figures": (ROOT / "paper_figures",)
}  # fmt: skip
if PAPERS_DIR is not None:
    HOMES["paper_figures"] += (PAPERS_DIR,)
if (ROOT / "benchmarks" / "measure.py").is_file():
    HOMES["benchmarks"] = (ROOT / "benchmarks",)
# Modules that decide no number and no picture, whoever imports them. They check input and word
# messages, and what they fill in stands in a scene's own digest (defaults, a scheme chosen); or
# they show progress, tidy up, make these digests, or keep the end of a run beside what it measured.
# `dpd` itself only hands on what others make.
DECIDE_NOTHING = (
    "dpd", "dpd.digest", "dpd.errors",
    "dpd.own", "dpd.page", "dpd.page.base", "dpd.page.kinds",
    "dpd.physics.common.automatic",
    "dpd.runs", "dpd.runs.result",
    "dpd.scene.sections", "dpd.scene.yaml", "dpd.sources",
)  # fmt: skip
COMPILER = "dpd.jit"  # what a module with kernels imports
TEXT = re.compile(r"\w+\.\w+")  # that may name a file beside a module
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
IMPORTS = (ast.Import, ast.ImportFrom)
HINTS = {ast.FunctionDef: "returns", ast.AsyncFunctionDef: "returns", ast.arg: "annotation"}
OF_HINTS = ("__future__", "typing")  # modules that serve hints and the forms of records
# Of a page: what it refuses or says, and what words its settings.
REFUSES = (
    "stands", "cannot", "refuses", "conflicts", "unknown", "untried", "notes", "caption", "example",
    "controlled_pressure",
)  # fmt: skip
SETTINGS = ("setting", "interval_setting", "Field")
WORDS = ("description", "unit", "of")


class Source(NamedTuple):
    """What counts of a source file."""

    digest: str  # of its code, and of data files beside it that are named there
    # Files of ours that it imports, at its top or in a function, with those of their packages; of a
    # user's file also those of its folder.
    imports: frozenset[Path]


@cache
def sources_digest(*modules: str | Path, without: frozenset[Path] = frozenset()) -> str:
    """Digest of some modules, by name or file, and of all that they import: twelve hex digits.

    Files ``without`` which it is are left out, with what they alone import.
    """

    def find():
        found = reachable(modules, without.union(filter(None, map(file_of, DECIDE_NOTHING))))
        lines = sorted(f"{_place(path)} {source_of(path).digest}" for path in found)
        return text_digest("\n".join(lines))

    return cached(f"{modules} {sorted(without)}", find)


def page_digest(path: Path) -> str:
    """Digest of a user's file, of those of its folder that it imports, and of what they import.

    Raises `OSError` or `ValueError` if one cannot be read, or a folder is imported.
    """
    own = files_of(path)
    ours = {file for each in own for file in source_of(each).imports if _home(file)}
    lines = sorted(f"{each.name} {source_of(each).digest}" for each in own)
    return text_digest(" ".join([*lines, sources_digest(*sorted(ours))]))


def files_of(path: Path) -> list[Path]:
    """A user's file, and the files of its folder that it imports, one through another."""
    found = [path]
    for each in found:  # which grows
        imports = sorted(source_of(each).imports)
        found += [file for file in imports if not _home(file) and file not in found]
    return found


@cache
def kernel_digest() -> str:
    """Digest of all that decides what Numba compiles: modules with kernels, and their imports."""

    def find():
        jit, files = file_of(COMPILER), sorted(PACKAGE.rglob("*.py"))
        formulas = PACKAGE / "physics"  # which kernels get in records
        kernels = (f for f in files if jit in source_of(f).imports or f.parent == formulas)
        return sources_digest(*kernels)

    return cached("kernels", find)


def cached(question: str, find: Callable[[], str]) -> str:
    """What another process has found for the same sources; otherwise find it, and keep it.

    To parse all sources takes a tenth of a second, which each of a study's hundreds of jobs would
    spend; to read them, and what is kept, takes three thousandths.
    """
    path = cache_folder("sources") / f"{_state()}_{text_digest(question)}"
    with suppress(OSError):
        if len(found := path.read_text()) == len(_state()):
            return found
    found = find()
    with suppress(OSError):  # where nothing can be kept, it is found each time
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(found)
    return found


@cache
def _state():
    """Digest of all files of our packages, byte by byte."""
    total = hashlib.sha256()
    for home in chain(*HOMES.values()):
        for folder, folders, inside in os.walk(home):
            folders[:] = sorted(each for each in folders if each[0] not in "._")
            for path in (Path(folder, name) for name in sorted(inside)):
                total.update(f"{path} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()[:12]


@cache
def reachable(
    modules: tuple[str | Path, ...], without: frozenset[Path] = frozenset()
) -> frozenset[Path]:
    """Files of some modules, of all that they import, and of the packages that these are in.

    Those ``without`` are not followed.
    """
    waiting = [path for module in modules for path in _files(module)]
    found = set()
    while waiting:
        path = waiting.pop()
        if path not in found and path not in without:
            found.add(path)
            waiting += source_of(path).imports
    return frozenset(found)


@cache
def file_of(name: str) -> Path | None:
    """The file of a module of ours; None for other modules, and for folders that are no package."""
    first, *rest = name.split(".")
    places = [home.joinpath(*rest) for home in HOMES.get(first, ())]
    files = (file for each in places for file in (Path(f"{each}.py"), each / "__init__.py"))
    return next((file for file in files if file.is_file()), None)


@cache
def _files(module):
    """Files that are read when a module is imported: its own, and those of its packages."""
    path = module if isinstance(module, Path) else file_of(module)
    if path is None:
        return ()
    packages = (folder / "__init__.py" for folder in path.parents if _home(folder))
    return (path, *(package for package in packages if package.is_file()))


def _home(path):
    """The folder of the package of ours that a file is in; None for a user's."""
    return next((each for each in chain(*HOMES.values()) if path.is_relative_to(each)), None)


def _place(path):
    """What a file is called in digests, wherever it lies: installed sources have the same."""
    home = _home(path)
    return str(path.relative_to(home.parent) if home else path)


def source_of(path: Path) -> Source:
    """The `Source` of a file, which may be another one by now."""
    return _parsed(path, path.read_bytes())


@cache
def _parsed(path, text):
    packages = frozenset(_files(path)) if _home(path) else frozenset()
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):  # whoever imports it says what is wrong
        return Source(hashlib.sha256(text).hexdigest(), packages)
    digest, imports, texts = _read(tree)
    for data in sorted(path.with_name(text) for text in texts):
        if data.suffix != ".py" and data.is_file():
            digest.update(hashlib.sha256(data.read_bytes()).digest())
    return Source(digest.hexdigest(), packages.union(*(_imported(node, path) for node in imports)))


def _read(tree):
    """Digest of a tree less docstrings, hints and places in the file; its imports; texts in it.

    `ast.dump` would be slower than to parse.
    """
    parts, imports, texts, waiting = [], [], set(), [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.AST):
            parts.append(type(node).__name__)
            fields = {field: getattr(node, field, None) for field in node._fields}
            fields.pop(HINTS.get(type(node)), None)
            if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
                fields["body"] = node.body[1:]
            if isinstance(node, ast.ClassDef):
                fields["body"] = [item for item in fields["body"] if not _refuses(item)]
            elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in SETTINGS:
                fields["args"] = node.args[1:]
                fields["keywords"] = [each for each in node.keywords if each.arg not in WORDS]
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts |= {node.value} if TEXT.fullmatch(node.value) else set()
            elif isinstance(node, IMPORTS):
                imports.append(node)
            waiting += fields.values()
        elif isinstance(node, list):
            counting = [item for item in node if not _serves_hints(item)]
            parts.append(len(counting))
            waiting += counting
        else:
            parts.append(node)
    return hashlib.sha256(repr(parts).encode("utf-8", "backslashreplace")), imports, texts


def _serves_hints(node):
    """Whether a node is there for type hints alone: an import of `typing`, or for a checker."""
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.ImportFrom) and node.module in OF_HINTS


def _refuses(node):
    """Whether a node of a class says what may be asked of a page: no number hangs on that."""
    if isinstance(node, ast.Assign):
        return getattr(node.targets[0], "id", "") in REFUSES
    return isinstance(node, ast.FunctionDef) and node.name in REFUSES


def _imported(node, path):
    """Files that an ``import`` or a ``from ... import`` reads."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield from _files(alias.name) or _sibling(path, alias.name)
        return
    if node.level:  # imports are absolute here
        return
    if node.module.split(".")[0] not in HOMES:
        yield from _sibling(path, node.module)
        return
    yield from _files(node.module)
    module = file_of(node.module)
    if module is None or module.name == "__init__.py":  # what is imported may be modules in it
        for alias in node.names:
            yield from _files(f"{node.module}.{alias.name}")


def _sibling(path, module):
    """The file of a module in the folder of a user's file."""
    first = module.split(".")[0]
    if _home(path):
        return ()
    if (path.parent / first / "__init__.py").is_file():
        raise ValueError(f"it imports the folder {first!r}; beside a page stand files alone")
    file = path.parent / f"{first}.py"
    return (file,) if file.is_file() else ()


# --- what decides the results of each stage

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


def run_sources(scene: Any) -> str:
    """Digest of the sources of a run: of its rooms, and of the pages that its scene uses."""
    pages = {type(page).__module__ for page in (scene.start, *scene.observe.values())}
    pages |= _terms_of_start(scene)
    return _digest_of("simulate", pages.union(*(_terms(stage.scene) for stage in scene.stages)))


def start_sources(scene: Any) -> str:
    """Digest of the sources that decide a scene's first configuration.

    It is the same for all scenes that share a start.
    """
    return _digest_of("start", {type(scene.start).__module__} | _terms_of_start(scene))


def kernels_name(scene: Any) -> str:
    """A name for the kernels of all scenes in which the same terms act, by their sources.

    Where it changes, `run_sources` of those scenes change as well.
    """
    return _digest_of("compile", _terms(scene, of_kernels=True))


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
