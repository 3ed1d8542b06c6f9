"""Measurements of the engine by name, each written to a file of its own."""

from __future__ import annotations

import os
import platform
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dpd.analysis.collect import save
from dpd.benchmark.beside import beside_lammps
from dpd.benchmark.features import features
from dpd.benchmark.scaling import scaling
from dpd.benchmark.schemes import schemes
from dpd.benchmark.tension import tension_beside_lammps
from dpd.errors import UserError, suggestion
from dpd.pipeline.simulate import versions
from dpd.stages import stage_digest

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

# The names that dpd.pipeline.sections allows.
MEASUREMENTS: dict[str, Callable[..., xr.Dataset]] = {
    "lammps": beside_lammps,
    "scaling": scaling,
    "schemes": schemes,
    "features": features,
    "tension": tension_beside_lammps,
}


def measure(name: str, path: str | Path, say: Callable[[str], None] = print, **sizes: Any) -> None:
    """Make a measurement and write it.

    Parameters
    ----------
    name : str
        A key of `MEASUREMENTS`.
    path : path
    say : callable
        Called with a sentence now and then.
    sizes
        What the measurement takes smaller than it is.

    Raises
    ------
    UserError
        For a name that is not known.
    """
    if name not in MEASUREMENTS:
        raise UserError(f"measure: {name!r} is not known; {suggestion(name, MEASUREMENTS)}")
    begun = time.perf_counter()
    data = MEASUREMENTS[name](say=say, **sizes)
    data.attrs |= {
        "measurement": name,
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "sources": stage_digest("measure"),
        "seconds": time.perf_counter() - begun,
    } | versions()
    data.attrs["description"] += f" On {processor()}, {data.attrs['cores']} core(s)."
    save(data, path)


def processor() -> str:
    """What the machine calls its processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
