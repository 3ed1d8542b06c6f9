"""What runs, waits, is done or failed: of a study, or of a run of one's own."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.arguments import pause

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages
    from dpd.pipeline.status import RunStatus


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    status = stages.add(
        "status", _status, "say what runs, how far it is, what failed, and what is left"
    )
    status.description = (
        "Of a study: its runs at work with step, kT, pressure and speed; what is done, waits, was "
        "stopped or failed, and why. Of runs of your own the same. It only reads."
    )
    status.add_argument(
        "path", nargs="?", type=Path,
        help="results of a study, as results/quick (default: of that in config/config.yaml); or "
        "run.nc of a run of your own, or its folder",
    )  # fmt: skip
    status.add_argument("--papers", nargs="+", help="if not those of config/config.yaml")
    status.add_argument(
        "--watch", type=pause, metavar="SECONDS", help="again and again, with that pause"
    )
    status.add_argument("--json", action="store_true", help="as one line of JSON, for scripts")


def _status(options: Namespace) -> None:
    import json
    from dataclasses import asdict

    from dpd.pipeline.status import as_text, of_snakemake, seconds_left

    while True:
        title, runs = _look(options.path, options.papers)
        if options.json:
            found = {"time": time.time(), "seconds_left": seconds_left(runs)}
            print(json.dumps(found | {"runs": [asdict(run) for run in runs]}), flush=True)
        else:
            of_study = any(len(run.name) > 1 for run in runs)
            said = of_snakemake() if of_study else ""
            print("\n".join(filter(None, [as_text(runs, title), said])), flush=True)
        if options.watch is None:
            return
        time.sleep(options.watch)


def _look(path: Path | None, papers: list[str] | None) -> tuple[str, list[RunStatus]]:
    """What to look at: a study or runs of one's own; with a title."""
    from dpd.errors import UserError
    from dpd.pipeline.paths import results_of
    from dpd.pipeline.status import own_status, runs_in, study_status
    from dpd.pipeline.study import CONFIG, SEEDED, read_config, studies

    study = read_config()["study"] if path is None else path.resolve().name
    folder = results_of(study).folder if path is None or str(path) == study else str(path)
    if path is not None and path.is_dir() and runs_in(path):
        return str(path), own_status(path)
    seeded = SEEDED.fullmatch(study)
    named = seeded[1] if seeded else study
    if (CONFIG / "config.yaml").is_file() and named in studies():
        return folder, study_status(study, folder, papers)
    if path is None or path.is_dir():
        raise UserError(
            f"{path or folder}: no study in config/config.yaml has the name {study!r}, and no run "
            "lies there; allowed: the folder of a study's results, as results/quick; run.nc of a "
            "run, or a folder with such results"
        )
    return str(path), own_status(path)
