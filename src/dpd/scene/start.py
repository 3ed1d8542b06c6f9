"""What a scene says of its first configuration: what decides it, what it costs, who makes it."""

from __future__ import annotations

import hashlib
import os
from functools import cache
from typing import TYPE_CHECKING, Any

from dpd.digest import value_digest
from dpd.errors import UserError, reason
from dpd.page import is_table
from dpd.scene.bonding import laws_of

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.scene.scene import Scene

FLIGHT = 0.8  # r_c, a step of a random flight where bonds have no rest length
OF_FILE = ("path", "frame", "sha256")  # keys of method file alone
LAST_FRAME = -1  # of a file with several configurations
PIECE = 2**20  # bytes of a file that are read at once
SMALL = 0.1  # of a run's steps: a start that takes no more is made by the run itself


def start_description(scene: Scene) -> dict[str, Any]:
    """The part of a scene that decides its first configuration, as plain data.

    Runs whose descriptions agree share one start.
    """
    data, start = scene.data, scene.data["start"]
    kept = {
        "dimension": data["dimension"],
        "box": list(scene.box),
        "molecules": data["molecules"],
        "method": start["method"],
        "kT": start.get("kT", data["thermostat"]["kT"]),
        "seed": start.get("seed", data["seed"]),
    }
    if "mass" in data:
        kept["mass"] = data["mass"]
    if scene.ended:
        kept["between"] = [list(scene.ended), *(scene.origin[axis] for axis in scene.ended)]
    if reads_file(scene):
        kept["file"] = [start["sha256"], start.get("frame", LAST_FRAME)]
        if "pressure" in data:
            kept["box_of_file"] = data["pressure"]["axes"]
    elif grows(scene):
        kept["polymerize"] = start["polymerize"]
    elif "bond" in data:
        kept["flight"] = _flights(data["bond"])
    if "relax" in start:
        kept["relax"] = start["relax"]
    if scene.own_forces and ("relax" in start or grows(scene)):
        kept["own"] = {term.key: data[term.key] for term in scene.own_forces}
    if "relax" in start or grows(scene):
        kept["forces"] = start_forces(scene)
        kept["thermostat"] = data["thermostat"]["kT"]
    return kept


def start_digest(scene: Scene) -> str:
    """Digest of what decides the first configuration of a scene."""
    return value_digest(start_description(scene))


def start_forces(scene: Scene) -> dict[str, Any]:
    """Forces of growth and relaxation: those of the scene, but for start.forces."""
    data, changed = scene.data, scene.data["start"]["forces"]
    forces = {"repulsion": scene.repulsions}
    if "walls" in data:
        forces["walls"] = data["walls"]
    if "core" in data or "core" in changed:
        forces["core"] = data.get("core", {}) | changed.get("core", {})
    if "bond" in data or "bond" in changed:
        forces["bond"] = _changed_bond(data.get("bond", {}), changed.get("bond", {}))
    if "angle" in data and not grows(scene):
        forces["angle"] = data["angle"]
    forces["gamma"] = changed.get("gamma", data["thermostat"]["gamma"])
    return forces


def _flights(bond):
    """The length of a step of a random flight; one for each law of a table."""
    lengths = [float(law["length"]) or FLIGHT for law in laws_of(bond)]
    return dict(zip(bond, lengths)) if is_table(bond) else lengths[0]


def _changed_bond(bond, changed):
    """The law of bonds with changes; of a table, each law."""
    if is_table(bond):
        return {pair: law | changed for pair, law in bond.items()}
    return bond | changed


def start_work(scene: Scene) -> int:
    """Beads to bond and steps to relax, which progress counts; 0 if beads are only placed."""
    return (scene.beads if grows(scene) else 0) + relaxing(scene)


def start_is_shared(scene: Scene) -> bool:
    """Whether a job of its own makes the first configuration, for all runs that begin with it.

    So it is where chains grow, or where it takes more than a tenth of the run's steps. Less is
    not worth a job: the run makes its own. This looks at the one scene alone: that other runs
    come and go leaves what was run as it is.
    """
    return grows(scene) or relaxing(scene) > SMALL * sum(scene.steps)


def grows(scene: Scene) -> bool:
    """Whether the chains of a scene grow from monomers."""
    return scene.data["start"]["method"] == "polymerize"


def reads_file(scene: Scene) -> bool:
    """Whether the first configuration of a scene is read from a file."""
    return scene.data["start"]["method"] == "file"


def with_file(start: dict[str, Any], folder: str | Path, where: str) -> dict[str, Any]:
    """What a scene says of a start from a file, with the file's whole path and its content.

    Parameters
    ----------
    start : dict
        Valid, of method ``file``.
    folder : path
        From which a relative path counts.
    where : str
        File to name in messages.

    Returns
    -------
    dict
        With ``path`` and ``sha256``. A digest that is given stays: the file is then not looked at
        before it is needed.

    Raises
    ------
    UserError
        If there is no file that can be read.
    """
    path = os.path.abspath(os.path.join(folder, start["path"]))
    return start | {"path": path, "sha256": start.get("sha256") or file_digest(path, where)}


def file_digest(path: str, where: str) -> str:
    """SHA-256 of what is in a file.

    Parameters
    ----------
    path : str
    where : str
        File to name in messages.

    Raises
    ------
    UserError
        If it cannot be read.
    """
    from dpd.files import check_input  # NetCDF, which few scenes need to be read

    try:
        check_input(path)
        found = os.stat(path)
        return _digest_of(path, found.st_mtime_ns, found.st_size)
    except UserError as problem:
        raise UserError(f"{where}: start.path: {problem}") from None
    except OSError as problem:
        raise UserError(
            f"{where}: start.path: {path}: cannot be read ({reason(problem)})"
        ) from None


@cache
def _digest_of(path, changed, size):
    """The same; a file that has not changed is read once for all scenes of a sweep."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
    return digest.hexdigest()


def relaxing(scene: Scene) -> int:
    """Steps of relaxation of a scene's first configuration."""
    return scene.data["start"].get("relax", {}).get("steps", 0)
