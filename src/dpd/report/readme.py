"""The tables of README.md, filled from the verdict table of a study that git keeps."""

import re

from dpd.errors import UserError
from dpd.report.archive import read_archive
from dpd.report.markdown import counts

BLOCK = re.compile(r"(<!-- begin: (.+?) -->\n).*?(<!-- end -->)", re.S)


def filled(text: str) -> str:
    """A text with its marked blocks made anew.

    A block begins with ``<!-- begin: STUDY counts -->`` and ends with ``<!-- end -->``.

    Parameters
    ----------
    text : str

    Returns
    -------
    str

    Raises
    ------
    UserError
        If a block asks for what there is not.
    """

    def made(block):
        return f"{block[1]}{_block(block[2])}\n{block[3]}"

    if text.count("<!-- begin:") != len(BLOCK.findall(text)):
        raise UserError("README.md: a block that begins has no <!-- end -->, or no line of its own")
    return BLOCK.sub(made, text)


def _block(asked):
    study, *kind = asked.split()
    if kind != ["counts"]:
        raise UserError(f"README.md: <!-- begin: {asked} -->: allowed: '{study} counts'")
    return counts(read_archive(study), lambda paper: f"[{paper}](paper_figures/{paper}/README.md)")
