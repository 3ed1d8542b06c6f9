"""NetCDF files that are whole or not there, and say what made them."""

import os
import shutil
from pathlib import Path

import netCDF4
import numpy as np

from dpd.errors import UserError


def write(path, variables, attributes):
    """Write a NetCDF file; a kill while writing leaves nothing under its name.

    Parameters
    ----------
    path : path
    variables : dict
        Name to (dimensions, array, units, long_name).
    attributes : dict
        Strings and numbers.
    """
    replace_whole(path, lambda draft: _fill(draft, variables, attributes))


def replace_whole(path, make):
    """Let ``make(draft)`` write a draft beside ``path``, then put it in its place.

    A failure removes the draft; a kill leaves it, but nothing under the name asked for.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(path.name + ".writing")
    try:
        make(draft)
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def check_room(path, size):
    """Refuse a place where a file of some bytes cannot be written, before it is needed.

    Parameters
    ----------
    path : path
        Of the file to come; its folder is made.
    size : int

    Raises
    ------
    UserError
        If the folder cannot be made or written, or its disk has less room.
    """
    path = Path(path)
    probe = path.with_name(f"{path.name}.{os.getpid()}.probe")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"0" * 4096)
        probe.unlink()
        free = shutil.disk_usage(path.parent).free
    except OSError as problem:
        raise UserError(
            f"{path}: cannot be written ({problem.strerror}); make {path.parent} writable or "
            "choose another place"
        ) from None
    if free < size:
        raise UserError(
            f"{path}: {free / 2**20:.0f} MiB are free there, {size / 2**20:.0f} MiB are needed for "
            "checkpoint and result; make room or choose another place"
        )


def _fill(draft, variables, attributes):
    with netCDF4.Dataset(draft, "w") as file:
        for name, (dimensions, values, units, long_name) in variables.items():
            values = np.asarray(values)
            for axis, size in zip(dimensions, values.shape):
                if axis not in file.dimensions:
                    file.createDimension(axis, size)
            kind = str if values.dtype.kind in "UO" else values.dtype
            compressed = {} if kind is str or values.ndim == 0 else {"zlib": True, "complevel": 1}
            variable = file.createVariable(name, kind, dimensions, **compressed)
            variable[...] = values.astype(object) if kind is str else values
            variable.units, variable.long_name = units, long_name
        file.setncatts(attributes)


def read(path):
    """Read a NetCDF file that `write` made.

    Returns
    -------
    variables : dict of str to array
    attributes : dict

    Raises
    ------
    UserError
        If it is missing or is not NetCDF.
    """
    if not Path(path).is_file():
        raise UserError(f"{path}: there is no such file")
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            variables = {name: variable[...] for name, variable in file.variables.items()}
            return variables, {name: file.getncattr(name) for name in file.ncattrs()}
    except OSError:
        raise UserError(
            f"{path}: not a whole NetCDF file; if it should be one, make it again"
        ) from None


def attribute(path, name):
    """One attribute of a NetCDF file, its variables left unread."""
    with netCDF4.Dataset(path) as file:
        return file.getncattr(name)


def check_digest(path, attributes, name, expected, remedy):
    """Refuse a file that other sources made.

    Raises
    ------
    UserError
        If the attribute ``name`` is not the expected digest.
    """
    found = attributes.get(name)
    if found != expected:
        raise UserError(f"{path}: made by other sources ({name} {found}, now {expected}); {remedy}")
