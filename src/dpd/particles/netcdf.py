"""What a ``run.nc`` says of beads: the last configuration, without the scene, and density fields.

Variables ``last_...`` (see `variables_of`) have the beads in the order of their identities,
molecule after molecule. ``last_image`` is missing where all are 0, ``last_masses`` where all are 1.
Attributes: ``last_box``, the edges in r_c, and ``last_step``; under shear ``last_tilt``, the tilt
factors xy, xz and yz of the lattice of images. Velocities are then those about the flow.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dpd import files
from dpd.engine.loop import put_back, stored_in
from dpd.errors import UserError
from dpd.particles.particles import Particles, box_of_file, of_scene, of_state, tilt_factors
from dpd.scene.scene import Scene

STATE = "state"  # group with all arrays of a state, by which a run goes on to the same bits
POSITION = "last_position"  # what tells a file with a configuration from one without
# Of each array: dimensions, units, long_name; in the file it is called last_...
ARRAYS = {
    "position": (("axis", "bead"), "r_c", "last positions, in the box"),
    "velocity": (("axis", "bead"), "r_c / tau", "last velocities"),
    "image": (("axis", "bead"), "1", "boxes by which the bead is further"),
    "species": (("bead",), "1", "species, number in last_names"),
    "names": (("name",), "1", "names of the species"),
    "bonds": (("bond", "end"), "1", "numbers of the bonded beads"),
    "angles": (("angle", "corner"), "1", "beads of angles"),
    "masses": (("name",), "m", "mass of a bead of each species"),
}
NOT_IF_ZERO = "image", "bonds", "angles"  # which are not written if there is nothing to say
FIELD = "density_field"  # the variable, and the observable
IMAGE = ".vti"
THICK = 1.0  # r_c, the one cell along z in which a field of two dimensions lies


def variables_of(particles: Particles) -> dict[str, tuple]:
    """A configuration as `dpd.files.write` takes variables."""
    found = {}
    for name, (dimensions, units, text) in ARRAYS.items():
        array = getattr(particles, name)
        if array is not None and (np.any(array) or name not in NOT_IF_ZERO):
            found[f"last_{name}"] = (dimensions, np.asarray(array), units, text)
    return found


def attributes_of(particles: Particles) -> dict[str, Any]:
    """The rest of it, as `dpd.files.write` takes attributes."""
    tilt = tilt_factors(particles.box)
    found = {"last_box": np.array(particles.box, float), "last_step": particles.step}
    found |= {"last_types": json.dumps([*particles.types.items()])} if particles.types else {}
    return found | ({"last_tilt": np.array(tilt)} if any(tilt) else {})


def particles_of(
    variables: Mapping[str, np.ndarray], attributes: Mapping[str, Any], path: str | Path
) -> Particles:
    """The last configuration of a file that `dpd.files.read` has read, not `checked` yet."""
    if POSITION not in variables:
        raise UserError(
            f"{path}: holds no last configuration. `dpd run` keeps one; a run of a study does if "
            "its scene says 'keep_state: true'"
        )
    with files.reading(path):
        arrays: dict[str, Any] = {
            name: variables[f"last_{name}"] for name in ARRAYS if f"last_{name}" in variables
        }
        arrays["names"] = tuple(map(str, arrays["names"]))
        absent: dict[str, Any] = {
            "image": np.zeros(arrays["position"].shape, np.int32),
            "bonds": np.zeros((0, 2), np.uint32),
            "velocity": None,
        }
        types = json.loads(attributes.get("last_types", "[]"))
        absent["types"] = {tuple(beads): name for beads, name in types}
        box = box_of_file(attributes["last_box"], attributes.get("last_tilt", ()), path)
        return Particles(box=box, step=int(attributes.get("last_step", 0)), **absent | arrays)


def read_netcdf(path: Path) -> Particles:
    """The last configuration of a result, or a first one, or what `dpd.particles.write` made."""
    variables, attributes = files.read(path)
    if "start_digest" in attributes:
        return _of_arrays(files.read(path, STATE)[0], attributes["scene"], path)
    if POSITION in variables or "position" not in variables or "scene" not in attributes:
        return particles_of(variables, attributes, path).checked(path)
    scene, position = Scene.of_result(attributes["scene"], str(path)), variables["position"]
    edges = variables.get("box_edges", scene.period)
    box, image = box_of_file(edges, variables.get("box_tilt", ()), path), np.zeros_like(position)
    return of_scene(scene, box, position, image, None, sum(scene.steps)).checked(path)


def read_checkpoint(path: Path) -> Particles:
    """The configuration of a checkpoint."""
    found = stored_in(path)
    if found is None or "scene" not in found.note:
        raise UserError(f"{path}: no checkpoint of this version, or a damaged one; run again")
    return _of_arrays(found.arrays, found.note["scene"], path)


def _of_arrays(arrays, scene, path):
    """Beads in the order of identities, with names and bonds of their scene."""
    state = put_back(arrays, ())
    return of_state(Scene.of_result(scene, str(path)), state).checked(path)


class Fields(NamedTuple):
    """Densities of some species on a grid, in frames over time."""

    names: tuple[str, ...]
    time: np.ndarray  # (frames,) in tau since the end of equilibration
    box: np.ndarray  # (frames, dimension) edges in r_c
    density: np.ndarray  # (frames, species, ...) in beads per r_c^dimension; cells of each axis

    @property
    def dimension(self) -> int:
        return self.box.shape[1]

    def __str__(self) -> str:
        cells = " x ".join(map(str, self.density.shape[2:]))
        return f"densities of {', '.join(self.names)} in {cells} cells, {len(self.time)} frames"


def read_fields(path: Path) -> Fields:
    """The density fields of a ``run.nc``; `UserError` if it cannot be read, or has none."""
    return fields_of(files.read(path)[0], path)


def fields_of(variables: Mapping[str, np.ndarray], path: object) -> Fields:
    """The density fields among the variables of a run; refused if they are lacking or damaged."""
    if FIELD not in variables:
        raise UserError(
            f"{path}: holds no density field, which a run.nc does if its scene says "
            "'observe: [{density_field: {every: 20, average: 10}}]'"
        )
    asked = FIELD, "field_box", "field_time", "species"
    density, box, time, names = (variables[name] for name in asked)
    there = np.isfinite(density).all(axis=tuple(range(1, density.ndim)))
    if not there.any():
        raise UserError(f"{path}: the run was lost before the first frame of its density field")
    return Fields(tuple(map(str, names)), time[there], box[there], density[there])


def write_image(fields: Fields, frame: int, path: str | Path) -> None:
    """Write one frame, counted from 0, with a scalar ``density A`` of the cells for each species A.

    The corner of the box is at 0; in two dimensions the cells are about z = 0.
    """
    try:
        from pyevtk.hl import imageToVTK
    except ModuleNotFoundError:
        raise UserError(
            f"{path}: the library pyevtk, which writes VTK files, is not installed: pip install "
            "'dpd-papers[draw]'"
        ) from None
    density, box = fields.density[frame], fields.box[frame]
    spacing = [float(edge) / cells for edge, cells in zip(box, density.shape[1:])]
    origin = [0.0, 0.0, 0.0]
    if fields.dimension == 2:
        density, spacing, origin = density[..., None], [*spacing, THICK], [0.0, 0.0, -THICK / 2]
    cells = {f"density {name}": np.asfortranarray(one) for name, one in zip(fields.names, density)}

    def make(draft):
        made = Path(f"{draft}{IMAGE}")  # the library adds this to every name
        try:
            imageToVTK(str(draft), tuple(origin), tuple(spacing), cells)
            made.replace(draft)
        finally:
            made.unlink(missing_ok=True)

    files.replace_whole(path, make)
