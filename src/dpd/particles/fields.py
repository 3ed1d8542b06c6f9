"""Density fields of a finished run, also as VTK image data, which ParaView and OVITO open."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd import files
from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping

FIELD = "density_field"  # the variable, and the observable
IMAGE = ".vti"
THICK = 1.0  # r_c, the one cell along z in which a field of two dimensions lies
_ASKED_FOR = (
    "holds no density field, which a run.nc does if its scene says "
    "'observe: [{density_field: {every: 20, average: 10}}]'"
)


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

    def number(self, frame: int, path: object) -> int:
        """A frame that may be counted from the last one, as -1, from 0 on; refused if not there."""
        count = len(self.time)
        if not -count <= frame < count:
            raise UserError(
                f"{path}: there is no frame {frame} of the density field; allowed: 0 to "
                f"{count - 1}, or from the end -1 to -{count}"
            )
        return frame % count


def read_fields(path: Path) -> Fields:
    """The density fields of a ``run.nc``; `UserError` if it cannot be read, or has none."""
    if path.suffix.lower() != ".nc":
        files.check_input(path)
        raise UserError(f"{path}: {_ASKED_FOR}")
    return fields_of(files.read(path)[0], path)


def fields_of(variables: Mapping[str, np.ndarray], path: object) -> Fields:
    """The density fields among the variables of a run; refused if they are lacking or damaged."""
    if FIELD not in variables:
        raise UserError(f"{path}: {_ASKED_FOR}")
    density, box = variables[FIELD], variables.get("field_box", np.zeros((0, 0)))
    time, names = variables.get("field_time", np.zeros(0)), variables.get("species", np.zeros(0))
    frames, dimension = len(density), density.ndim - 2
    shapes = (box.shape, time.shape, names.shape)
    if shapes != ((frames, dimension), (frames,), density.shape[1:2]) or dimension not in (2, 3):
        raise UserError(f"{path}: its density field is damaged; make the file anew")
    there = np.isfinite(density).all(axis=tuple(range(1, density.ndim)))
    if not there.any():
        raise UserError(f"{path}: the run was lost before the first frame of its density field")
    return Fields(tuple(map(str, names)), time[there], box[there], density[there])


def write_image(fields: Fields, frame: int, path: str | Path) -> None:
    """Write one frame, counted from 0, with a scalar ``density A`` of the cells for each species A.

    The grid fills the box, whose corner is at 0. A field of two dimensions is one cell thick, in
    the middle of which is z = 0. Its time is not in the file.

    `UserError` if the file cannot be written, or the library that writes it is not installed.
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
            with suppress(FileNotFoundError):
                made.unlink()

    files.replace_whole(path, make)
