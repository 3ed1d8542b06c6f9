"""A run from Python."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.api.datasets import load
from dpd.errors import Stopped, UserError, shown
from dpd.own import measures, refuse_to_run
from dpd.page import Observable
from dpd.progress import Progress
from dpd.runs.extend import extend as make_longer
from dpd.runs.run import Options
from dpd.runs.run import run as run_alone
from dpd.scene.scene import Scene
from dpd.scene.sections import Basics
from dpd.scene.yaml import read_yaml

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import xarray as xr

CHECKPOINT_EVERY = 60.0  # s of wall clock


def run(
    scene: str | os.PathLike | Mapping[str, Any] | Scene,
    *,
    observe: Sequence[Any] = (),
    pages: Sequence[Any] = (),
    start: str | os.PathLike | None = None,
    output: str | os.PathLike | None = None,
    threads: int = 1,
    progress: bool | None = None,
    overwrite: bool = False,
) -> xr.Dataset:
    """Simulate a scene.

    Ctrl-C stops it after the steps under way, with a `KeyboardInterrupt`. With an ``output``, the
    state is kept beside it once a minute and then, and the same call goes on from there, to the
    same bits.

    Parameters
    ----------
    scene : path, dict or dpd.Scene
        What to simulate; a path is that of a YAML file.
    observe : list, optional
        More to measure than the scene names: functions as ``def gyration(snapshot)``, which
        return a number or an array of a `dpd.observe.common.snapshot.Snapshot`; objects of classes
        of one's own, as ``Gyration(of="A")``; names, as a scene has them. Functions and classes
        stand in a file or a cell of a notebook, with all that they use.
    pages : list, optional
        Files with pages of one's own, or classes such as pair forces, that the scene may then name.
    start : path, optional
        First configuration, as ``dpd run --start`` takes it: read if the file is there, otherwise
        made and kept in it. Without it, it is made as the scene says.
    output : path, optional
        A file to keep the result in, whose name ends in ``.nc``. If it holds the result of the same
        scene already, nothing is run, with a warning. Without it nothing is left on the disk.
    threads : int, optional
        Threads that share the work. The results are the same bits.
    progress : bool, optional
        Whether to show a bar. If not given: at a terminal and in a notebook, and elsewhere a line
        on standard error every 20 seconds.
    overwrite : bool, optional
        Whether to replace what is in the place of the output.

    Returns
    -------
    xarray.Dataset
        What was measured, see `dpd.load`.

    Raises
    ------
    dpd.UserError
        If the scene is not allowed, a file cannot be read or written, or would be replaced unasked,
        or the run blows up.

    Examples
    --------
    >>> import dpd
    >>> fluid = {
    ...     "dimension": 3, "box": 6, "molecules": [{"architecture": "A", "density": 3}],
    ...     "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
    ...     "steps": {"equilibrate": 100, "sample": 400}, "observe": ["thermo", "rdf"],
    ... }
    >>> run = dpd.run(fluid, progress=False)
    >>> bool(0.9 < run.kT.mean() < 1.1)
    True
    >>> g = run.rdf.mean("block")  # the radial distribution function
    >>> bool(g.sel(r=2.5, method="nearest") > 0.8)
    True

    A dict of another system follows from this one:

    >>> hotter = dpd.run(fluid | {"thermostat": {"kT": 2}}, progress=False)
    >>> bool(hotter.kT.mean() > 1.8)
    True
    """
    scene = as_scene(scene, observe, pages)
    if output is None:
        refuse_more_files(scene, "dpd.run(..., output='run.nc')")
    with place_for(output, "run.nc") as path:
        every = None if output is None else CHECKPOINT_EVERY
        more = {"tell": lambda sentence: None, "label": "dpd.run"}
        options = _options(threads, every, overwrite, progress, **more)
        with keyboard_interrupt():
            run_alone(scene, path, Path(start) if start else None, options)
        return load(path)


def extend(
    path: str | os.PathLike,
    *,
    sample: int,
    output: str | os.PathLike | None = None,
    threads: int = 1,
    progress: bool | None = None,
    overwrite: bool = False,
) -> xr.Dataset:
    """Make a finished run longer, to the same bits as if it had been planned that long.

    Parameters
    ----------
    path : path
        The result of `dpd.run` with an ``output``, or of ``dpd run``.
    sample : int
        Steps of sampling to add.
    output : path, optional
        A file for the longer result. Without it, that takes the place of the run once it is whole.
    threads, progress, overwrite : optional
        See `dpd.run`. Stopped with Ctrl-C, or killed, the same call goes on.

    Returns
    -------
    xarray.Dataset
        The longer result, see `dpd.load`.

    Raises
    ------
    dpd.UserError
        If the file is no run that can be made longer; or as `dpd.run` does.

    Examples
    --------
    With ``fluid`` as in `dpd.run`:

    >>> short = dpd.run(fluid, output="short.nc", progress=False)
    >>> longer = dpd.extend("short.nc", sample=100, output="longer.nc", progress=False)
    >>> short.time.size, longer.time.size
    (100, 125)
    >>> bool((longer.kT[:100] == short.kT).all())
    True
    """
    run, longer = Path(path), Path(path if output is None else output)
    options = _options(threads, CHECKPOINT_EVERY, overwrite, progress)
    with keyboard_interrupt():
        make_longer(run, sample, longer, options)
    return load(longer)


def _options(threads, every_seconds, overwrite, progress, **more):
    bar = partial(Progress, bar=progress)
    return Options(threads, every_seconds, overwrite, own=True, say=warn, progress=bar, **more)


@contextmanager
def keyboard_interrupt() -> Iterator[None]:
    """A script sees a run that Ctrl-C has stopped as `KeyboardInterrupt`."""
    try:
        yield
    except Stopped as stopped:
        raise KeyboardInterrupt(str(stopped)) from None


def as_scene(
    given: str | os.PathLike | Mapping[str, Any] | Scene,
    observe: Sequence[Any] = (),
    pages: Sequence[Any] = (),
) -> Scene:
    """A scene from what a person gives for one, with more pages and observables.

    Refused is also a page that stands in no file, where no other process could find it.
    """
    refuse_to_run()
    if isinstance(given, Scene) and not observe and not pages:
        return given
    asked = [_asked(page) for page in observe]
    pages = [*pages, *(page for _, page in asked if page is not None)]
    where, folder = "scene", Path()
    if isinstance(given, str | os.PathLike):
        path = Path(given)
        data, where, folder = read_yaml(path), str(path), path.parent
    elif isinstance(given, Scene):
        data, where = given.data, given.where
    elif isinstance(given, Mapping):
        data = plain(given)
    else:
        raise UserError(
            f"scene: {type(given).__name__} is none; allowed: a path of a YAML file, a dict, or a "
            "dpd.Scene"
        )
    named = data.get("observe", Basics.model_fields["observe"].default)
    if isinstance(named, list):  # the scene refuses all else
        data = data | {"observe": [*named, *(item for item, _ in asked)]}
    return Scene(data, where, folder, pages)


def _asked(page):
    """An observable as a scene names it; and itself, if it is one's own."""
    if isinstance(page, str | Mapping):
        return plain(page), None
    if isinstance(page, Observable):
        own = None if type(page).__module__.startswith("dpd.") else type(page)
        return {page.key: page.model_dump(exclude_unset=True, by_alias=True)}, own
    if isinstance(page, FunctionType) and measures(page):
        return page.__name__, page
    raise UserError(
        f"observe: {shown(page)} is no observable; allowed: names, functions of a file as 'def "
        "mine(snapshot)', and objects of classes as 'class Mine(Observable, key=\"mine\")'"
    )


def plain(value: Any) -> Any:
    """The same as YAML has it: arrays and tuples as lists, numbers of NumPy as Python's."""
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


@contextmanager
def place_for(result: str | os.PathLike | None, name: str = "") -> Iterator[Path]:
    """Where a result goes: as asked for, or where it is there for a while."""
    if result is not None:
        yield Path(result)
        return
    with TemporaryDirectory(prefix="dpd-") as folder:
        yield Path(folder, name)


def refuse_more_files(scene: Scene, call: str) -> None:
    """Refuse a run whose files would be lost; a ``call`` says how they would not."""
    for name in scene.files_beside("run.nc"):
        raise UserError(
            f"{scene.where}: observe.{name}: writes a file beside the result, and no result is "
            f"kept; name one, as {call}"
        )


def warn(sentence: str) -> None:
    """A warning as Python has it; nothing for an empty one, or where standard error is closed."""
    if sentence:
        with suppress(ValueError):
            warnings.warn(sentence, stacklevel=2)
