"""Configurations in the files that this program writes: results, starts and checkpoints."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd import files
from dpd.engine.checkpoint import stored_in
from dpd.errors import UserError
from dpd.particles.netcdf import POSITION, particles_of
from dpd.particles.particles import SLID, Particles, box_at, box_of_file, checked, of_scene
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def read_netcdf(path: Path) -> Particles:
    """Read the configuration of a NetCDF file.

    That is the last one of a result that keeps it, or what its observable ``configuration`` saw
    last, without velocities; or a first configuration; or what `dpd.particles.formats.write` made.

    Raises
    ------
    UserError
        If the file cannot be read, is none of these, or holds what no simulation can begin with.
    """
    variables, attributes = files.read(path)
    if POSITION in variables or "position" not in variables or "scene" not in attributes:
        return checked(particles_of(variables, attributes, path), path)
    scene = _scene_of(attributes["scene"], path)
    step = sum(scene.steps) if "scene_digest" in attributes else 0
    box = box_at(scene, 0, int(attributes.get(SLID, 0)))
    if "box_tilt" in variables:
        box = box_of_file(scene.box, variables["box_tilt"], path)
    if "box_edges" in variables:
        box = tuple(map(float, variables["box_edges"]))
    return _of_scene(scene, variables, step, box, path)


def read_checkpoint(path: Path) -> Particles:
    """Read the configuration of a checkpoint.

    Raises
    ------
    UserError
        If the file is no checkpoint, is damaged, or holds what no simulation can begin with.
    """
    found = stored_in(path)
    if found is None:
        raise UserError(
            f"{path}: no checkpoint, or a damaged one; allowed: what a run of this program leaves "
            "where it is stopped"
        )
    if "scene" not in found.note:
        raise UserError(f"{path}: a checkpoint without its scene, of an older version; run again")
    scene, stored = _scene_of(found.note["scene"], path), found.arrays
    order = np.argsort(stored["identity"])
    beads = {name: stored[name][:, order] for name in ("position", "velocity")}
    beads |= {"image": stored["image"]} if "image" in stored else {}
    step = int(stored["step"])
    box = box_at(scene, step, int(stored["slid"]) if "slid" in stored else None)
    if "box" in stored:
        box = tuple(map(float, stored["box"]))
    return _of_scene(scene, beads, step, box, path)


def _scene_of(text, path):
    """The scene that a file was made from."""
    try:
        data = json.loads(text)
    except (ValueError, TypeError):
        data = None
    if not isinstance(data, dict):
        raise UserError(f"{path}: its attribute 'scene' is damaged; make the file anew")
    return Scene(data, str(path))


def _of_scene(
    scene: Scene, beads: Mapping[str, Any], step: int, box: tuple[float, ...], path: Path
) -> Particles:
    """Beads in the order of identities, with names and bonds of their scene."""
    shape = (scene.dimension, scene.beads)
    for name, kind in (("position", "f"), ("velocity", "f"), ("image", "i")):
        found = beads.get(name)
        if found is not None and (found.shape != shape or found.dtype.kind != kind):
            raise UserError(
                f"{path}: {name} is {found.dtype} of shape {found.shape}, and the scene in the "
                f"file has {shape}; make the file anew"
            )
    image = beads.get("image", np.zeros(shape, np.int32))
    position = beads["position"]
    if (bad := ~np.isfinite(position).all(axis=0)).any():
        raise UserError(
            f"{path}: bead {np.argmax(bad)} has a position that is not a finite number; make the "
            "file anew"
        )
    return checked(of_scene(scene, box, position, image, beads.get("velocity"), step), path)
