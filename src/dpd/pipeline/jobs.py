"""What Snakemake's rules ask of the jobs of a study: their files, which comes first, what it needs.

A cluster ends a job that takes more than it asked for. A run that is ended keeps a checkpoint, and
the next try asks for more; still it is cheaper to ask for enough. So a job asks for `GENEROUS`
times what is expected, in its second try for twice that, in its third for three times.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from dpd.start import BYTES_PER_BEAD, start_digest, start_is_shared

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

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
    """Priorities of all runs: that of the highest number begins first.

    The longest run comes first, so that none is left to the end, where a core would wait for it.
    The study may name sweeps that come before, in the order of their worth; the shortest run of
    each of these comes first, so that much of it is whole whenever somebody stops the study.

    ``first``: sweeps as ``paper.sweep``, the one of the greatest worth in front. Result: from
    paper, sweep and point to a number from 1 up.
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
