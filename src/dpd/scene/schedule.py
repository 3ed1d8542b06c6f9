"""Values of a scene that change while it runs: each stage is a scene of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.errors import UserError, suggestion
from dpd.page import Change
from dpd.scene.yaml import changed

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dpd.scene.scene import Scene


class Stage(NamedTuple):
    """What a run is like behind a step, until the next one."""

    step: int
    scene: Scene


def enter(scene: Scene, step: int, settings: Mapping[str, Any], where: str) -> None:
    """Go on with other values, by keys that are joined by dots, behind a step.

    Raises
    ------
    UserError
        If a value is not allowed, or cannot change while a system runs, or the step has passed.
    """
    last = scene.stages[-1]
    if step < last.step:
        raise UserError(f"{where}: step {step} is before {last.step}, at which values change")
    for key in settings:
        if (section := key.split(".")[0]) not in scene.terms:
            raise UserError(
                f"{where}: {key!r} cannot change while the system runs; "
                f"{suggestion(section, list(scene.terms))}"
            )
    if scene.is_auto or scene.data["duration"]:
        raise UserError(f"{where}: counts steps; name scheme and dt, and 'steps', no duration")
    search = {"search": "list" if scene.skin else "cells", "skin": scene.data["pairs"]["skin"]}
    data = {key: value for key, value in last.scene.data.items() if key != "schedule"}
    now = type(scene)(changed(data | {"pairs": search}, settings, where), where)
    for change in scene.made.keys() ^ now.made.keys():
        key = (scene.made | now.made)[change]
        raise UserError(
            f"{where}: {key!r} would begin or cease to act, which what is measured must know "
            "from the first step; begin with a small value"
        )
    if now.period != scene.period:
        raise UserError(
            f"{where}: beads would get further behind walls, or less far, than there is room for; "
            "take stiffer walls from the beginning"
        )
    key = scene.made.get(Change.SLIDES, "")
    if key and (now.dt, now.terms[key]) != (scene.dt, scene.terms[key]):
        raise UserError(
            f"{where}: images slide evenly: with {key!r} neither that nor dt can change while "
            "the system runs"
        )
    if now.dt != last.scene.dt and step > scene.steps.equilibrate:
        scene.refuse(scene.unobserved(scene.made | {Change.PACE: "schedule"}))
    scene.stages.append(Stage(step, now))
