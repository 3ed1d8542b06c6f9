"""A sweep from Python: runs on several cores, kept in a folder, gathered into one dataset."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from dpd import files
from dpd.analysis.collect import collect, save
from dpd.api.datasets import CONVENTIONS, UNITS
from dpd.api.runs import as_scene, place_for, plain, refuse_more_files, warn
from dpd.digest import PACKAGE
from dpd.errors import Occupied, UserError, shown
from dpd.pipeline.paths import run_file
from dpd.pipeline.points import fixed
from dpd.pipeline.sections import SweptAxis
from dpd.pipeline.sweep import Point, Sweep, unfold
from dpd.progress import Progress
from dpd.runs.result import is_made, result_there
from dpd.runs.run import Options, whole
from dpd.sentences import read_section

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

    from dpd.scene.scene import Scene

WARNING = "warning: "  # what a command puts before one


def sweep(
    scene: str | os.PathLike | Mapping[str, Any] | Scene,
    axes: Mapping[str, Sequence | Mapping],
    *,
    observe: Sequence[Any] = (),
    pages: Sequence[Any] = (),
    replicas: int = 1,
    processes: int | None = None,
    threads: int = 1,
    output: str | os.PathLike | None = None,
    progress: bool | None = None,
    overwrite: bool = False,
) -> xr.Dataset:
    """Simulate all combinations of some values of a scene.

    Each run is a process of its own, with a seed that follows from the scene's seed and from the
    values: more values or replicas change none of the former runs. Ctrl-C stops them all.

    Parameters
    ----------
    scene : path, dict or dpd.Scene
        See `dpd.run`. It names its scheme and time step, and observes ``thermo``.
    axes : dict
        Keys of the scene, joined by dots, as ``"core.radius"`` or ``"molecules.0.density"``; each
        with a list of its values, which are numbers or words. Several keys, or text such as
        ``"A 10"``, need a name and what the axis of a paper has (see config/README.md), as
        ``{"length": {"set": "molecules.0.architecture", "text": "A {}", "values": [5, 10]}}``.
    observe, pages, progress : optional
        See `dpd.run`.
    replicas : int, optional
        Runs of each combination, with seeds of their own.
    processes, threads : int, optional
        Runs at a time, as many as there are cores for if not given; threads of each run.
    output : path, optional
        A folder for the results. Those that are there already, of the same scene, are not made
        again, with a warning where another version of this program made them; a run that was
        stopped goes on. The dataset is kept in it as ``sweep.nc``. Without it nothing is left on
        the disk.
    overwrite : bool, optional
        Whether to replace results of other scenes and versions, and a ``sweep.nc`` of other axes.

    Returns
    -------
    xarray.Dataset
        The dimensions are the axes, by their keys, and ``replica``. A time series such as ``kT``
        becomes its mean, with ``kT_error`` (a standard error that knows about correlation),
        ``kT_correlation_time`` and more; averages and tables are kept whole.

    Raises
    ------
    dpd.UserError
        If a scene is not allowed, or a file would be replaced unasked, before anything is run; or
        if runs fail, once all have ended.

    Examples
    --------
    With ``fluid`` as in `dpd.run`:

    >>> found = dpd.sweep(fluid, {"repulsion.A A": [10, 25]}, replicas=2, progress=False)
    >>> dict(found.pressure.sizes)
    {'repulsion.A A': 2, 'replica': 2}
    >>> soft, hard = found.pressure.mean("replica")
    >>> bool(soft < hard), bool((found.pressure_error > 0).all())
    (True, True)
    """
    planned = _planned(as_scene(scene, observe, pages), axes, whole("replicas", replicas))
    threads = Options(threads).threads
    if processes is None:
        processes = max(1, len(os.sched_getaffinity(0)) // threads)
    workers = whole("processes", processes)
    if output is None:
        refuse_more_files(planned.points[0].scene, "dpd.sweep(..., output='runs')")
    with place_for(output) as folder:
        missing = [point for point in planned.points if _is_missing(point, folder, overwrite)]
        if not overwrite:
            _refuse_other(folder / "sweep.nc", planned)
        _run_all(missing, _Runs(folder, threads, overwrite), workers, progress)
        paths = [run_file(folder, point.name) for point in planned.points]
        data = collect(planned, paths, any_version=True)
        # Last configurations are for those who go on from a run.
        data = data.drop_vars([name for name in data.variables if str(name).startswith("last_")])
        data = data.assign_attrs(Conventions=CONVENTIONS, comment=UNITS)
        if output is not None:
            save(data, folder / "sweep.nc")
    return data


def _planned(scene: Scene, axes: Mapping[str, Sequence | Mapping], replicas: int) -> Sweep:
    key = f"{fixed(scene).where}: sweep"
    described = {}
    for name, values in plain(axes).items():
        if isinstance(values, dict):
            read_section(SweptAxis, values, key, f"axes.{name}")
            described[name] = values
        elif isinstance(values, list):
            described[name] = {"values": values, "set": name, "units": "reduced", "long_name": name}
        else:
            raise UserError(f"{key}.axes.{name}: {shown(values)} is no list, such as [0.1, 0.2]")
    given = {"scene": scene.data, "replicas": replicas}
    return unfold("dpd", "sweep", given, key, described)


def _is_missing(point: Point, folder: Path, overwrite: bool) -> bool:
    """Whether a point has to be run; refused where something else is in its place."""
    result = Path(run_file(folder, point.name))
    if is_made(point.scene, result):
        return False
    return overwrite or result_there(point.scene, result, warn) is None


def _refuse_other(path: Path, planned: Sweep) -> None:
    """Refuse to let the dataset take the place of what is none, or has what this one lacks."""
    held: dict[str, Any] = {}
    with suppress(UserError):
        held, attributes = files.read(path)
        held = held if "sweep" in attributes else {}
    if not held:
        files.refuse_to_replace(path)
        return
    known = {axis.name: np.asarray(axis.labels).tolist() for axis in planned.axes}
    same = np.ndim(held.get("beads", 0)) == len(known) and known.keys() <= held.keys()
    if not same or any(set(np.ravel(held[name]).tolist()) - set(known[name]) for name in known):
        raise Occupied(f"{path}: holds a sweep with other axes or values, which this one lacks")


class _Runs:
    """Processes that run points of a sweep, each `python -m dpd run`.

    Processes that Python's own pool starts would run a script anew that has no guard of
    ``__main__``, and could not be stopped so that they keep their states.
    """

    def __init__(self, folder: Path, threads: int, overwrite: bool):
        self._folder = folder
        self._options = ["--threads", str(threads), *["--overwrite"] * overwrite]
        self._at_work: set[subprocess.Popen] = set()
        self._stopped = False

    def run(self, point: Point) -> tuple[Sequence[str], str]:
        """Sentences of warning, and what went wrong, if anything."""
        result = Path(run_file(self._folder, point.name))
        if self._stopped:
            return (), ""
        scene = result.with_name("scene.yaml")
        text = yaml.safe_dump(point.scene.data)
        files.replace_whole(scene, lambda draft: draft.write_text(text))
        command = [sys.executable, "-P", "-m", "dpd", "run", scene, "-o", result]
        path = os.pathsep.join(filter(None, [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]))
        child = subprocess.Popen(
            [*map(str, command), *self._options], text=True,
            env=os.environ | {"PYTHONPATH": path}, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip
        self._at_work.add(child)
        if self._stopped:
            child.terminate()
        _, said = child.communicate()
        self._at_work.discard(child)
        lines = said.strip().splitlines()
        warned = [line.removeprefix(WARNING) for line in lines if line.startswith(WARNING)]
        if child.returncode == 0:
            return warned, ""
        problem = lines[-1] if lines else f"ended with code {child.returncode}"
        problem = problem.removeprefix("error: ").removeprefix(f"{scene}: ")
        return warned, problem

    def stop(self) -> None:
        """Ask all of them to keep their states and to end."""
        self._stopped = True
        for child in list(self._at_work):
            child.terminate()


def _run_all(points: Sequence[Point], runs: _Runs, workers: int, progress: bool | None) -> None:
    """Run points of a sweep; say what failed once all have ended."""
    with (
        Progress(len(points), "dpd.sweep", progress) as done,
        ThreadPoolExecutor(workers) as pool,
    ):
        under_way: list[Future] = [pool.submit(runs.run, point) for point in points]
        try:
            for number, _ in enumerate(as_completed(under_way), 1):
                done(number)
        except BaseException:
            runs.stop()
            pool.shutdown(cancel_futures=True)
            raise
    failed = []
    for point, future in zip(points, under_way):
        warned, problem = future.result()
        for sentence in warned:
            warnings.warn(f"{point.name}: {sentence}", stacklevel=3)
        failed += [f"{point.name}: {problem}"] if problem else []
    if failed:
        raise UserError(f"{len(failed)} of {len(points)} runs failed; the first: {failed[0]}")
