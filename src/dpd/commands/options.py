"""Options that several stages share."""

from __future__ import annotations

import importlib
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dpd.arguments import THREADS_PER_CORE, count, seconds
from dpd.digest import ROOT
from dpd.errors import UserError

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace
    from collections.abc import Collection, Mapping, Sequence
    from types import ModuleType

    from dpd.pipeline.sweep import Sweep
    from dpd.pipeline.theory import TheorySweep
    from dpd.runs.run import Options

LITTLE = 2**20  # bytes of a result whose size is not known before


def add_threads(parser: ArgumentParser) -> None:
    """How many threads share the work of a run."""
    parser.add_argument(
        "--threads", type=count, default=1, metavar="N",
        help=f"threads that share the work (default 1, at most {THREADS_PER_CORE} per core); the "
        "results are the same bits",
    )  # fmt: skip


def add_checkpoints(parser: ArgumentParser) -> None:
    """How often the state of a run is kept while it runs."""
    parser.add_argument(
        "--checkpoint-every", type=seconds, default=60.0, metavar="SECONDS",
        help="wall clock between checkpoints (default 60; 0: as often as the run looks at the "
        "clock); the same command resumes from one",
    )  # fmt: skip


def options_of(options: Namespace, **more: Any) -> Options:
    """How a run is carried out, as a command's options and some more say."""
    from dpd.runs.run import Options

    overwrite = getattr(options, "overwrite", False)
    return Options(
        options.threads, options.checkpoint_every, overwrite,
        signals=(signal.SIGINT, signal.SIGTERM, signal.SIGHUP), **more,
    )  # fmt: skip


def print_summary(found: Mapping[str, float]) -> None:
    """What a run of one's own has found."""
    for name, value in found.items():
        print(f"{name:32s} {value:.6g}")


def add_overwrite(parser: ArgumentParser) -> None:
    """Whether a file that is there may be lost."""
    parser.add_argument(
        "--overwrite", action="store_true",
        help="replace what is in the place of the output; without it, that stays",
    )  # fmt: skip


def add_derived(parser: ArgumentParser) -> None:
    """What other sweeps have measured for the stage's own."""
    parser.add_argument(
        "--derived", type=Path, metavar="FILE",
        help="what other sweeps have measured for this one, from `derive`, if it needs that",
    )  # fmt: skip


def add_data(parser: ArgumentParser) -> None:
    """Collected sweeps and measurements that a result is made from."""
    parser.add_argument(
        "--data", type=Path, nargs="*", default=[], metavar="FILE",
        help="collected sweeps and measurements that it is made from, in any order",
    )  # fmt: skip


def sweep_of(options: Namespace, points: Sequence[str] = ()) -> Sweep:
    """The sweep that a stage is about, of those that are simulated; with named points alone."""
    from dpd.pipeline.study import read_paper

    paper = read_paper(options.paper, options.study, [options.sweep], points)
    if options.sweep in paper.theory:
        raise UserError(
            f"sweep {options.sweep}: it is calculated and has no runs; the stage for it is: "
            "python -m dpd calculate"
        )
    return paper.sweeps[options.sweep]


def theory_of(options: Namespace) -> TheorySweep:
    """The sweep that a stage is about, of those that are calculated."""
    from dpd.pipeline.study import read_paper

    paper = read_paper(options.paper, options.study, only=[options.sweep])
    if options.sweep in paper.sweeps:
        raise UserError(
            f"sweep {options.sweep}: its points are runs; the stages for it are: python -m dpd "
            "simulate, and collect"
        )
    return paper.theory[options.sweep]


def resolved_sweep(options: Namespace, points: Sequence[str] = ()) -> Sweep:
    """The same with what other sweeps have measured for it."""
    from dpd.pipeline.derived import resolved

    return resolved(sweep_of(options, points), options.derived)


def data_of(options: Namespace, names: Collection[str]) -> dict[str, Path]:
    """Files of the sweeps and measurements that are wanted, by name, out of those given."""
    from dpd.analysis.collect import name_of

    given = {name_of(path): path for path in options.data}
    for name in names:
        if name not in given:
            raise UserError(f"--data: none of the files is {name!r}, which is needed; add its file")
    return {name: given[name] for name in names}


def benchmarks() -> ModuleType:
    """The module `benchmarks.measure`, which stands beside the package in a clone alone."""
    if not (ROOT / "benchmarks" / "measure.py").is_file():
        raise UserError(
            f"{ROOT / 'benchmarks'}: there is no such folder; speed is measured in a clone of the "
            "repository: change into one"
        )
    sys.path.insert(0, str(ROOT))
    return importlib.import_module("benchmarks.measure")
