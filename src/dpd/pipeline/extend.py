"""A finished run made longer, to the same bits as one that was planned that long."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dpd.drafts import remove_drafts, unfinished
from dpd.engine.checkpoint import refuse_other_file
from dpd.files import attributes, check_output, read
from dpd.interrupts import asked, listening
from dpd.pipeline.kept import Former, read_former, refuse_other
from dpd.pipeline.lock import alone, told_before
from dpd.pipeline.pace import RUN, Pace, Report
from dpd.pipeline.running import say, say_if_resumed
from dpd.pipeline.simulate import RunSettings, checkpoint_path, simulate, summary
from dpd.pipeline.there import refuse_to_lose, remove_left, result_there
from dpd.progress import Progress
from dpd.scene.scene import Scene
from dpd.stages import run_sources

NETCDF = ".nc"


@dataclass(frozen=True)
class Extension:
    """Which run to make longer, and how.

    Attributes
    ----------
    run : Path
        The result of a run that kept its state.
    sample : int
        Steps of sampling to add.
    output : Path
        The file to write; it may be that of the run, which stays until the longer one is whole.
    threads : int
    every_seconds : float
        Wall clock between checkpoints.
    overwrite : bool
        Replace what else is in the place of the output, see `dpd.pipeline.there`.
    stopping, say, progress : callable
        See `dpd.pipeline.running.Order`.
    """

    run: Path
    sample: int
    output: Path
    threads: int = 1
    every_seconds: float = 60.0
    overwrite: bool = False
    stopping: Callable[[], int] = asked
    say: Callable[[str], None] = say
    progress: Callable[[int, str], Progress] = Progress


def extend(extension: Extension) -> dict[str, float]:
    """Make a run longer, or go on with that where it was stopped or killed.

    Parameters
    ----------
    extension : Extension

    Returns
    -------
    dict
        Summary, see `dpd.pipeline.simulate.simulate`.

    Raises
    ------
    UserError
        If the file is no run that can be made longer, see `dpd.pipeline.kept.read_former`; or as
        `dpd.pipeline.running.run_alone` does.
    Stopped
        If a signal asked for it.
    """
    run, output = extension.run, extension.output
    checkpoint = checkpoint_path(output)
    check_output(output, NETCDF, [] if output == run else [run])
    check_output(checkpoint, "", [run])
    refuse_other_file(checkpoint)
    refuse_other(run, attributes(run))  # before there is a lock beside what is no run at all
    with alone(output, extension.say) as report:
        former = read_former(run)  # as it is now that nobody else is at work on it
        beside = list(former.scene.files_beside(output).values())
        if output != run:
            for path in beside:
                check_output(path, "", [run, *former.scene.files_beside(run).values()])
        for path in (output, checkpoint, *beside, *map(unfinished, beside)):
            remove_drafts(path)
        scene, there = longer(former.scene, extension.sample), None
        if output == run and _was_killed(former, extension, checkpoint):
            there = former.scene
            extension.say(f"{run}: has been made longer before, by a command that was killed then")
        elif not extension.overwrite and output == run:
            refuse_to_lose(scene, checkpoint)
        elif not extension.overwrite:
            there = result_there(scene, output, extension.say)
        if there is not None:
            remove_left(checkpoint, there)
            return summary(there, *read(output))
        with listening():
            return _go_on(scene, former, extension, checkpoint, report)


def _was_killed(former: Former, extension: Extension, checkpoint: Path) -> bool:
    """Whether this very command was killed after the longer result was in its place.

    The result says from where it was made longer. That it was by a command that came to no end, its
    checkpoint says, or its lock.
    """
    step, first = former.state.step, former.attributes.get("extended_from_step")
    left = remove_left(checkpoint, former.scene)
    left = left or told_before(extension.output).get("steps") == step
    return left and first is not None and int(first) + extension.sample == step


def _go_on(
    scene: Scene, former: Former, extension: Extension, checkpoint: Path, report: Report
) -> dict[str, float]:
    begun = time.perf_counter()
    if former.attributes.get("sources") != run_sources(scene):
        extension.say(
            f"{extension.run}: made by other sources than today's, so its last bits may differ "
            "from those of a run that was made today"
        )
    say_if_resumed(checkpoint)
    steps = sum(scene.steps)
    shown = extension.progress(steps, f"{extension.run}: longer")
    with Pace(shown, report, RUN, steps) as progress:
        progress(former.state.step)  # so that the lock says how long it is to become
        how = RunSettings(
            checkpoint, extension.every_seconds, extension.threads, progress, extension.stopping,
            extension.say, begun, keep=True, former=former.observers,
        )  # fmt: skip
        return simulate(scene, extension.output, former.state, how)


def longer(scene: Scene, sample: int) -> Scene:
    """A scene with more steps of sampling.

    An observable whose interval is longer than the shorter run has looked once, at its end. It
    keeps that interval, unless the longer run would not have looked yet.

    Parameters
    ----------
    scene : Scene
    sample : int
        Steps to add.

    Returns
    -------
    Scene
    """
    done = scene.steps.sample
    data: dict[str, Any] = scene.data | {"steps": scene.data["steps"] | {"sample": done + sample}}
    found = Scene(data, scene.where)
    kept = {
        name: page.model_dump(exclude_none=True, by_alias=True)
        for name, page in scene.observe.items()
        if page.every != found.observe[name].every <= page.watched(scene)
    }
    if kept:
        observe = []
        for item in data["observe"]:
            name = item if isinstance(item, str) else next(iter(item))
            observe.append({name: kept[name]} if name in kept else item)
        found = Scene(data | {"observe": observe}, scene.where)
    found.chosen = scene.chosen
    return found
