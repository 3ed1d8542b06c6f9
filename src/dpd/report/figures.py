"""From sweeps and measurements to a figure's files: picture, PDF, numbers, verdicts, caption."""

import importlib.util
import json
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import TypeVar

import matplotlib as mpl
import pandas as pd
import xarray as xr
from fontTools.subset import Options
from matplotlib import pyplot as plt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure

from dpd.analysis.collect import load, save
from dpd.analysis.statistics import degrees_of
from dpd.analysis.verdicts import figure_path, rows
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.folders import ROOT, shortened
from dpd.page.own import blaming
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
# How glyphs join is no part of a PDF, whose glyphs have places: to read it took 0.3 s of 0.8.
getattr(Options, "_drop_tables_default", []).extend(["GSUB", "GPOS", "GDEF"])


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
    with blaming(module, "to read it"):
        spec.loader.exec_module(module)
    for name, meaning in NEEDED.items():
        if not hasattr(module, name):
            raise UserError(f"{shortened(path)}: {name} is missing: {meaning}")
    return module


def call(module: ModuleType, name: str, argument: object, kind: type[T]) -> T:
    """What a function of a figure file returns; `UserError` if it raises, or it is no ``kind``."""
    with blaming(module, name):
        found = getattr(module, name)(argument)
    if not isinstance(found, kind):
        where = shortened(str(module.__file__))
        raise UserError(f"{where}: {name} returned {type(found).__name__}, not {kind.__name__}")
    return found


@mpl.rc_context(LOOK)
def make_figure(paper: str, figure: str, sources: Mapping[str, str | Path], folder: Path) -> None:
    """Write a figure's .png, .pdf, .nc, .csv, and .html with its caption; or raise `UserError`."""
    begun = time.perf_counter()
    module = load_module(paper, figure)
    data = {name: load(path) for name, path in sources.items()}

    def made(scattered):
        drawn = {name: each.copy(deep=False) for name, each in data.items()}
        for each in drawn.values():  # errors of series times a factor for their degrees
            for key in [key for key in each.data_vars if f"{key}_degrees" in each]:
                error, degrees = (each.variables[f"{key}_{name}"] for name in ("error", "degrees"))
                error.data = error.data * scattered(degrees.data)
        numbers = call(module, "compute", drawn, xr.Dataset)
        found = call(module, "measured", numbers, dict)
        return numbers, {name: one.by_sampling for name, one in found.items()}

    numbers, degrees = degrees_of(made)
    numbers.attrs["degrees"] = json.dumps(degrees)
    table = verdicts_of(module, paper, figure, numbers)
    seen = call(module, "describe", numbers, str) if hasattr(module, "describe") else module.TITLE
    numbers.attrs |= {"paper": paper, "figure": figure, "seen": seen}
    drawn = call(module, "draw", numbers, Figure)
    with blaming(module, "caption"):
        text = caption(figure, module, data, numbers)
    base = str(folder / figure)
    replace_whole(f"{base}.csv", lambda draft: table.to_csv(draft, index=False))
    replace_whole(f"{base}.html", lambda draft: draft.write_text(text))
    title = f"{paper}, {label(figure)}: {module.TITLE}"
    about = {"Title": title, "Description": seen}
    # By canvases: savefig draws all twice, first for the layout, which drawing does as well.
    drawn.set_dpi(mpl.rcParams["savefig.dpi"])
    canvas = FigureCanvasAgg(drawn)
    replace_whole(f"{base}.png", lambda draft: canvas.print_png(draft, metadata=about))
    drawn.set_layout_engine("none")  # what it has found for the one holds for the other
    of_pdf, about = FigureCanvasPdf(drawn), {"Title": title, "Subject": seen, "CreationDate": None}
    replace_whole(f"{base}.pdf", lambda draft: of_pdf.print_pdf(draft, metadata=about))
    plt.close(drawn)
    numbers.attrs["seconds"] = time.perf_counter() - begun
    save(numbers, f"{base}.nc")


def verdicts_of(module: ModuleType, paper: str, figure: str, numbers: xr.Dataset) -> pd.DataFrame:
    """The verdict table of a figure, from its module and the numbers that its ``compute`` gave."""
    degrees = json.loads(numbers.attrs.get("degrees", "{}"))
    return rows(paper, figure, call(module, "measured", numbers, dict), degrees)
