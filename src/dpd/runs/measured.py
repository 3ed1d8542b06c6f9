"""What a run has measured, as its file holds it; and what it warns of."""

from __future__ import annotations

import json
import resource
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.analysis.statistics import mean_and_error, trend
from dpd.page import Change
from dpd.stages import run_sources

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dpd.engine.simulation import Simulation
    from dpd.files import Variable
    from dpd.scene.scene import Scene

# Share by which kT may be off without a word, and standard errors that it may; samples needed.
FAR_OFF, SURE, FEWEST = 0.05, 4.0, 20
DRIFT = 0.01  # of a bead's thermal velocity, from which on a start drifts


class Gathered(NamedTuple):
    """What a run has measured: variables for its file, their values by name, and attributes."""

    variables: dict[str, Variable]
    values: dict[str, np.ndarray]
    attributes: dict[str, Any]


def gathered(
    scene: Scene, simulation: Simulation, observers: list[Any], timed: Mapping[str, Any]
) -> Gathered:
    """All that a run has measured in the end; ``timed`` attributes say how it went."""
    variables: dict[str, Variable] = {}
    for observer in observers:
        variables |= observer.variables()
    values = {name: np.asarray(variable[1]) for name, variable in variables.items()}
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
    attributes = {**attributes, **versions(), **timed}
    if scene.chosen:
        attributes["chosen"] = scene.chosen["said"]
    if warning := warning_of(scene, values):
        attributes["warning"] = warning
    return Gathered(_with_means(variables), values, attributes)


def _with_means(variables):
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


def warning_of(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """All that a run of these values by name warns of; nothing if it is as asked."""
    found, end = [drift_warning(scene, values)], sum(scene.steps)
    half = scene.during(end - scene.steps.sample // 2, end)  # of which the others tell
    held = {(each.kT, str(each.terms.get(each.made.get(Change.STRETCHES, "")))) for each in half}
    if len(held) == 1:
        found += [temperature_warning(half[-1], values), pressure_warning(half[-1], values)]
    return "; ".join(filter(None, found))


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


def temperature_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a run was not at its temperature, with the cause, as far as that is known."""
    asked = scene.kT
    if (found := _off(values.get("kT", np.empty(0)), asked)) is None:
        return ""
    kT, mean, error = found
    slope, driven = trend(np.arange(len(kT)), kT), {Change.FLOWS, Change.SLIDES} & scene.made.keys()
    cause = "dt may be too large for this scene; a run with half of it tells"
    if not scene.takes_heat:
        cause = "without friction (every gamma is 0) nothing holds it"
    elif abs(slope.slope) > SURE * slope.error and slope.slope * (mean - asked) < 0:
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
