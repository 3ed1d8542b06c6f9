"""The command: `dpd` where it is installed, `python -m dpd` anywhere."""

import gc
import os
import signal
import sys
import warnings
from contextlib import suppress
from typing import NoReturn


def command() -> NoReturn:
    """Do what stands on the command line, and end the process."""
    while os.open(os.devnull, os.O_RDWR) < 3:
        """A file that is opened must not take the place of a standard stream that is closed."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup has it
            signal.signal(number, _end)
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.reconfigure(errors="backslashreplace")  # names of files need not be UTF-8
    warnings.formatwarning = lambda message, *_: f"warning: {message}\n"
    from dpd.commands.main import main

    # Looking for garbage among all that modules and compilers leave behind takes a tenth of the
    # time to import and to compile. It is done seldom, and compiling takes a tenth more memory.
    gc.set_threshold(100_000, 50, 100)
    # All files are closed in the end. Taking LLVM apart would cost each of a study's hundreds of
    # jobs a quarter of a second more.
    os._exit(main())


def _end(number, frame):
    """End here and now, with nothing left that is half done; a run looks for signals itself."""
    if files := sys.modules.get("dpd.files"):  # which takes time to import
        for path in list(files.TEMPORARY):
            with suppress(OSError):
                os.unlink(path)
    with suppress(OSError):
        os.write(2, b"error: interrupted\n")
    os._exit(128 + number)


if __name__ == "__main__":
    command()
