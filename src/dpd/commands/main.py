"""`dpd COMMAND ...`: the parser, and how a command ends."""

import shlex
import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from contextlib import suppress

import dpd
from dpd.commands import COMMANDS, called, user  # noqa: F401  # it declares commands
from dpd.errors import FAILED, Occupied, Stopped, UserError, reason


def new_parser(arguments: Sequence[str] = ()) -> ArgumentParser:
    """The parser of the command that comes first in some arguments; of all where that is none."""
    asked = arguments[0] if arguments else ""
    if asked not in COMMANDS:
        from dpd.commands import pipeline  # noqa: F401  # which users rarely call themselves
    parser = ArgumentParser(
        prog=called(), usage="%(prog)s [-h] [--version] COMMAND ...",
        description="Dissipative particle dynamics: runs, figures, verdicts.",
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"dpd-papers {dpd.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", prog=called())
    for name in [asked] if asked in COMMANDS else COMMANDS:
        command = COMMANDS[name]
        said = command.function.__doc__ or ""
        added = commands.add_parser(name, description=said, help=said.partition("\n")[0])
        for names, settings in command.arguments:
            added.add_argument(*names, **settings)
        added.set_defaults(command=command)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return 0, 1 for what a user can mend, or 128 and the number of a signal."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = new_parser(arguments).parse_args(arguments)
    function, _, output = options.command
    try:
        if output and "." in output:  # a file, no folder: refused before anything is computed
            from dpd.files import check_output, check_place

            check_output(options.output, output[output.rfind(".") :])
            if options.output.parent.exists():  # no folder is made for what may be refused
                check_place(options.output)
        function(options)
        print(end="", flush=True)
    except BrokenPipeError:  # as with `| head`
        return 0
    except Stopped as problem:
        return _fail(problem, 128 + problem.signal)
    except Occupied as problem:
        again = f"{called()} {shlex.join(arguments)} --overwrite"
        return _fail(f"{problem.args[0]}; to replace it: {again}")
    except UserError as problem:
        return _fail(problem)
    except OSError as problem:  # a disk, a file or a folder that is not as it should be
        where = f"{problem.filename}: " if problem.filename else ""
        return _fail(f"{where}{reason(problem)}")
    except MemoryError as problem:
        return _fail(f"there is not enough memory: {problem}")
    except ModuleNotFoundError as problem:
        if (problem.name or "dpd").partition(".")[0] in ("dpd", "paper_figures", "benchmarks"):
            raise  # one of our own is missing, which is a fault
        return _fail(
            f"the library {problem.name!r} is not installed, and this command needs it: "
            "pip install 'dpd-papers[pipeline]'"
        )
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    return 0


def _fail(problem, code=1):
    with suppress(OSError):
        print(f"{FAILED}{problem}", file=sys.stderr, flush=True)
    return code
