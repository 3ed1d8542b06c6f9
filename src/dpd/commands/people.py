"""What people ask before a study, or of the engine: costs, speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.commands.options import benchmarks
from dpd.errors import UserError

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare these stages."""
    plan = stages.add("plan", _plan, "say what a study costs, by the rates of runs that are there")
    plan.add_argument("--study", help="if not that of config/config.yaml")
    plan.add_argument("--papers", nargs="+", help="if not those of config/config.yaml")
    plan.add_argument("--cores", type=int, default=2, help="cores to share it (default 2)")
    stages.add("bench", _bench, "measure the engine's speed, beside LAMMPS if installed")


def _plan(options: Namespace) -> None:
    from dpd.pipeline.plan import as_text, plan
    from dpd.pipeline.study import read_config, read_paper

    given = {"study": options.study, "papers": options.papers}
    config = read_config({key: value for key, value in given.items() if value})
    papers = [read_paper(name, config["study"]) for name in config["papers"]]
    if options.cores < 1:
        raise UserError(f"--cores: {options.cores} is out of range; allowed: >= 1")
    print(as_text(plan(papers, config["study"]), options.cores))


def _bench(options: Namespace) -> None:
    benchmarks().bench()
