"""Commands of papers and studies: what rules call, and what people ask before and after a study."""

import importlib
import math
import sys
import traceback
from argparse import Namespace
from collections.abc import Collection
from pathlib import Path

from dpd.commands import CHECKPOINTS, THREADS, command, option, options_of, positive
from dpd.commands.user import write_texts
from dpd.errors import FAILED, Stopped, UserError, suggestion
from dpd.folders import ROOT, shortened

DATA = option(
    "--data", type=Path, nargs="*", default=[], metavar="FILE",
    help="collected sweeps and measurements that it takes values from, in any order",
)  # fmt: skip


@command(
    option("--study", help="if not that of config/config.yaml"),
    option("--papers", nargs="+", help="if not those of config/config.yaml"),
    option("--cores", type=int, default=2, help="cores to share it (default 2)"),
)
def plan(options: Namespace) -> None:
    """Say what a study costs, by the rates of runs that are there."""
    from dpd.pipeline.jobs import as_text, plan
    from dpd.pipeline.paper import read_config, read_paper

    given = {"study": options.study, "papers": options.papers}
    config = read_config({key: value for key, value in given.items() if value})
    papers = [read_paper(name, config["study"]) for name in config["papers"]]
    if options.cores < 1:
        raise UserError(f"--cores: {options.cores} is out of range; allowed: >= 1")
    print(as_text(plan(papers, config["study"], config["batch"]), options.cores))


@command()
def bench(options: Namespace) -> None:
    """Measure the engine's speed, beside LAMMPS if installed."""
    _of_clone("benchmarks.measure").bench()


def _of_clone(name):
    """A module of the repository that is not installed with the package."""
    if not (ROOT / f"{name.replace('.', '/')}.py").is_file():
        raise UserError("this command is for a clone of the repository: change into one")
    sys.path.insert(0, str(ROOT))
    return importlib.import_module(name)


@command(
    "study", option("papers", nargs="+"),
    option("--kernels", metavar="NAME", help="only scenes that need these, as Snakemake has them"),
    output="made.txt",
)  # fmt: skip
def compile_(options: Namespace) -> None:
    """Compile what a study needs."""
    from dpd.digests import kernels_name
    from dpd.pipeline.jobs import compile_for
    from dpd.pipeline.paper import read_paper

    papers = [read_paper(paper, options.study) for paper in options.papers]
    sweeps = [sweep for paper in papers for sweep in paper.sweeps.values()]
    scenes = [point.scene for sweep in sweeps for point in sweep.points]
    if options.kernels is not None:
        scenes = [scene for scene in scenes if kernels_name(scene) == options.kernels]
    write_texts({options.output: "\n".join(compile_for(scenes)) + "\n"})


@command("study", "paper", "sweep", "point", output="start.nc")
def start(options: Namespace) -> None:
    """Make a first configuration, such as a melt whose chains grow."""
    from dpd.pipeline.paper import read_paper
    from dpd.runs import Progress
    from dpd.start import start_work
    from dpd.start.common.files import write_start

    paper = read_paper(options.paper, options.study, [options.sweep], [options.point])
    if options.sweep not in paper.sweeps:
        raise UserError(f"sweep {options.sweep}: is calculated, and starts from no configuration")
    scene = paper.sweeps[options.sweep].point(options.point).scene
    with Progress(start_work(scene), f"{options.sweep} start") as progress:
        write_start(scene, options.output, progress)


def _sweep(options, calculated=False):
    """The sweep that a command is about, with what other sweeps have measured for it."""
    from dpd.pipeline.paper import read_paper

    points = getattr(options, "points", ())
    paper = read_paper(options.paper, options.study, [options.sweep], points)
    if calculated != (options.sweep in paper.theory):
        other = "simulate, and then: collect" if calculated else "calculate"
        raise UserError(f"sweep {options.sweep}: the command for it is: python -m dpd {other}")
    sweep = (paper.theory if calculated else paper.sweeps)[options.sweep]
    if not sweep.derived:
        return sweep
    from dpd.analysis.collect import load
    from dpd.analysis.structure import derive

    paths = _data(options, {rule.from_ for rule in sweep.derived.values()})
    return derive(sweep, {name: load(path) for name, path in paths.items()})


@command(
    "study", "paper", "sweep", option("points", nargs="+"),
    option("-o", "--output", required=True, type=Path, nargs="+", help="run.nc of each point"),
    option("--start", type=Path, metavar="FILE",
           help="their first configuration; without it, it is made"),
    DATA, CHECKPOINTS, THREADS,
)  # fmt: skip
def simulate(options: Namespace) -> None:
    """Run some points of a sweep, one after the other."""
    from dpd.runs.run import run

    if len(options.output) != len(options.points):
        raise UserError("-o: name one run.nc for each point, in their order")
    sweep = _sweep(options)
    points = [sweep.point(name) for name in options.points]
    failed = 0
    for point, output in zip(points, options.output):
        name = f"{options.sweep} {point.name}"
        try:
            found = run(point.scene, output, options.start, options_of(options, label=name))
            said = ", ".join(f"{quantity} {value:.6g}" for quantity, value in found.items())
            print(f"{name}: {said}", flush=True)
        except Stopped:
            raise
        except UserError as problem:  # the other points are worth running all the same
            if len(points) == 1:
                raise UserError(f"{name}: {problem}") from None
            print(f"{FAILED}{name}: {problem}", file=sys.stderr, flush=True)
            failed += 1
    if failed:
        raise UserError(f"{failed} of {len(points)} points failed")


