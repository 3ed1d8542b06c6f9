"""All pages of the repository that are written by a program, wholly or in part."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from dpd.analysis.published import Entry
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.sections import Config, PaperFile
from dpd.pipeline.study import check_repository
from dpd.report.archive import FIGURES, read_archive
from dpd.report.keys import rows_of, scene_rows, text_of
from dpd.report.markdown import counts, key_table
from dpd.report.paper_page import paper_page, papers_with_pages
from dpd.report.variables import run_table, sweep_table, verdict_table
from dpd.scene.sections import Basics

BLOCK = re.compile(r"(<!-- begin: (.+?) -->\n).*?(<!-- end -->)", re.S)


def pages() -> dict[Path, str]:
    """Path to text of every such page, as it should be now."""
    check_repository()
    readme, config = ROOT / "README.md", ROOT / "config"
    made = {readme: filled(readme.read_text())}
    made |= {config / "README.md": papers_page(), config / "SCENES.md": scenes_page()}
    return made | {FIGURES / name / "README.md": paper_page(name) for name in papers_with_pages()}


def write_pages() -> list[Path]:
    """Write the pages that are not as they should be, and say which."""
    written = []
    for path, text in pages().items():
        if not path.is_file() or path.read_text() != text:
            replace_whole(path, partial(Path.write_text, data=text))
            written.append(path)
    return written


def papers_page() -> str:
    """config/README.md: keys of what says what a study is, and of papers."""
    keys = {"config": rows_of(Config, ""), "paper": rows_of(PaperFile, "")}
    keys["published"] = rows_of(Entry, "NAME.")
    text = {"config": text_of(Config), "paper": text_of(PaperFile)}
    return _page("papers", keys, text=text, sweep=sweep_table(), verdicts=verdict_table())


def scenes_page() -> str:
    """config/SCENES.md: keys of scenes, and what results hold."""
    return _page(
        "scenes", {"scene": scene_rows()}, text={"scene": text_of(Basics)}, run=run_table()
    )


def _page(name, keys, **values):
    """A page from its template; keys are rows of tables by name."""
    tables = {name: key_table(rows) for name, rows in keys.items()}
    loader = FileSystemLoader(Path(__file__).parent)
    environment = Environment(
        loader=loader, undefined=StrictUndefined, keep_trailing_newline=True, autoescape=False
    )
    return environment.get_template(f"{name}.md.j2").render(keys=tables, **values)


def filled(text: str) -> str:
    """A text with its marked blocks made anew, from the verdicts of a study that git keeps.

    A block begins with ``<!-- begin: STUDY counts -->`` and ends with ``<!-- end -->``.

    Raises
    ------
    UserError
        If a block asks for what there is not.
    """

    def made(block):
        study, *kind = block[2].split()
        if kind != ["counts"]:
            raise UserError(f"README.md: <!-- begin: {block[2]} -->: allowed: '{study} counts'")
        table = counts(read_archive(study), "[{0}](paper_figures/{0}/README.md)".format)
        return f"{block[1]}{table}\n{block[3]}"

    if text.count("<!-- begin:") != len(BLOCK.findall(text)):
        raise UserError("README.md: a block that begins has no <!-- end -->, or no line of its own")
    return BLOCK.sub(made, text)
