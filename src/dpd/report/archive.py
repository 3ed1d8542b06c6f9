"""Verdict tables that git keeps: what README.md and the pages of the papers are made from."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
from PIL import Image

from dpd.analysis.collect import reading
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.study import SEEDED

if TYPE_CHECKING:
    from dpd.pipeline.paths import Results

ARCHIVE = ROOT / "results" / "archive"
FIGURES = ROOT / "paper_figures"
NEEDED = {"paper", "figure", "quantity", "kind", "published", "published_error", "rounding",
          "value", "error", "deviation_sigma", "verdict"}  # fmt: skip


def archive(study: str, results: Results) -> list[Path]:
    """Keep the verdict table of all papers, and draw anew the pictures that git keeps.

    Git keeps the picture of a figure if there is one beside the figure's file; the new one is as
    wide as the old one. Of a study with another seed than 1 the table alone is kept.

    Parameters
    ----------
    study : str
    results : dpd.pipeline.paths.Results
        Of the study.

    Returns
    -------
    list of path
        What was written: the table, then pictures.

    Raises
    ------
    UserError
        If there is no such table, or it was made by an older version.
    """
    source = results.verdicts()
    table = read_table(source)
    target = ARCHIVE / study / "verdicts.csv"
    replace_whole(target, lambda draft: shutil.copyfile(source, draft))
    written = [target]
    for paper in [] if SEEDED.fullmatch(study) else sorted(set(table.paper)):
        for kept in pictures(paper):
            drawn = Path(results.figure(paper, kept.stem, "png"))
            if drawn.is_file():
                _put_in_place(drawn, kept)
                written.append(kept)
    return written


def pictures(paper: str) -> list[Path]:
    """Pictures of a paper's figures that git keeps, in the order of their names.

    Raises
    ------
    UserError
        If a picture has no figure file beside it.
    """
    found = sorted((FIGURES / paper).glob("*.png"))
    for path in found:
        if not path.with_suffix(".py").is_file():
            raise UserError(f"{path}: there is no figure file {path.stem}.py beside this picture")
    return found


def _put_in_place(drawn, kept):
    """A figure in the width of the picture that is kept, in few colours."""
    with Image.open(kept) as old, Image.open(drawn) as new:
        size = old.width, round(new.height * old.width / new.width)
        few = in_few_colours(new.convert("RGB").resize(size, Image.Resampling.LANCZOS))
    replace_whole(kept, lambda draft: few.save(draft, "png", optimize=True))


def in_few_colours(picture: Image.Image) -> Image.Image:
    """A picture in 256 colours, which takes a third of the room and looks the same."""
    return picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)


def studies() -> list[str]:
    """Names of the studies that have a table in the archive; of each, that of the seed 1."""
    names = sorted(path.parent.name for path in ARCHIVE.glob("*/verdicts.csv"))
    return [name for name in names if not SEEDED.fullmatch(name)]


def read_archive(study: str) -> pd.DataFrame:
    """The verdict table of a study.

    Raises
    ------
    UserError
        If there is no such table, or it was made by an older version.
    """
    return read_table(ARCHIVE / study / "verdicts.csv")


def read_table(path: str | Path) -> pd.DataFrame:
    """A verdict table from a file, refused as in `read_archive`."""
    with reading(path, "table of verdicts"):
        table = pd.read_csv(path)
    if lacking := NEEDED - set(table.columns):
        raise UserError(
            f"{path}: no column {', '.join(sorted(lacking))}; let snakemake make it again"
        )
    return table
