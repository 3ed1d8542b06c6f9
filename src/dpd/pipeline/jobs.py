"""The jobs of a study: what each asks a cluster for, kernels, and what all cost.

A cluster ends a job that takes more than it asked for. Its next try goes on from a checkpoint, and
asks for more: `GENEROUS` times what is expected in the first, then twice, then three times that.
"""

import glob
import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from statistics import median
from typing import Any

from dpd import files
from dpd.errors import UserError
from dpd.pipeline.paper import Paper
from dpd.pipeline.paths import results_of
from dpd.pipeline.sweep import Point, Sweep
from dpd.scene.scene import Scene
from dpd.start import BYTES_PER_BEAD, start_digest

# Bead-steps per second on one core: nine of ten runs of the study `quick` are faster, the slowest
# has 3.6e6; and of all together, on an AMD EPYC (Zen 5).
RATE, USUAL = 5e6, 23e6
OF_RANK, OF_EACH = 0.6e6, 80  # of a rank of LAMMPS, and its MB
PER_JOB = 0.9  # seconds that a job takes beside that: kernels are read, a figure is drawn
GENEROUS = 5  # times what is expected: other processors are slower
STARTUP = 1.0  # minutes: Snakemake and Python start and read kernels, on a slow disk
PROCESSES = 1000  # MB of a run without beads, 200 measured, and of the Snakemakes that start it


def minutes(scenes: Sequence[Scene], attempt: int, longest: int) -> int:
    """Minutes of wall clock for runs with starts, on one core, in the nth try: the next goes on."""
    starts = sum(each.beads * (each.relaxing + each.start.work) for each in scenes)
    seconds = starts / RATE + sum(map(expected, scenes))
    return min(attempt * math.ceil(STARTUP + GENEROUS * seconds / 60), longest)


def expected(scene: Scene) -> float:
    """Seconds that a run takes, on slow processors."""
    return scene.work / (OF_RANK * scene.ranks if "engine" in scene.data else RATE)


def megabytes(scenes: Sequence[Scene], attempt: int) -> int:
    """MB of memory to ask for, `GENEROUS` times those of the beads, in the nth try."""
    beads = max(scene.beads for scene in scenes)
    others = OF_EACH * max(scene.ranks for scene in scenes)
    return attempt * (PROCESSES + others + math.ceil(GENEROUS * BYTES_PER_BEAD * beads / 1e6))


def quickest(paper: Paper) -> list[str]:
    """The sweeps of that figure of a paper which takes the least work, if any are simulated."""

    def work(sweeps):
        return sum(point.scene.work for name in sweeps for point in paper.sweeps[name].points)

    figures = ([s for s in each.sweeps if s in paper.sweeps] for each in paper.figures.values())
    return min(filter(None, figures), key=work, default=[])


def batches(sweep: Sweep, seconds: float) -> list[list[Point]]:
    """Points by jobs, in their order: expected to take ``seconds`` together, from one start."""
    found: list[list[Point]] = []
    taken, last = math.inf, ""
    for point in sweep.points:
        start = start_digest(point.scene) if point.scene.start.work else ""
        if taken + expected(point.scene) > seconds or start != last:
            found.append([])
            taken, last = 0.0, start
        found[-1].append(point)
        taken += expected(point.scene)
    return found


# --- the kernels that it needs


def compile_for(scenes: Iterable[Scene]) -> list[str]:
    """Compile all variants of kernels that scenes need, in one process, as they share most."""
    from dpd.engine.simulation import Simulation
    from dpd.observe.common.measured import observables
    from dpd.start.common.make import compile_start, system_of

    smallest: dict[str, Scene] = {}
    for scene in [stage.scene for each in scenes for stage in each.stages]:
        start = f"from {scene.start.key}", *scene.start_terms
        system = system_of(scene)
        kinds = [f"{scene.dimension} dimensions", "list" if scene.skin else "cells"]
        kinds.append("several species" if len(scene.species) > 1 else "one species")
        for record in (*system.forces, system.scheme):
            if record is not None:
                absent = [name for name, value in record._asdict().items() if value is None]
                kinds.append(" without ".join([type(record).__name__, *absent]))
        variant = ", ".join([*kinds, *scene.observe, *start])
        if scene.beads < smallest.setdefault(variant, scene).beads:
            smallest[variant] = scene
    for scene in smallest.values():
        simulation = Simulation(system_of(scene), compile_start(scene))
        for observer in observables(scene, simulation.system, None, simulation.state):
            if hasattr(observer, "record"):  # sums, which the loop adds up
                continue
            observer.sample(simulation)
            if 2 * observer.every <= scene.steps.sample:  # some compare a sample with that before
                observer.sample(simulation)
    return list(smallest)


