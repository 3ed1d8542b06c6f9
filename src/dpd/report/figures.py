"""From sweeps and measurements to a figure's files: picture, PDF, numbers, verdicts, caption."""

from __future__ import annotations

import json
import time
from io import BytesIO
from typing import TYPE_CHECKING

import matplotlib as mpl
import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

from dpd.analysis.collect import load, reading, save
from dpd.analysis.statistics import degrees_of
from dpd.analysis.verdicts import COLUMNS, rows
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report.captions import caption
from dpd.report.figure_file import blamed_on, call, load_module
from dpd.report.style import LOOK
from dpd.report.text import label

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path
    from types import ModuleType


NEEDED = {"paper", "figure", "quantity", "kind", "published", "value", "error", "verdict"}


@mpl.rc_context(LOOK)
def make_figure(paper: str, figure: str, sources: Mapping[str, str | Path], folder: Path) -> None:
    """Write ``figure``.png, .pdf, .nc, .csv and .html, its caption, to a folder.

    ``sources``: collected sweeps and measurements by name. Raises `UserError` if one is missing, or
    the figure's file is broken.
    """
    begun = time.perf_counter()
    module = load_module(paper, figure)
    data = {name: load(path) for name, path in sources.items()}

    def made(scattered):
        drawn = {name: _with_other_errors(each, scattered) for name, each in data.items()}
        numbers = call(module, "compute", drawn, xr.Dataset)
        found = call(module, "measured", numbers, dict)
        return numbers, {name: one.by_sampling for name, one in found.items()}

    numbers, degrees = degrees_of(made)
    numbers.attrs["degrees"] = json.dumps(degrees)
    table = verdicts_of(module, paper, figure, numbers)
    described = hasattr(module, "describe")
    seen = call(module, "describe", numbers, str) if described else module.TITLE
    numbers.attrs |= {"paper": paper, "figure": figure, "seen": seen}
    drawn = call(module, "draw", numbers, Figure)
    with blamed_on(module, "the caption"):
        text = caption(figure, module, data, numbers)

    def path(kind):
        return folder / f"{figure}.{kind}"

    replace_whole(path("csv"), lambda draft: table.to_csv(draft, index=False))
    replace_whole(path("html"), lambda draft: draft.write_text(text))
    title = f"{paper}, {label(figure)}: {module.TITLE}"
    about = {"Title": title, "Description": seen}
    replace_whole(path("png"), lambda draft: drawn.savefig(draft, format="png", metadata=about))
    drawn.set_layout_engine("none")  # what it has found for the one holds for the other
    about = {"Title": title, "Subject": seen, "CreationDate": None}
    replace_whole(path("pdf"), lambda draft: drawn.savefig(draft, format="pdf", metadata=about))
    plt.close(drawn)
    numbers.attrs["seconds"] = time.perf_counter() - begun
    save(numbers, path("nc"))


def verdicts_of(module: ModuleType, paper: str, figure: str, numbers: xr.Dataset) -> pd.DataFrame:
    """The verdict table of a figure, from its module and the numbers that its ``compute`` gave."""
    degrees = json.loads(numbers.attrs.get("degrees", "{}"))
    return rows(paper, figure, call(module, "measured", numbers, dict), degrees)


def _with_other_errors(data, scattered):
    """A sweep, each error of a series multiplied by a factor for its degrees of freedom."""
    known = [name for name in data.data_vars if f"{name}_degrees" in data]
    return data.assign({
        f"{name}_error": data[f"{name}_error"] * scattered(data[f"{name}_degrees"].values)
        for name in known
    })  # fmt: skip


def small_png(picture: Image.Image) -> bytes:
    """A file of a picture in 256 colours: it takes a third of the room and looks the same."""
    written = BytesIO()
    few = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    few.save(written, "png", optimize=True)
    return written.getvalue()


def joined(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Verdict tables as one, without rows where no figure has a published number."""
    # Without an empty one: it would turn numbers of the others into text.
    filled = [table for table in tables if len(table)]
    if not filled:
        return pd.DataFrame(columns=COLUMNS)
    return pd.concat(filled, ignore_index=True)


def read_verdicts(path: str | Path) -> pd.DataFrame:
    """A verdict table from a file. Raises `UserError` if it is missing, damaged or an older one."""
    with reading(path, "table of verdicts"):
        table = pd.read_csv(path)
    if lacking := NEEDED - set(table.columns):
        raise UserError(
            f"{path}: no column {', '.join(sorted(lacking))} of a table of verdicts; let snakemake "
            "make it again"
        )
    return table.reindex(columns=COLUMNS)
