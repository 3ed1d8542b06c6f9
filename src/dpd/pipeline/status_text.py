"""A status as text for people and as JSON for scripts."""

from __future__ import annotations

import json
import math
import os
import time
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from dpd.pipeline.pace import START
from dpd.pipeline.run_status import AT_WORK, DONE, FAILS, STATES, STOPPED, WAITS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from dpd.pipeline.jobs import JobStatus
    from dpd.pipeline.run_status import RunStatus
    from dpd.pipeline.status import Left, Status

# Kinds of jobs beside the runs, in the order of their work.
KINDS = {
    "kernels": "kernels", "start": "starts", "theory": "sweeps of theory", "sweep": "sweeps",
    "derived": "derived values", "measurement": "measurements", "figure": "figures",
    "verdicts": "verdicts", "report": "report",
}  # fmt: skip
MOST = 20  # runs, or jobs, that are listed with what is wrong with them
OLD = 120.0  # s after which it is said how old a step is


def as_json(status: Status) -> str:
    """The whole status as one line of JSON; what is not known is null.

    Parameters
    ----------
    status : Status
    """
    data = asdict(status)
    for run, found in zip(status.runs, data["runs"]):
        found["seconds_left"] = run.seconds_left
    data["counts"] = dict.fromkeys(STATES, 0) | Counter(run.state for run in status.runs)
    return json.dumps(_without_nan(data))


def _without_nan(value: Any) -> Any:
    """Plain data with None for numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _without_nan(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def as_text(status: Status) -> str:
    """The status in lines for a person: what runs, what is wrong, what is done, what is left.

    Parameters
    ----------
    status : Status
    """
    at = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(status.time))
    counts = Counter(run.state for run in status.runs)
    said = ", ".join(f"{counts[state]} {state}" for state in STATES if counts[state])
    lines = [f"{status.folder}, {at}: {len(status.runs)} runs: {said or 'none'}"]
    lines += _at_work(status)
    if not status.study:
        lines += _finished(status.runs)
    for state in (FAILS, STOPPED):
        lines += _troubles(state, [run for run in status.runs if run.state == state])
    lines += _failed_jobs(status.jobs)
    if status.study:
        if not os.path.isdir(status.folder):
            command = f"snakemake --cores 2 --config study={status.study}"
            lines += ["", f"there are no results yet; this makes them: {command}"]
        lines += ["", *_table(status.runs)]
        lines += ["", f"other jobs that are done: {_jobs(status.jobs)}"]
    if status.study or counts[AT_WORK]:
        lines += ["", _left(status.left)]
    return "\n".join(lines)


def _at_work(status: Status) -> Iterator[str]:
    """What runs now, and how far it is."""
    for run in status.runs:
        if run.state == AT_WORK:
            yield ""
            yield f"at work: {' '.join(run.name)}"
            yield from (f"  {line}" for line in _of_run(run, status.time))
    for job in status.jobs:
        if job.state == AT_WORK:
            yield ""
            yield f"at work: {job.kind} {job.name} {job.why}".rstrip()


def _of_run(run: RunStatus, now: float) -> Iterator[str]:
    """Lines on a run at work."""
    if run.why:
        yield run.why
    elif run.step is None:
        yield "it begins"
    if run.step is not None:
        share = f" of {run.steps} ({run.step / run.steps:.0%})" if run.steps else ""
        what = "its first configuration: step" if run.doing == START else "step"
        late = run.seen is not None and now - run.seen > OLD
        old = f" {duration(now - (run.seen or now))} ago" if late else ""
        left = run.seconds_left
        ends = f", {duration(left)} left" if left is not None and run.doing != START else ""
        yield f"{what} {run.step}{share}{old}{_speed(run)}{ends}"
    if measured := _measured(run):
        yield f"{measured} (in its checkpoint of step {run.measured_step})"
    if run.process is not None:
        yield f"process {run.process} on {run.host}, begun {run.since}"


def _speed(run: RunStatus) -> str:
    """Steps and bead-steps per second, after a comma."""
    if not run.rate:
        return ""
    beads = f", {run.rate * run.beads:.3g} bead-steps/s" if run.beads else ""
    return f", {run.rate:.4g} steps/s{beads}"


def _measured(run: RunStatus) -> str:
    """Temperature and pressure as far as they are known."""
    found = run.measured
    values = {
        "kT": number(found.kT, found.kT_error),
        "pressure": number(found.pressure, found.pressure_error),
    }
    return ", ".join(f"{name} {value}" for name, value in values.items() if value)


def _finished(runs: Sequence[RunStatus]) -> Iterator[str]:
    """Runs of one's own that are done."""
    for run in runs:
        if run.state == DONE:
            yield ""
            yield f"done: {' '.join(run.name)}"
            yield f"  {run.step} steps{_speed(run)}"
            yield from (f"  {line}" for line in (_measured(run), run.why) if line)