# --- what a study will cost


def plan(papers: Iterable[Paper], study: str, seconds: float) -> list[dict[str, Any]]:
    """Cost of every simulated sweep of some papers: a row each, with hours, MB of memory and disk.

    By the median speed of its runs in this study, else by the fastest one in others, which may be
    short, else by `USUAL`: not ``measured``.
    ``seconds``: as of `batches`. Figures are jobs of a paper's first sweep.
    """
    rows: list[dict[str, Any]] = []
    for paper in papers:
        others = len(paper.figures) + len(paper.theory)
        for sweep in paper.sweeps.values():
            runs = [results_of(each).run(paper.name, sweep.name, "*") for each in (study, "*")]
            known = _rates(runs[0]) or [max(_rates(runs[1]), default=0)]
            rate, scenes = median(known) or USUAL, [point.scene for point in sweep.points]
            hours = [scene.work / rate / 3600 for scene in scenes]
            rows.append({
                "paper": paper.name, "sweep": sweep.name, "runs": len(scenes),
                "beads": max(scene.beads for scene in scenes), "rate": rate,
                "core_hours": sum(hours), "longest": max(hours), "memory": megabytes(scenes, 1),
                "disk": sum(map(_kept, scenes)), "measured": any(known),
                "jobs": len(batches(sweep, seconds)) + 1 + others,
            })  # fmt: skip
            others = 0
    return rows


def _rates(pattern):
    """Bead-steps per second of the results that a pattern names."""
    found = []
    for path in glob.glob(pattern):
        with suppress(UserError, KeyError):  # what is damaged will be made anew
            found.append(float(files.attributes(path)["bead_steps_per_second"]))
    return [rate for rate in found if rate > 0]


def _kept(scene):
    """MB of the result of a run at most, without a trajectory beside it."""
    from dpd.observe.common.measured import observables
    from dpd.start.common.make import system_of

    observers = observables(scene, system_of(scene))
    kept = sum(array.nbytes for observer in observers for array in observer.arrays.values())
    state = 8 * scene.beads * (4 * scene.dimension + 2)
    return (state + kept) / 1e6


def as_text(rows: Sequence[Mapping[str, Any]], cores: int) -> str:
    """The plan as a table with a sum; a rate that is not measured stands in brackets."""
    import pandas as pd

    if not rows:
        return "no runs"
    table, shown_hours = pd.DataFrame(rows), "{:.2f}".format
    rates = zip(table.rate / 1e6, table.measured)
    shown = table.drop(columns=["measured", "jobs"]).assign(
        rate=[f"{rate:.2f}" if known else f"({rate:.1f})" for rate, known in rates]
    )
    names = {"rate": "10^6/s", "core_hours": "core-h", "longest": "longest h"}
    formats = {"core-h": shown_hours, "longest h": shown_hours, "MB/job": "{:.0f}".format}
    shown = shown.rename(columns=names | {"memory": "MB/job", "disk": "disk MB"})
    total = table.core_hours.sum() + table.jobs.sum() * PER_JOB / 3600
    hours = max(total / cores, table.longest.max())
    text = (
        f"{shown.to_string(index=False, formatters=formats, float_format='%.1f')}\n"
        f"{table.runs.sum()} runs in {table.jobs.sum()} jobs: {total:.2f} core-hours, "
        f"{f'{60 * hours:.0f} minutes' if hours < 2 else f'{hours:.1f} hours'} on {cores} cores; "
        f"{table.disk.sum():.0f} MB of results at most, without trajectories"
    )
    if table.measured.all():
        return text
    return (
        f"{text}\nRates in brackets are not measured: {USUAL / 1e6:g}e6 bead-steps/s, the mean "
        "over all of 'quick'. Runs of any study measure them: --config study=smoke first."
    )
