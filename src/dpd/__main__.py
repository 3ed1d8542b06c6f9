"""`python -m dpd`."""

import gc
import os
import sys
import warnings

from dpd.interrupts import watch
from dpd.streams import make_steady

make_steady()
watch()
warnings.formatwarning = lambda message, *_: f"warning: {message}\n"

from dpd.commands.main import main  # noqa: E402  what is imported from here on may be interrupted

# Looking for garbage among all that modules and compilers leave behind takes a tenth of the time
# to import and to compile. It is done seldom, and compiling takes a tenth more memory for it.
gc.set_threshold(100_000, 50, 100)

code = main()
# All files are closed. Taking LLVM apart would cost each of a study's hundreds of jobs a quarter
# of a second more.
for stream in (sys.stdout, sys.stderr):
    stream.flush()
os._exit(code)
