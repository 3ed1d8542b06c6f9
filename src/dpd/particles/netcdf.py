"""The last configuration of a run in its ``run.nc``, as one that can be read without the scene.

Variables, each with the beads in the order of their identities (molecule after molecule):

- ``last_position`` (axis, bead): in r_c, inside the box.
- ``last_velocity`` (axis, bead): in r_c / tau; it may be missing.
- ``last_image`` (axis, bead): boxes by which the bead is further; missing where all are 0.
- ``last_species`` (bead): numbers in ``last_names``.
- ``last_names`` (name): names of the species.
- ``last_bonds`` (bond, end): identities of both ends; missing where there is none.
- ``last_angles`` (angle, corner): identities of the three beads; missing where there is none.
- ``last_masses`` (name): of a bead of each species; missing where all are 1.

Attributes: ``last_box``, the edges in r_c, and ``last_step``; under shear ``last_tilt``, the tilt
factors xy, xz and yz of the lattice of images. Velocities are then those about the flow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError
from dpd.particles.particles import Particles, box_of_file, tilt_factors

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

POSITION = "last_position"  # what tells a file with a configuration from one without


def variables_of(particles: Particles) -> dict[str, tuple]:
    """A configuration as `dpd.files.write` takes variables.

    Parameters
    ----------
    particles : Particles

    Returns
    -------
    dict of str to (dimensions, array, units, long_name)
    """
    along = ("axis", "bead")
    found = {
        POSITION: (along, particles.position, "r_c", "last positions, in the box"),
        "last_velocity": (along, particles.velocity, "r_c / tau", "last velocities"),
        "last_image": (along, particles.image, "1", "boxes by which the bead is further"),
        "last_species": (("bead",), particles.species, "1", "species, number in last_names"),
        "last_names": (("name",), np.array(particles.names), "1", "names of the species"),
        "last_bonds": (("bond", "end"), particles.bonds, "1", "numbers of the bonded beads"),
        "last_angles": (("angle", "corner"), particles.angles, "1", "beads of angles"),
        "last_masses": (("name",), particles.masses, "m", "mass of a bead of each species"),
    }
    without = {
        "last_velocity": particles.velocity is None,
        "last_image": not particles.image.any(),
        "last_bonds": not len(particles.bonds),
        "last_angles": not len(particles.angles),
        "last_masses": particles.masses is None,
    }
    return {name: variable for name, variable in found.items() if not without.get(name)}


def attributes_of(particles: Particles) -> dict[str, Any]:
    """The rest of it, as `dpd.files.write` takes attributes."""
    tilt = tilt_factors(particles.box)
    found = {"last_box": np.array(particles.box, float), "last_step": particles.step}
    return found | ({"last_tilt": np.array(tilt)} if any(tilt) else {})


def particles_of(
    variables: Mapping[str, np.ndarray], attributes: Mapping[str, Any], path: str | Path
) -> Particles:
    """The configuration of a file that `dpd.files.read` has read.

    Parameters
    ----------
    variables, attributes : dict
    path : path
        Of the file, for messages.

    Returns
    -------
    Particles

    Raises
    ------
    UserError
        If there is none, or a part of it is missing or has another shape. Whether its numbers make
        sense is for the caller to check.
    """
    if POSITION not in variables:
        raise UserError(
            f"{path}: holds no last configuration. `dpd run` keeps one; a run of a study does if "
            "its scene says 'keep_state: true'"
        )
    edges = tuple(float(edge) for edge in np.atleast_1d(attributes.get("last_box", ())))
    box = box_of_file(edges, attributes.get("last_tilt", ()), path)
    position = _array(variables, POSITION, (len(box), None), "f", path)
    beads = position.shape[1]
    names = _array(variables, "last_names", (None,), "UO", path)
    return Particles(
        box=box,
        position=position,
        image=_optional(variables, "last_image", position.shape, "i", path, np.int32),
        velocity=(
            _array(variables, "last_velocity", position.shape, "f", path)
            if "last_velocity" in variables
            else None
        ),
        species=_array(variables, "last_species", (beads,), "u", path),
        names=tuple(map(str, names)),
        bonds=_optional(variables, "last_bonds", (None, 2), "u", path, np.uint32),
        angles=_optional(variables, "last_angles", (None, 3), "u", path, np.uint32),
        step=int(attributes.get("last_step", 0)),
        masses=(
            _array(variables, "last_masses", (len(names),), "f", path)
            if "last_masses" in variables
            else None
        ),
    )


def _optional(variables, name, shape, kind, path, missing):
    """An array, or zeros of a type where the file has none."""
    if name not in variables:
        return np.zeros([size or 0 for size in shape], missing)
    return _array(variables, name, shape, kind, path)


def _array(variables, name, shape, kind, path):
    """An array of a shape, in which None is any size, and of a kind of numbers."""
    found = variables.get(name)
    if found is None:
        raise UserError(f"{path}: its last configuration is not whole: {name} is missing")
    fits = found.ndim == len(shape) and all(
        wanted in (None, size) for wanted, size in zip(shape, found.shape)
    )
    if not fits or found.dtype.kind not in kind:
        wanted = " x ".join("any" if size is None else str(size) for size in shape)
        raise UserError(
            f"{path}: {name} is {found.dtype} of shape {found.shape}, where one of {wanted} is "
            "needed; make the file anew"
        )
    return found
