"""What of a study runs, waits, is done or failed, and how long the rest will take.

Nothing is written, no lock is taken, and Snakemake is not asked: a study may be at work meanwhile.
"""

from __future__ import annotations

import glob
import heapq
import math
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from dpd.errors import UserError, reason
from dpd.pipeline.derived import resolved
from dpd.pipeline.jobs import JobStatus, jobs_of, open_logs
from dpd.pipeline.lock import lock_of
from dpd.pipeline.paths import Results, page_suffix
from dpd.pipeline.run_status import AT_WORK, DONE, WAITS, RunStatus, look_at
from dpd.pipeline.study import read_config, read_paper

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from dpd.pipeline.study import Paper
    from dpd.pipeline.sweep import Sweep


@dataclass(frozen=True)
class Left:
    """How long the runs that are not done will take, by the rates of those that have run.

    Starts, compilation, figures and pages are not in it.

    Attributes
    ----------
    core_seconds : float or None
        Of all of them together; None where no run has a rate yet.
    cores : int
        Jobs that are at work now.
    seconds : float or None
        Of wall clock on so many cores; None where nothing is at work, or no rate is known.
    borrowed : int
        Runs whose rate is that of other sweeps, because no run of theirs has one.
    """

    core_seconds: float | None
    cores: int
    seconds: float | None
    borrowed: int


@dataclass(frozen=True)
class Status:
    """A study, or some runs of one's own, as they are now.

    Attributes
    ----------
    folder : str
        Of the results; or a path of a run.
    study : str
        Nothing for runs of one's own.
    time : float
        As `time.time` has it.
    runs : list of RunStatus
    jobs : list of JobStatus
        What else the study makes.
    left : Left
    """

    folder: str
    study: str
    time: float
    runs: list[RunStatus]
    jobs: list[JobStatus]
    left: Left


class Study:
    """A study that is looked at again and again.

    Parameters
    ----------
    study : str
    folder : str
        Of its results.
    papers : list of str or None
        Those of config/config.yaml if None.

    Raises
    ------
    UserError
        If the configuration is not right.
    """

    def __init__(self, study: str, folder: str, papers: Sequence[str] | None = None) -> None:
        all_papers = read_config()["papers"]
        names = papers or all_papers
        self._study, self._results = study, Results(folder)
        self._papers = [read_paper(name, study) for name in names]
        self._page = page_suffix(names, all_papers)

    def look(self) -> Status:
        """The study as it is now."""
        _check_readable(self._results.folder)
        writing = open_logs(self._results.logs)
        runs = [run for paper in self._papers for run in self._runs(paper, writing)]
        runs += _others(self._results, {run.path for run in runs})
        done = [run.path for run in runs if run.state == DONE]
        jobs = jobs_of(self._papers, self._results, self._page, done, writing)
        return Status(
            self._results.folder, self._study, time.time(), runs, jobs, left_of(runs, jobs)
        )

    def _runs(self, paper: Paper, writing: frozenset[str]) -> Iterator[RunStatus]:
        """Those of a paper, in the order of its sweeps."""
        for planned in paper.sweeps.values():
            sweep, why = _resolved(planned, self._results.derived(paper.name, planned.name))
            for point in sweep.points:
                run = look_at(
                    (paper.name, sweep.name, point.name),
                    self._results.run(paper.name, sweep.name, point.name),
                    point.scene,
                    self._results.log(paper.name, "runs", sweep.name, point.name),
                    writing,
                )
                if why and run.state == DONE:
                    run = replace(run, state=WAITS, work=float(point.scene.work))
                yield replace(run, why=why) if why and run.state == WAITS else run


def _resolved(sweep: Sweep, table: str) -> tuple[Sweep, str]:
    """A sweep with what others measure for it, as far as that is known; and what it waits for."""
    try:
        return resolved(sweep, table), ""
    except UserError:
        sources = ", ".join(sorted({rule.source for rule in sweep.derived}))
        return sweep, f"it takes values that other sweeps measure first: {sources}"


def _others(results: Results, known: set[str]) -> list[RunStatus]:
    """Runs at work in the folder of a study that are not of the study as it is planned now."""
    found = []
    locks = lock_of(Results(glob.escape(results.folder)).run("*", "*", "*"))
    for lock in sorted(glob.glob(str(locks))):
        path = lock.removesuffix(locks.suffix)
        if path not in known:
            paper, _, sweep, point = Path(path).relative_to(results.folder).parts[:4]
            run = look_at((paper, sweep, point), path)
            if run.state == AT_WORK:
                found.append(replace(run, why="it is not in the study as it is now"))
    return found


def _check_readable(folder):
    """Refuse a folder that cannot be read; one that is not there has no results yet."""
    try:
        os.listdir(folder)
    except FileNotFoundError:
        pass
    except OSError as problem:
        raise UserError(f"{folder}: cannot be read ({reason(problem)})") from None


class _Rate(NamedTuple):
    """Bead-steps per second; and whether it is that of other sweeps."""

    value: float
    borrowed: bool


class _Rates:
    """Rates of the runs of a study that have one: means over work, by sweep, by paper, of all."""

    def __init__(self, runs: Sequence[RunStatus]) -> None:
        self._sums: dict[tuple[str, ...], list[float]] = {}
        for run in runs:
            if run.rate and run.beads and run.steps:
                work = float(run.beads * run.steps)
                for length in range(3):
                    sums = self._sums.setdefault(run.name[:length], [0.0, 0.0])
                    sums[0] += work
                    sums[1] += work / (run.rate * run.beads)

    def of(self, run: RunStatus) -> _Rate | None:
        """The rate of the runs that are most like one: of its sweep, its paper, or all."""
        for length in (2, 1, 0):
            if sums := self._sums.get(run.name[:length]):
                return _Rate(sums[0] / sums[1], length < 2)
        return None


def left_of(runs: Sequence[RunStatus], jobs: Sequence[JobStatus] = ()) -> Left:
    """What the runs that are not done will take, begun in the order that Snakemake takes.

    Parameters
    ----------
    runs : list of RunStatus
    jobs : list of JobStatus

    Returns
    -------
    Left
    """
    rates, borrowed = _Rates(runs), 0
    at_work: list[float] = []
    waiting: list[float] = []
    for run in runs:
        if run.state == DONE:
            continue
        seconds = run.seconds_left
        if seconds is None:
            rate = rates.of(run)
            if rate is None or math.isnan(run.work):
                return Left(None, _at_work(runs, jobs), None, 0)
            seconds = run.work / rate.value
            borrowed += rate.borrowed
        (at_work if run.state == AT_WORK else waiting).append(seconds)
    cores, total = _at_work(runs, jobs), sum(at_work) + sum(waiting)
    if not cores:
        return Left(total, 0, None, borrowed)
    free = [*at_work, *[0.0] * (cores - len(at_work))]  # when each core is free again
    heapq.heapify(free)
    for seconds in sorted(waiting, reverse=True):  # the longest first
        heapq.heapreplace(free, free[0] + seconds)
    return Left(total, cores, max(free), borrowed)


def _at_work(runs, jobs):
    """How many jobs are at work."""
    return sum(each.state == AT_WORK for each in (*runs, *jobs))
