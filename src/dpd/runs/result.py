"""What a result holds beside what was measured, and what is in the place of one.

A run of one's own keeps its last configuration, which is for everybody (`dpd.particles.netcdf`),
and in the group ``state`` what `dpd.runs.run.extend` needs: the arrays of its last checkpoint
(`dpd.engine.loop.arrays_of`). People edit a scene and run it again: a result of the same
scene is kept, and nothing else is replaced unless they ask for it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd import files
from dpd.engine.loop import arrays_of, file_of, put_back, stored_in
from dpd.errors import Occupied, UserError
from dpd.observe.common.measured import observables
from dpd.particles.netcdf import attributes_of, variables_of
from dpd.particles.particles import Particles, box_at, of_scene
from dpd.scene.scene import Scene
from dpd.stages import run_sources
from dpd.start.common.make import system_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from dpd.engine.state import State

STATE = "state"  # name of the group
NO_STATE = "not_extendable"  # attribute that says why there is no such group


class Final(NamedTuple):
    """What `dpd.files.write` takes."""

    variables: dict[str, tuple]
    attributes: dict[str, Any]
    groups: dict[str, dict[str, np.ndarray]]


class Former(NamedTuple):
    """A finished run that a longer one can go on from; its observables have all they had."""

    scene: Scene
    state: State
    observers: list[Any]
    attributes: dict[str, Any]


def checkpoint_path(path: str | Path) -> Path:
    """Where the checkpoint of a result lies: beside it, under a name that no rule declares."""
    path = Path(path)
    return path.with_name(path.stem + ".checkpoint")


def go_on_from(observer: Any, former: Any, step: int) -> None:
    """Put an observable where ``former``, that of a run planned otherwise, has got to at a step.

    Its arrays do not depend on how long a run is planned to be, but for series and levels of
    correlations, for which a longer one has more room, and a shorter one enough. One that looks
    less often in the longer run, and not yet, begins anew; it is refused if it would have looked.
    """
    if observer.every != former.every:
        if observer.every <= step:
            raise UserError(
                f"observe.{observer.key}: in a run of that length it looks every {observer.every} "
                f"steps, and has looked every {former.every}; run the longer scene anew"
            )
        return
    if (file := file_of(observer)) is not None:
        file.go_on_after(former.file.path, int(former.arrays["taken"][0]), former.arrays["digests"])
    for name, array in observer.arrays.items():
        room = min(len(array), len(former.arrays[name]))
        array[:room] = former.arrays[name][:room]


def last_configuration(scene: Scene, state: State) -> Particles:
    """The beads of a state, by their identities."""
    box = box_at(scene, state.step, state.slid) if state.box is None else state.box
    position, velocity = (state.by_identity(each) for each in (state.position, state.velocity))
    return of_scene(scene, box, position, state.image, velocity, state.step)


def final_of(scene: Scene, state: State, observers: list[Any], why_not: str = "") -> Final:
    """What a run keeps at its end; ``why_not`` says why no longer run can go on from it."""
    last = last_configuration(scene, state)
    attributes = attributes_of(last)
    if why_not:
        return Final(variables_of(last), attributes | {NO_STATE: why_not}, {})
    arrays = {name.replace("/", "."): each for name, each in arrays_of(state, observers).items()}
    return Final(variables_of(last), attributes, {STATE: arrays})


def read_former(path: str | Path) -> Former:
    """The finished run in a file; `UserError` if it is none that can be made longer."""
    attributes = files.attributes(path)
    refuse_other(path, attributes)
    scene, stored = scene_of(path, attributes), files.read_group(path, STATE)
    if not stored:
        why = attributes.get(NO_STATE) or (
            "it holds no state to go on from. `dpd run --overwrite` makes it again with one; a run "
            "of a study has one if its scene says 'keep_state: true'"
        )
        raise UserError(f"{path}: {why}")
    arrays = {name.replace(".", "/"): array for name, array in stored.items()}
    try:
        if attributes["scene_digest"] != scene.digest or "position" not in arrays:
            raise ValueError
        state = put_back(arrays, ())
        observers = list(observables(scene, system_of(scene), path, state))
        put_back(arrays, observers)
    except (KeyError, ValueError):  # a default has changed, or what is kept
        raise UserError(
            f"{path}: made by another version of this program, which alone can make it longer; a "
            f"new run can begin with its last configuration: --start {path}"
        ) from None
    return Former(scene, state, observers, attributes)


def refuse_other(path: str | Path, attributes: Mapping[str, Any]) -> None:
    """Refuse what is no result, and that of a run which was lost, by the attributes of a file."""
    if "scene" not in attributes or "scene_digest" not in attributes:
        what = "a first configuration" if "start_digest" in attributes else "some other NetCDF file"
        raise UserError(f"{path}: this is {what}, not the result of a run; name a run.nc")
    lost = int(attributes.get("lost_step", -1))
    if lost >= 0:
        raise UserError(
            f"{path}: this run was lost at step {lost} (it blew up, or its bonds got "
            "too long), so nothing can go on from it; run its scene with a smaller dt"
        )


def scene_of(path: str | Path, attributes: Mapping[str, Any]) -> Scene:
    """The scene of a result, with the step that was chosen for it; or of a checkpoint's note."""
    scene = Scene.of_result(attributes.get("scene"), str(path))
    if chosen := attributes.get("chosen"):
        scene.chosen = chosen if isinstance(chosen, dict) else {"said": chosen}
    return scene


