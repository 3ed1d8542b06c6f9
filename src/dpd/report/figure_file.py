"""The file of a figure: read, called, and blamed for what goes wrong in it."""

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

NEEDED = {
    "TITLE": "the first sentence of the caption",
    "compute": "from sweeps by name to the plotted numbers, an xarray.Dataset",
    "draw": "from those numbers to a matplotlib figure",
}
# What a file may leave out that belongs to no published figure.
OPTIONAL = {"measured": lambda numbers: {}, "PAPER_SHOWS": ""}


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
    for name, meaning in NEEDED.items():
        if not hasattr(module, name):
            raise UserError(f"{shortened(path)}: {name} is missing: {meaning}")
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
    except Exception as fault:
        said, place, line, code = f"{part} raised {type(fault).__name__}: {fault}", path, None, ""
        for frame in traceback.extract_tb(fault.__traceback__):
            if Path(frame.filename).parent == Path(path).parent:
                place, line = frame.filename, frame.lineno
                code = linecache.getline(place, line or 0)
        if isinstance(fault, SyntaxError):
            said, code = f"this is not Python: {fault.msg}", fault.text or ""
            place, line = fault.filename or path, fault.lineno
        at, code = f": line {line}" if line else "", f" (`{code.strip()}`)" if code else ""
        raise UserError(f"{shortened(place)}{at}: {said}{code}") from fault


def call(module: ModuleType, name: str, argument: object, kind: type[T]) -> T:
    """What a function of a figure file returns; `UserError` if it raises, or it is no ``kind``."""
    with blamed_on(module, name):
        found = getattr(module, name)(argument)
    if not isinstance(found, kind):
        where = shortened(str(module.__file__))
        raise UserError(f"{where}: {name} returned {type(found).__name__}, not {kind.__name__}")
    return found
