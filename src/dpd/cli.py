"""`python -m dpd STAGE ...`: what the rules call, and what a person can paste."""

import argparse
import os
import sys
from pathlib import Path

from dpd.arguments import THREADS_PER_CORE, count, seconds
from dpd.errors import Stopped, UserError, reason
from dpd.interrupts import asked
from dpd.streams import unprinted

LITTLE = 2**20  # bytes of a result whose size is not known before
SEVERAL = {"papers": "+", "tables": "*"}  # arguments that are lists


def main(arguments: list[str] | None = None) -> int:
    """Run one stage; return the exit code.

    That is 0 once the result is there, whether or not its summary could be printed; 1 for what
    the user can mend; 128 and the number of the signal that ended it.
    """
    options = _parser().parse_args(arguments)
    try:
        _check_place(options)
        options.stage(options)
        if options.prints and (problem := unprinted()):
            raise UserError(f"standard output: cannot be written ({reason(problem)})")
    except Stopped as problem:
        return _fail(problem, 128 + asked())
    except UserError as problem:
        return _fail(problem)
    except OSError as problem:  # a disk, a file or a folder that is not as it should be
        where = f"{problem.filename}: " if problem.filename else ""
        return _fail(f"{where}{reason(problem)}")
    except MemoryError as problem:
        return _fail(f"there is not enough memory: {problem}")
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    return 0


def _check_place(options):
    """Refuse an output that would do harm, before anything is computed."""
    if options.suffix:
        from dpd.files import check_output

        check_output(options.output, options.suffix)


def _fail(problem, code=1):
    print(f"error: {problem}", file=sys.stderr)
    return code


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m dpd", description="Dissipative particle dynamics: runs, figures, verdicts."
    )
    stages = parser.add_subparsers(title="stages", required=True, metavar="STAGE")

    def stage(name, function, help, *names, output=None, prints=False):
        sub = stages.add_parser(name, help=help, description=help)
        for argument in names:
            sub.add_argument(argument, nargs=SEVERAL.get(argument))
        if output:
            sub.add_argument("-o", "--output", required=True, type=Path, help=output)
        sub.set_defaults(stage=function, suffix=Path(output or "").suffix, prints=prints)
        return sub

    run = stage("run", _run, "run a scene of your own", "scene", output="run.nc")
    run.add_argument(
        "--checkpoint-every", type=seconds, default=60.0, metavar="SECONDS",
        help="wall clock between checkpoints (default 60; 0: as often as the run looks at the "
        "clock); the same command resumes from one",
    )  # fmt: skip
    run.add_argument(
        "--start", type=Path, metavar="FILE",
        help="first configuration: read if the file is there, otherwise made and kept in it",
    )  # fmt: skip
    _add_threads(run)
    stage("bench", _bench, "measure the engine's speed, beside LAMMPS if installed", prints=True)
    stage("measure", _measure, "make a measurement of the benchmark", "name", output="name.nc")
    compile_ = stage(
        "compile", _compile, "compile what a study needs", "study", "papers",
        output="made.txt",
    )  # fmt: skip
    compile_.add_argument(
        "--terms", nargs="*", metavar="TERM",
        help="only scenes in which just these act: bond, core, exchange, langevin, or none",
    )  # fmt: skip
    stage(
        "start", _start, "make a first configuration",
        "study", "paper", "sweep", "point", output="start.nc",
    )  # fmt: skip
    simulate = stage(
        "simulate", _simulate, "run one point of a sweep",
        "study", "paper", "sweep", "point", output="run.nc",
    )  # fmt: skip
    simulate.add_argument(
        "--start", type=Path, metavar="FILE", help="first configuration; without it, it is made"
    )
    _add_derived(simulate)
    _add_threads(simulate)
    collect = stage(
        "collect", _collect, "gather a sweep", "study", "paper", "sweep", output="sweep.nc"
    )
    collect.add_argument(
        "--runs", type=Path, required=True, metavar="FOLDER", help="with POINT/run.nc of each point"
    )
    _add_derived(collect)
    derive = stage(
        "derive", _derive, "find values of a sweep's scenes that other sweeps measure",
        "study", "paper", "sweep", output="sweep.csv",
    )  # fmt: skip
    _add_data(derive)
    figure = stage("figure", _figure, "make a figure", "study", "paper", "figure", output="folder")
    _add_data(figure)
    figure.add_argument(
        "--traceback", type=Path, metavar="FILE",
        help="where to keep the whole traceback if the figure's file raises something",
    )  # fmt: skip
    stage("verdicts", _verdicts, "join the verdict tables of figures", "tables", output="table.csv")
    report = stage("report", _report, "write the report", "study", "papers", output="report.html")
    report.add_argument(
        "--results", type=Path, required=True, metavar="FOLDER", help="results of the study"
    )
    report.add_argument("--archived", type=Path, metavar="FILE", help="verdicts of a long study")
    plan = stage(
        "plan", _plan, "say what a study costs before it runs, from measured rates", prints=True
    )
    plan.add_argument("--study", help="if not that of config/config.yaml")
    plan.add_argument("--papers", nargs="+", help="if not those of config/config.yaml")
    plan.add_argument("--cores", type=int, default=2, help="cores to share it (default 2)")
    show = stage(
        "show", _show, "say which values a study runs, and which file each comes from", prints=True
    )
    show.add_argument("study")
    show.add_argument("paper")
    show.add_argument("sweep", nargs="?", help="without it: what the study replaces in the paper")
    stage(
        "schemes", _schemes, "write config/schemes.yaml, for scheme auto, from the benchmark",
        "study", output="schemes.yaml",
    )  # fmt: skip
    stage("archive", _archive, "keep in git what a study has found", "study")
    stage("readme", _readme, "write README.md's tables, config/README.md and the papers' pages")
    return parser


