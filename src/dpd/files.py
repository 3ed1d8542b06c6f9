"""Files that are whole or not there; NetCDF that says what made it."""

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from dpd.errors import Occupied, UserError, reason, shown

# Dimensions, values, units, long_name; other attributes by name where there are some.
Variable = (
    tuple[Sequence[str], npt.ArrayLike, str, str]
    | tuple[Sequence[str], npt.ArrayLike, str, str, Mapping[str, float]]
)
ONE_AT_A_TIME = threading.RLock()  # see `opened`
TEMPORARY: set[Path] = set()  # drafts and locks, of no use once this process has ended


def write(
    path: str | Path,
    variables: Mapping[str, Variable],
    attributes: Mapping[str, Any],
    groups: Mapping[str, Mapping[str, np.ndarray]] | None = None,
) -> None:
    """Write a NetCDF file, whole or not at all; groups have plain arrays."""

    def fill(draft):
        with opened(draft, "w") as file:
            for name, variable in variables.items():
                _put(file, name, *variable)
            file.setncatts(attributes)
            for group, arrays in (groups or {}).items():
                place = file.createGroup(group)
                for name, array in arrays.items():
                    _put(place, name, [f"size_{size}" for size in array.shape], array)

    replace_whole(path, fill)


def _put(file, name, axes, values, units="", long_name="", own=()):
    """Write an array; an axis is one of its own where another array has another size there."""
    values, dimensions = np.asarray(values), []
    for axis, size in zip(axes, values.shape):
        if axis in file.dimensions and file.dimensions[axis].size != size:
            axis = f"{axis}_{size}"
        if axis not in file.dimensions:
            file.createDimension(axis, size)
        dimensions.append(axis)
    kind = str if values.dtype.kind in "UO" else values.dtype
    packed = {"zlib": True, "complevel": 1, "fletcher32": True}  # the last is a checksum
    packed = {} if kind is str or values.ndim == 0 else packed
    variable = file.createVariable(name, kind, dimensions, **packed)
    variable[...] = values.astype(object) if kind is str else values
    if long_name:
        variable.setncatts({"units": units, "long_name": long_name} | dict(own))


def replace_whole(path: str | Path, make: Callable[[Path], object]) -> None:
    """Let ``make(draft)`` write a draft beside ``path``, then put it in its place."""
    path = Path(path)
    check_output(path)
    with writing(path), draft_of(path) as draft:
        make(draft)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say in a sentence what the system or a library has against a file that is written."""
    try:
        yield
    except (OSError, RuntimeError) as problem:
        raise UserError(
            f"{path}: cannot be written ({reason(problem)}); make room there, or "
            f"{path.parent} writable, or choose another place"
        ) from None


def check_output(path: str | Path, suffix: str = "", inputs: Iterable[str | Path] = ()) -> None:
    """Refuse a place that is no file, has another suffix, or is that of an input by any name."""
    path = Path(path)
    name = os.path.abspath(path)
    if "\\" in name or name.encode(errors="ignore").decode() != name:
        raise UserError(f"{str(path)!r}: the NetCDF library opens no such name; choose another one")
    if os.path.exists(path) and not os.path.isfile(path):
        raise UserError(f"{path}: is no file, as a folder or a device; name the file to write")
    if path.suffix != suffix and suffix:  # run.NC would share with run.nc what lies beside
        raise UserError(f"{path}: a file is written here whose name ends in {suffix}; name it so")
    for given in inputs:
        there = os.path.exists(path) and os.path.exists(given) and os.path.samefile(path, given)
        if there or os.path.realpath(given) == os.path.realpath(path):
            raise UserError(
                f"{path}: what is written would take the place of what is read, {given}; choose "
                "another name"
            )


def is_filled(path: str | Path) -> bool:
    """Whether something is there that could be lost."""
    return os.path.lexists(path) and (not os.path.isfile(path) or os.path.getsize(path) > 0)


def refuse_to_replace(path: str | Path) -> None:
    """Refuse a place where a file would be lost that is not empty."""
    if is_filled(path):
        raise Occupied(f"{path}: is there already")


def check_place(path: str | Path) -> None:
    """Refuse a place where no file can be written; its folder is made."""
    path = Path(path)
    with writing(path), draft_of(path, is_kept=False) as draft:
        draft.write_bytes(b"0" * 4096)


def read(path: str | Path, group: str = "") -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Variables and attributes of a NetCDF file, or `UserError`; of a group, none if not there."""
    with _reading(path) as file:
        place = file.groups.get(group) if group else file
        if place is None:
            return {}, {}
        variables = {name: variable[...] for name, variable in place.variables.items()}
        return variables, {name: place.getncattr(name) for name in place.ncattrs()}


