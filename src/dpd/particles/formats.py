"""Read and write configurations of beads, by the kind of the file."""

from __future__ import annotations

from pathlib import Path

from dpd import files
from dpd.errors import UserError
from dpd.particles.particles import Particles

GSD, DATA, NETCDF, CHECKPOINT = (".gsd",), (".data", ".lmp"), (".nc",), (".checkpoint",)
READ = (*GSD, *DATA, *NETCDF, *CHECKPOINT)


def read(path: str | Path, frame: int = -1) -> Particles:
    """Read one configuration, by the suffix of the file.

    Parameters
    ----------
    path : path
        GSD (``.gsd``), LAMMPS data (``.data``, ``.lmp``), or what this program writes: ``.nc``,
        ``.checkpoint``.
    frame : int
        Of a trajectory, from 0; negative numbers count from the last. Other files have one.

    Raises
    ------
    UserError
        If the file is of no known kind, cannot be read, is damaged, or holds what no simulation
        can begin with: see `dpd.particles.particles.checked`.
    """
    path = Path(path)
    files.check_input(path)
    if path.suffix in GSD:
        from dpd.particles.gsd_files import read_gsd

        return read_gsd(path, frame)
    if frame not in (0, -1):
        raise UserError(f"{path}: there is no frame {frame}: the file holds one configuration")
    if path.suffix in DATA:
        from dpd.particles.lammps_data import read_data

        return read_data(path)
    raise UserError(f"{path}: not a kind of file that can be read; allowed: {', '.join(READ)}")
