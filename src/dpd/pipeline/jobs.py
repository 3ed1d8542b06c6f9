"""The jobs of a study beside its runs, as they are now: kernels, starts, sweeps, figures, pages.

Their files say less than those of runs. A job counts as done if its files are there, and are not
older than what they are made from, which must be made itself. Snakemake knows more: it remembers
the sources of each.
"""

from __future__ import annotations

import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from dpd.pipeline.made_from import (
    data_of_figure,
    derived_from,
    kernels_for,
    page_sources,
    verdicts_of,
    waiting_for_starts,
)
from dpd.pipeline.run_status import AT_WORK, DONE, FAILS, WAITS, last_error, tail_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Sequence

    from dpd.pipeline.paths import Results
    from dpd.pipeline.study import Paper

STEP = re.compile(r"step \d+ of \d+ \(.*\)$")  # ends a line of `dpd.progress.Progress`
WRITING = os.O_WRONLY | os.O_RDWR
FIGURE_FILES = ("png", "pdf", "nc", "csv", "html")


class Job(NamedTuple):
    """A job that is no run.

    Attributes
    ----------
    kind : str
        What it makes: kernels, start, theory, sweep, derived, measurement, figure, verdicts or
        report.
    name : str
    outputs : tuple of str
    log : str
    inputs : tuple of str
        Files that it is made from.
    """

    kind: str
    name: str
    outputs: tuple[str, ...]
    log: str
    inputs: tuple[str, ...] = ()


@dataclass(frozen=True)
class JobStatus:
    """Such a job as it is now.

    Attributes
    ----------
    kind, name, log : str
        As of a `Job`.
    state : str
        At work, done, failed, or waits.
    why : str
        The error, or how far it is.
    """

    kind: str
    name: str
    log: str
    state: str
    why: str = ""


def jobs_of(
    papers: Sequence[Paper], results: Results, page: str, runs: Iterable[str],
    writing: Collection[str],
) -> list[JobStatus]:  # fmt: skip
    """All jobs of a study that are no runs.

    Parameters
    ----------
    papers : list of Paper
    results : Results
    page : str
        What the names of report and verdict table end in.
    runs : iterable of str
        Results of the runs that are done.
    writing : collection of str
        From `open_logs`.

    Returns
    -------
    list of JobStatus
    """
    found, made = [], set(runs)
    for job in [*(job for paper in papers for job in _jobs(paper, results)),
                *_pages(papers, results, page)]:  # fmt: skip
        found.append(_status(job, made, writing))
        if found[-1].state == DONE:
            made.update(job.outputs)
    return found


def _jobs(paper: Paper, results: Results) -> Iterator[Job]:
    """The jobs of a paper, each after those whose files it needs."""
    name = paper.name
    for kernels in kernels_for(paper):
        log = results.log(name, "compiled", kernels)
        yield Job("kernels", f"{name} {kernels}", (results.compiled(name, kernels),), log)
    for start, ((sweep, _), *_) in waiting_for_starts(paper).items():
        log = results.log(name, "starts", start)
        yield Job("start", f"{name} {sweep} {start}", (results.start(name, start),), log)
    for theory in paper.theory:
        log = results.log(name, "sweeps", theory)
        yield Job("theory", f"{name} {theory}", (results.sweep(name, theory),), log)
    for sweep in paper.sweeps.values():
        if not sweep.derived:
            yield _collection(paper, sweep, results)
    for sweep in paper.sweeps.values():
        if sweep.derived:
            sources = derived_from(results, name, sweep)
            log = results.log(name, "derived", sweep.name)
            table = results.derived(name, sweep.name)
            yield Job("derived", f"{name} {sweep.name}", (table,), log, tuple(sources))
            yield _collection(paper, sweep, results, table)
    for measurement in paper.measurements:
        log = results.log(name, "measurements", measurement)
        file = results.measurement(name, measurement)
        yield Job("measurement", f"{name} {measurement}", (file,), log)
    for figure, feeds in paper.figures.items():
        inputs = data_of_figure(results, name, feeds)
        log = results.log(name, "figures", figure)
        outputs = tuple(results.figure(name, figure, kind) for kind in FIGURE_FILES)
        yield Job("figure", f"{name} {figure}", outputs, log, tuple(inputs))


def _collection(paper, sweep, results, *derived):
    """The job that puts the runs of a sweep on its axes."""
    runs = [results.run(paper.name, sweep.name, point.name) for point in sweep.points]
    log = results.log(paper.name, "sweeps", sweep.name)
    file = results.sweep(paper.name, sweep.name)
    return Job("sweep", f"{paper.name} {sweep.name}", (file,), log, (*runs, *derived))


def _pages(papers: Sequence[Paper], results: Results, page: str) -> Iterator[Job]:
    """The verdict table and the report."""
    log = results.log(f"verdicts{page}")
    yield Job(
        "verdicts", "all", (results.verdicts(page),), log, tuple(verdicts_of(results, papers))
    )
    log = results.log(f"report{page}")
    yield Job("report", "all", (results.report(page),), log, tuple(page_sources(results, papers)))


def _status(job: Job, made: set[str], writing: Collection[str]) -> JobStatus:
    about = job.kind, job.name, job.log
    if os.path.abspath(job.log) in writing:
        steps = [found[0] for line in tail_of(job.log) if (found := STEP.search(line))]
        return JobStatus(*about, AT_WORK, steps[-1] if steps else "")
    if made.issuperset(job.inputs) and _is_new(job.outputs, job.inputs):
        return JobStatus(*about, DONE)
    error = last_error(job.log)
    return JobStatus(*about, FAILS, error) if error else JobStatus(*about, WAITS)


def _is_new(outputs, inputs):
    """Whether all outputs are there, none older than an input."""
    try:
        made = min(os.stat(path).st_mtime_ns for path in outputs)
        return all(os.stat(path).st_mtime_ns <= made for path in inputs)
    except OSError:
        return False


def open_logs(folder: str | Path) -> frozenset[str]:
    """Logs below a folder that a process of this machine is writing: its job is at work.

    A rule passes what its command says to `tee`, which has the log open as long as the command
    lives. Of processes of other users and machines nothing is seen.

    Parameters
    ----------
    folder : path

    Returns
    -------
    frozenset of str
        Absolute paths.
    """
    begins, found = f"{os.path.abspath(folder)}{os.sep}", set()
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # another user's, or it has just ended
            for link in os.scandir(process / "fd"):
                path = os.readlink(link.path)
                if path.startswith(begins) and _is_written(process / "fdinfo" / link.name):
                    found.add(path)
    return frozenset(found)


def _is_written(about: Path) -> bool:
    """Whether an open file is there to be written, by what the system says of it."""
    with suppress(OSError, StopIteration, IndexError, ValueError):
        lines = about.read_text().splitlines()
        flags = next(line for line in lines if line.startswith("flags:"))
        return bool(int(flags.split()[1], 8) & WRITING)
    return False
