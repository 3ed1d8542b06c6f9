"""Pages of papers in the site, by the templates of the report, from what git keeps of studies."""

import dataclasses
import os
import shutil
from pathlib import Path

from PIL import Image, PngImagePlugin

from docs.pages import rendered, rows_of_archive
from dpd import files
from dpd.folders import ROOT
from dpd.pipeline.paper import read_config, read_paper, read_study
from dpd.pipeline.paths import LONG_STUDY, Results
from dpd.report import archive
from dpd.report.figures import load_module
from dpd.report.page import write_page
from dpd.report.rows import Row
from dpd.report.text import label

QUICK = "quick"  # the study of all papers
SOURCES = ("config/papers", "paper_figures")  # that pages link to


def study_of(paper: str) -> str:
    """The longest archived study that has figures of a paper."""
    kept = archive.manifest_of(LONG_STUDY).get("figures", {})
    return LONG_STUDY if any(name.startswith(f"{paper}/") for name in kept) else QUICK


def rows_of(paper: str) -> list[Row]:
    """Its verdicts in that study."""
    return [row for row in rows_of_archive(study_of(paper)) if row["paper"] == paper]


def archived_counts(folder: str = "papers") -> str:
    """A table of all papers in Markdown, each with a link to its page."""
    rows = [row for name in read_config()["papers"] for row in rows_of(name)]
    return rendered("counts.md.j2", tables=[rows], link=f'<a href="{folder}/{{0}}.html">{{0}}</a>')


def write_paper_pages(folder: Path) -> None:
    """A page for each paper below a folder, with pictures and numbers beside it."""
    for source in SOURCES:
        kinds = shutil.ignore_patterns("__pycache__", "*.png", "*.md")
        shutil.copytree(
            ROOT / source, folder / "sources" / source, ignore=kinds, dirs_exist_ok=True
        )
    for name in read_config()["papers"]:
        study, rows = study_of(name), rows_of(name)
        paper, results = read_paper(name, study, only=[]), Results(str(folder))
        there = {
            figure: each for figure, each in paper.figures.items()
            if _put_figure(name, figure, study, rows, results)
        }  # fmt: skip
        page = folder / f"{name}.html"
        about = read_study(study).description
        write_page(study, about, [dataclasses.replace(paper, figures=there)], folder, page)
        here = os.path.relpath(ROOT, folder)  # where pages of a clone look for sources
        page.write_text(page.read_text().replace(f'"{here}/', '"sources/'))


def _put_figure(paper: str, figure: str, study: str, verdicts: list[Row], results: Results) -> bool:
    """The files of a figure as a study has them, out of the archive; whether it has any."""
    rows = [row["entry"] for row in verdicts if row["entry"]["figure"] == figure]
    kept = archive.ARCHIVE / study / paper / f"{figure}.nc"
    picture = next(
        (p for p in (kept.with_suffix(".png"), archive.FIGURES / paper / f"{figure}.png")
         if p.is_file()), None,
    )  # fmt: skip
    if (study == LONG_STUDY and not kept.is_file()) or not (rows or picture):
        return False
    table = Path(results.figure(paper, figure, "csv"))
    table.parent.mkdir(parents=True, exist_ok=True)
    table.write_bytes(archive.table_text(rows))
    module, seen = load_module(paper, figure), ""
    if kept.is_file():
        shutil.copy(kept, table.with_suffix(".nc"))
        seen = files.attributes(kept).get("seen", "")
    if picture:
        words = PngImagePlugin.PngInfo()
        words.add_itxt("Title", f"{paper}, {label(figure)}: {module.TITLE}")
        words.add_itxt("Description", seen or module.TITLE)
        with Image.open(picture) as image:
            image.save(table.with_suffix(".png"), pnginfo=words)
    return True
