"""Pages of a user's own: a file becomes a module whose name carries the digest of its source."""

import ast
import linecache
import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import import_module, invalidate_caches
from importlib.util import module_from_spec, spec_from_file_location
from inspect import signature
from itertools import combinations_with_replacement
from pathlib import Path
from traceback import extract_tb
from types import FunctionType, ModuleType, new_class
from typing import Any, Self

from dpd.digests import calculations_file, files_of, sources_digest, text_digest
from dpd.errors import UserError, reason, shown
from dpd.files import draft_of
from dpd.folders import ROOT, cache_folder, shortened
from dpd.page import (
    KINDS,
    BondForce,
    Calculation,
    Change,
    Given,
    Observable,
    Page,
    PairForce,
    Start,
    Term,
    names,
)

STEP = 1e-6  # r_c, for the slope of an energy
_importing: list[Path] = []  # files of pages that are imported just now


def load(path: str | Path, where: str, digest: str = "") -> tuple[dict[str, Any], str]:
    """The pages of a file by key, and its digest, that of a result if given; else `UserError`."""
    path = Path(path)
    try:
        found = sources_digest([path])
    except (OSError, ValueError) as problem:
        text = f"cannot be read ({reason(problem)})" if isinstance(problem, OSError) else problem
        raise UserError(f"{where}: {path}: {text}") from None
    if digest and digest != found:
        raise UserError(
            f"{where}: {path}: is not the file that this was made with: its digest is {found}, and "
            f"not {digest}; name the file anew, as with --page"
        )
    if path.suffix != ".py":
        raise UserError(f"{where}: {path}: a file of pages ends in .py")
    pages = dict(_pages(_module(path, f"own_{path.stem}_{found}", where)))
    if not pages:
        raise UserError(
            f"{where}: {path}: there is no page in it; a page is a class with a key, as 'class "
            "Mine(Observable, key=\"mine\")', or a function that measures, as 'def mine(snapshot)'"
        )
    for key, page in pages.items():
        if wrong := _wrong(key, page):
            raise UserError(f"{where}: {path}: {wrong}")
    return pages, found


def _wrong(key, page):
    """Why a class cannot be a page of one's own, or nothing."""
    if not issubclass(page, Observable | PairForce | BondForce | Start):
        kind, allowed = page.__mro__[1].__name__, "Observable, PairForce, BondForce, Start"
        return f"{key!r} is a {kind}; allowed in a file of one's own: {allowed}"
    if issubclass(page, Term) and "number" in page.model_fields:
        return f"{key!r} has a setting 'number', which kernels use; take another name"
    if any(key in names(kind) for kind in (Observable, Start, Term) if issubclass(page, kind)):
        return f"{key!r} is a page of the package; take another key"
    gives = getattr(page, "gives", {})
    try:
        kinds = {kind for (kind, *_), _, _ in gives.values()}
    except (TypeError, ValueError, AttributeError):
        kinds = {""}
    if not kinds.issubset(KINDS):
        return (
            f"'gives' of {key!r} should have (dimensions, units, long_name) by names, as "
            f'{{"height": (("block",), "r_c", "mean height")}}; the first of the dimensions is one '
            f"of {', '.join(KINDS)}"
        )
    if "lag" in kinds and not page.compared:
        return f"{key!r} gives averages over 'lag': say in 'compared' which dimensions it compares"
    if gives and page.of_sums and kinds != {"sample"}:
        return f"{key!r} measures sums ('of_sums'): the first dimension of all it gives is 'sample'"
    return ""


def _module(path: Path, name: str, where: str) -> ModuleType:
    """The module of a file, imported once, and after an edit; those beside it are its own."""
    files = files_of(path)
    texts = [file.read_bytes() for file in files]
    if getattr(sys.modules.get(name), "texts_of_page", None) == texts:
        return sys.modules[name]
    spec = spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # it is a .py file that can be read
    siblings = [file.stem for file in files[1:]]
    others = {stem: sys.modules.pop(stem) for stem in siblings if stem in sys.modules}
    module = sys.modules[name] = module_from_spec(spec)
    sys.path.insert(0, str(path.parent))
    _importing.append(path)
    try:
        invalidate_caches()
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as problem:  # whatever a file of someone's own may raise
        del sys.modules[name]
        said = blame(problem, [str(path)]) or f"{path}: {_said(problem)}"
        raise UserError(f"{where}: {said}") from None
    finally:
        _importing.pop()
        sys.path.remove(str(path.parent))
        for stem in siblings:
            sys.modules.pop(stem, None)
        sys.modules.update(others)
    module.texts_of_page = texts  # type: ignore[attr-defined]
    return module