def is_made(scene: Scene, path: str | Path) -> bool:
    """Whether a result is there that belongs to a scene and to the sources as they are."""
    if not all(each.is_file() for each in (Path(path), *scene.files_beside(path).values())):
        return False
    try:
        made = files.attributes(path)
    except UserError:
        return False
    return (made.get("scene_digest"), made.get("sources")) == (scene.digest, run_sources(scene))


def result_there(scene: Scene, output: Path, say: Callable[[str], object]) -> Scene | None:
    """The scene of a result that is there, if it is the same (``say`` tells); None for no file.

    Raises `Occupied` if anything else is in its place, or in that of what lies beside it.
    """
    checkpoint, sidecars = checkpoint_path(output), scene.files_beside(output).values()
    if not files.is_filled(output):
        refuse_to_lose(scene, checkpoint)
        for path in sidecars if not stored_in(checkpoint) else ():
            files.refuse_to_replace(path)
        return None
    try:
        attributes = files.attributes(output)
        former = scene_of(output, attributes) if "scene_digest" in attributes else None
    except UserError as problem:
        raise Occupied(f"{output}: is there already, and cannot be read: {problem}") from None
    if former is None:
        raise Occupied(f"{output}: is there already, and is no result of a run")
    if not _same(scene, former):
        raise Occupied(f"{output}: holds the result of {_other(scene, former)}")
    if missing := [path for path in sidecars if not path.is_file()]:
        raise Occupied(f"{output}: is there already, but not {missing[0]}, which belongs to it")
    is_ours = attributes.get("sources") == run_sources(former)
    version = "" if is_ours else ", made by another version of this program"
    say(f"{output}: is there already, of the same scene{version}; it is kept, and nothing was run")
    return former


def refuse_to_lose(scene: Scene, checkpoint: Path) -> None:
    """Refuse to begin anew where the state of a run lies from which this one cannot go on."""
    if not (stored := stored_in(checkpoint)):
        return
    holds = f"{checkpoint}: holds the state of a run that was stopped or killed,"
    try:
        former = scene_of(checkpoint, stored.note)
    except UserError as problem:
        raise Occupied(f"{holds} which this version cannot read: {problem}") from None
    if not _same(scene, former):
        raise Occupied(f"{holds} of {_other(scene, former)}")
    key = {"sources": run_sources(former), "kept": former.data.get("keep_state", True)}
    if {"scene": stored.key.get("scene"), **key} != stored.key:
        raise Occupied(
            f"{holds} of another version of this program, or of a study, which alone can go on "
            "with it"
        )


def remove_left(checkpoint: Path, scene: Scene) -> bool:
    """Remove the checkpoint of a run whose result is whole; whether there was one."""
    stored = stored_in(checkpoint)
    left = stored is not None and stored.key.get("scene") == scene.digest
    if left:
        os.unlink(checkpoint)
    return left


def _same(scene, former):
    """Whether two scenes are the same; one that leaves its step to us is with what it found."""
    if scene.is_auto:
        said = (former.chosen or {}).get("said", "")
        if not said.endswith(f"asked for: {100 * scene.terms['integrator'].tolerance:g} %)"):
            return False
        scene = Scene(scene.data | {"integrator": former.data["integrator"]}, scene.where)
    return scene.digest == former.digest


def _other(scene, former):
    """What distinguishes the scene of a file from one that is to be run."""
    mine, its = scene.data, former.data
    keys = sorted(key for key in mine.keys() | its.keys() if mine.get(key) != its.get(key))
    hint = " (`dpd extend` makes a result longer)" if keys == ["steps"] else ""
    return f"another scene, with other values of {', '.join(keys)}{hint}"
