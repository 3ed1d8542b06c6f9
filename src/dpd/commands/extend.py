"""A finished run made longer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dpd.arguments import steps
from dpd.commands.options import (
    add_checkpoints,
    add_overwrite,
    add_threads,
    options_of,
    print_summary,
)

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    extend = stages.add("extend", _extend, "make a finished run longer", "run")
    extend.description = (
        "Go on with a finished run, to the same bits as if it had been planned that long. "
        "Killed or stopped, the same command goes on."
    )
    extend.add_argument(
        "--sample", type=steps, required=True, metavar="STEPS", help="steps of sampling to add"
    )
    extend.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="longer.nc (default: in the place of the run, once it is whole)",
    )  # fmt: skip
    add_checkpoints(extend)
    add_threads(extend)
    add_overwrite(extend)


def _extend(options: Namespace) -> None:
    from dpd.runs.extend import extend

    run = Path(options.run)
    output = options.output or run
    print_summary(extend(run, options.sample, output, options_of(options, own=True)))
