"""Read and write configurations of beads, by the kind of the file."""

from pathlib import Path

from dpd import files
from dpd.errors import UserError
from dpd.particles.particles import Particles

WRITTEN = ".gsd", ".data", ".lmp", ".nc"
READ = (*WRITTEN, ".checkpoint")


def read(path: str | Path, frame: int = -1) -> Particles:
    """Read one configuration, by the suffix of the file, one of `READ`.

    A frame of a trajectory counts from 0, or from the last with -1, -2 ...; other files have one.
    `UserError` if the file is of no known kind, cannot be read, is damaged, or holds what no
    simulation can begin with: see `dpd.particles.particles.Particles.checked`.
    """
    path, kind = Path(path), refuse_suffix(path, READ)
    files.check_input(path)
    with files.reading(path):
        if kind == ".gsd":
            from dpd.particles.gsd_files import read_gsd

            return read_gsd(path, frame)
        if frame not in (0, -1):
            raise UserError(f"{path}: there is no frame {frame}: the file holds one configuration")
        if kind in (".data", ".lmp"):
            from dpd.particles.lammps import read_data

            return read_data(path)
        from dpd.particles.netcdf import read_checkpoint, read_netcdf

        return read_netcdf(path) if kind == ".nc" else read_checkpoint(path)


def write(particles: Particles, path: str | Path) -> tuple[str, ...]:
    """Write one configuration, by the suffix of the file; return what it cannot keep, if any."""
    path, kind = Path(path), refuse_suffix(path, WRITTEN)
    if kind == ".gsd":
        from dpd.particles.gsd_files import write_gsd

        files.replace_whole(path, lambda draft: write_gsd(particles, draft))
        without = "there are no velocities: programs that read GSD take them to be 0"
        return () if particles.velocity is not None else (without,)
    if kind == ".nc":
        from dpd.particles.netcdf import attributes_of, variables_of

        files.write(path, variables_of(particles), attributes_of(particles))
        return ()
    from dpd.particles.lammps import as_data

    text = as_data(particles)
    files.replace_whole(path, lambda draft: draft.write_text(text))
    return ("names of the species are comments behind the masses, which LAMMPS does not keep",)


def refuse_suffix(path: str | Path, allowed: tuple[str, ...]) -> str:
    """The suffix of a file, if it is allowed; ``.data`` also for names as LAMMPS' ``data.melt``."""
    path = Path(path)
    if path.suffix.lower() in allowed:
        return path.suffix.lower()
    if path.name.startswith("data."):
        return ".data"
    what = f"suffix {path.suffix!r}" if path.suffix else "name without a suffix"
    raise UserError(
        f"{path}: a {what}, which says what kind of file it is; allowed: {', '.join(allowed)}, and "
        "data.NAME"
    )
