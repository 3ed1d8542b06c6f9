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
from dpd.start import BYTES_PER_BEAD

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
BASE_MEMORY = 200.0  # MiB of a process that has imported all and compiled nothing
COPIES = 4  # of the state while it moves: its own, those sorted, those of a checkpoint


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


def batches(sweep: Sweep, seconds: float) -> list[list[Point]]:
    """Points of a sweep, in their order, whose runs share a job.

    As many as are expected to take some ``seconds`` together.
    """
    found: list[list[Point]] = []
    taken = math.inf
    for point in sweep.points:
        expected = point.scene.work / RATE
        if taken + expected > seconds:
            found.append([])
            taken = 0.0
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
        variant = ", ".join([*_kernels(scene, system_of(scene)), *scene.observe])
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
    """Cost of every sweep of some papers: a row each, in the order of `HEADER`, and ``measured``.

    A sweep's speed is the median of its runs in this study, or else in others; where there are
    none, `RATE` stands for it and ``measured`` is false. Hours of a sweep of theory are NaN until
    it was calculated once.
    """
    rows = []
    for paper in papers:
        for sweep in paper.sweeps.values():
            known = _rates(study, paper.name, sweep.name) or _rates("*", paper.name, sweep.name)
            rate = median(known or [RATE])
            row = {"paper": paper.name, "sweep": sweep.name, "rate": rate, "measured": bool(known)}
            rows.append(row | _cost([point.scene for point in sweep.points], rate))
        for name, theory in paper.theory.items():
            path, seconds = results_of(study).sweep(paper.name, name), math.nan
            with suppress(UserError, AttributeError):
                seconds = float(files.attribute(path, "seconds"))
            rows.append({
                "paper": paper.name, "sweep": name, "runs": len(theory.points), "beads": 0,
                "bead_steps": 0.0, "rate": math.nan, "core_hours": seconds / 3600,
                "longest": seconds / 3600, "memory": BASE_MEMORY, "disk": 0.0,
                "measured": not math.isnan(seconds),
            })  # fmt: skip
    return rows


def _rates(study, paper, sweep):
    """Bead-steps per second of the runs of a sweep that are done."""
    found = []
    for path in glob.glob(results_of(study).run(paper, glob.escape(sweep), "*")):
        with suppress(UserError, AttributeError):  # what is damaged will be made anew
            found.append(float(files.attribute(path, "bead_steps_per_second")))
    return [rate for rate in found if rate > 0]


def _cost(scenes, rate):
    """Work, hours, and MiB of memory and disk of some runs."""
    work = [scene.work for scene in scenes]
    sizes = [_sizes(scene) for scene in scenes]
    return {
        "runs": len(scenes), "beads": max(scene.beads for scene in scenes),
        "bead_steps": float(sum(work)), "core_hours": sum(work) / rate / 3600,
        "longest": max(work) / rate / 3600,
        "memory": BASE_MEMORY + max(COPIES * state + kept for state, kept, _ in sizes),
        "disk": sum(map(sum, sizes)),
    }  # fmt: skip


def _sizes(scene):
    """MiB of a scene's state, of what its observables keep, and of files that they write."""
    from dpd.observe.common.measured import observables
    from dpd.start.common.make import system_of

    observers = observables(scene, system_of(scene))
    kept = sum(array.nbytes for observer in observers for array in observer.arrays.values())
    written = sum(getattr(observer, "file_bytes", 0) for observer in observers)
    state = 8 * scene.beads * (4 * scene.dimension + 2)
    return [size / 2**20 for size in (state, kept, written)]


HEADER = (
    f"{'paper':20s} {'sweep':24s} {'runs':>5s} {'beads':>7s} {'bead-steps':>10s} {'10^6/s':>8s} "
    f"{'core-h':>8s} {'longest h':>9s} {'MiB/job':>8s} {'disk MiB':>8s}"
)


def as_text(rows: Sequence[Mapping[str, Any]], cores: int) -> str:
    """The plan as a table with a sum; a rate that is not measured stands in brackets."""
    lines = [HEADER]
    for row in rows:
        rate = f"{row['rate'] / 1e6:.2f}" if row["measured"] else f"({row['rate'] / 1e6:.1f})"
        lines.append(
            f"{row['paper']:20s} {row['sweep']:24s} {row['runs']:5d} {row['beads']:7d} "
            f"{row['bead_steps']:10.2e} {'-' if math.isnan(row['rate']) else rate:>8s} "
            f"{_hours(row['core_hours']):>8s} {_hours(row['longest']):>9s} "
            f"{row['memory']:8.0f} {row['disk']:8.1f}"
        )
    hours = sum(row["core_hours"] for row in rows if not math.isnan(row["core_hours"]))
    longest = max([0.0, *(row["longest"] for row in rows if not math.isnan(row["longest"]))])
    lines.append(
        f"{sum(row['runs'] for row in rows)} runs: {hours:.1f} core-hours, "
        f"{max(hours / cores, longest):.1f} hours on {cores} cores at best; "
        f"{sum(row['disk'] for row in rows):.0f} MiB of results at most"
    )
    if not all(row["measured"] or math.isnan(row["rate"]) for row in rows):
        lines.append(
            f"Rates in brackets are not measured: {RATE / 1e6:g}e6 bead-steps/s, which nine of ten "
            "runs of the study 'quick' exceed. Runs of any study measure them: make a small one "
            "first (--config study=smoke)."
        )
    return "\n".join(lines)


def _hours(hours):
    return "-" if math.isnan(hours) else f"{hours:.2f}"
