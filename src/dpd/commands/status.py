"""What runs, waits, is done or failed: of a study, or of a run of one's own."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.arguments import pause

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.parser import Stages
    from dpd.pipeline.own_runs import OwnRuns
    from dpd.pipeline.status import Study

LOOK = 0.1  # s between looks whether it should stop
CLEAR = b"\033[H\033[J"  # moves to the upper left corner of a terminal and empties it


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    status = stages.add(
        "status", _status, "say what runs, how far it is, what failed, and what is left",
        prints=True,
    )  # fmt: skip
    status.description = (
        "Of a study: its runs at work with step, kT, pressure, speed and time left; what is done, "
        "waits, was stopped or failed, and why. Of runs of your own the same. It only reads."
    )
    status.add_argument(
        "path", nargs="?", type=Path,
        help="results of a study, as results/quick (default: of that in config/config.yaml); or "
        "run.nc of a run of your own, or its folder",
    )  # fmt: skip
    status.add_argument("--papers", nargs="+", help="if not those of config/config.yaml")
    status.add_argument(
        "--watch", type=pause, metavar="SECONDS",
        help="again and again, with that pause, until Ctrl-C; the configuration is read once",
    )  # fmt: skip
    status.add_argument("--json", action="store_true", help="as one line of JSON, for scripts")


def _status(options: Namespace) -> None:
    from dpd.interrupts import asked, listening
    from dpd.pipeline.status_text import as_json, as_text
    from dpd.streams import is_heard

    seen = _seen(options.path, options.papers)
    form = as_json if options.json else as_text
    if options.watch is None:
        print(form(seen.look()))
        return
    with listening():
        while not asked() and is_heard():
            text = form(seen.look())
            on_screen = sys.stdout.isatty() and not options.json
            if on_screen:
                os.write(sys.stdout.fileno(), CLEAR)
            print(text, end="\n" if options.json else "\n\n")
            sys.stdout.flush()
            end = time.monotonic() + options.watch
            while time.monotonic() < end and not asked():
                time.sleep(LOOK)


def _seen(path: Path | None, papers: list[str] | None) -> Study | OwnRuns:
    """What to look at: a study or runs of one's own."""
    from dpd.errors import UserError
    from dpd.pipeline.own_runs import ALLOWED, OwnRuns, result_of, runs_in
    from dpd.pipeline.paths import results_of
    from dpd.pipeline.status import Study
    from dpd.pipeline.study import CONFIG, SEEDED, read_config, studies

    if path is None:
        study = read_config()["study"]
        return Study(study, results_of(study).folder, papers)
    if path.is_dir() and runs_in(path):
        return OwnRuns(path)
    study = path.resolve().name
    seeded = SEEDED.fullmatch(study)
    named = seeded[1] if seeded else study
    is_study = (CONFIG / "config.yaml").is_file() and named in studies()
    if is_study and (path.is_dir() or not path.exists()):
        is_name = not path.is_dir() and str(path) == study  # as in `dpd status smoke`
        return Study(study, results_of(study).folder if is_name else str(path), papers)
    if path.is_dir():
        raise UserError(
            f"{path}: no study in config/config.yaml has the name {study!r}, and no run lies "
            f"there; {ALLOWED}"
        )
    return OwnRuns(result_of(path))
