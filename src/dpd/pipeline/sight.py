"""What a run has measured so far, from its checkpoint; or in all, from its result."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from dpd import files
from dpd.analysis.statistics import mean_and_error
from dpd.engine.checkpoint import MARK, NOTE
from dpd.engine.state import State
from dpd.errors import reason
from dpd.scene.scene import Scene

RECENT = 4096  # files of which the last look is remembered


@dataclass(frozen=True)
class Measured:
    """Means of what a run has sampled, with their standard errors.

    Attributes
    ----------
    kT, kT_error : float
        While a run equilibrates, of that moment alone, without an error (NaN).
    pressure, pressure_error : float
        With the virial of conservative forces; NaN where it was not measured.
    """

    kT: float = np.nan
    kT_error: float = np.nan
    pressure: float = np.nan
    pressure_error: float = np.nan


NOTHING = Measured()


@dataclass(frozen=True)
class Sight:
    """What a checkpoint shows.

    Attributes
    ----------
    step : int
    scene_digest, sources : str
        Of the run that it is of.
    scene : Scene or None
        None in one of an older version.
    measured : Measured
    seen : float
        When it was written, as `time.time` has it.
    """

    step: int
    scene_digest: str
    sources: str
    scene: Scene | None
    measured: Measured
    seen: float


def measured_in(path: str | Path) -> Measured:
    """What a result has measured.

    Raises
    ------
    UserError
        If it cannot be read.
    """
    found, _ = files.read(path)
    return Measured(*_mean(found.get("kT")), *_mean(found.get("pressure")))


def _mean(series):
    """Mean and error of the values of a series that are numbers; NaN for none."""
    values = np.asarray([] if series is None else series, dtype=float)
    values = values[np.isfinite(values)]
    if len(values) < 2:
        return (float(values[0]) if len(values) else np.nan), np.nan
    mean, error, _ = mean_and_error(values)
    return mean, error


def sight_of(path: Path) -> Sight | str | None:
    """What a checkpoint shows; a sentence where it is damaged; None where there is none.

    Parameters
    ----------
    path : Path
    """
    try:
        there = os.stat(path)
    except FileNotFoundError:
        return None
    except OSError as problem:
        return f"{path}: cannot be read ({reason(problem)})"
    return _sight(path, there.st_mtime_ns, there.st_size)


@lru_cache(RECENT)
def _sight(path, changed, size):
    """The same of a file, read once unless it changes."""
    if not path.is_file():
        return f"{path}: is no checkpoint"
    try:
        with np.load(path) as stored:
            key = json.loads(str(stored[MARK]))
            note = json.loads(str(stored[NOTE])) if NOTE in stored else None
            scene = None
            if isinstance(note, dict) and "scene" in note:
                scene = Scene.of_result(note["scene"], str(path))
            return Sight(
                int(stored["step"]), key["scene"], key["sources"], scene,
                _measured_so_far(stored, scene), changed / 1e9,
            )  # fmt: skip
    except OSError as problem:
        if files.is_of_system(problem):
            return f"{path}: cannot be read ({reason(problem)})"
        return f"{path}: a damaged checkpoint"
    except Exception:  # NumPy, zipfile and JSON have a dozen for files that are damaged
        return f"{path}: a damaged checkpoint"


def _temperature_of(stored, scene):
    """kT of the beads in a checkpoint, about the flow; NaN where their scene is not known."""
    if scene is None:
        return np.nan
    from dpd.engine.simulation import Snapshot  # the engine, which few looks need
    from dpd.observe.common.thermal import ThermalMotion
    from dpd.start.common.make import system_of

    system, species = system_of(scene), stored.get("species")
    now = State(stored["position"], stored["velocity"], None, stored["identity"], species, 0)
    thermal = ThermalMotion(scene, system).velocities(Snapshot(system, now))
    return float(np.mean(system.mass_of(species) * thermal**2))


def _measured_so_far(stored: Any, scene: Scene | None) -> Measured:
    """Means over the samples in a checkpoint; kT of the moment where there are none yet."""
    arrays = {name.rpartition("/")[2]: name for name in stored.files}
    kT = _mean(stored[arrays["kT"]] if "kT" in arrays else None)
    if not np.isfinite(kT[0]):
        return Measured(kT=_temperature_of(stored, scene))
    return Measured(*kT, *_mean(stored[arrays["pressure"]] if "pressure" in arrays else None))
