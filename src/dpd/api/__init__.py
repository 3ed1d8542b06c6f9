"""What people use from Python: runs, sweeps and results."""

import os
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType
from typing import Any

import numpy as np
import xarray as xr
import yaml

from dpd import files
from dpd.analysis import collect
from dpd.errors import FAILED, Occupied, Stopped, UserError, shown
from dpd.folders import PACKAGE
from dpd.page import Observable
from dpd.page.own import measures, refuse_to_run
from dpd.pipeline.paths import run_file
from dpd.pipeline.sweep import Sweep, SweepFile, SweptAxis, fixed, unfold
from dpd.runs import Progress
from dpd.runs import run as running
from dpd.runs.result import is_made, result_there
from dpd.runs.run import WARNING, Options, whole
from dpd.scene.scene import Scene
from dpd.scene.sections import Basics
from dpd.scene.yaml import read_section, read_yaml

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
    """Simulate a scene; what was measured, see `dpd.load`.

    Ctrl-C stops it after the steps under way, with a `KeyboardInterrupt`. With an ``output``, the
    state is kept beside it once a minute and then, and the same call goes on, to the same bits.
    Raises `dpd.UserError` if the scene is not allowed, a file cannot be read or written or would be
    replaced unasked, or the run blows up.

    Parameters
    ----------
    scene : path of a YAML file, dict or dpd.Scene
        What to simulate.
    observe : list, optional
        More to measure than the scene names: names, as a scene has them; functions as
        ``def gyration(snapshot)``, which return a number or an array of a
        `dpd.observe.common.snapshot.Snapshot`; objects of classes of one's own, as
        ``Gyration(of="A")``. They stand in a file or a cell of a notebook, with all that they use.
    pages : list, optional
        Files with pages of one's own, or classes such as pair forces, that the scene may then name.
    start : path, optional
        First configuration: read if the file is there, otherwise made and kept in it.
    output : path, optional
        A ``.nc`` file to keep the result in. If it holds that of the same scene already, nothing
        is run, with a warning. Without it nothing is left on the disk.
    threads : int, optional
        Threads that share the work. The results are the same bits.
    progress : bool, optional
        Whether to show a bar; by default at a terminal and in a notebook, elsewhere lines.
    overwrite : bool, optional
        Whether to replace what is in the place of the output.

    Examples
    --------
    >>> import dpd
    >>> fluid = {
    ...     "dimension": 3, "box": 6, "molecules": [{"architecture": "A", "density": 3}],
    ...     "repulsion": {"A A": 25}, "integrator": {"scheme": "gw-vv", "dt": 0.04},
    ...     "steps": {"equilibrate": 100, "sample": 400}, "observe": ["thermo", "rdf"],
    ... }
    >>> run = dpd.run(fluid, progress=False)
    >>> run.kT.dims, run.time.units, run.pressure.units
    (('time',), 'tau', 'kT / r_c^3')
    >>> bool(run.rdf.mean("block").sel(r=2.5, method="nearest") > 0.8)  # g(r)
    True
    """
    scene = as_scene(scene, observe, pages)
    with _place_for(output, "run.nc", scene, "dpd.run(..., output='run.nc')") as path:
        options = _options(threads, progress, overwrite, keeps=output is not None)
        with keyboard_interrupt():
            running.run(scene, path, Path(start) if start else None, options)
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

    ``path`` is the result of `dpd.run` with an ``output``, or of ``dpd run``; ``sample`` are steps
    to add, in which the last values of a schedule or a ramp hold. Without an ``output`` the longer
    result takes the place of the run once it is whole. Stopped with Ctrl-C, or killed, the same
    call goes on. For all else see `dpd.run`.

    Examples
    --------
    With ``fluid`` as in `dpd.run`:

    >>> short = dpd.run(fluid, output="short.nc", progress=False)
    >>> longer = dpd.extend("short.nc", sample=100, output="longer.nc", progress=False)
    >>> short.time.size, longer.time.size
    (40, 50)
    """
    longer = Path(path if output is None else output)
    with keyboard_interrupt():
        running.extend(Path(path), sample, longer, _options(threads, progress, overwrite))
    return load(longer)


def _options(threads, progress, overwrite, keeps=True):
    return Options(
        threads, CHECKPOINT_EVERY if keeps else None, overwrite, own=True, label="dpd.run",
        say=warn, tell=lambda sentence: None, of_start=warn,
        progress=partial(Progress, bar=progress),
    )  # fmt: skip


def load(path: str | os.PathLike) -> xr.Dataset:
    """Read the result of a run or of a sweep, which `dpd.run`, `dpd.sweep` or ``dpd run`` wrote.

    Of a run these are the variables of its observables. Time series have the dimension and
    coordinate ``time``, in tau since the end of equilibration, or one of their own, as
    ``clusters_time``; averages over parts of the run have ``block``. Variables have ``units``
    (reduced: r_c, kT, the mass of a bead, tau) and ``long_name``, series of numbers, as ``run.kT``,
    the attributes ``mean``, ``error`` (standard; 1.96 of it make a 95 % interval) and
    ``correlation_time``. Raises `dpd.UserError` if the file is missing, damaged or another.
    """
    path, remedy = Path(path), "if it should be the result of a run or a sweep, make it again"
    files.check_input(path)
    data = collect.load(path, remedy)
    if "sweep" in data.attrs:
        return data
    if "scene_digest" not in data.attrs:
        raise UserError(f"{path}: neither the result of a run nor of a sweep; {remedy}")
    for name in [str(each) for each in data.dims if str(each).endswith("sample")]:
        time = f"{name.removesuffix('sample')}time"
        data = data.set_coords(time).swap_dims({name: time})
    dimension = str(data.sizes.get("axis", "dimension"))
    for variable in data.variables.values():
        if "units" in variable.attrs:
            variable.attrs["units"] = variable.attrs["units"].replace("dimension", dimension)
    return data


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
    values: more values or replicas change none of the former runs. Ctrl-C stops them all. Raises
    `dpd.UserError` if a scene is not allowed or a file would be replaced unasked, before anything
    is run; or if runs fail, once all have ended.

    Parameters
    ----------
    axes : dict
        Keys of the scene, joined by dots, as ``"core.radius"`` or ``"molecules.0.density"``; each
        with a list of its values, which are numbers or words. Several keys, or text such as
        ``"A 10"``, need a name and what the axis of a paper has (see docs/guide/papers.md), as
        ``{"length": {"set": "molecules.0.architecture", "text": "A {}", "values": [5, 10]}}``.
    scene, observe, pages, progress : optional
        See `dpd.run`.
    replicas, processes, threads : int, optional
        Runs of each combination, with seeds of their own; runs at a time, by default as many as
        there are cores for; threads of each run.
    output : path, optional
        A folder for the results, and for the dataset as ``sweep.nc``. Results of the same scene
        are not made again (a warning tells of other versions), and a run that was stopped goes on.
        Without it nothing is left on the disk.
    overwrite : bool, optional
        Whether to replace results of other scenes and versions, and a ``sweep.nc`` of other axes.

    Returns
    -------
    xarray.Dataset
        The dimensions are the axes, by their keys, and ``replica``. A series over ``time``, as
        ``kT``, becomes its mean, with ``kT_error`` (which knows about correlation) and more; those
        of other intervals, averages and tables are kept whole, arrays over ``time`` are not.

    Examples
    --------
    With ``fluid`` as in `dpd.run`:

    >>> found = dpd.sweep(fluid, {"repulsion.A A": [10, 25]}, replicas=2, progress=False)
    >>> dict(found.pressure.sizes)
    {'repulsion.A A': 2, 'replica': 2}
    """
    planned = _planned(as_scene(scene, observe, pages), axes, whole("replicas", replicas))
    threads = Options(threads).threads
    first = planned.points[0].scene
    if processes is None:
        processes = max(1, len(os.sched_getaffinity(0)) // max(threads, first.ranks))
    workers = whole("processes", processes)
    with _place_for(output, "", first, "dpd.sweep(..., output='runs')") as folder:
        paths = [Path(run_file(folder, point.name)) for point in planned.points]
        missing = [
            (point, path) for point, path in zip(planned.points, paths)
            if not is_made(point.scene, path)
            and (overwrite or result_there(point.scene, path, warn) is None)
        ]  # fmt: skip
        if not overwrite:
            _refuse_other(folder / "sweep.nc", planned)
        _run_all(missing, threads, overwrite, workers, progress)
        data = collect.collect(planned, paths, any_version=True)
        if output is not None:
            collect.save(data, folder / "sweep.nc")
    return data


def _planned(scene: Scene, axes: Mapping[str, Sequence | Mapping], replicas: int) -> Sweep:
    key = f"{fixed(scene).where}: sweep"
    described = {}
    for name, values in plain(axes).items():
        if name in scene.ramps:
            raise UserError(f"{key}.axes.{name}: the scene has a ramp there; write its first value")
        if isinstance(values, dict):
            described[name] = read_section(SweptAxis, values, key, f"axes.{name}")
        elif isinstance(values, list):
            described[name] = SweptAxis.model_construct(
                values=values, set=name, units="reduced", long_name=name
            )
        else:
            raise UserError(f"{key}.axes.{name}: {shown(values)} is no list, such as [0.1, 0.2]")
    # Not read as a section: here the name of an axis may be any key of the scene.
    given = SweepFile.model_construct(scene=scene.data, replicas=replicas, axes=described)
    for place, problem in given.conflicts():
        raise UserError(f"{key}.{place}: {problem}" if place else f"{key}: {problem}")
    return unfold("dpd", "sweep", given, key)


def _refuse_other(path: Path, planned: Sweep) -> None:
    """Refuse to let the dataset take the place of what is none, or has what this one lacks."""
    try:
        held, attributes = files.read(path)
    except UserError:
        attributes = {}
    if "sweep" not in attributes:
        files.refuse_to_replace(path)
        return
    known = {axis.name: np.asarray(axis.labels).tolist() for axis in planned.axes}
    same = np.ndim(held.get("beads", 0)) == len(known) and known.keys() <= held.keys()
    if not same or any(set(np.ravel(held[name]).tolist()) - set(known[name]) for name in known):
        raise Occupied(f"{path}: holds a sweep with other axes or values, which this one lacks")


def _run_all(points, threads, overwrite, workers, progress):
    """Run points of a sweep by `python -m dpd run`: a pool would need a guard of ``__main__``."""
    at_work: set[subprocess.Popen] = set()
    python = os.pathsep.join(filter(None, [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]))
    command = [sys.executable, "-P", "-m", "dpd", "run", "--threads", str(threads)]
    command += ["--overwrite"] * overwrite

    def run_one(point, result):
        scene, text = result.with_name("scene.yaml"), yaml.safe_dump(point.scene.data)
        files.replace_whole(scene, lambda draft: draft.write_text(text))
        with subprocess.Popen(
            [*command, str(scene), "-o", str(result)], text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": python},
        ) as child:  # fmt: skip
            at_work.add(child)
            said = child.communicate()[1].strip().splitlines()
        at_work.discard(child)
        for line in said:
            if line.startswith(WARNING):
                warnings.warn(f"{point.name}: {line.removeprefix(WARNING)}", stacklevel=1)
        if not child.returncode:
            return ""
        problem = said[-1] if said else f"ended with code {child.returncode}"
        return f"{point.name}: {problem.removeprefix(FAILED).removeprefix(f'{scene}: ')}"

    with Progress(len(points), "dpd.sweep", progress) as done, ThreadPoolExecutor(workers) as pool:
        under_way = [pool.submit(run_one, *each) for each in points]
        try:
            for number, _ in enumerate(as_completed(under_way), 1):
                done(number)
        except BaseException:  # all are asked to keep their states and to end
            pool.shutdown(wait=False, cancel_futures=True)
            while not all(each.done() for each in under_way):
                for child in list(at_work):
                    child.terminate()
                time.sleep(0.1)
            raise
    failed = [problem for each in under_way if (problem := each.result())]
    if failed:
        raise UserError(f"{len(failed)} of {len(points)} runs failed; the first: {failed[0]}")


@contextmanager
def keyboard_interrupt() -> Iterator[None]:
    """Raise `KeyboardInterrupt` where Ctrl-C has stopped a run."""
    try:
        yield
    except Stopped as stopped:
        raise KeyboardInterrupt(str(stopped)) from None


def as_scene(
    given: str | os.PathLike | Mapping[str, Any] | Scene,
    observe: Sequence[Any] = (),
    pages: Sequence[Any] = (),
) -> Scene:
    """A scene from what a person gives for one, with more pages and observables."""
    refuse_to_run()
    if isinstance(given, Scene) and not observe and not pages:
        return given
    asked = [_asked(page) for page in observe]
    pages = [*pages, *(page for _, page in asked if page is not None)]
    where, folder = "scene", Path()
    if isinstance(given, str | os.PathLike):
        data, where, folder = read_yaml(Path(given)), str(Path(given)), Path(given).parent
    elif isinstance(given, Scene):
        data, where = given.data, given.where
    else:
        data = plain(given)
    usual = Basics.model_fields["observe"].default
    named = data.get("observe", usual) if isinstance(data, dict) else None
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
def _place_for(result, name, scene, call):
    """Where a result goes: as asked for, or where it is there for a while."""
    if result is not None:
        yield Path(result)
        return
    refuse_more_files(scene, call)
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
