"""Density fields as VTK image data (``.vti``), which ParaView and OVITO open."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dpd import files
from dpd.errors import UserError

if TYPE_CHECKING:
    from dpd.particles.fields import Fields

IMAGE = ".vti"
THICK = 1.0  # r_c, the one cell along z in which a field of two dimensions lies


def write_image(fields: Fields, frame: int, path: str | Path) -> None:
    """Write one frame, a scalar of the cells for each species, called ``density A`` and so on.

    The grid fills the box, whose corner is at 0. A field of two dimensions is one cell thick, in
    the middle of which is z = 0. Its time is not in the file.

    Parameters
    ----------
    fields : Fields
    frame : int
        From 0.
    path : path
        Its name ends in ``.vti``.

    Raises
    ------
    UserError
        If the file cannot be written, or the library that writes it is not installed.
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
