"""What a result holds and warns of, and what is in the place of one.

Beside its last configuration (`dpd.particles.netcdf`) a run of one's own keeps for `extend` the
arrays of its last checkpoint (`dpd.engine.loop.arrays_of`), in the group ``state``.
"""

import json
import os
import resource
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dpd import files
from dpd.analysis.statistics import mean_and_error, trend
from dpd.digests import run_sources
from dpd.engine.loop import arrays_of, counts_from, file_of, put_back, stored_in
from dpd.engine.simulation import Simulation
from dpd.engine.state import State
from dpd.errors import Occupied, UserError
from dpd.observe.common.measured import LONG
from dpd.page import Change
from dpd.particles.netcdf import STATE, attributes_of, variables_of
from dpd.particles.particles import of_state
from dpd.scene.scene import Scene


class Former(NamedTuple):
    """A finished run that a longer one can go on from; ``arrays`` are those of a checkpoint."""

    path: Path
    scene: Scene
    state: State
    arrays: dict[str, np.ndarray]
    attributes: dict[str, Any]


def checkpoint_path(path: str | Path) -> Path:
    """Where the checkpoint of a result lies: beside it, under a name that no rule declares."""
    return Path(path).with_suffix(".checkpoint")


def read_former(path: str | Path) -> Former:
    """The finished run in a file; `UserError` if it is none that can be made longer."""
    attributes = files.attributes(path)
    if "scene" not in attributes or "scene_digest" not in attributes:
        what = "a first configuration" if "start_digest" in attributes else "some other NetCDF file"
        raise UserError(f"{path}: this is {what}, not the result of a run; name a run.nc")
    lost = int(attributes.get("lost_step", -1))
    if lost >= 0:
        raise UserError(
            f"{path}: this run was lost at step {lost} (it blew up, or its bonds got "
            "too long), so nothing can go on from it; run its scene with a smaller dt"
        )
    scene, arrays = scene_of(path, attributes), files.read(path, STATE)[0]
    if not arrays:
        raise UserError(
            f"{path}: it holds no state to go on from. `dpd run --overwrite` makes it again with "
            "one; a run of a study has one if its scene says 'keep_state: true'"
        )
    if attributes["scene_digest"] != scene.digest or "position" not in arrays:
        raise _of_another_version(path)  # a default has changed
    return Former(Path(path), scene, put_back(arrays, ()), arrays, attributes)


def go_on_from(arrays: Mapping[str, np.ndarray], observers: list[Any], equilibrate: int) -> None:
    """Put observables where those of a run planned otherwise have got to, by `arrays_of`."""
    step = put_back(arrays, observers, equilibrate).step
    for each in observers:
        looks, taken = (step - counts_from(each, equilibrate)) // each.every, each.arrays["taken"]
        if max(looks, 1) != max(taken, 1):  # one that would look now first has yet to
            raise UserError(
                f"observe.{each.key}: in a run of that length it looks every {each.every} steps, "
                f"and has looked {taken[0]} times by step {step}; run the longer scene anew"
            )


def go_on_after(former: Former, observers: list[Any]) -> None:
    """The same for a run that goes on from a finished one, with the files beside that."""
    try:
        go_on_from(former.arrays, observers, former.scene.steps.equilibrate)
    except (KeyError, ValueError):  # what is kept has changed
        raise _of_another_version(former.path) from None
    sidecars = former.scene.files_beside(former.path)
    for each in filter(file_of, observers):
        frames, digests = int(each.arrays["frames"][0]), each.arrays["digests"]
        file_of(each).go_on_after(sidecars[each.key], frames, digests)


def _of_another_version(path):
    return UserError(
        f"{path}: made by another version of this program, which alone can make it longer; a new "
        f"run can begin with its last configuration: --start {path}"
    )


def scene_of(path: str | Path, attributes: Mapping[str, Any]) -> Scene:
    """The scene of a result, with the step that was chosen for it; or of a checkpoint's note."""
    scene = Scene.of_result(attributes.get("scene"), str(path))
    if chosen := attributes.get("chosen"):
        scene.chosen = chosen if isinstance(chosen, dict) else {"said": chosen}
    return scene


def is_made(scene: Scene, path: str | Path) -> bool:
    """Whether a result is there that belongs to a scene and to the sources as they are."""
    if not all(each.is_file() for each in (Path(path), *scene.files_beside(path).values())):
        return False
    try:
        made = files.attributes(path)
    except UserError:
        return False
    return (made.get("scene_digest"), made.get("sources")) == (scene.digest, run_sources(scene))


