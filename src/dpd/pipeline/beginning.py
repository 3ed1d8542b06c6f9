"""How a run begins: its first configuration is made, or read from a file of whatever origin."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from dpd import files
from dpd.errors import UserError
from dpd.page import Term, names
from dpd.scene.scene import Scene
from dpd.scene.start import start_digest
from dpd.stages import start_sources
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import make_start

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.engine.state import State

NETCDF = ".nc"


class Begun(NamedTuple):
    """A scene that knows where it starts from, and its first configuration."""

    scene: Scene
    state: State


def begun(
    scene: Scene,
    path: Path | None,
    progress: Callable[[int], object] | None,
    say: Callable[[str], object],
) -> Begun:
    """Begin a run of one's own.

    Parameters
    ----------
    scene : Scene
    path : Path or None
        Of the first configuration. If nothing is there, it is made and kept there. A start of this
        scene is taken as it is. Of any other file the scene's part ``start`` is replaced by
        ``{method: file}``, so that what is in it becomes part of the scene.
    progress : callable or None
        See `dpd.start.common.make.make_start`.
    say : callable
        Called with a sentence for what a person should know of the file.

    Returns
    -------
    Begun

    Raises
    ------
    UserError
        If the file cannot be read, or holds another system.
    """
    if path is None:
        return Begun(scene, make_start(scene, progress, say))
    if not path.exists():
        if path.suffix.lower() != NETCDF:
            raise UserError(
                f"{path}: there is no such file to start from. (A name in {NETCDF} that is not "
                "there yet would be made.)"
            )
        write_start(scene, path, progress, say)
        return Begun(scene, read_start(scene, path))
    found = begins_with(scene, path, say)
    if found is scene:
        return Begun(scene, read_start(scene, path))
    return Begun(found, make_start(found, progress, say))


def begins_with(scene: Scene, path: Path | None, say: Callable[[str], object]) -> Scene:
    """The scene that `begun` runs: the same one, if its start is in the file, or will be."""
    if path is None or not path.exists():
        return scene
    attributes = _attributes(path)
    if "start_digest" in attributes and attributes["start_digest"] == start_digest(scene):
        if attributes.get("start_sources") == start_sources(scene):
            return scene
        say(f"{path}: made by other sources than today's, which may make other bits of it")
    former = _scene_of(attributes)
    # What decides how beads move; a start from a run that had other values is said to be one.
    motion = sorted({*names(Term), *scene.terms, "mass"})
    if changed := [key for key in motion if former and former.get(key) != scene.data.get(key)]:
        say(f"{path}: made with other values of {', '.join(changed)} than this scene has")
    if "scene_digest" in attributes and former.get("seed") == scene.data["seed"]:
        say(
            f"{path}: its run had the seed {scene.data['seed']} as well, so the same noise comes "
            "again; another 'seed' makes the two independent"
        )
    return starting_from(scene, path)


def starting_from(scene: Scene, path: Path) -> Scene:
    """The same scene with its first configuration from a file, as it stands there.

    Raises
    ------
    UserError
        If the file cannot be read.
    """
    kept = {key: scene.data["start"][key] for key in ("kT", "seed") if key in scene.data["start"]}
    start = kept | {"method": "file", "path": str(path)}
    return Scene(scene.data | {"start": start}, scene.where)


def _attributes(path):
    """Attributes of a NetCDF file; none of another one."""
    if path.suffix.lower() != NETCDF:
        return {}
    return files.attributes(path)


def _scene_of(attributes):
    """What a file keeps of the scene that it was made from; nothing if that cannot be read."""
    try:
        found = json.loads(attributes.get("scene", "{}"))
    except (ValueError, TypeError):
        return {}
    return found if isinstance(found, dict) else {}
