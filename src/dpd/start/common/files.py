"""First configurations as files: made once for all runs that begin with them."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd import files
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.page import Term, names
from dpd.particles.particles import SLID
from dpd.scene.scene import Scene
from dpd.stages import start_sources
from dpd.start import start_description, start_digest
from dpd.start.common.make import make_start, make_start_and_record

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

NETCDF = ".nc"
REMEDY = (
    "let snakemake make it again; for a run of your own name a file for --start that is not there "
    "yet: the first configuration is made and kept in it"
)


def write_start(
    scene: Scene,
    path: str | Path,
    progress: Callable[[int], object] | None = None,
    say: Callable[[str], object] | None = None,
) -> None:
    """Make the first configuration of a scene, see `make_start`, and write it."""
    begun = time.perf_counter()
    state, record = make_start_and_record(scene, progress, say)
    variables: dict[str, tuple[tuple[str, ...], np.ndarray, str, str]] = {
        "position": (("axis", "bead"), state.position, "r_c", "positions in the box"),
        "velocity": (("axis", "bead"), state.velocity, "r_c / tau", "velocities"),
        "image": (("axis", "bead"), state.image, "1", "boxes by which the bead is further"),
    }
    if state.species is not None:
        variables["species"] = (("bead",), state.species, "1", "number of the species")
    if state.box is not None:
        variables["box_edges"] = (("axis",), np.array(state.box), "r_c", "edges of the box")
    for name, (dimensions, units, text) in scene.start.records.items():
        if name in record:
            variables[name] = (dimensions, record[name], units, text)
    attributes: dict[str, Any] = {
        "scene": json.dumps(scene.data),  # of one of the runs that share the start
        "start": json.dumps(start_description(scene)),
        "start_digest": start_digest(scene),
        "start_sources": start_sources(scene),
        "seconds": time.perf_counter() - begun,
    }
    if state.slid:
        attributes[SLID] = str(state.slid)
    files.write(path, variables, attributes)


def read_start(scene: Scene, path: str | Path) -> State:
    """Read a first configuration; refused if of another scene or other sources, or damaged."""
    variables, attributes = files.read(path)
    if "start_digest" not in attributes:
        what = "the result of a run" if "scene_digest" in attributes else "some other NetCDF file"
        raise UserError(
            f"{path}: this is {what}, not a first configuration. --start wants a file that an "
            "earlier --start or `python -m dpd start` wrote, or a name that is not there yet: the "
            "first configuration is then made and kept in it"
        )
    if attributes["start_digest"] != start_digest(scene):
        raise UserError(
            f"{path}: the first configuration of another scene than {scene.where} (start_digest "
            f"{attributes['start_digest']}, now {start_digest(scene)}); {REMEDY}"
        )
    files.check_digest(path, attributes, "start_sources", start_sources(scene), REMEDY)
    shape = (scene.dimension, scene.beads)
    wanted: dict[str, tuple[int, ...]] = dict.fromkeys(("position", "velocity", "image"), shape)
    if len(scene.species) > 1:
        wanted["species"] = shape[1:]
    for name, expected in wanted.items():
        if name not in variables or variables[name].shape != expected:
            raise UserError(f"{path}: has no {name} of shape {expected} that it needs; {REMEDY}")
    return State(
        variables["position"], variables["velocity"], None,
        np.arange(scene.beads, dtype=np.uint32), variables.get("species"), 0,
        slid=int(attributes[SLID]) if SLID in attributes else None,
        box=tuple(map(float, variables["box_edges"])) if "box_edges" in variables else None,
        image=variables["image"],
    )  # fmt: skip


def begin(
    scene: Scene,
    path: Path,
    progress: Callable[[int], object] | None,
    say: Callable[[str], object],
) -> tuple[Scene, State]:
    """Begin a run of one's own, with its first configuration in a file.

    If nothing is there, it is made and kept there. A start of this scene is taken as it is. Of any
    other file the scene's part ``start`` is replaced by ``{method: file}``, so that what is in it
    becomes part of the scene. What a person should know of the file is said.
    """
    if not path.exists():
        if path.suffix.lower() != NETCDF:
            raise UserError(
                f"{path}: there is no such file to start from. (A name in {NETCDF} that is not "
                "there yet would be made.)"
            )
        write_start(scene, path, progress, say)
    found = begins_with(scene, path, say)
    return found, read_start(found, path) if found is scene else make_start(found, progress, say)


def begins_with(scene: Scene, path: Path, say: Callable[[str], object]) -> Scene:
    """The scene that `begin` runs: the same one, if its start is in the file."""
    attributes = files.attributes(path) if path.suffix.lower() == NETCDF else {}
    if "start_digest" in attributes and attributes["start_digest"] == start_digest(scene):
        if attributes.get("start_sources") == start_sources(scene):
            return scene
        say(f"{path}: made by other sources than today's, which may make other bits of it")
    former: dict[str, Any] = {}
    with suppress(ValueError, TypeError):
        former = dict(json.loads(attributes.get("scene", "{}")))
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
    """The same scene with its first configuration from a file, as it stands there."""
    same = {key: scene.data["start"][key] for key in ("kT", "seed") if key in scene.data["start"]}
    start = same | {"method": "file", "path": str(path)}
    return Scene(scene.data | {"start": start}, scene.where)
