"""Density fields of a finished run."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd import files
from dpd.errors import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

FIELD = "density_field"  # the variable, and the observable


class Fields(NamedTuple):
    """Densities of some species on a grid, in frames over time.

    Attributes
    ----------
    names : tuple of str
        Of the species.
    time : (frames,) array
        In tau since the end of equilibration.
    box : (frames, dimension) array
        Edges in r_c.
    density : (frames, species, ...) array
        In beads per r_c^dimension, with an axis of cells for each axis of the box.
    """

    names: tuple[str, ...]
    time: np.ndarray
    box: np.ndarray
    density: np.ndarray

    @property
    def dimension(self) -> int:
        return self.box.shape[1]

    def __str__(self) -> str:
        cells = " x ".join(map(str, self.density.shape[2:]))
        return f"densities of {', '.join(self.names)} in {cells} cells, {len(self.time)} frames"

    def number(self, frame: int, path: object) -> int:
        """The number of a frame that may be counted from the last one, as -1.

        Raises
        ------
        UserError
            If there is no such frame.
        """
        count = len(self.time)
        if not -count <= frame < count:
            raise UserError(
                f"{path}: there is no frame {frame} of the density field; allowed: 0 to "
                f"{count - 1}, or from the end -1 to -{count}"
            )
        return frame % count


def read_fields(path: Path) -> Fields:
    """Read the density fields of a ``run.nc``.

    Raises
    ------
    UserError
        If the file cannot be read, or has none.
    """
    if path.suffix.lower() != ".nc":
        files.check_input(path)
        raise UserError(f"{path}: {_ASKED_FOR}")
    variables, _ = files.read(path)
    return fields_of(variables, path)


def fields_of(variables: Mapping[str, np.ndarray], path: object) -> Fields:
    """The density fields among the variables of a run.

    Parameters
    ----------
    variables : dict of str to array
    path : path
        Where they come from, for messages.

    Raises
    ------
    UserError
        If there are none, or only damaged ones.
    """
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


_ASKED_FOR = (
    "holds no density field, which a run.nc does if its scene says "
    "'observe: [{density_field: {every: 20, average: 10}}]'"
)
