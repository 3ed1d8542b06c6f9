"""What the command line takes: the stages of all groups, each with its arguments.

A module of commands has a function ``add_to(stages)``, which declares each stage with its arguments
and the function that does it. That function imports what it needs when it is called, and only the
module of the stage that is asked for is imported: the start of every process that a study makes
would pay for more.
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import dpd

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

# Modules of commands and their stages, in the order in which --help lists them.
GROUPS = {
    "new": ["new"],
    "runs": ["run"],
    "keys": ["keys", "schema"],
    "extend": ["extend"],
    "status": ["status"],
    "particles": ["convert"],
    "draw": ["draw"],
    "repulsion": ["repulsion"],
    "parameters": ["parameters"],
    "people": ["plan", "bench"],
    "points": ["compile", "start", "simulate", "collect", "derive", "calculate", "measure"],
    "figures": [
        "figure", "verdicts", "compare", "report", "schemes", "archive", "restore", "redraw",
        "readme",
    ],
}  # fmt: skip
SEVERAL = {"papers": "+", "tables": "*"}  # arguments that are lists


class Stages:
    """The stages of a parser, to which modules of commands add theirs.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """

    def __init__(self, parser: argparse.ArgumentParser):
        self._subparsers = parser.add_subparsers(title="stages", required=True, metavar="STAGE")

    def add(
        self,
        name: str,
        function: Callable[[argparse.Namespace], None],
        help: str,
        *names: str,
        output: str | None = None,
        prints: bool = False,
    ) -> argparse.ArgumentParser:
        """Declare a stage.

        Parameters
        ----------
        name : str
        function : callable
            Does it, given the options.
        help : str
        *names : str
            Its arguments without which it does nothing.
        output : str, optional
            What it writes to the path after ``-o``; the path must have the suffix of this name.
        prints : bool, optional
            Whether what it prints is its result, so that it fails if that cannot be written.

        Returns
        -------
        argparse.ArgumentParser
            Of this stage, for further options.
        """
        parser = self._subparsers.add_parser(name, help=help, description=help)
        for argument in names:
            parser.add_argument(argument, nargs=SEVERAL.get(argument))
        if output:
            parser.add_argument("-o", "--output", required=True, type=Path, help=output)
        parser.set_defaults(stage=function, suffix=Path(output or "").suffix, prints=prints)
        return parser


def called() -> str:
    """The command as it was typed: an installed program ``dpd``, or a module of Python."""
    return "dpd" if Path(sys.argv[0]).stem == "dpd" else "python -m dpd"


def new_parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of the stage that comes first in some arguments; of all where that is none."""
    parser = argparse.ArgumentParser(
        prog=called(), description="Dissipative particle dynamics: runs, figures, verdicts."
    )
    parser.add_argument("--version", action="version", version=f"dpd-papers {dpd.__version__}")
    stages = Stages(parser)
    asked = arguments[0] if arguments else ""
    groups = [group for group, names in GROUPS.items() if asked in names]
    for group in groups or GROUPS:
        import_module(f"dpd.commands.{group}").add_to(stages)
    return parser
