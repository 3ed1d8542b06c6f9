"""All pages of the repository that are written by a program, wholly or in part."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from dpd.digest import ROOT
from dpd.files import replace_whole
from dpd.pipeline.study import check_repository
from dpd.report.archive import FIGURES
from dpd.report.document import config_readme
from dpd.report.paper_page import paper_page, papers_with_pages
from dpd.report.readme import filled


def pages() -> dict[Path, str]:
    """Path to text of every such page, as it should be now."""
    check_repository()
    readme = ROOT / "README.md"
    made = {readme: filled(readme.read_text()), ROOT / "config" / "README.md": config_readme()}
    made |= {FIGURES / name / "README.md": paper_page(name) for name in papers_with_pages()}
    return made


def write_pages() -> list[Path]:
    """Write the pages that are not as they should be.

    Returns
    -------
    list of path
        Those that were written.
    """
    written = []
    for path, text in pages().items():
        if not path.is_file() or path.read_text() != text:
            replace_whole(path, partial(Path.write_text, data=text))
            written.append(path)
    return written