def result_there(scene: Scene, output: Path, say: Callable[[str], object]) -> Scene | None:
    """The scene of a result, if it is the same (``say`` tells); None for no file; or `Occupied`."""
    checkpoint, sidecars = checkpoint_path(output), scene.files_beside(output).values()
    if not files.is_filled(output):
        refuse_to_lose(scene, checkpoint)
        for path in sidecars if not stored_in(checkpoint) else ():
            files.refuse_to_replace(path)
        return None
    try:
        attributes = files.attributes(output)
        former = scene_of(output, attributes) if "scene_digest" in attributes else None
    except UserError as problem:
        raise Occupied(f"{output}: is there already, and cannot be read: {problem}") from None
    if former is None:
        raise Occupied(f"{output}: is there already, and is no result of a run")
    if not _same(scene, former):
        raise Occupied(f"{output}: holds the result of {_other(scene, former)}")
    if missing := [path for path in sidecars if not path.is_file()]:
        raise Occupied(f"{output}: is there already, but not {missing[0]}, which belongs to it")
    is_ours = attributes.get("sources") == run_sources(former)
    version = "" if is_ours else ", made by another version of this program"
    say(f"{output}: is there already, of the same scene{version}; it is kept, and nothing was run")
    return former


def refuse_to_lose(scene: Scene, checkpoint: Path) -> None:
    """Refuse to begin anew where the state of a run lies from which this one cannot go on."""
    if not (stored := stored_in(checkpoint)):
        return
    holds = f"{checkpoint}: holds the state of a run that was stopped or killed,"
    try:
        former = scene_of(checkpoint, stored.note)
    except UserError as problem:
        raise Occupied(f"{holds} which this version cannot read: {problem}") from None
    if not _same(scene, former):
        raise Occupied(f"{holds} of {_other(scene, former)}")
    key = {"sources": run_sources(former), "kept": former.data.get("keep_state", True)}
    if {"scene": stored.key.get("scene"), **key} != stored.key:
        raise Occupied(
            f"{holds} of another version of this program, or of a study, which alone can go on "
            "with it"
        )


def remove_left(checkpoint: Path, scene: Scene) -> bool:
    """Remove the checkpoint of a run whose result is whole; whether there was one."""
    stored = stored_in(checkpoint)
    left = stored is not None and stored.key.get("scene") == scene.digest
    if left:
        os.unlink(checkpoint)
    return left


def _same(scene, former):
    """Whether two scenes are the same; one that leaves its step to us is with what it found."""
    if scene.is_auto:
        said = (former.chosen or {}).get("said", "")
        if not said.endswith(f"asked for: {100 * scene.terms['integrator'].tolerance:g} %)"):
            return False
        scene = Scene(scene.data | {"integrator": former.data["integrator"]}, scene.where)
    return scene.digest == former.digest


def _other(scene, former):
    """What distinguishes the scene of a file from one that is to be run."""
    mine, its = scene.data, former.data
    keys = sorted(key for key in mine.keys() | its.keys() if mine.get(key) != its.get(key))
    hint = " (`dpd extend` makes a result longer)" if keys == ["steps"] else ""
    return f"another scene, with other values of {', '.join(keys)}{hint}"


# Share by which kT may be off without a word, and standard errors that it may; samples needed.
FAR_OFF, SURE, FEWEST = 0.05, 4.0, 20
DRIFT = 0.01  # of a bead's thermal velocity, from which on a start drifts


def write_result(
    path: Path, scene: Scene, simulation: Simulation, observers: list[Any],
    timed: Mapping[str, Any], keeps: bool = True, save: Callable[[], str] | None = None,
) -> tuple[dict[str, float], list[str]]:  # fmt: skip
    """Finish the files beside a result, and write that last, which says that all is there.

    Returns its `summary`, and what is to be warned of. Before, ``save`` keeps the end: a kill costs
    no trajectory, and extends nothing twice. A result that ``keeps`` it has the last configuration,
    and its state for longer runs.
    """
    variables: dict[str, files.Variable] = {}
    for observer in observers:
        variables |= observer.variables()
    values = {name: np.asarray(variable[1]) for name, variable in variables.items()}
    long = [int(each.arrays["count"][0]) for each in observers if each.key == "stretch"]
    attributes = _attributes(scene, simulation, values | {"long_bonds": np.sum(long)}, timed)
    warnings, groups = [attributes.get("warning", "")], {}
    own = list(filter(file_of, observers))
    if save and (own or "extended_from_step" in attributes):
        warnings.append(save())
    for observer in own:
        file_of(observer).finish(path)
    found = _with_means(variables)
    if keeps:
        last = of_state(scene, simulation.state)
        found, attributes = found | variables_of(last), attributes | attributes_of(last)
        groups = {STATE: arrays_of(simulation.state, observers)}
    files.write(path, found, attributes, groups)
    return summary(scene, values, attributes), list(filter(None, warnings))