def refuse_to_run() -> None:
    """Refuse what a file of pages, such as a script, would run whenever it is imported."""
    if _importing:
        raise UserError(
            "this file is imported wherever its pages are needed, and would run something then; "
            "put that below a line 'if __name__ == \"__main__\":'"
        )


def _pages(module: ModuleType) -> Iterator[tuple[str, type[Page]]]:
    for name, page in vars(module).items():
        if getattr(page, "__module__", "") != module.__name__:
            continue
        if isinstance(page, type) and issubclass(page, Page):
            page.model_rebuild()  # a wrong setting fails here, not at its first use
            if page.key:
                yield page.key, page
        elif isinstance(page, FunctionType) and name == page.__name__ and measures(page):
            yield name, _page_of(page)


class Function(Observable):
    """A plain function that measures; every sample is kept, under its name."""

    stands = frozenset(Change)  # who writes one has a scene in mind
    _shape: tuple[int, ...] = ()

    def shaped(self, now: Any) -> Self:
        import numpy as np

        with blaming(self):
            shape = np.shape(self.measure(now))
        shaped = self.model_copy()
        shaped._shape = shape
        return shaped

    def given(self, scene: Any) -> dict[str, Given]:
        dimensions, units, text = self.gives[self.key]
        return {self.key: ((*dimensions, *self.axes(scene)), units, text)}

    def axes(self, scene: Any) -> dict[str, Any]:
        axis = f"{self.key}_index"
        names = [f"{axis}{k}" for k in range(len(self._shape))] if len(self._shape) > 1 else [axis]
        return {name: (range(n), "1", "index") for name, n in zip(names, self._shape)}


def measures(function: Callable) -> bool:
    """Whether a function is an observable."""
    name = function.__qualname__  # a name with points, as of a method, is that of no page
    own = name.isidentifier() and not name.startswith("_")
    return own and list(signature(function).parameters) == ["snapshot"]


@cache
def _page_of(function):
    """A function as a page."""
    name, text = function.__name__, (function.__doc__ or function.__name__).split("\n\n")[0]
    inside = {
        "__module__": function.__module__,
        "__doc__": text,
        "gives": {name: (("sample",), "reduced", " ".join(text.split()).rstrip("."))},
        "measure": lambda self, now: function(now),
    }
    return new_class(name, (Function,), {"key": name}, lambda body: body.update(inside))


def file_of(page: Any) -> str:
    """The file of a path, class or function; of a notebook's cell, in the cache; or `UserError`."""
    if isinstance(page, str | os.PathLike):
        return os.path.abspath(page)
    name, module = getattr(page, "__name__", shown(page)), getattr(page, "__module__", "")
    parts = vars(page).values() if isinstance(page, type) else [page]
    functions = (part for part in parts if isinstance(part, FunctionType))
    place = next((f.__code__.co_filename for f in functions if f.__module__ == module), "")
    if not os.path.isfile(place) and (lines := linecache.getlines(place)):
        return _file_of_cell(lines, name)
    path = getattr(sys.modules.get(module), "__file__", None) or place
    if not os.path.isfile(path):
        raise UserError(
            f"{name!r} stands in no file, where a run that goes on in another process could find "
            "it; write it into one, and import it"
        )
    return os.path.abspath(path)


def _file_of_cell(lines: Sequence[str], name: str) -> str:
    """A file with what a cell defines by a name, and what that uses."""
    body, needed, used = ast.parse("".join(lines)).body, {name, "*"}, list[ast.stmt]()
    while found := [node for node in body if node not in used and needed & _defined(node)]:
        used += found
        needed |= {n.id for node in found for n in ast.walk(node) if isinstance(n, ast.Name)}
    text = ast.unparse(ast.Module([node for node in body if node in used], []))
    path = cache_folder("pages") / f"cell_{text_digest(text)}.py"
    if not path.is_file():
        with draft_of(path) as draft:
            draft.write_text(text)
    return str(path)


