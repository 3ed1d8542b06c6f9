"""A run: from a scene and its first configuration to run.nc."""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd import files
from dpd.analysis.statistics import mean_and_error
from dpd.compiling import COMPILING
from dpd.engine.checkpoint import Checkpoint, counts_from, file_of
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.errors import LostRun, Stopped, UserError
from dpd.observe import observables
from dpd.page import Change
from dpd.pipeline.kept import NOTHING, go_on_from, kept_of
from dpd.pipeline.run_warnings import warning_of
from dpd.stages import run_sources
from dpd.start.common.make import system_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dpd.engine.state import State
    from dpd.scene.scene import Scene

COPIES = 3  # on the disk: of a checkpoint, of the draft of the next one, of the result


@dataclass(frozen=True)
class RunSettings:
    """How a run is carried out; none of it changes a bit of its result.

    Attributes
    ----------
    checkpoint : path or None
        Where the state is kept while it runs; an interrupted run of the same scene and
        sources goes on from there.
    every_seconds : float
        Wall clock between checkpoints.
    threads : int
        See `dpd.engine.simulation.Simulation`.
    progress : callable or None
        Called with the number of steps done.
    stopping, say : callable or None
        See `dpd.engine.loop.run`.
    begun : float or None
        When the work on this run began, as `time.perf_counter` has it: with its start, where the
        run made that itself. Otherwise when it is called.
    keep : bool
        Whether the result keeps the last configuration, and the state that a longer run goes on
        from, if the scene does not say.
    former : list or None
        Observables of the shorter run that this one goes on from, at its end; the state is then
        that of its end as well. See `dpd.pipeline.kept.Former`.
    """

    checkpoint: Path | None = None
    every_seconds: float = 60.0
    threads: int = 1
    progress: Callable | None = None
    stopping: Callable | None = None
    say: Callable | None = None
    begun: float | None = None
    keep: bool = False
    former: list | None = None


def simulate(
    scene: Scene, path: str | Path, state: State, settings: RunSettings = RunSettings()
) -> dict[str, float]:
    """Run a scene and write what it observed.

    Parameters
    ----------
    scene : Scene
    path : path
        The NetCDF file; written at the end, whole.
    state : State
        From `read_start` or `make_start` of `dpd.start.common`, or the end of a shorter run.
    settings : RunSettings

    Returns
    -------
    dict
        Summary: seconds, bead-steps per second, and means of what was measured.

    Raises
    ------
    UserError
        If the run blows up or is stopped; the last checkpoint stays. Before it begins, if
        there is no room for checkpoint and result.
    """
    begun = time.perf_counter() if settings.begun is None else settings.begun
    if scene.is_auto:
        raise UserError(
            f"{scene.where}: integrator.scheme: 'auto' has not been tried on the scene yet; call "
            "dpd.pipeline.probing.settle(scene, state) first, or name scheme and dt"
        )
    systems = [(stage.step, system_of(stage.scene)) for stage in scene.stages]
    system = systems[0][1]
    simulation = Simulation(system, state, settings.threads)
    observers = observables(scene, system, path, state)
    keeps = scene.data.get("keep_state", settings.keep)
    for observer, former in zip(observers, settings.former or ()):
        looked = state.step - counts_from(observer, scene.steps.equilibrate)
        go_on_from(observer, former, looked)
    own_files = list(filter(None, map(file_of, observers)))
    for file in own_files:
        file.refuse_other_files()
    _check_room(path, settings.checkpoint, simulation, observers)
    sources, keeper = run_sources(scene), None
    if settings.checkpoint:
        key = {"scene": scene.digest, "sources": sources, "kept": keeps}
        note = {"chosen": scene.chosen, "scene": json.dumps(scene.data)}
        keeper = Checkpoint(settings.checkpoint, key, note)
    running, lost = time.perf_counter() - COMPILING.seconds, -1
    try:
        done = run(
            simulation, scene.steps, observers, keeper, settings.progress, settings.every_seconds,
            settings.stopping, settings.say, systems,
        )  # fmt: skip
    except LostRun as problem:
        if scene.data["unstable"] != "record":
            raise _with_place(problem, scene, keeper) from None
        done = lost = problem.step
    except UserError as problem:
        raise _with_place(problem, scene, keeper) from None
    now, compiled = time.perf_counter(), COMPILING.seconds
    timed = {
        "lost_step": lost,
        "seconds": now - begun,
        "bead_steps_per_second": scene.beads * done / max(now - compiled - running, 1e-9),
    }
    variables, values, attributes = gathered(scene, simulation, observers, timed)
    if settings.former:
        attributes["extended_from_step"] = state.step
    sentences = [attributes.get("warning", "")]
    if keeper and own_files and lost < 0:
        # A kill before the result is there costs no trajectory.
        sentences.append(keeper.save(simulation, observers))
    lost_frames = ""
    try:
        for observer in observers:  # before the result, which says that all is there
            if file := file_of(observer):
                arrays = observer.arrays
                lost_frames = file.finish(int(arrays["taken"][0]), arrays["digests"], Path(path))
                sentences.append(lost_frames)
        kept = NOTHING
        if keeps and lost < 0:
            kept = kept_of(scene, simulation.state, observers, lost_frames)
        files.write(path, variables | kept.variables, attributes | kept.attributes, kept.groups)
    except UserError as problem:
        if keeper and lost < 0 and (unsaved := keeper.save(simulation, observers)):
            problem = UserError(f"{problem}; {unsaved}")
        raise _with_place(problem, scene, keeper) from None
    if keeper:
        keeper.discard()
    for sentence in filter(None, sentences):
        if settings.say:
            settings.say(sentence)  # now: where warnings are errors, it raises
    return summary(scene, values, attributes)


