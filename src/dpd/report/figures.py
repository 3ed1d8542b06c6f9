"""From sweeps and measurements to a figure's files: picture, PDF, numbers, verdicts, caption."""

import importlib.util
import json
import sys
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TypeVar

import matplotlib as mpl
import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from dpd.analysis.collect import load, save
from dpd.analysis.statistics import degrees_of
from dpd.analysis.verdicts import figure_path, rows
from dpd.digest import ROOT, shortened
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report.style import LOOK
from dpd.report.text import caption, label

T = TypeVar("T")
NEEDED = {
    "TITLE": "the first sentence of the caption",
    "compute": "from sweeps by name to the plotted numbers, an xarray.Dataset",
    "draw": "from those numbers to a matplotlib figure",
}
# What a file may leave out that belongs to no published figure.
OPTIONAL = {"measured": lambda numbers: {}, "PAPER_SHOWS": ""}


def load_module(paper: str, figure: str) -> ModuleType:
    """The module of a figure.

    It has ``compute(data)``, ``draw(numbers)`` and ``TITLE``; with numbers in published.yaml also
    ``measured(numbers)``, ours by their names. It may have ``PAPER_SHOWS``, what the paper's own
    figure shows; below its caption ``ERRORS``, ``warnings(numbers)``, sentences, and
    ``table(numbers)``, a data frame of text; and ``describe(numbers)``, one or two sentences for
    those who cannot see the picture. It may import from ``paper_figures`` in any folder.

    Raises `UserError` if the file is missing, lacks one of these, or cannot be read as Python.
    """
    path = figure_path(paper, figure)
    if sys.path[0] != str(ROOT):
        # First, as the folder that the command is given in may be another copy of the repository.
        sys.path.insert(0, str(ROOT))
    spec = importlib.util.spec_from_file_location(f"paper_figures.{paper}.{figure}", path)
    assert spec and spec.loader  # as its name ends in .py
    module = importlib.util.module_from_spec(spec)
    vars(module).update(OPTIONAL)
    with blamed_on(module, "the file, while it is read,"):
        spec.loader.exec_module(module)
    for name, meaning in NEEDED.items():
        if not hasattr(module, name):
            raise UserError(f"{shortened(path)}: {name} is missing: {meaning}")
    return module


@contextmanager
def blamed_on(module: ModuleType, part: str) -> Iterator[None]:
    """Turn what a part of a figure file raises into a sentence with file and line, perhaps of what
    figures of the paper share.
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
                place, line, code = frame.filename, frame.lineno, frame.line or ""
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


@mpl.rc_context(LOOK)
def make_figure(paper: str, figure: str, sources: Mapping[str, str | Path], folder: Path) -> None:
    """Write ``figure``.png, .pdf, .nc, .csv and .html, its caption, from ``sources``, collected
    sweeps and measurements by name; `UserError` if one is missing, or the figure's file is broken.
    """
    begun = time.perf_counter()
    module = load_module(paper, figure)
    data = {name: load(path) for name, path in sources.items()}

    def made(scattered):
        drawn = {}
        for name, each in data.items():  # its errors of series times a factor for their degrees
            errors = [f"{key}_error" for key in each.data_vars if f"{key}_degrees" in each]
            factors = {key: scattered(each[f"{key[:-6]}_degrees"].values) for key in errors}
            drawn[name] = each.assign({key: each[key] * factors[key] for key in errors})
        numbers = call(module, "compute", drawn, xr.Dataset)
        found = call(module, "measured", numbers, dict)
        return numbers, {name: one.by_sampling for name, one in found.items()}

    numbers, degrees = degrees_of(made)
    numbers.attrs["degrees"] = json.dumps(degrees)
    table = verdicts_of(module, paper, figure, numbers)
    seen = call(module, "describe", numbers, str) if hasattr(module, "describe") else module.TITLE
    numbers.attrs |= {"paper": paper, "figure": figure, "seen": seen}
    drawn = call(module, "draw", numbers, Figure)
    with blamed_on(module, "the caption"):
        text = caption(figure, module, data, numbers)
    base = str(folder / figure)
    replace_whole(f"{base}.csv", lambda draft: table.to_csv(draft, index=False))
    replace_whole(f"{base}.html", lambda draft: draft.write_text(text))
    title = f"{paper}, {label(figure)}: {module.TITLE}"
    about = {"Title": title, "Description": seen}
    replace_whole(f"{base}.png", lambda draft: drawn.savefig(draft, format="png", metadata=about))
    drawn.set_layout_engine("none")  # what it has found for the one holds for the other
    about = {"Title": title, "Subject": seen, "CreationDate": None}
    replace_whole(f"{base}.pdf", lambda draft: drawn.savefig(draft, format="pdf", metadata=about))
    plt.close(drawn)
    numbers.attrs["seconds"] = time.perf_counter() - begun
    save(numbers, f"{base}.nc")


def verdicts_of(module: ModuleType, paper: str, figure: str, numbers: xr.Dataset) -> pd.DataFrame:
    """The verdict table of a figure, from its module and the numbers that its ``compute`` gave."""
    degrees = json.loads(numbers.attrs.get("degrees", "{}"))
    return rows(paper, figure, call(module, "measured", numbers, dict), degrees)
