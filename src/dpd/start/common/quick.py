"""Scenes with starts that take no time, for those that only compile kernels or time them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.scene.scene import Scene
from dpd.start.common.make import make_start

if TYPE_CHECKING:
    from dpd.engine.state import State


def random_start(scene: Scene) -> Scene:
    """A scene whose molecules are placed where they would grow or be read from a file."""
    start = scene.start.stand_in()
    return scene if start == scene.data["start"] else _with(scene, start=start)


def compile_start(scene: Scene) -> State:
    """Compile what a scene's start needs: a small one if it grows, relaxation for one step.

    Returns
    -------
    State
        A start of the scene, placed and hardly relaxed.
    """
    if tiny := scene.start.tiny(scene):
        make_start(_with(scene, **tiny))
    return make_start(_hardly_relaxed(random_start(scene)))


def _hardly_relaxed(scene):
    """A scene whose start takes one step where it takes any."""
    start = scene.data["start"]
    if "relax" not in start:
        return scene
    return _with(scene, start=start | {"relax": start["relax"] | {"steps": 1}})


def _with(scene, **changes):
    return Scene(scene.data | changes, scene.where)
