"""What of a study, or of one's own runs, is at work, done, stopped, failed or waits: only read."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dpd import files
from dpd.analysis.statistics import mean_and_error
from dpd.engine.loop import stored_in
from dpd.errors import FAILED, UserError
from dpd.pipeline.paper import CONFIG, read_config, read_paper, studies, variant_of
from dpd.pipeline.paths import Results, errors_in, results_of
from dpd.runs import worker_on
from dpd.runs.result import checkpoint_path, is_made
from dpd.scene.scene import Scene

AT_WORK, DONE, STOPPED, FAILS, WAITS = "at work", "done", "stopped", "failed", "waiting"
STATES = (AT_WORK, DONE, STOPPED, FAILS, WAITS)
ASKED = ("as asked", "interrupted")  # in the last sentence of a command that a signal has ended
MOST = 20  # runs that are listed with what is wrong with them


@dataclass
class RunStatus:
    """One run as it is now."""

    name: tuple[str, ...]  # paper, sweep and point; or the path of a run of one's own
    path: str  # of its result
    state: str = WAITS  # of `STATES`
    why: str = ""  # it is in that state, or who is at work
    step: int | None = None
    steps: int | None = None  # in all
    beads: int | None = None
    rate: float | None = None  # steps/s of the last minute; of a run that is done, of the whole
    # kT and pressure with their standard errors, over the samples so far.
    measured: dict[str, tuple[float, float]] = field(default_factory=dict)


def study_status(study: str, folder: str, papers: Sequence[str] | None = None) -> list[RunStatus]:
    """All runs of some papers in a study; of those of config/config.yaml if None."""
    from dpd.analysis.collect import load
    from dpd.analysis.structure import derive

    results, found = Results(folder), []
    for paper in [read_paper(name, study) for name in papers or read_config()["papers"]]:
        errors = {}
        for line in errors_in(f"{results.logs}/{paper.name}/runs"):
            if not any(words in line for words in ASKED):
                point, _, said = line.removeprefix(FAILED).partition(": ")
                errors[point] = said
        for sweep in paper.sweeps.values():
            measured = {rule.from_ for rule in sweep.derived.values()}
            with suppress(UserError):  # until these are there, none of its runs is done
                sources = {each: load(results.sweep(paper.name, each)) for each in measured}
                sweep = derive(sweep, sources) if sources else sweep
            for point in sweep.points:
                name = (paper.name, sweep.name, point.name)
                error = errors.get(f"{sweep.name} {point.name}", "")
                found.append(look_at(name, results.run(*name), point.scene, error))
    return found


def status_of(path: Path | None, papers: Sequence[str] | None) -> tuple[str, list[RunStatus]]:
    """A title, and the runs of a folder, a run.nc, a study, or if None that of config.yaml."""
    paths = [] if path is None else [path]
    if path is not None and path.is_dir():  # the results of all runs in it, done or begun
        there = sorted(path.iterdir())
        begun = {each.with_suffix("") for each in there if each.name.endswith(".nc.lock")}
        begun |= {each.with_suffix(".nc") for each in there if each.suffix == ".checkpoint"}
        made = [each for each in there if each.suffix == ".nc" and look_at((), each).state == DONE]
        paths = sorted(begun.union(made))
    own = [look_at((str(each),), each) for each in paths]
    if own and own[0].state != WAITS:
        return str(path), own
    study = read_config()["study"] if path is None else path.resolve().name
    folder = results_of(study).folder if path is None or str(path) == study else str(path)
    if (CONFIG / "config.yaml").is_file() and variant_of(study)[0] in studies():
        return folder, study_status(study, folder, papers)
    if own:
        raise UserError(f"{path}: {own[0].why or 'there is no such run; name a run.nc'}")
    raise UserError(
        f"{path or folder}: no study in config/config.yaml has the name {study!r}, and no run lies "
        "there; name a folder of a study's results or of runs, or a run.nc"
    )


def look_at(
    name: tuple[str, ...], path: str | Path, scene: Scene | None = None, error: str = ""
) -> RunStatus:
    """The status of a run, with the ``scene`` that is to run, and the error in its log."""
    run = RunStatus(name, str(path))
    if scene is not None:
        run.steps, run.beads = sum(scene.steps), scene.beads
    checkpoint = checkpoint_path(path)
    try:
        worker = worker_on(path)
    except UserError as problem:
        run.state, run.why = FAILS, str(problem)
        return run
    if worker is not None and worker.alive:
        run.state, run.why = AT_WORK, f"process {worker.process} on {worker.host}"
        run.step, steps, run.rate = (worker.report.get(key) for key in ("step", "steps", "rate"))
        run.steps = steps or run.steps
        if stored := stored_in(checkpoint):
            run.measured = _means(stored.arrays)
        return run
    _look_at_result(run, scene)
    if run.state == DONE:
        return run
    if error:
        run.state, run.why = FAILS, error
    elif worker is not None or os.path.lexists(checkpoint):
        why = "it was stopped" if worker is None else f"process {worker.process} was killed"
        run.state, run.why, stored = STOPPED, f"{why}; it begins anew", stored_in(checkpoint)
        if stored and (scene is None or stored.key["scene"] == scene.digest):
            run.step, run.measured = int(stored.arrays["step"]), _means(stored.arrays)
            run.why = f"{why}; it goes on from step {run.step}"
    return run


def _look_at_result(run, scene):
    """Whether a run is done; it waits if there is no result, or one that is of no use."""
    if not os.path.lexists(run.path):
        return
    try:
        values, found = files.read(run.path)
        steps, beads = int(found["steps"]), int(found["beads"])
    except UserError as problem:
        run.why = str(problem).removeprefix(f"{run.path}: ")
        return
    except KeyError:
        run.why = "not the result of a run"
        return
    if scene is not None and not is_made(scene, run.path):
        run.why = "its scene, or the sources, changed since its result was made"
        return
    run.state, run.measured = DONE, _means(values)
    run.step, run.steps, run.beads = steps, steps, beads
    run.rate = float(found["bead_steps_per_second"]) / beads


def _means(arrays: Mapping[str, np.ndarray]) -> dict[str, tuple[float, float]]:
    """Means of what was sampled, and their errors; not of what has no value yet."""
    found = {}
    for name, array in arrays.items():
        short = name.rpartition(".")[2]
        if short in ("kT", "pressure") and np.isfinite(array).any():
            mean, error, _ = mean_and_error(array[np.isfinite(array)])
            found[short] = (float(mean), float(error))
    return found


def as_text(runs: Sequence[RunStatus], title: str) -> str:
    """A table of counts by sweep, with what is at work and what went wrong."""
    lines = [f"{title}: {_counts(runs) or 'no runs'}"]
    for state in (AT_WORK, STOPPED, FAILS):
        chosen = [run for run in runs if run.state == state]
        lines += [f"{state}: {_line(run)}" for run in chosen[:MOST]]
        lines += [f"and {len(chosen) - MOST} more {state}"] * (len(chosen) > MOST)
    of_study = [run for run in runs if len(run.name) > 1]
    lines += [f"done: {_line(run)}" for run in runs if run.state == DONE and run not in of_study]
    for sweep in dict.fromkeys(run.name[:2] for run in of_study):
        lines.append(f"  {' '.join(sweep)}: {_counts([r for r in runs if r.name[:2] == sweep])}")
    if left := seconds_left(runs):
        cores = sum(run.state == AT_WORK for run in runs)
        lines.append(f"left: {left / 3600:.2g} h of the {cores} at work")
    return "\n".join(lines)


def _counts(runs):
    counts = Counter(run.state for run in runs)
    return ", ".join(f"{counts[state]} {state}" for state in STATES if counts[state])


def _line(run: RunStatus) -> str:
    """A run, how far it is, what it has measured, and why it is as it is."""
    found = [f"step {run.step} of {run.steps}"] if run.step is not None else []
    found += [f"{run.rate:.4g} steps/s"] if run.rate else []
    found += [f"{name} {mean:.4g} +- {error:.2g}" for name, (mean, error) in run.measured.items()]
    return f"{' '.join(run.name)}: {', '.join([*found, *([run.why] if run.why else [])])}"


def seconds_left(runs: Sequence[RunStatus]) -> float | None:
    """Of wall clock, for all runs on the cores at work at their mean rate; None if not known."""
    known = [(run, run.beads, run.steps) for run in runs if run.beads and run.steps]
    rates = [run.rate * beads for run, beads, _ in known if run.rate]
    at_work = sum(run.state == AT_WORK for run in runs)
    if not rates or not at_work:
        return None
    left = [beads * (steps - (run.step or 0)) for run, beads, steps in known if run.state != DONE]
    return float(sum(left) / np.mean(rates) / at_work)
