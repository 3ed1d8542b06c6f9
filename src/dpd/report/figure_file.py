"""The file of a figure, and sentences on what is wrong with it."""

from __future__ import annotations

import importlib.util
import linecache
import sys
import traceback
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from dpd.digest import ROOT, paper_folder, shortened
from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

    T = TypeVar("T")

FUNCTIONS = {
    "compute": "compute(data), from sweeps by name to the plotted numbers, an xarray.Dataset",
    "draw": "draw(numbers), from those to a matplotlib figure",
}
TEXTS = {"TITLE": "TITLE, the first sentence of the caption"}
MEASURED = {
    "measured": "measured(numbers), from those to a dict of dpd.analysis.verdicts.Measured",
}
# What a file may leave out that belongs to no published figure.
OPTIONAL = {"measured": lambda numbers: {}, "PAPER_SHOWS": ""}


class BrokenFigure(UserError):
    """A figure file that raised something; the exception is its ``__cause__``."""

    def whole_traceback(self) -> str:
        """What a developer wants to see."""
        return "".join(traceback.format_exception(self.__cause__))


def figure_path(paper: str, figure: str) -> Path:
    """The file of a figure. Raises `UserError` if it is missing."""
    path = paper_folder(paper) / f"{figure}.py"
    if not path.is_file():
        raise UserError(
            f"{paper}.yaml: figures.{figure}: there is no file {shortened(path)}; "
            "write it, with the functions of one of its neighbours, or take the figure out"
        )
    return path


def load_module(paper: str, figure: str) -> ModuleType:
    """The module of a figure.

    It has ``compute(data)``, ``draw(numbers)`` and ``TITLE``. With numbers in published.yaml it has
    ``measured(numbers)``, which gives ours by their names. It may also have ``PAPER_SHOWS``, what
    the paper's own figure shows; ``ERRORS``, ``warnings(numbers)``, sentences, and
    ``table(numbers)``, a data frame of text; they go below its caption; and
    ``describe(numbers)``, which says in one or two sentences what is seen, for those who cannot see
    the picture. It may import what it shares with other figures, as in
    ``from paper_figures.benchmark.shared import ranged``: that works from any folder.

    Raises `UserError` if the file is missing, lacks one of these, or cannot be read as Python.
    """
    path = figure_path(paper, figure)
    if sys.path[0] != str(ROOT):
        # First, as the folder that the command is given in may be another copy of the repository.
        sys.path.insert(0, str(ROOT))
    spec = importlib.util.spec_from_file_location(f"paper_figures.{paper}.{figure}", path)
    # A file whose name ends in .py has a spec, and that has a loader.
    module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
    with blamed_on(module, "the file, while it is read,"):
        spec.loader.exec_module(module)  # type: ignore[union-attr]
    for name, meaning in (FUNCTIONS | TEXTS).items():
        if not hasattr(module, name):
            needed = "; ".join((FUNCTIONS | TEXTS).values())
            raise UserError(
                f"{shortened(path)}: {name} is missing: {meaning}. A figure file needs {needed}"
            )
    for name, value in OPTIONAL.items():
        setattr(module, name, getattr(module, name, value))
    return module


@contextmanager
def blamed_on(module: ModuleType, part: str) -> Iterator[None]:
    """Turn what a part of a figure file raises into a sentence with the file's name and line.

    Where the fault lies in what figures of the paper share, that file is named.
    """
    path = str(module.__file__)
    try:
        yield
    except UserError:
        raise
    except SyntaxError as fault:
        said = f"this is not Python: {fault.msg}{_code(fault.text)}"
        where = shortened(fault.filename or path)
        raise BrokenFigure(f"{where}: line {fault.lineno}: {said}") from fault
    except Exception as fault:
        said = f"{part} raised {type(fault).__name__}: {fault}"
        frames = traceback.extract_tb(fault.__traceback__)
        own = [frame for frame in frames if Path(frame.filename).parent == Path(path).parent]
        if not own:
            raise BrokenFigure(f"{shortened(path)}: {said}") from fault
        place = own[-1]
        code = _code(linecache.getline(place.filename, place.lineno or 0))
        where = f"{shortened(place.filename)}: line {place.lineno}"
        raise BrokenFigure(f"{where}: {said}{code}") from fault


def wanted(module: ModuleType, part: str, value: object, kind: type[T]) -> T:
    """A value that a part of a figure file returned, refused if it is not of the kind."""
    if not isinstance(value, kind):
        raise UserError(
            f"{shortened(str(module.__file__))}: {part} returned {type(value).__name__}, "
            f"not {kind.__name__}; a figure file needs {(FUNCTIONS | MEASURED)[part]}"
        )
    return value


def _code(line):
    return f" (`{line.strip()}`)" if line and line.strip() else ""
