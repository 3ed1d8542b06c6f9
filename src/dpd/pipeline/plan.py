"""What a study will cost, by the speed of runs that are there already."""

from __future__ import annotations

import glob
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd import files
from dpd.errors import UserError
from dpd.observe.common.measured import observables
from dpd.pipeline.jobs import RATE
from dpd.pipeline.paths import results_of
from dpd.start.common.make import system_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from dpd.pipeline.paper import Paper
    from dpd.scene.scene import Scene

BASE_MEMORY = 200.0  # MiB of a process that has imported all and compiled nothing
COPIES = 4  # of the state while it moves: its own, those sorted, those of a checkpoint


def plan(papers: Iterable[Paper], study: str) -> list[dict[str, Any]]:
    """Cost of every sweep of some papers: a row each, in the order of `HEADER`, and ``measured``.

    A sweep's speed is the median of its runs in this study, or else in others; where there are
    none, `RATE` stands for it and ``measured`` is false. Hours of a sweep of theory are NaN until
    it was calculated once.
    """
    rows = []
    for paper in papers:
        for sweep in paper.sweeps.values():
            scenes = [point.scene for point in sweep.points]
            work = np.array([scene.work for scene in scenes], dtype=float)
            known = _rates(study, paper.name, sweep.name) or _rates("*", paper.name, sweep.name)
            rate = float(np.median(known)) if known else RATE
            sizes = [sizes_of(scene) for scene in scenes]
            rows.append({
                "paper": paper.name, "sweep": sweep.name, "runs": len(scenes),
                "beads": max(scene.beads for scene in scenes), "bead_steps": work.sum(),
                "rate": rate, "core_hours": work.sum() / rate / 3600,
                "longest": work.max() / rate / 3600,
                "memory": BASE_MEMORY + max(COPIES * each.state + each.kept for each in sizes),
                "disk": sum(sum(each) for each in sizes), "measured": bool(known),
            })  # fmt: skip
        for name, theory in paper.theory.items():
            seconds = _seconds_of_theory(results_of(study).sweep(paper.name, name))
            rows.append({
                "paper": paper.name, "sweep": name, "runs": len(theory.points), "beads": 0,
                "bead_steps": 0.0, "rate": np.nan, "core_hours": seconds / 3600,
                "longest": seconds / 3600, "memory": BASE_MEMORY, "disk": 0.0,
                "measured": bool(np.isfinite(seconds)),
            })  # fmt: skip
    return rows


def _rates(study, paper, sweep):
    """Bead-steps per second of the runs of a sweep that are done."""
    found = []
    for path in glob.glob(results_of(study).run(paper, glob.escape(sweep), "*")):
        with suppress(UserError, AttributeError):  # what is damaged will be made anew
            found.append(float(files.attribute(path, "bead_steps_per_second")))
    return [rate for rate in found if rate > 0]


def _seconds_of_theory(path):
    """How long a calculation took; NaN if there is none."""
    with suppress(UserError, AttributeError):
        return float(files.attribute(path, "seconds"))
    return np.nan


class Sizes(NamedTuple):
    """MiB of a scene's state, of what its observables keep, and of files that they write."""

    state: float
    kept: float
    beside: float


def sizes_of(scene: Scene) -> Sizes:
    """The `Sizes` of a scene."""
    observers = observables(scene, system_of(scene))
    kept = sum(array.nbytes for observer in observers for array in observer.arrays.values())
    beside = sum(getattr(observer, "file_bytes", 0) for observer in observers)
    state = 8 * scene.beads * (4 * scene.dimension + 2)
    return Sizes(*(size / 2**20 for size in (state, kept, beside)))


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
            f"{row['bead_steps']:10.2e} {'-' if np.isnan(row['rate']) else rate:>8s} "
            f"{_hours(row['core_hours']):>8s} {_hours(row['longest']):>9s} "
            f"{row['memory']:8.0f} {row['disk']:8.1f}"
        )
    hours = np.nansum([row["core_hours"] for row in rows])
    longest = np.nanmax([0.0, *(row["longest"] for row in rows)])
    lines.append(
        f"{sum(row['runs'] for row in rows)} runs: {hours:.1f} core-hours, "
        f"{max(hours / cores, longest):.1f} hours on {cores} cores at best; "
        f"{sum(row['disk'] for row in rows):.0f} MiB of results at most"
    )
    if not all(row["measured"] or np.isnan(row["rate"]) for row in rows):
        lines.append(
            f"Rates in brackets are not measured: {RATE / 1e6:g}e6 bead-steps/s, which nine of ten "
            "runs of the study 'quick' exceed. Runs of any study measure them: make a small one "
            "first (--config study=smoke)."
        )
    return "\n".join(lines)


def _hours(hours):
    return "-" if np.isnan(hours) else f"{hours:.2f}"
