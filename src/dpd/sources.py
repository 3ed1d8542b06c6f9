"""Digests of source files: of some modules and of all that they import.

Nothing is imported here to find that out: files are parsed. What counts of a file is its syntax
tree without comments, docstrings, type hints of functions, what a page refuses and line numbers,
so that a wording changes no digest. The folder of Numba's compiled kernels is named after such a
digest as well: from the same tree it compiles the same code.
"""

from __future__ import annotations

import ast
import gc
import hashlib
import os
import shutil
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.digest import PACKAGE, ROOT, cache_folder, text_digest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

# The packages that are followed: `dpd` itself, and the figures of papers.
HOMES = {"dpd": PACKAGE, "paper_figures": ROOT / "paper_figures"}
# What their files are called in digests, wherever they lie: installed sources have the same.
PLACES = {"dpd": "src/dpd"}
# Modules that decide no number and no picture, whoever imports them. They check input and word
# messages, and what they fill in stands in a scene's own digest (defaults, a scheme chosen); or
# they show progress, tidy up, make these digests, or keep the end of a run beside what it measured.
# `dpd` itself only hands on what others make.
DECIDE_NOTHING = (
    "dpd", "dpd.compiling", "dpd.digest", "dpd.drafts", "dpd.errors", "dpd.interrupts",
    "dpd.own", "dpd.page", "dpd.pipeline.kept", "dpd.pipeline.sections",
    "dpd.physics.common.automatic", "dpd.progress", "dpd.scene.changes",
    "dpd.scene.limits", "dpd.scene.sections", "dpd.scene.yaml", "dpd.sentences", "dpd.sources",
    "dpd.stages", "dpd.streams",
)  # fmt: skip
COMPILER = "dpd.jit"  # what a module with kernels imports
# Kernels of the benchmark are compiled into folders of their own.
OWN_KERNELS = PACKAGE / "benchmark"
DATA = "DATA_FILES"  # name of the list, in a module, of files beside it that it reads
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
IMPORTS = (ast.Import, ast.ImportFrom)
HINTS = {ast.FunctionDef: "returns", ast.AsyncFunctionDef: "returns", ast.arg: "annotation"}
OF_HINTS = ("__future__", "typing")  # modules that serve hints and the forms of records
# Of a page: what it refuses, and settings, whose values stand in a scene's own digest.
SAYS_WHAT_NOT = ("stands", "cannot")
REFUSES = ("refuses", "conflicts", "unknown", "untried", "notes", "held")
SETTINGS = ("setting", "interval_setting", "Field")
MOST_KEPT = 40  # states of the sources for which digests are kept


class Source(NamedTuple):
    """What counts of a source file.

    Attributes
    ----------
    digest : str
        Of its code, and of the data files that it names in ``DATA_FILES``.
    imports : frozenset of Path
        Files of ours that it imports, at its top or in a function, with those of their packages.
    """

    digest: str
    imports: frozenset


def sources_digest(*modules: str | Path, without: Collection[str] = ()) -> str:
    """Digest of the sources of some modules and of all that they import.

    Parameters
    ----------
    modules : str or Path
        Names, as ``dpd.pipeline.simulate``, or files.
    without : collection of str
        Names of modules that are left out, with what they alone import.

    Returns
    -------
    str
        Twelve hexadecimal digits.
    """
    return _digest_of(modules, frozenset(without))


@cache
def _digest_of(modules, without):
    def find():
        found = reachable(modules, without.union(DECIDE_NOTHING))
        lines = sorted(f"{_place(path)} {source_of(path).digest}" for path in found)
        return text_digest("\n".join(lines))

    return kept(f"{modules} {sorted(without)}", find)


def _place(path):
    """The name of a file in digests, such as ``src/dpd/jit.py``."""
    for package, home in HOMES.items():
        if path.is_relative_to(home):
            return f"{PLACES.get(package, package)}/{path.relative_to(home)}"
    return str(path)


@cache
def kernel_digest() -> str:
    """Digest of all that decides what Numba compiles: modules with kernels, and their imports."""

    def find():
        kernels = [
            path
            for path in sorted(PACKAGE.rglob("*.py"))
            if OWN_KERNELS not in path.parents and file_of(COMPILER) in source_of(path).imports
        ]
        kernels += sorted((PACKAGE / "physics").glob("*.py"))  # whose formulas they get in records
        return sources_digest(*kernels)

    return kept("kernels", find)


def kept(question: str, find: Callable[[], str]) -> str:
    """What another process has found for the same sources; otherwise find it, and keep it.

    To parse all sources takes a tenth of a second, which each of a study's hundreds of jobs would
    spend; to read them, and what is kept, takes three thousandths.

    Parameters
    ----------
    question : str
        What is to be found, in words that differ from those of other questions.
    find : callable
        Returns a digest.

    Returns
    -------
    str
    """
    folder = cache_folder("sources") / _state()
    path = folder / text_digest(question)
    with suppress(OSError):
        found = path.read_text()
        if len(found) == len(_state()):
            return found
    found = find()
    with suppress(OSError):  # where nothing can be kept, it is found each time
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            states = sorted(folder.parent.iterdir(), key=lambda state: state.stat().st_mtime_ns)
            for old in states[:-MOST_KEPT]:
                shutil.rmtree(old, ignore_errors=True)
        draft = path.with_name(f"{path.name}.{os.getpid()}")
        draft.write_text(found)
        os.replace(draft, path)
    return found


