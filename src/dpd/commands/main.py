"""`python -m dpd STAGE ...`: what the rules call, and what a person can paste."""

from __future__ import annotations

import argparse
import shlex
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import dpd
from dpd.errors import FAILED, Occupied, Stopped, UserError, reason
from dpd.sources import HOMES

if TYPE_CHECKING:
    from argparse import Namespace
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
SEVERAL = {"papers": "+", "points": "+", "tables": "*"}  # arguments that are lists


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

        Returns
        -------
        argparse.ArgumentParser
            Of this stage, for further options.
        """
        parser = self._subparsers.add_parser(name, help=help, description=help)
        for argument in names:
            parser.add_argument(argument, nargs=SEVERAL.get(argument))
        if output:
            several = "+" if "points" in names else None
            parser.add_argument(
                "-o", "--output", required=True, type=Path, help=output, nargs=several
            )
        parser.set_defaults(stage=function, suffix=Path(output or "").suffix)
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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one stage; return the exit code.

    That is 0 once the result is there, also if who reads the output has left; 1 for what the user
    can mend; 128 and the number of the signal that ended it.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after the command; those of this process if not given.

    Returns
    -------
    int
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    options = new_parser(arguments).parse_args(arguments)
    try:
        _check_place(options)
        options.stage(options)
        print(end="", flush=True)
    except BrokenPipeError:  # as with `| head`
        return 0
    except Stopped as problem:
        return _fail(problem, 128 + problem.signal)
    except Occupied as problem:
        again = shlex.join(arguments)
        return _fail(f"{problem.args[0]}; to replace it: {called()} {again} --overwrite")
    except UserError as problem:
        return _fail(problem)
    except OSError as problem:  # a disk, a file or a folder that is not as it should be
        where = f"{problem.filename}: " if problem.filename else ""
        return _fail(f"{where}{reason(problem)}")
    except MemoryError as problem:
        return _fail(f"there is not enough memory: {problem}")
    except ModuleNotFoundError as problem:
        return _fail(_not_installed(problem))
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    return 0


def _check_place(options: Namespace) -> None:
    """Refuse an output that would do harm, before anything is computed."""
    if options.suffix:
        from dpd.files import check_output

        outputs = options.output
        for output in outputs if isinstance(outputs, list) else [outputs]:
            check_output(output, options.suffix)


def _not_installed(problem: ModuleNotFoundError) -> str:
    """A sentence on a library that is missing; what misses one of our own modules is a fault."""
    if (problem.name or "dpd").partition(".")[0] in HOMES:
        raise problem
    return (
        f"the library {problem.name!r} is not installed, and this stage needs it: "
        "pip install 'dpd-papers[pipeline]'"
    )


def _fail(problem: Exception | str, code: int = 1) -> int:
    with suppress(OSError):
        print(f"{FAILED}{problem}", file=sys.stderr, flush=True)
    return code
