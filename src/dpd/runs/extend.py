"""A finished run made longer, to the same bits as one that was planned that long."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from dpd.engine.checkpoint import refuse_other_file
from dpd.files import attributes, check_output, read, remove_drafts, unfinished
from dpd.runs.lock import alone
from dpd.runs.measured import summary
from dpd.runs.result import (
    checkpoint_path,
    read_former,
    refuse_other,
    refuse_to_lose,
    remove_left,
    result_there,
)
from dpd.runs.run import NETCDF, Options, say_if_resumed, simulate, stop_on, whole
from dpd.scene.scene import Scene
from dpd.stages import run_sources

if TYPE_CHECKING:
    from pathlib import Path


OWN = Options(own=True)


def extend(run: Path, sample: int, output: Path, options: Options = OWN) -> dict[str, float]:
    """Make a run longer by steps of sampling, or go on with that where it was stopped or killed.

    The ``output`` may be the file of the run, which stays until the longer one is whole. Returns a
    summary and raises what `dpd.runs.run.run` does, and `UserError` for what cannot be made longer.
    """
    sample, checkpoint = whole("sample", sample), checkpoint_path(output)
    check_output(output, NETCDF, [] if output == run else [run])
    check_output(checkpoint, "", [run])
    refuse_other_file(checkpoint)
    refuse_other(run, attributes(run))  # before there is a lock beside what is no run at all
    with alone(output, options.say) as lock:
        begun, former = time.perf_counter(), read_former(run)  # now nobody else is at work on it
        beside = list(former.scene.files_beside(output).values())
        if output != run:
            for path in beside:
                check_output(path, "", [run, *former.scene.files_beside(run).values()])
        for path in (output, checkpoint, *beside, *map(unfinished, beside)):
            remove_drafts(path)
        scene, there = longer(former.scene, sample), None
        if output == run and _was_killed(former, sample, checkpoint, lock):
            there = former.scene
            options.say(f"{run}: has been made longer before, by a command that was killed then")
        elif not options.overwrite and output == run:
            refuse_to_lose(scene, checkpoint)
        elif not options.overwrite:
            there = result_there(scene, output, options.say)
        if there is not None:
            remove_left(checkpoint, there)
            return summary(there, *read(output))
        if former.attributes.get("sources") != run_sources(scene):
            options.say(
                f"{run}: made by other sources than today's, so its last bits may differ from "
                "those of a run that was made today"
            )
        say_if_resumed(checkpoint)
        shown = options.progress(sum(scene.steps), f"{run}: longer", lock=lock)
        with stop_on(options.signals) as stopping, shown as progress:
            progress(former.state.step)  # so that the lock says how long it is to become
            return simulate(
                scene, output, former.state, options, progress, stopping, begun, former.observers
            )


def _was_killed(former, sample, checkpoint, lock):
    """Whether this very command was killed after the longer result was in its place.

    The result says from where it was made longer. That it was by a command that came to no end, its
    checkpoint says, or its lock.
    """
    step, first = former.state.step, former.attributes.get("extended_from_step")
    left = remove_left(checkpoint, former.scene) or lock.left.get("steps") == step
    return left and first is not None and int(first) + sample == step


def longer(scene: Scene, sample: int) -> Scene:
    """A scene with more steps of sampling.

    An observable whose interval is longer than the shorter run has looked once, at its end. It
    keeps that interval, unless the longer run would not have looked yet.
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