def check_input(path: str | Path) -> None:
    """Refuse to read what is no file."""
    if not os.path.exists(path):
        raise UserError(f"{path}: there is no such file")
    if not os.path.isfile(path):
        raise UserError(f"{path}: is not a file")


def attributes(path: str | Path) -> dict[str, Any]:
    """All attributes of a NetCDF file, its variables left unread."""
    with _reading(path) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


@contextmanager
def opened(path: str | Path, mode: Literal["r", "w"] = "r") -> Iterator[Any]:
    """A NetCDF file, to read or to write; in one thread at a time, as the HDF5 library needs."""
    import netCDF4  # its library takes time to import

    # Of a name alone the library drops blanks in front, and takes some for addresses.
    with ONE_AT_A_TIME, netCDF4.Dataset(os.path.abspath(path), mode) as file:
        yield file


@contextmanager
def _reading(path):
    """A NetCDF file to read from, or a sentence on why it cannot be."""
    check_input(path)
    with reading(path, "NetCDF file", "make it again"), opened(path) as file:
        file.set_auto_mask(False)
        yield file


@contextmanager
def reading(
    path: object, kind: str = "file", remedy: str = "copy or write it again"
) -> Iterator[None]:
    """Say in a sentence what the system, a library or NumPy has against a file that is read."""
    try:
        with np.errstate(all="ignore"):
            yield
    except UserError:
        raise
    except Exception as problem:  # a dozen kinds, for bytes and numbers in it that cannot be
        if (getattr(problem, "errno", None) or 0) > 0:  # what the NetCDF library finds is below
            raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
        said = shown(reason(problem).replace(str(path), "the file") or "damaged", str)
        raise UserError(f"{path}: not a whole {kind} ({said}); {remedy}") from None


def check_digest(
    path: str | Path, attributes: Mapping[str, Any], name: str, expected: str, remedy: str
) -> None:
    """Refuse a file that other sources made: its attribute ``name`` is not the expected digest."""
    found = attributes.get(name)
    if found != expected:
        raise UserError(f"{path}: made by other sources ({name} {found}, now {expected}); {remedy}")


@contextmanager
def draft_of(path: Path, is_kept: bool = True) -> Iterator[Path]:
    """A name beside a file, this thread's own, for what takes its place after the block."""
    draft = path.with_name(f"{path.name}.{threading.get_native_id()}.writing")
    TEMPORARY.add(draft)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.unlink(missing_ok=True)  # of a process of that number, which was killed
        draft.touch(exist_ok=False)
        yield draft
        if is_kept:
            os.replace(draft, path)
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        TEMPORARY.discard(draft)


def remove_drafts(path: Path) -> None:
    """Remove what killed processes left of a file; for the one at work on it, `dpd.runs`."""
    with suppress(OSError):
        for draft in path.parent.glob(f"{escape(path.name)}.*.writing"):
            draft.unlink(missing_ok=True)


def unfinished(path: Path) -> Path:
    """Where a file grows beside its place, with a suffix by which programs know it."""
    return path.with_name(f"{path.stem}.unfinished{path.suffix}")
