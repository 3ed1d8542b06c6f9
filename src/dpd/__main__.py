"""The command: `dpd` where it is installed, `python -m dpd` anywhere."""

import gc
import os
import sys
import warnings
from typing import NoReturn

from dpd.interrupts import watch
from dpd.streams import make_steady


def command() -> NoReturn:
    """Do what stands on the command line, and end the process."""
    make_steady()
    watch()
    warnings.formatwarning = lambda message, *_: f"warning: {message}\n"
    from dpd.commands.main import main  # what is imported from here on may be interrupted

    # Looking for garbage among all that modules and compilers leave behind takes a tenth of the
    # time to import and to compile. It is done seldom, and compiling takes a tenth more memory.
    gc.set_threshold(100_000, 50, 100)
    code = main()
    # All files are closed. Taking LLVM apart would cost each of a study's hundreds of jobs a
    # quarter of a second more.
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)


if __name__ == "__main__":
    command()