@cache
def _state():
    """Digest of all files of our packages, byte by byte."""
    total = hashlib.sha256()
    for home in HOMES.values():
        for folder, folders, names in os.walk(home):
            folders[:] = sorted(set(folders) - {"__pycache__"})
            for name in sorted(names):
                path = os.path.join(folder, name)
                with open(path, "rb") as file:
                    content = hashlib.sha256(file.read()).hexdigest()
                total.update(f"{os.path.relpath(path, home)} {content}\n".encode())
    return total.hexdigest()[:12]


@cache
def reachable(
    modules: tuple[str | Path, ...], without: frozenset[str] = frozenset()
) -> frozenset[Path]:
    """Files of some modules, of all that they import, and of the packages that these are in.

    Parameters
    ----------
    modules : tuple of str or Path
    without : frozenset of str
        Names of modules that are not followed.

    Returns
    -------
    frozenset of Path
    """
    waiting = [path for module in modules for path in _files(module)]
    left_out = {file_of(name) for name in without}
    found = set()
    while waiting:
        path = waiting.pop()
        if path not in found and path not in left_out:
            found.add(path)
            waiting += source_of(path).imports
    return frozenset(found)


@cache
def file_of(name: str) -> Path | None:
    """The file of a module of ours; None for other modules, and for folders that are no package."""
    first, *rest = name.split(".")
    return _file_in(HOMES[first], rest) if first in HOMES else None


def _file_in(folder, parts):
    place = folder.joinpath(*parts)
    for path in (Path(f"{place}.py"), place / "__init__.py"):
        if path.is_file():
            return path
    return None


@cache
def _files(module):
    """Files that are read when a module is imported: its own, and those of its packages."""
    path = module if isinstance(module, Path) else file_of(module)
    if path is None:
        return ()
    packages = (folder / "__init__.py" for folder in path.parents if _is_ours(folder))
    return (path, *(package for package in packages if package.is_file()))


def _is_ours(folder):
    return any(home == folder or home in folder.parents for home in HOMES.values())


@cache
def source_of(path: Path) -> Source:
    """The `Source` of a file."""
    text = path.read_bytes()
    with _no_collection():
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError):  # whoever imports it says what is wrong
            return Source(hashlib.sha256(text).hexdigest(), frozenset(_files(path)))
        digest, imports = _read(tree)
    for name in constant(tree, DATA, ()):
        digest.update(hashlib.sha256((path.parent / name).read_bytes()).digest())
    files = {file for node in imports for file in _imported(node, path)}
    return Source(digest.hexdigest(), frozenset(files.union(_files(path))))


@contextmanager
def _no_collection():
    """Spare Python the search for garbage among the nodes of a tree, a third of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _read(tree):
    """Digest of a tree less docstrings, hints and places in the file; its nodes that import.

    `ast.dump` would be slower than to parse.
    """
    parts, imports, waiting = [], [], [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.AST):
            parts.append(type(node).__name__)
            fields = {field: getattr(node, field, None) for field in node._fields}
            fields.pop(HINTS.get(type(node)), None)
            if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
                fields["body"] = node.body[1:]
            if isinstance(node, ast.ClassDef):
                fields["body"] = [item for item in fields["body"] if not _only_refuses(item)]
            waiting += fields.values()
            if isinstance(node, IMPORTS):
                imports.append(node)
        elif isinstance(node, list):
            counting = [item for item in node if not _serves_hints(item)]
            parts.append(len(counting))
            waiting += counting
        else:
            parts.append(node)
    return hashlib.sha256(repr(parts).encode("utf-8", "backslashreplace")), imports


def _serves_hints(node):
    """Whether a node is there for type hints alone: an import of `typing`, or for a checker."""
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.ImportFrom) and node.module in OF_HINTS


def _only_refuses(node):
    """Whether a node of a class says what may be asked of a page: no number hangs on that."""
    if isinstance(node, ast.FunctionDef):
        return node.name in REFUSES
    if isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Call):
        return getattr(node.value.func, "id", "") in SETTINGS
    return isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in SAYS_WHAT_NOT


def _imported(node, path):
    """Files that an ``import`` or a ``from ... import`` reads."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield from _files(alias.name)
        return
    parts = node.module.split(".") if node.module else []
    if node.level:
        folder = path.parents[node.level - 1]
    elif parts[0] in HOMES:
        folder = HOMES[parts.pop(0)]
    else:
        return
    module = _file_in(folder, parts)
    if module is not None:
        yield from _files(module)
    if module is None or module.name == "__init__.py":  # what is imported may be modules in it
        for alias in node.names:
            if file := _file_in(folder, [*parts, alias.name]):
                yield from _files(file)


def constant(tree: ast.Module, name: str, default: Any = None) -> Any:
    """The value of a plain constant at the top of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", None) == name:
            return ast.literal_eval(node.value)
    return default
