"""Stages of the pipeline that simulate or calculate: from kernels to the table of a sweep."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.commands.options import (
    LITTLE,
    add_checkpoints,
    add_data,
    add_derived,
    add_threads,
    benchmarks,
    data_of,
    options_of,
    resolved_sweep,
    sweep_of,
    theory_of,
)
from dpd.errors import FAILED, Stopped, UserError

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare these stages."""
    compile_ = stages.add(
        "compile", _compile, "compile what a study needs", "study", "papers",
        output="made.txt",
    )  # fmt: skip
    compile_.add_argument(
        "--kernels", metavar="NAME", help="only scenes that need these, as Snakemake calls them"
    )  # fmt: skip
    stages.add(
        "start", _start, "make a first configuration",
        "study", "paper", "sweep", "point", output="start.nc",
    )  # fmt: skip
    simulate = stages.add(
        "simulate", _simulate, "run some points of a sweep, one after the other",
        "study", "paper", "sweep", "points", output="run.nc",
    )  # fmt: skip
    simulate.add_argument(
        "--start",
        type=Path,
        metavar="FILE",
        help="their first configuration; without it, it is made",
    )
    add_derived(simulate)
    add_checkpoints(simulate)
    add_threads(simulate)
    collect = stages.add(
        "collect", _collect, "gather a sweep", "study", "paper", "sweep", output="sweep.nc"
    )
    collect.add_argument(
        "--runs", type=Path, required=True, metavar="FOLDER", help="with POINT/run.nc of each point"
    )
    add_derived(collect)
    derive = stages.add(
        "derive", _derive, "find values of a sweep's scenes that other sweeps measure",
        "study", "paper", "sweep", output="sweep.csv",
    )  # fmt: skip
    add_data(derive)
    stages.add(
        "calculate", _calculate, "calculate a sweep of theory; of a former file only what changed",
        "study", "paper", "sweep", output="sweep.nc",
    )  # fmt: skip
    stages.add("measure", _measure, "make a measurement of the benchmark", "name", output="name.nc")


def _compile(options: Namespace) -> None:
    from dpd.files import replace_whole
    from dpd.pipeline.compiling import compile_for, with_kernels
    from dpd.pipeline.study import read_paper

    scenes = []
    for paper in options.papers:
        for sweep in read_paper(paper, options.study).sweeps.values():
            scenes += [point.scene for point in sweep.points]
    if options.kernels is not None:
        scenes = with_kernels(scenes, options.kernels)
    compiled = compile_for(scenes)
    replace_whole(options.output, lambda draft: draft.write_text("\n".join(compiled) + "\n"))


def _start(options: Namespace) -> None:
    from dpd.files import check_room
    from dpd.progress import Progress
    from dpd.start import start_work
    from dpd.start.common.files import write_start

    scene = sweep_of(options, [options.point]).point(options.point).scene
    check_room(options.output, LITTLE)
    with Progress(start_work(scene), f"{options.sweep} start") as progress:
        write_start(scene, options.output, progress)


def _simulate(options: Namespace) -> None:
    from dpd.runs.run import run

    if len(options.output) != len(options.points):
        raise UserError("-o: name one run.nc for each point, in their order")
    sweep = resolved_sweep(options, options.points)
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


def _collect(options: Namespace) -> None:
    from dpd.analysis.collect import collect, save
    from dpd.pipeline.paths import run_file

    sweep = resolved_sweep(options)
    paths = [run_file(options.runs, point.name) for point in sweep.points]
    save(collect(sweep, paths), options.output)


def _derive(options: Namespace) -> None:
    from dpd.analysis.collect import load
    from dpd.analysis.derive import derive
    from dpd.pipeline.derived import write_derived

    sweep = sweep_of(options)
    if not sweep.derived:
        raise UserError(f"sweep {sweep.name}: nothing is derived; see 'derive' in config/README.md")
    paths = data_of(options, {rule.source for rule in sweep.derived})
    sources = {name: load(path) for name, path in paths.items()}
    write_derived(derive(sweep, sources), options.output)


def _calculate(options: Namespace) -> None:
    from dpd.analysis.collect import save
    from dpd.files import check_room
    from dpd.pipeline.calculate import calculate
    from dpd.progress import Progress

    sweep = theory_of(options)
    check_room(options.output, LITTLE)
    with Progress(len(sweep.points), f"{sweep.name}") as progress:
        data = calculate(sweep, options.output, progress)
    save(data, options.output)
    print(f"points: {len(sweep.points)}, of which calculated now: {data.points_calculated}")


def _measure(options: Namespace) -> None:
    from dpd.files import check_room

    check_room(options.output, LITTLE)
    benchmarks().measure(options.name, options.output, say=lambda line: print(line, flush=True))
