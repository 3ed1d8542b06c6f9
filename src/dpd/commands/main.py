"""`python -m dpd STAGE ...`: what the rules call, and what a person can paste."""

from __future__ import annotations

import shlex
import sys
from typing import TYPE_CHECKING

from dpd.commands.parser import called, new_parser
from dpd.errors import FAILED, Occupied, Stopped, UserError, reason
from dpd.interrupts import asked
from dpd.sources import HOMES
from dpd.streams import unprinted

if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one stage; return the exit code.

    That is 0 once the result is there, whether or not its summary could be printed; 1 for what
    the user can mend; 128 and the number of the signal that ended it.

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
        if options.prints and (problem := unprinted()):
            raise UserError(f"standard output: cannot be written ({reason(problem)})")
    except Stopped as problem:
        return _fail(problem, 128 + asked())
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

        check_output(options.output, options.suffix)


def _not_installed(problem: ModuleNotFoundError) -> str:
    """A sentence on a library that is missing; what misses one of our own modules is a fault."""
    if (problem.name or "dpd").partition(".")[0] in HOMES:
        raise problem
    return (
        f"the library {problem.name!r} is not installed, and this stage needs it: "
        "pip install 'dpd-papers[pipeline]'"
    )


def _fail(problem: Exception | str, code: int = 1) -> int:
    print(f"{FAILED}{problem}", file=sys.stderr)
    return code
