"""Digests: of values, and of source files, of some modules and of all that they import.

What counts is the syntax tree without wordings, hints and what a page refuses. In ``params`` of
rules, for Snakemake does not see the code that they call, digests make an edited kernel rerun
simulations, and an edited plot plots only; in files, they tell stages what other sources made.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from functools import cache, wraps
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from dpd.folders import PACKAGE, PAPERS_DIR, ROOT, cache_folder, paper_folder
from dpd.page import NEEDED, Observable, Start, Term, names

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
    "dpd", "dpd.folders", "dpd.errors",
    "dpd.page.own", "dpd.page", "dpd.page.base", "dpd.page.kinds",
    "dpd.runs", "dpd.runs.result",
    "dpd.scene.sections", "dpd.scene.yaml", "dpd.digests",
)  # fmt: skip
COMPILER = "dpd.jit"  # what a module with kernels imports
TEXT = re.compile(r"\w+\.\w+")  # that may name a file beside a module
OF_HINTS = ("__future__", "typing")  # modules that serve hints and the forms of records
# Of a page: what it refuses or says, and what words its settings.
REFUSES = (
    "stands", "cannot", "refuses", "conflicts", "unknown", "usual", "nowhere", "untried", "notes",
    "example", "controlled_pressure", "lammps", "not_in_lammps",
)  # fmt: skip
SETTINGS = ("setting", "Field")
WORDS = ("description", "unit", "of")


class Source(NamedTuple):
    digest: str  # of its code, and of data files beside it that are named there
    # Files of ours that it imports, at its top or in a function, with those of their packages; of a
    # user's file also those of its folder.
    imports: frozenset[Path]


def cached_on_disk(find: Callable[..., str]) -> Callable[..., str]:
    """Decorator: what a process has found is read again, in 3 ms, not parsed in some 300."""

    @cache
    @wraps(find)
    def found(*arguments: Any) -> str:
        question = text_digest(f"{find.__name__} {arguments}")
        path = cache_folder("sources") / f"{_state()}_{question}"
        with suppress(OSError):
            if len(there := path.read_text()) == len(question):
                return there
        answer = find(*arguments)
        with suppress(OSError):  # where nothing can be written, it is found each time
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(answer)
        return answer

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


@cached_on_disk
def kernel_digest() -> str:
    """Digest of all that decides what Numba compiles: modules with kernels, and their imports."""
    jit, formulas = file_of(COMPILER), PACKAGE / "physics"  # which kernels get in records
    files = PACKAGE.rglob("*.py")
    return sources_digest(f for f in files if jit in source_of(f).imports or f.parent == formulas)


def sources_digest(modules: Iterable[str | Path], without: frozenset = frozenset()) -> str:
    """Of some modules and all that they import, less what decides nothing and files ``without``.

    Raises `OSError` or `ValueError` for a user's file that cannot be read.
    """
    found = reachable(modules, without.union(map(file_of, DECIDE_NOTHING)))
    return text_digest("\n".join(sorted(f"{_place(f)} {source_of(f).digest}" for f in found)))


def files_of(path: Path) -> list[Path]:
    """A user's file, and the files of its folder that it imports, one through another."""
    own = (file for file in reachable([path]) if not _home(file))
    return sorted(own, key=lambda file: (file != path, file))


def reachable(
    modules: Iterable[str | Path], without: Collection[Path | None] = ()
) -> frozenset[Path]:
    """Files of some modules, of their packages, and of all imports that are not ``without``."""
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
    return str(path.relative_to(home.parent)) if home else path.name


def source_of(path: Path) -> Source:
    """The `Source` of a file, which may be another one by now."""
    return _parsed(path, path.read_bytes())


@cache
def _parsed(path, text):
    packages = frozenset(_files(path)) if _home(path) else frozenset()
    try:
        tree = CodeAlone().visit(ast.parse(text))
        digest = hashlib.sha256(ast.dump(tree).encode())
    except (SyntaxError, ValueError, RecursionError):  # whoever imports it says what is wrong
        return Source(hashlib.sha256(text).hexdigest(), packages)
    nodes = list(ast.walk(tree))
    texts = {node.value for node in nodes if isinstance(node, ast.Constant)}
    named = (text for text in texts if isinstance(text, str) and TEXT.fullmatch(text))
    for data in sorted(map(path.with_name, named)):
        if data.suffix != ".py" and data.is_file():
            digest.update(hashlib.sha256(data.read_bytes()).digest())
    imports = (_imported(node, path) for node in nodes)
    return Source(digest.hexdigest(), packages.union(*imports))