def _troubles(state: str, runs: Sequence[RunStatus]) -> Iterator[str]:
    """Runs that failed, or stopped, and why."""
    if runs:
        yield ""
        yield f"{state}:"
    for run in runs[:MOST]:
        yield f"  {' '.join(run.name)}: {run.why}"
    if len(runs) > MOST:
        yield f"  and {len(runs) - MOST} more"


def _failed_jobs(jobs: Sequence[JobStatus]) -> Iterator[str]:
    """The same of other jobs, with their logs."""
    for job in jobs:
        if job.state == FAILS:
            yield f"failed: {job.kind} {job.name}: {job.why} ({job.log})"


def _table(runs: Sequence[RunStatus]) -> Iterator[str]:
    """Counts by paper; and by sweep, where a sweep is neither done nor waits as a whole."""
    rows: dict[tuple[str, ...], Counter[str]] = {}
    for run in runs:
        for length in (1, 2):
            rows.setdefault(run.name[:length], Counter())[run.state] += 1
    names = {name: "  " * (len(name) - 1) + name[-1] for name in sorted(rows)}
    shown = [name for name in names if len(name) == 1 or _is_mixed(rows[name])]
    width = max((len(names[name]) for name in shown), default=0)
    yield f"{'runs':{width}s}  {'all':>5s}" + "".join(f"  {state:>7s}" for state in STATES)
    for name in shown:
        row = rows[name]
        counts = "".join(f"  {row[state] or '-':>7}" for state in STATES)
        yield f"{names[name]:{width}s}  {row.total():5d}{counts}"
    reasons = Counter(run.why for run in runs if run.state == WAITS and run.why)
    for why, count in reasons.most_common(MOST):
        yield f"{count} waiting: {why}"


def _is_mixed(row: Counter[str]) -> bool:
    return row.total() not in (row[DONE], row[WAITS])


def _jobs(jobs: Sequence[JobStatus]) -> str:
    """How many of each kind are done."""
    kinds = Counter(job.kind for job in jobs)
    done = Counter(job.kind for job in jobs if job.state == DONE)
    return ", ".join(
        f"{KINDS[kind]} {done[kind]} of {kinds[kind]}" for kind in KINDS if kinds[kind]
    )


def _left(left: Left) -> str:
    """What is left in one sentence."""
    if left.core_seconds is None:
        return (
            "left: not known before a run has finished, or has been at work for some seconds; "
            "`dpd plan` measures it beforehand"
        )
    if not left.core_seconds:
        return "left: no runs"
    work = f"{duration(left.core_seconds)} of one core for the runs"
    borrowed = ""
    if left.borrowed:
        borrowed = f"; for {left.borrowed} of them by the rates of other sweeps"
    if left.seconds is None:
        return f"left: {work}{borrowed}; nothing is at work"
    cores = "core that is" if left.cores == 1 else "cores that are"
    return f"left: {duration(left.seconds)} on the {left.cores} {cores} at work ({work}{borrowed})"


def duration(seconds: float | None) -> str:
    """A time in a unit that suits it; a dash if it is not known."""
    if seconds is None or not math.isfinite(seconds):
        return "-"
    for limit, length, unit in ((120, 1, "s"), (7200, 60, "min"), (172800, 3600, "h")):
        if seconds < limit:
            return f"{seconds / length:.0f} {unit}" if unit != "h" else f"{seconds / length:.1f} h"
    return f"{seconds / 86400:.1f} days"


def number(value: float, error: float) -> str:
    """A mean with its standard error, to two digits of that; nothing if it is not known."""
    if not math.isfinite(value):
        return ""
    if not math.isfinite(error) or error <= 0:
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} +- {error:.{digits}f}"