def _attributes(scene, simulation, values, timed):
    import numba

    density = scene.density
    if Change.STRETCHES in scene.made:  # the mean over the samples of a volume, which changes
        volume = values.get("volume", np.array([simulation.volume]))
        density = float(np.nanmean(scene.beads / volume))
    attributes = {
        "scene": json.dumps(scene.data),
        "scene_digest": scene.digest,
        "sources": run_sources(scene),
        "beads": scene.beads,
        "seed": scene.data["seed"],
        "steps": sum(scene.steps),
        "peak_memory_MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "number_density": density,
    }
    attributes |= {"numpy": np.__version__, "numba": numba.__version__, **timed}
    if scene.chosen:
        attributes["chosen"] = scene.chosen["said"]
    warnings = [drift_warning(scene, values), long_bonds_warning(scene, values)]
    end = sum(scene.steps)
    half = scene.during(end - scene.steps.sample // 2, end)  # of which the others tell
    held = {(each.kT, str(each.terms.get(each.made.get(Change.STRETCHES, "")))) for each in half}
    if len(held) == 1:
        warnings += [temperature_warning(half[-1], values), pressure_warning(half[-1], values)]
    if any(warnings):
        attributes["warning"] = "; ".join(filter(None, warnings))
    return attributes


def _with_means(variables):
    """The same, each series with what `dpd.load` says of it; NaN where not known."""
    found = dict(variables)
    for name, variable in variables.items():
        over = str(variable[0][0]) if len(variable[0]) == 1 else ""
        times = over.removesuffix("sample") + "time"
        # Of one's own pages over x_sample, at x_time.
        if over.endswith("sample") and times in variables and name != times:
            mean, error, memory = mean_and_error(variable[1])
            step = float(np.ravel(variables[times][1])[0])
            time = memory * step if np.isfinite(error) else np.nan
            found[name] = (*variable[:4], {"mean": mean, "error": error, "correlation_time": time})
    return found


def summary(
    scene: Scene, values: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> dict[str, float]:
    """Means of the measured series; both pressures have the kinetic part that was measured."""
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


def drift_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if the fluid drifts as a whole, and keeps that."""
    momentum = values.get("momentum", np.empty((0, 0)))[:1].ravel()
    if Change.FLOWS in scene.made or not len(momentum) or not np.isfinite(momentum).all():
        return ""
    mass = scene.beads if scene.masses is None else scene.masses[scene.kinds].sum()
    stays = np.isin(np.arange(scene.dimension), list(scene.momentum_axes))
    drift = np.where(stays, momentum / mass, 0.0)
    if mass * (drift @ drift) <= DRIFT**2 * scene.beads * scene.kT:
        return ""
    text = ", ".join(f"{velocity:g}" for velocity in np.round(drift, 3) + 0.0)
    return (
        f"the start drifts with ({text}) r_c / tau, which nothing takes up; kT and pressure are "
        "those about that drift"
    )


def long_bonds_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a flow draws bonds so long that some pull at another image, which turns them.

    At rest so few of them change no mean; of dumbbells under shear they made the stress 11 % low.
    """
    count = int(values.get("long_bonds", 0))
    if not count or Change.SLIDES not in scene.made:
        return ""
    return (
        f"{count} bonds were seen to reach over {LONG:.0%} of an edge, beyond half of which they "
        "pull at another image: the stress is too low; take a box that is longer along the flow"
    )


def temperature_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a run was not at its temperature, with the cause, as far as that is known."""
    asked = scene.kT
    if (found := _off(values.get("kT", np.empty(0)), asked)) is None:
        return ""
    kT, mean, error = found
    slope, slope_error, _ = trend(np.arange(len(kT)), kT)
    driven = {Change.FLOWS, Change.SLIDES} & scene.made.keys()
    cause = "dt may be too large for this scene; a run with half of it tells"
    if not scene.takes_heat:
        cause = "without friction (every gamma is 0) nothing holds it"
    elif abs(slope) > SURE * slope_error and slope * (mean - asked) < 0:
        cause = "it was still on its way there; let the run equilibrate for longer"
    elif driven and mean > asked:
        cause = f"the flow heats the fluid, or {cause}"
    return (
        f"kT is {mean:.4g} {_known(error)} instead of {asked:g} in the second half of the run, and "
        f"all that was measured belongs to that: {cause}"
    )


def _off(series, asked):
    """Second half of a series, its mean and error, if off by `FAR_OFF` and `SURE` errors."""
    half = series[len(series) // 2 :]
    if len(half) < FEWEST or not np.isfinite(half).all():
        return None
    mean, error, _ = mean_and_error(half)
    return (half, mean, error) if abs(mean - asked) > max(FAR_OFF * asked, SURE * error) else None


def _known(error):
    return f"+- {error:.2g}" if np.isfinite(error) else "(too short a run to know its error)"


def pressure_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a pressure was not what a term holds it at; nothing if it was."""
    for term in scene.terms.values():
        pressure, target = term.controlled_pressure(values)
        if pressure is not None and (found := _off(pressure, target)) is not None:
            _, mean, error = found
            return (
                f"the pressure is {mean:.4g} {_known(error)} instead of {target:g} in the second "
                "half of the run, so the volume has not settled: let the run equilibrate for "
                "longer, or begin nearer to the density at which it ended"
            )
    return ""