class CodeAlone(ast.NodeTransformer):
    """Leaves of a syntax tree what may change a number: no wording, nothing of type hints."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Whatever it is; of functions without their hints."""
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = node.body[ast.get_docstring(node, clean=False) is not None :]
        if isinstance(node, ast.FunctionDef):
            node.returns = None
        if isinstance(node, ast.arg):
            node.annotation = None
        return super().generic_visit(node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        """But for what it refuses, and why: no number hangs on that."""
        for each in list(node.body):
            of = each.targets[0] if isinstance(each, ast.Assign) else each
            if getattr(of, "id", getattr(of, "name", "")) in REFUSES:
                node.body.remove(each)
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Of settings without their words."""
        if getattr(node.func, "id", "") in SETTINGS:
            del node.args[:1]
            node.keywords = [each for each in node.keywords if each.arg not in WORDS]
        return self.generic_visit(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST | None:
        """But for modules that hints need."""
        return None if node.module in OF_HINTS else node

    def visit_If(self, node: ast.If) -> ast.AST | None:
        """But for what only a checker of types reads."""
        is_for_checkers = getattr(node.test, "id", "") == "TYPE_CHECKING"
        return None if is_for_checkers else self.generic_visit(node)


def _imported(node, path):
    """Files that an ``import`` or a ``from ... import`` reads; imports are absolute here."""
    found = []
    if isinstance(node, ast.Import):
        found = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom) and not node.level:  # what it imports may be modules
        found = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    for name in found:
        yield from _files(name) or _sibling(path, name)


def _sibling(path, module):
    """The file of a module in the folder of a user's file."""
    first = module.split(".")[0]
    if _home(path) or first in HOMES:
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
    "lammps": ("dpd.lammps.engine",),
    "collect": ("dpd.analysis.collect",),
    "calculate": ("dpd.analysis.collect",),
    "derive": ("dpd.analysis.structure",),
    "figure": ("dpd.report.figures",),
    "report": ("dpd.report.page",),
    "measure": ("benchmarks.measure",),
}
# A run uses statistics only to sum up its series, which are in its file, and to warn in words.
NOT_IN_RUNS = frozenset({PACKAGE / "analysis" / "statistics.py"})


@cached_on_disk
def stage_digest(stage: str, *files: Path) -> str:
    """Digest of the sources of a stage in `STAGES`, for any scene, and of a paper's ``files``."""
    kinds = Observable, Start, Term
    pages = [f"{kind.package}.{name}" for kind in kinds for name in names(kind)]
    running = pages if stage in ("simulate", "measure") else []
    return sources_digest((*STAGES[stage], *running, *files))


def run_sources(scene: Any) -> str:
    """Digest of the sources of a run, with those of the pages that its scene uses."""
    terms = (term for stage in scene.stages for term in stage.scene.terms.values())
    pages = [scene.start, *scene.observe.values(), *_terms_of_start(scene), *terms]
    found = _digest_of("simulate", pages)
    if "engine" not in scene.data:
        return found
    lines = [term.lammps(scene) for term in scene.terms.values()]
    return value_digest([found, _of_ours("lammps"), lines])


def start_sources(scene: Any) -> str:
    """Digest of the sources that decide a first configuration, for all scenes that share it."""
    return _digest_of("start", [scene.start, *_terms_of_start(scene)])


def kernels_name(scene: Any) -> str:
    """A name for the kernels of all scenes in which the same terms act, by their sources."""
    return _digest_of("compile", [term for term in scene.terms.values() if term.in_kernels])


def _terms_of_start(scene):
    """What acts while a first configuration is made, of what friction is that of pairs."""
    acting = scene.start_terms.values() if scene.start.acts else ()
    return [*map(scene.terms.get, NEEDED), *acting]


def calculations_file(paper: str) -> Path:
    """The file of a paper with what its sweeps of theory calculate."""
    return paper_folder(paper) / "calculations.py"


def _digest_of(stage, pages):
    """Of the sources of a stage, with those of some pages; a user's by their modules' names."""
    modules = {type(page).__module__ for page in pages}
    ours = sorted(name for name in modules if name.startswith("dpd."))
    own = sorted(name.rpartition("_")[2] for name in modules.difference(ours))
    return text_digest(" ".join([_of_ours(stage, *ours), *own]))


@cached_on_disk
def _of_ours(stage, *pages):
    return sources_digest((*STAGES[stage], *pages), unused(pages) | NOT_IN_RUNS)


def unused(pages: Iterable[str]) -> frozenset[Path | None]:
    """Files of terms other than those of what acts in a scene, and than those that they import."""
    acting = {path for page in pages if (path := file_of(page))}
    acting = acting.union(*(source_of(path).imports for path in acting))
    return frozenset(file_of(f"{Term.package}.{key}") for key in names(Term)) - acting


def value_digest(value: object) -> str:
    """Digest of a value made of plain dicts, lists, strings and numbers."""
    return text_digest(json.dumps(value, sort_keys=True))


def text_digest(text: str) -> str:
    """Twelve hexadecimal digits that differ where texts differ."""
    return hashlib.sha256(text.encode()).hexdigest()[:12]