class Gathered(NamedTuple):
    """What a run has measured: variables for its file, their values by name, and attributes."""

    variables: dict[str, files.Variable]
    values: dict[str, np.ndarray]
    attributes: dict[str, Any]


def gathered(
    scene: Scene, simulation: Simulation, observers: list[Any], timed: Mapping[str, Any]
) -> Gathered:
    """All that a run has measured in the end; ``timed`` attributes say how it went."""
    variables: dict[str, files.Variable] = {}
    for observer in observers:
        variables |= observer.variables()
    values = {name: np.asarray(variable[1]) for name, variable in variables.items()}
    density = {"number_density": mean_density(scene, simulation.volume, values)}
    attributes = _attributes(scene, run_sources(scene)) | density | timed
    if warning := warning_of(scene, values):
        attributes["warning"] = warning
    return Gathered(with_means(variables), values, attributes)


def _check_room(path, checkpoint, simulation, observers):
    """Refuse to begin where checkpoint and result will not fit."""
    kept = sum(array.nbytes for observer in observers for array in observer.arrays.values())
    state = sum(a.nbytes for a in vars(simulation.state).values() if hasattr(a, "nbytes"))
    beside = sum(getattr(observer, "file_bytes", 0) for observer in observers)
    for place in (path, checkpoint) if checkpoint else (path,):
        files.check_room(place, COPIES * (kept + state) + beside)


def _attributes(scene, sources):
    """What a result says of its making, except how the run went."""
    attributes = {
        "scene": json.dumps(scene.data),
        "scene_digest": scene.digest,
        "sources": sources,
        "beads": scene.beads,
        "seed": scene.data["seed"],
        "steps": sum(scene.steps),
        "peak_memory_MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    } | versions()
    if scene.chosen:
        attributes["chosen"] = scene.chosen["said"]
    return attributes


def mean_density(scene: Scene, volume: float, values: Mapping[str, np.ndarray]) -> float:
    """Beads per r_c^dimension: the mean over the samples of a volume that changes.

    Parameters
    ----------
    scene : Scene
    volume : float
        Of the box in the end.
    values : dict of str to array
        What was measured, by name.
    """
    if Change.STRETCHES not in scene.made:
        return scene.density
    sampled = values.get("volume", np.array([volume]))
    sampled = sampled[np.isfinite(sampled)]
    return float(np.mean(scene.beads / sampled)) if len(sampled) else scene.beads / volume


def _with_place(problem, scene, keeper):
    """A problem of a run, with the scene's file and where the last good state is."""
    kept = keeper is not None and keeper.is_ours and keeper.path.exists()
    last = f"; its last good state is in {keeper.path}" if kept else ""
    kind = Stopped if isinstance(problem, Stopped) else UserError
    return kind(f"{scene.where}: {str(problem).rstrip('.')}{last}")


def summary(
    scene: Scene, values: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> dict[str, float]:
    """Means of the measured series, for a person at a terminal.

    Both pressures have the kinetic part that was measured, as ``pressure`` and
    ``pressure_tensor_all`` in the file.

    Parameters
    ----------
    scene : Scene
    values : dict of str to array
        Variables of the file by name.
    attributes : dict
        Of the file.
    """
    found = {
        "beads": attributes["beads"],
        "steps": attributes["steps"],
        "seconds": attributes["seconds"],
        "bead-steps per second": attributes["bead_steps_per_second"],
    }
    if "kT" in values:
        found["kT"] = float(np.mean(values["kT"]))
    if "volume" in values:
        found["number density"] = float(attributes["number_density"])
    if "pressure" in values:
        found["pressure (conservative virial)"] = float(np.mean(values["pressure"]))
        diagonal = np.trace(values["pressure_tensor_all"], axis1=1, axis2=2)
        found["pressure (virial of all forces)"] = float(np.mean(diagonal)) / scene.dimension
    if "bond_mean" in values:
        found["mean bond length"] = float(np.mean(values["bond_mean"]))
    return found


def is_made(scene: Scene, path: str | Path) -> bool:
    """Whether a result is there that belongs to a scene and to the sources as they are."""
    if not all(each.is_file() for each in (Path(path), *scene.files_beside(path).values())):
        return False
    try:
        made = [files.attribute(path, name) for name in ("scene_digest", "sources")]
    except (UserError, AttributeError):  # not NetCDF, or not a run
        return False
    return made == [scene.digest, run_sources(scene)]


def with_means(variables: Mapping[str, files.Variable]) -> dict[str, files.Variable]:
    """The same, each series with what `dpd.load` says of it; NaN where not known.

    Those over ``sample``, whose times are ``time``, and of one's own pages, as ``x_sample``.
    """
    found = dict(variables)
    for name, variable in variables.items():
        over = str(variable[0][0]) if len(variable[0]) == 1 else ""
        times = over.removesuffix("sample") + "time"
        if over.endswith("sample") and times in variables and name != times:
            mean, error, memory = mean_and_error(variable[1])
            step = float(np.ravel(variables[times][1])[0])
            time = memory * step if np.isfinite(error) else np.nan
            found[name] = (*variable[:4], {"mean": mean, "error": error, "correlation_time": time})
    return found


def versions() -> dict[str, str]:
    """Of what computes, for a file."""
    import numba

    return {"numpy": np.__version__, "numba": numba.__version__}


def checkpoint_path(path: str | Path) -> Path:
    """Where the checkpoint of a result lies: beside it, under a name that no rule declares."""
    path = Path(path)
    return path.with_name(path.stem + ".checkpoint")
