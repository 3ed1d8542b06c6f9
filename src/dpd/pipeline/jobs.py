"""The jobs of a study: what each asks a cluster for, kernels, and what all cost.

A cluster ends a job that takes more than it asked for. A run that is ended keeps a checkpoint, and
the next try asks for more; still it is cheaper to ask for enough. So a job asks for `GENEROUS`
times what is expected, in its second try for twice that, in its third for three times.
"""

from __future__ import annotations

import glob
import math
from contextlib import suppress
from statistics import median
from typing import TYPE_CHECKING, Any

from dpd import files
from dpd.errors import UserError
from dpd.pipeline.paths import results_of
from dpd.start import BYTES_PER_BEAD, start_digest, start_is_shared

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from dpd.pipeline.paper import Paper
    from dpd.pipeline.sweep import Point, Sweep
    from dpd.scene.scene import Scene

# Bead-steps per second on one core: nine of ten runs of the study `quick` are faster, and the
# slowest of them, which follows displacements in many beads, has 1.1e6.
RATE = 3e6
GENEROUS = 3  # times what is expected
BEGINNING = 1.0  # minutes: Snakemake and Python start and read kernels, on a slow disk
PROCESSES = 1000  # MB of a run without beads, 200 measured, and of the Snakemakes that start it


def minutes(scenes: Sequence[Scene], attempt: int, longest: int) -> int:
    """Minutes of wall clock to ask for, on one core, for runs with their starts, in the nth try.

    At most ``longest``, what the cluster allows: a run that needs more goes on in its next try.
    """
    work = sum(each.work + each.beads * (each.relaxing + each.start.work) for each in scenes)
    return min(attempt * math.ceil(BEGINNING + GENEROUS * work / RATE / 60), longest)


def megabytes(scenes: Sequence[Scene], attempt: int) -> int:
    """MB of memory to ask for, `GENEROUS` times those of the beads, in the nth try."""
    beads = max(scene.beads for scene in scenes)
    return attempt * (PROCESSES + math.ceil(GENEROUS * BYTES_PER_BEAD * beads / 1e6))


def quickest(paper: Paper) -> list[str]:
    """The sweeps of that figure of a paper which takes the least work, if any are simulated."""

    def work(sweeps):
        return sum(point.scene.work for name in sweeps for point in paper.sweeps[name].points)

    figures = ([s for s in each.sweeps if s in paper.sweeps] for each in paper.figures.values())
    return min(filter(None, figures), key=work, default=[])


def batches(sweep: Sweep, seconds: float) -> list[list[Point]]:
    """Points of a sweep, in their order, whose runs share a job.

    As many as are expected to take some ``seconds`` together, and share their start, if any.
    """
    found: list[list[Point]] = []
    taken, last = math.inf, ""
    for point in sweep.points:
        expected = point.scene.work / RATE
        start = start_digest(point.scene) if start_is_shared(point.scene) else ""
        if taken + expected > seconds or start != last:
            found.append([])
            taken, last = 0.0, start
        found[-1].append(point)
        taken += expected
    return found


# --- the kernels that it needs


def compile_for(scenes: Iterable[Scene]) -> list[str]:
    """Compile every variant of the kernels that some scenes need; a line on each.

    All in one process: most of what a variant is made of is that of others, and what a process
    has compiled once it does not compile again.
    """
    from dpd.engine.simulation import Simulation
    from dpd.observe.common.measured import observables
    from dpd.start.common.make import compile_start, system_of

    smallest: dict[str, Scene] = {}
    for scene in [stage.scene for each in scenes for stage in each.stages]:
        start = f"from {scene.start.key}", *scene.start_terms
        variant = ", ".join([*_kernels(scene, system_of(scene)), *scene.observe, *start])
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


def _kernels(scene, system):
    """What decides which kernels of the engine a scene needs, in words.

    Numba compiles a kernel for each class of a record, and for which of its fields are None.
    """
    yield f"{scene.dimension} dimensions"
    yield "several species" if len(scene.species) > 1 else "one species"
    for record in (*system.forces, system.scheme):
        if record is not None:
            absent = [name for name, value in record._asdict().items() if value is None]
            yield " without ".join([type(record).__name__, *absent])
    yield "list" if scene.skin else "cells"


# --- what a study will cost


def plan(papers: Iterable[Paper], study: str) -> list[dict[str, Any]]:
    """Cost of every sweep of some papers: a row each, with hours, and MB of memory and disk.

    A sweep's speed is the median of its runs in this study, or else in others; where there are
    none, `RATE` stands for it and ``measured`` is false. Sweeps of theory take seconds or minutes.
    """
    rows: list[dict[str, Any]] = []
    for paper in papers:
        for sweep in paper.sweeps.values():
            runs = [results_of(each).run(paper.name, sweep.name, "*") for each in (study, "*")]
            known = _rates(runs[0]) or _rates(runs[1])
            rate, scenes = median(known or [RATE]), [point.scene for point in sweep.points]
            hours = [scene.work / rate / 3600 for scene in scenes]
            rows.append({
                "paper": paper.name, "sweep": sweep.name, "runs": len(scenes),
                "beads": max(scene.beads for scene in scenes), "rate": rate,
                "core_hours": sum(hours), "longest": max(hours), "memory": megabytes(scenes, 1),
                "disk": sum(map(_kept, scenes)), "measured": bool(known),
            })  # fmt: skip
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
    table, hours = pd.DataFrame(rows), "{:.2f}".format
    rates = zip(table.rate / 1e6, table.measured)
    shown = table.drop(columns="measured").assign(
        rate=[f"{rate:.2f}" if known else f"({rate:.1f})" for rate, known in rates]
    )
    names = {"rate": "10^6/s", "core_hours": "core-h", "longest": "longest h"}
    formats = {"core-h": hours, "longest h": hours, "MB/job": "{:.0f}".format}
    shown = shown.rename(columns=names | {"memory": "MB/job", "disk": "disk MB"})
    total, longest = table.core_hours.sum(), table.longest.max()
    text = (
        f"{shown.to_string(index=False, formatters=formats, float_format='%.1f')}\n"
        f"{table.runs.sum()} runs: {total:.1f} core-hours, {max(total / cores, longest):.1f} hours "
        f"on {cores} cores at best; {table.disk.sum():.0f} MB of results at most, "
        "without trajectories"
    )
    if table.measured.all():
        return text
    return (
        f"{text}\nRates in brackets are not measured: {RATE / 1e6:g}e6 bead-steps/s, which nine of "
        "ten runs of the study 'quick' exceed. Runs of any study measure them: make a small one "
        "first (--config study=smoke)."
    )