def _add_threads(parser):
    parser.add_argument(
        "--threads", type=count, default=1, metavar="N",
        help=f"threads that share the work (default 1, at most {THREADS_PER_CORE} per core); the "
        "results are the same bits",
    )  # fmt: skip


def _add_derived(parser):
    parser.add_argument(
        "--derived", type=Path, metavar="FILE",
        help="what other sweeps have measured for this one, from `derive`, if it needs that",
    )  # fmt: skip


def _add_data(parser):
    parser.add_argument(
        "--data", type=Path, nargs="*", default=[], metavar="FILE",
        help="collected sweeps and measurements that it is made from, in any order",
    )  # fmt: skip


def _run(options):
    from dpd.files import check_output
    from dpd.pipeline.running import Order, run_alone
    from dpd.scene.scene import Scene

    inputs = [options.scene, *([options.start] if options.start else [])]
    check_output(options.output, ".nc", inputs)
    if options.start and not options.start.exists():
        check_output(options.start, ".nc", [options.scene])
    scene = Scene.read(options.scene)
    for sentence in scene.notes:
        print(sentence)
    found = run_alone(
        Order(
            scene, options.output, options.scene, options.start, keep_start=True,
            threads=options.threads, every_seconds=options.checkpoint_every, inputs=tuple(inputs),
        )
    )  # fmt: skip
    for name, value in found.items():
        print(f"{name:32s} {value:.6g}")


def _bench(options):
    from dpd.benchmark.speed import against_lammps, as_text

    print(as_text(against_lammps(say=print)))


def _measure(options):
    from dpd.benchmark.measure import measure
    from dpd.files import check_room

    check_room(options.output, LITTLE)
    measure(options.name, options.output, say=lambda line: print(line, flush=True))


def _compile(options):
    from dpd.files import replace_whole
    from dpd.pipeline.compiling import compile_for, with_terms
    from dpd.pipeline.study import read_paper

    scenes = []
    for paper in options.papers:
        for sweep in read_paper(paper, options.study).sweeps.values():
            scenes += [point.scene for point in sweep.points]
    if options.terms is not None:
        scenes = with_terms(scenes, frozenset(options.terms))
    compiled = compile_for(scenes)
    replace_whole(options.output, lambda draft: draft.write_text("\n".join(compiled) + "\n"))


def _sweep(options):
    from dpd.pipeline.study import read_paper

    return read_paper(options.paper, options.study, only=[options.sweep]).sweeps[options.sweep]


def _resolved_sweep(options):
    """The sweep with what other sweeps have measured for it."""
    from dpd.pipeline.derived import resolved

    return resolved(_sweep(options), options.derived)


def _data_of(options, names):
    """Files of the sweeps and measurements that are wanted, by name, out of those given."""
    from dpd.analysis.collect import name_of

    given = {name_of(path): path for path in options.data}
    for name in names:
        if name not in given:
            raise UserError(f"--data: none of the files is {name!r}, which is needed; add its file")
    return {name: given[name] for name in names}


def _start(options):
    from dpd.files import check_room
    from dpd.progress import Progress
    from dpd.scene.start import start_work
    from dpd.start.files import write_start

    scene = _sweep(options).point(options.point).scene
    check_room(options.output, LITTLE)
    with Progress(start_work(scene), f"{options.sweep} start") as progress:
        write_start(scene, options.output, progress)


