"""The jobs of a study: their order, what each asks a cluster for, kernels, and what all cost.

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
from dpd.sources import kernels_name
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
GROUPS = {"short": 2.0, "medium": 10.0}  # to the minutes that a job of it takes at most
PROCESSES = 1000  # MB of a run without beads, 200 measured, and of the Snakemakes that start it
BASE_MEMORY = 200.0  # MiB of a process that has imported all and compiled nothing
COPIES = 4  # of the state while it moves: its own, those sorted, those of a checkpoint


def waiting_for_starts(paper: Paper) -> dict[str, list[tuple[str, Point]]]:
    """Digest of each start to the (name of a sweep, point) pairs that need it, in order."""
    waiting: dict[str, list[tuple[str, Point]]] = {}
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            if start_is_shared(point.scene):
                waiting.setdefault(start_digest(point.scene), []).append((sweep.name, point))
    return waiting


def priorities(
    papers: Mapping[str, Paper], first: Sequence[str] = ()
) -> dict[tuple[str, str, str], int]:
    """Priorities of all runs, by paper, sweep and point: the highest begins first; from 1 up.

    The longest run comes first, so that none is left to the end, where a core would wait for it.
    The study may name sweeps that come before, as ``paper.sweep``, that of the greatest worth in
    ``first`` place; of each of them the shortest run is first.
    """
    work = {
        (paper.name, sweep.name, point.name): round(point.scene.work / 1e6)
        for paper in papers.values()
        for sweep in paper.sweeps.values()
        for point in sweep.points
    }
    most = 1 + max(work.values(), default=0)
    worth = {name: len(first) - place for place, name in enumerate(first)}
    found = {}
    for run, amount in work.items():
        of_sweep = worth.get(f"{run[0]}.{run[1]}")
        found[run] = 1 + (amount if of_sweep is None else (of_sweep + 1) * most - amount)
    return found


def start_bead_steps(scene: Scene) -> int:
    """Work of a first configuration, as `dpd.scene.scene.Scene.work` has that of a run."""
    return scene.beads * (scene.relaxing + scene.start.work)


def minutes(bead_steps: float, attempt: int, longest: int) -> int:
    """Minutes of wall clock to ask for, on one core, in a try counted from 1.

    At most ``longest``, what the cluster allows: a run that needs more goes on in its next try.
    """
    asked = math.ceil(BEGINNING + GENEROUS * _expected_minutes(bead_steps))
    return min(attempt * asked, longest)


def megabytes(beads: int, attempt: int) -> int:
    """MB of memory to ask for, `GENEROUS` times those of the beads, in a try counted from 1."""
    return attempt * (PROCESSES + math.ceil(GENEROUS * BYTES_PER_BEAD * beads / 1e6))


def group(bead_steps: float) -> str | None:
    """Name of the group of such a job, of `GROUPS`; None for one that is long enough.

    On a cluster Snakemake submits several jobs of one group together, as many as the profile says.
    """
    expected = _expected_minutes(bead_steps)
    return next((name for name, most in GROUPS.items() if expected < most), None)


def batches(sweep: Sweep, seconds: float) -> list[list[Point]]:
    """Points of a sweep, in their order, whose runs share a job.

    As many as are expected to take some ``seconds`` together, and have the same start.
    """
    found: list[list[Point]] = []
    taken, last = math.inf, ""
    for point in sweep.points:
        expected = 60 * _expected_minutes(point.scene.work)
        start = start_digest(point.scene) if start_is_shared(point.scene) else ""
        if taken + expected > seconds or start != last:
            found.append([])
            taken, last = 0.0, start
        found[-1].append(point)
        taken += expected
    return found


def _expected_minutes(bead_steps):
    return bead_steps / RATE / 60


# --- the kernels that it needs


def with_kernels(scenes: Sequence[Scene], name: str) -> list[Scene]:
    """The scenes that need the kernels of a name; or whose starts do, if none."""
    for of_start in (False, True):
        if found := [scene for scene in scenes if kernels_name(scene, of_start) == name]:
            return found
    raise UserError(f"--kernels: no scene needs {name!r}; leave it out, and all are compiled")


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