@command(
    "study", "paper", "sweep",
    option("--runs", type=Path, required=True, metavar="FOLDER",
           help="with POINT/run.nc of each point"),
    DATA, output="sweep.nc",
)  # fmt: skip
def collect(options: Namespace) -> None:
    """Gather a sweep."""
    from dpd.analysis.collect import collect, save
    from dpd.pipeline.paths import run_file

    sweep = _sweep(options)
    paths = [run_file(options.runs, point.name) for point in sweep.points]
    save(collect(sweep, paths), options.output)


def _data(options: Namespace, names: Collection[str]) -> dict[str, Path]:
    """Files of the sweeps and measurements that are wanted, by name, out of those given."""
    from dpd.files import attributes

    given = {}
    for path in options.data:
        made = attributes(path)
        given[str(made["sweep" if "sweep" in made else "measurement"])] = path
    for name in names:
        if name not in given:
            raise UserError(f"--data: none of the files is {name!r}, which is needed; add its file")
    return {name: given[name] for name in names}


@command("study", "paper", "sweep", output="sweep.nc")
def calculate(options: Namespace) -> None:
    """Calculate a sweep of theory."""
    from dpd.analysis.collect import calculate, save
    from dpd.runs import Progress

    sweep = _sweep(options, calculated=True)
    with Progress(len(sweep.points), f"{sweep.name}") as progress:
        data = calculate(options.paper, sweep, progress)
    save(data, options.output)


@command(
    "study", "paper", "figure", DATA,
    option("--traceback", type=Path, metavar="FILE",
           help="where to keep the whole traceback if the figure's file raises something"),
    output="folder",
)  # fmt: skip
def figure(options: Namespace) -> None:
    """Make a figure."""
    from dpd.pipeline.paper import file_of_paper, read_paper
    from dpd.report.figures import make_figure

    figures = read_paper(options.paper, options.study, only=[]).figures
    if options.figure not in figures:
        where = shortened(file_of_paper("papers", options.paper))
        allowed = suggestion(options.figure, figures)
        raise UserError(f"figure: {options.figure!r} is not in {where}; {allowed}")
    figure = figures[options.figure]
    sources = _data(options, (*figure.sweeps, *figure.measurements))
    try:
        make_figure(options.paper, options.figure, sources, options.output)
    except UserError as problem:
        if options.traceback and problem.__cause__:
            text = "".join(traceback.format_exception(problem.__cause__))
            write_texts({options.traceback: text})
        raise


@command(option("tables", nargs="*"), output="table.csv")
def verdicts(options: Namespace) -> None:
    """Join the verdict tables of figures."""
    from dpd.report.archive import table_text
    from dpd.report.rows import read_rows

    write_texts({options.output: table_text(read_rows(*options.tables)).decode()})


NAMED = "a study, a folder of its results or archive, or a verdict table"


@command(option("one", help=NAMED), option("other", help=NAMED))
def compare(options: Namespace) -> None:
    """Say whether two studies differ as their error bars predict."""
    from dpd.report.archive import as_text, compared, table_of

    print(as_text(compared(table_of(options.one), table_of(options.other))))


@command(
    "study",
    option("--runs-from", type=positive, default=math.inf, metavar="HOURS",
           help="also keep runs of the long study that took so long or longer, for `restore`"),
)  # fmt: skip
def archive(options: Namespace) -> None:
    """Keep in git what a study has found."""
    from dpd.report.archive import keep

    for path in keep(options.study, options.runs_from):
        print(f"kept: {path}")
    print("now: python -m dpd readme")


@command("study")
def restore(options: Namespace) -> None:
    """Take runs of the long study from the archive."""
    from dpd.report.archive import restore

    paths = [f"restored: {path}" for path in restore(options.study)]
    print("\n".join(paths or ["nothing to do: all runs that the archive keeps are there"]))


@command("study")
def redraw(options: Namespace) -> None:
    """Draw and judge archived figures again, from their numbers."""
    from dpd.report.archive import redraw

    for path in redraw(options.study):
        print(f"changed: {path}")
    print("now: python -m dpd readme")


@command()
def readme(options: Namespace) -> None:
    """Write README.md's tables, the pages in config and those of papers."""
    for path in _of_clone("docs.pages").write_pages():
        print(f"written: {path}")