def _simulate(options):
    from dpd.files import check_output
    from dpd.pipeline.running import Order, run_alone
    from dpd.pipeline.simulate import is_made

    inputs = (options.start,) if options.start else ()
    check_output(options.output, ".nc", inputs)
    sweep = _resolved_sweep(options)
    scene = sweep.point(options.point).scene
    # Snakemake cannot know that what was measured anew came out as before.
    if sweep.derived and is_made(scene, options.output):
        options.output.touch()
        print(f"{options.output}: is there already, of the same scene and the same sources")
        return
    found = run_alone(
        Order(
            scene, options.output, f"{options.sweep} {options.point}", options.start,
            threads=options.threads, inputs=inputs, wait=True,
        )
    )  # fmt: skip
    print(", ".join(f"{name} {value:.6g}" for name, value in found.items()))


def _collect(options):
    from dpd.analysis.collect import collect, save
    from dpd.pipeline.paths import run_file

    sweep = _resolved_sweep(options)
    paths = [run_file(options.runs, point.name) for point in sweep.points]
    save(collect(sweep, paths), options.output)


def _derive(options):
    from dpd.analysis.collect import load
    from dpd.analysis.derive import derive
    from dpd.pipeline.derived import write_derived

    sweep = _sweep(options)
    if not sweep.derived:
        raise UserError(f"sweep {sweep.name}: nothing is derived; see 'derive' in config/README.md")
    paths = _data_of(options, {rule.source for rule in sweep.derived})
    sources = {name: load(path) for name, path in paths.items()}
    write_derived(derive(sweep, sources), options.output)


def _figure(options):
    from dpd.files import replace_whole
    from dpd.pipeline.study import read_paper
    from dpd.report.figure_file import BrokenFigure
    from dpd.report.figures import make_figure

    paper = read_paper(options.paper, options.study, only=[])
    if options.figure not in paper.figures:
        from dpd.scene.schema import suggestion

        raise UserError(
            f"figure: {options.figure!r} is not in config/papers/{options.paper}.yaml; "
            f"{suggestion(options.figure, paper.figures)}"
        )
    figure = paper.figures[options.figure]
    sources = _data_of(options, (*figure.sweeps, *figure.measurements))
    try:
        make_figure(options.paper, options.figure, sources, options.output)
    except BrokenFigure as problem:
        if options.traceback is None:
            raise UserError(f"{problem}; --traceback FILE keeps the whole traceback") from None
        text = problem.whole_traceback()
        replace_whole(options.traceback, lambda draft: draft.write_text(text))
        raise UserError(f"{problem}; the whole traceback is in {options.traceback}") from None


def _verdicts(options):
    from dpd.files import replace_whole
    from dpd.report.figures import joined_verdicts

    table = joined_verdicts(options.tables)
    replace_whole(options.output, lambda draft: table.to_csv(draft, index=False))


def _report(options):
    from dpd.pipeline.study import read_paper, read_study
    from dpd.report.overhead import overhead
    from dpd.report.page import write_page

    papers = [read_paper(name, options.study) for name in options.papers]
    description = read_study(options.study)["description"]
    # Set by the Snakefile: a parameter that differs every time would make the page again.
    begun, cores = (os.environ.get(f"DPD_{name}") for name in ("BEGUN", "CORES"))
    cost = overhead(options.results, float(begun), int(cores)) if begun and cores else ""
    write_page(
        options.study, description, papers, options.results, options.output, cost, options.archived
    )


def _plan(options):
    from dpd.pipeline.plan import as_text, plan
    from dpd.pipeline.study import read_config, read_paper
    from dpd.progress import Progress

    given = {"study": options.study, "papers": options.papers}
    config = read_config({key: value for key, value in given.items() if value})
    papers = [read_paper(name, config["study"]) for name in config["papers"]]
    if options.cores < 1:
        raise UserError(f"--cores: {options.cores} is out of range; allowed: >= 1")
    with Progress(sum(len(paper.sweeps) for paper in papers), "measuring rates") as progress:
        rows = plan(papers, progress=progress)
    print(as_text(rows, options.cores))


def _show(options):
    from dpd.pipeline.overlay import overview, sweep_in_force

    if options.sweep is None:
        print(overview(options.study, options.paper))
    else:
        print(sweep_in_force(options.study, options.paper, options.sweep))


def _schemes(options):
    from dpd.files import replace_whole
    from dpd.pipeline.paths import results_of
    from dpd.report.recommended import recommendations

    text = recommendations(Path(results_of(options.study).figures("benchmark")))
    replace_whole(options.output, lambda draft: draft.write_text(text))


def _archive(options):
    from dpd.benchmark.measure import processor
    from dpd.report.whole_archive import Machine, keep

    for path in keep(options.study, Machine(processor(), os.cpu_count())):
        print(f"kept: {path}")
    print("now: python -m dpd readme")


def _readme(options):
    from dpd.report.pages import write_pages

    for path in write_pages():
        print(f"written: {path}")
