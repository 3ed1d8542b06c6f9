"""What a scene may ask for: sizes that can be run, and settings that have an effect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError
from dpd.scene.architecture import length_of
from dpd.scene.bonding import is_table, laws_of
from dpd.scene.flow import check_flow
from dpd.scene.shear import check_shear, room_for_images
from dpd.scene.start import OF_FILE, reads_file, start_forces
from dpd.scene.stretched import MOST_STRETCHED, STRETCHED, stretched_share
from dpd.scene.walls import check_walls

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

MOST_BEADS = 10**8  # 31 GB of state
MOST_STEPS = 10**12
MOST_WORK = 10**15  # bead-steps: about two years on one core
MOST_SPECIES = 256  # a bead's species is one byte


def check_beads(data: dict[str, Any], where: str) -> None:
    """Refuse more beads than fit, before molecules are written out bead by bead.

    Parameters
    ----------
    data : dict
        A valid scene with defaults.
    where : str
        File to name in messages.

    Raises
    ------
    UserError
    """
    volume, total = _volume(data), 0
    for place, kind in enumerate(data["molecules"]):
        length = length_of(kind["architecture"], f"{where}: molecules.{place}.architecture")
        beads = (
            max(length, kind["density"] * volume) if "density" in kind else kind["count"] * length
        )
        total += beads
        if total > MOST_BEADS:
            key = "density" if "density" in kind else "count"
            raise UserError(
                f"{where}: molecules.{place}.{key}: {kind[key]:g} makes {total:.3g} beads in all; "
                f"allowed: <= {MOST_BEADS}"
            )


def _volume(data):
    """Of the box; an edge for each axis, or one for all."""
    box = data["box"]
    volume = 1.0
    for edge in box if isinstance(box, list) else [box] * data["dimension"]:
        volume *= edge
    return volume


def check_limits(scene: Scene) -> None:
    """Refuse what is too large, and settings that would be without effect.

    Parameters
    ----------
    scene : Scene
        Otherwise checked.

    Raises
    ------
    UserError
    """

    def refuse(key, problem):
        raise UserError(f"{scene.where}: {key}: {problem}")

    if len(scene.species) > MOST_SPECIES:
        refuse("molecules", f"{len(scene.species)} species; allowed: <= {MOST_SPECIES}")
    _check_length(scene, refuse)
    _check_start_file(scene, refuse)
    _check_start_forces(scene, refuse)
    check_shear(scene, refuse)
    _check_bond_length(scene, refuse)
    check_walls(scene, refuse)
    check_flow(scene, refuse)


def _check_length(scene, refuse):
    """Steps and bead-steps of relaxation and run."""
    steps = sum(scene.steps) + scene.data["start"].get("relax", {}).get("steps", 0)
    work = scene.beads * steps
    if steps > MOST_STEPS or work > MOST_WORK:
        refuse(
            "steps and duration",
            f"{steps:.3g} steps, {work:.3g} bead-steps; allowed: <= {MOST_STEPS:.0e} steps and "
            f"<= {MOST_WORK:.0e} bead-steps, about two years on one core",
        )


def _check_start_file(scene, refuse):
    """Keys of a start from a file have no effect on other ones."""
    for key in OF_FILE:
        if key in scene.data["start"] and not reads_file(scene):
            refuse(
                f"start.{key}",
                f"has no effect with method {scene.data['start']['method']!r}; take "
                "'method: file', or remove the key",
            )


def _check_start_forces(scene, refuse):
    """start.forces act in growth and relaxation, and there as whole forces."""
    start = scene.data["start"]
    own = start["forces"]
    if own and "relax" not in start and start["method"] != "polymerize":
        refuse(
            "start.forces",
            "has no effect: nothing is relaxed or grown; add start.relax, as "
            "{steps: 1000, dt: 0.01}, or remove the key",
        )
    if "bond" in own and "bond" not in scene.data:
        refuse("start.forces.bond", "every molecule is a single bead; remove the key")
    forces = start_forces(scene)
    by_species = scene.data["thermostat"]["kind"] == "langevin" and np.ndim(scene.friction)
    if by_species and "gamma" not in own and ("relax" in start or start["method"] == "polymerize"):
        refuse(
            "thermostat.gamma",
            "one value for each species, and the start is relaxed or grown with friction between "
            "pairs; add start.forces.gamma, as 4.5",
        )
    for key in ("radius", "force"):
        if "core" in own and key not in forces["core"]:
            refuse(
                "start.forces.core",
                f"the key {key!r} is missing, and the scene has no 'core' to take it from",
            )
    core = forces.get("core", {})
    if 2 * core.get("radius", 0) + core.get("smooth", 0) > 1:
        refuse(
            "start.forces.core",
            f"a core of diameter {2 * core['radius']:g} and an edge of {core.get('smooth', 0):g} "
            "go past the cutoff; allowed: <= 1 together",
        )


def _check_bond_length(scene, refuse):
    """Bonds whose beads would be nearer to other images of each other than to their own."""
    bond = scene.data.get("bond", {})
    for place, law in enumerate(laws_of(bond)):
        share = stretched_share(law, scene.data["thermostat"]["kT"], room_for_images(scene))
        if share > MOST_STRETCHED:
            edges = " x ".join(f"{edge:g}" for edge in scene.box)
            refuse(
                f"bond.{list(bond)[place]}" if is_table(bond) else "bond",
                f"stiffness {law['stiffness']:g}, length {law['length']:g}: at this temperature "
                f"{share:.2g} of such bonds reach over {STRETCHED:.0%} of an edge of the box of "
                f"{edges} (estimated for bonds without other forces), and beyond half of it they "
                f"would pull at other images; allowed: {MOST_STRETCHED:g}. Take a larger box, or a "
                "stiffer or shorter bond",
            )