def _defined(node: ast.stmt) -> set[str]:
    """Names that a statement defines."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {(name.asname or name.name).split(".")[0] for name in node.names}
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    names = [each for each in ast.walk(node) if isinstance(each, ast.Name)]
    return {each.id for each in names if isinstance(each.ctx, ast.Store)}


def check_slope(page: PairForce | BondForce, scene: Any) -> None:
    """Hold a force to the slope of its energy, in plain Python, at some 50 distances each."""
    with blaming(page, f"{scene.where}: {page.key}"):
        for of, force, energy, distances in _formulas(page, scene):
            for r in distances:
                found, slope = force(r), (energy(r + STEP) - energy(r - STEP)) / (2 * STEP)
                if not abs(found + slope) <= 1e-5 * (1 + abs(slope)):
                    raise UserError(
                        f"{scene.where}: {page.key}: its force is not minus the slope of its "
                        f"energy: {of} at r = {r:.3f} it is {found:.6g}, and should be {-slope:.6g}"
                    )


def _formulas(page, scene):
    """Laws of a page: what each is for, its force and energy over r, and where to try them."""
    if isinstance(page, BondForce):
        from dpd.page.laws import usual_lengths

        for name, law in page.laws(scene).items():
            of = f"of bonds {name}" if name else "of a bond"
            yield of, law.force, law.energy, usual_lengths(law, scene.kT)
        return
    distances = [k / 50 - 0.003 for k in range(1, 50)]
    for one, other in combinations_with_replacement(scene.species, 2):
        law, of = page.between(one, other), f"between {one} and {other}"
        force, energy = ((lambda r, of=of: of(r, 1 - r)) for of in (law.force, law.energy))
        yield of, force, energy, distances


def blame(problem: BaseException, files: Collection[str]) -> str:
    """The file of pages in which something went wrong, its line, and what; nothing if in none."""
    if isinstance(problem, SyntaxError) and problem.filename in files:
        return f"{shortened(str(problem.filename))}: line {problem.lineno}: {problem.msg}"
    at = [each for each in extract_tb(problem.__traceback__) if each.filename in files][-1:]
    return "".join(f"{shortened(e.filename)}: line {e.lineno}: {_said(problem)}" for e in at)


def _said(problem):
    text = shown(problem, str)
    return str(problem) if isinstance(problem, UserError) else f"{type(problem).__name__}: {text}"


@contextmanager
def blaming(page: Page | ModuleType, place: str = "") -> Iterator[None]:
    """Say in a sentence where in its folder a page, or a figure, fails: at a place, or observed."""
    try:
        yield
    except UserError:
        raise
    except (Exception, SystemExit) as problem:  # whatever a page of someone's own may raise
        module = sys.modules[type(page).__module__] if isinstance(page, Page) else page
        file = Path(str(module.__file__))
        files = [str(path) for path in file.parent.glob("*.py")]
        said = blame(problem, files) or f"{shortened(file)}: {_said(problem)}"
        place = place or f"observe.{getattr(page, 'key', '')}"
        raise UserError(f"{place}: {said}") from problem


@cache
def calculations_of(paper: str) -> dict[str, type[Calculation]]:
    """What a paper's own file calculates, by the keys of its classes."""
    path = calculations_file(paper)
    short = shortened(path)
    if not path.is_file():
        raise UserError(
            f"{paper}.yaml: a sweep has 'theory', and there is no file "
            f"{short}; write it, with a class for each calculation, as "
            "paper_figures/crgw_2019 has it, or take the sweep out"
        )
    if sys.path[0] != str(ROOT):
        sys.path.insert(0, str(ROOT))
    try:
        module = import_module(f"paper_figures.{paper}.{path.stem}")
    except Exception as problem:  # whatever a file of someone's own may raise
        said = blame(problem, [str(path)]) or f"{short}: {type(problem).__name__}: {problem}"
        raise UserError(said) from None
    found = [each for each in vars(module).values() if isinstance(each, type)]
    return {each.key: each for each in found if issubclass(each, Calculation) and each.key}
