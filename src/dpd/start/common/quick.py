"""Scenes with starts that take no time, for those that only compile kernels or time them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.scene.scene import Scene
from dpd.scene.start import OF_FILE, grows, reads_file
from dpd.start.common.make import make_start

if TYPE_CHECKING:
    from dpd.engine.state import State

CHAINS = 32  # of each kind in a melt that is grown to compile growth
BOX = 8  # r_c, of that melt


def random_start(scene: Scene) -> Scene:
    """A scene whose molecules are placed where they would grow or be read from a file."""
    start = scene.data["start"]
    if reads_file(scene):
        rest = {key: value for key, value in start.items() if key not in OF_FILE}
        return _with(scene, start=rest | {"method": "random"})
    if not grows(scene):
        return scene
    return _with(scene, start={"method": "random", "seed": start.get("seed", 1)})


def compile_start(scene: Scene) -> State:
    """Compile what a scene's start needs: grow a small melt, relax for one step.

    Returns
    -------
    State
        A start of the scene, placed and hardly relaxed.
    """
    if grows(scene):
        make_start(_small_melt(scene))
    return make_start(_hardly_relaxed(random_start(scene)))


def _small_melt(scene):
    """A melt that grows as that of a scene does, in which bonds of any study fit."""
    kinds = [
        {"architecture": " ".join(sorted(set(kind.beads)) * 2), "count": CHAINS}
        for kind in scene.molecules
    ]
    return _with(scene, box=BOX, molecules=kinds, observe=["thermo"])


def _hardly_relaxed(scene):
    """A scene whose start takes one step where it takes any."""
    start = scene.data["start"]
    if "relax" not in start:
        return scene
    return _with(scene, start=start | {"relax": start["relax"] | {"steps": 1}})


def _with(scene, **changes):
    return Scene(scene.data | changes, scene.where)
