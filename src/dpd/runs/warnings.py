"""What a run warns of: where it was not at its temperature or pressure, and a start that drifts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dpd.analysis.statistics import mean_and_error, trend
from dpd.page import Change

if TYPE_CHECKING:
    from collections.abc import Mapping

    from dpd.scene.scene import Scene

# Share by which kT may be off without a word, and standard errors that it may; samples needed.
FAR_OFF, SURE, FEWEST = 0.05, 4.0, 20
DRIFT = 0.01  # of a bead's thermal velocity, from which on a start drifts
TURNING = 20.0  # kT that what few beads keep may be off, but for a chance of 1 in 5000


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
    momentum, axes = values.get("momentum", np.empty((0, 0))), list(scene.momentum_axes)
    if (
        Change.FLOWS in scene.made
        or not axes
        or not np.isfinite(momentum[:1]).all()
        or not len(momentum)
    ):
        return ""
    mass = scene.beads if scene.masses is None else scene.masses[scene.kinds].sum()
    drift = np.where(np.isin(np.arange(scene.dimension), axes), momentum[0] / mass, 0.0)
    if mass * (drift @ drift) <= DRIFT**2 * scene.beads * scene.kT:
        return ""
    text = ", ".join(f"{velocity:g}" for velocity in np.round(drift, 3) + 0.0)
    return (
        f"the start drifts with ({text}) r_c / tau, which nothing takes up; kT and pressure are "
        "those about that drift"
    )


def temperature_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a run was not at its temperature; nothing if it was."""
    asked = scene.kT
    if (found := _off(values.get("kT", np.empty(0)), asked)) is None:
        return ""
    kT, mean, error = found
    return (
        f"kT is {mean:.4g} {_known(error)} instead of {asked:g} in the second half of the run, and "
        f"all that was measured belongs to that: {_cause(scene, kT, mean / asked - 1, error)}"
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


def _cause(scene, kT, off, error):
    """Why kT is off by a share: what is left when all that can be ruled out is."""
    driven = not scene.made.keys().isdisjoint({Change.FLOWS, Change.SLIDES})
    if not scene.takes_heat:
        heat = ", and nothing takes up the heat of the flow" if driven else ""
        return f"without friction (every gamma is 0) nothing holds it{heat}"
    slope = trend(np.arange(len(kT)), kT)
    if abs(slope.slope) > SURE * slope.error and slope.slope * off < 0:
        return "it was still on its way there; let the run equilibrate for longer"
    if not np.isfinite(error):
        return "why is not known; let the run be longer"
    other, free = "", scene.dimension * (scene.beads - 1)
    closed = not driven and len(scene.momentum_axes) == scene.dimension
    if driven and off > 0:
        other = "the flow heats the fluid"
    elif closed and abs(off) * free < TURNING:
        other = "so few beads keep for long what they began with, a lone cluster its turning"
    if not other:
        return "dt is too large for this scene"
    return f"{other}, or dt is too large; a run with half of dt tells"


def pressure_warning(scene: Scene, values: Mapping[str, np.ndarray]) -> str:
    """A sentence if a pressure was not what a term holds it at; nothing if it was."""
    for term in scene.terms.values():
        pressure, target = term.held(values)
        if pressure is not None and (found := _off(pressure, target)) is not None:
            _, mean, error = found
            return (
                f"the pressure is {mean:.4g} {_known(error)} instead of {target:g} in the second "
                "half of the run, so the volume has not settled: let the run equilibrate for "
                "longer, or begin nearer to the density at which it ended"
            )
    return ""
