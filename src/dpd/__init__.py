"""Dissipative particle dynamics from Python: simulate a scene, and look at what was measured.

A *scene* says what is simulated and how long; `dpd keys` lists its keys.

- `dpd.run`: simulate a scene; what it measured, as an `xarray.Dataset`.
- `dpd.extend`: make a finished run longer.
- `dpd.Scene`: a scene that was checked and knows its beads, density and bonds.
- `dpd.draw`: a picture of beads and bonds, or of density fields, as a matplotlib figure.
- `dpd.load`: the result of an earlier run or sweep.
- `dpd.Simulation`: a scene that runs step by step, and is looked at and changed in between.
- `dpd.sweep`: all combinations of some values of a scene, on several cores.
- `dpd.UserError`: what they raise over anything that the user can mend, with a sentence on it.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dpd.api import extend as extend
    from dpd.api import load as load
    from dpd.api import run as run
    from dpd.api import sweep as sweep
    from dpd.api.live import Simulation as Simulation
    from dpd.errors import UserError as UserError
    from dpd.report.draw import draw as draw
    from dpd.scene.scene import Scene as Scene

__version__ = "0.3.0"  # the one place: pyproject.toml reads it

# Imported at their first use: to import what compiles and what plots takes two seconds.
_MODULES = {
    "Scene": "dpd.scene.scene",
    "Simulation": "dpd.api.live",
    "UserError": "dpd.errors",
    "draw": "dpd.report.draw",
    "extend": "dpd.api",
    "load": "dpd.api",
    "run": "dpd.api",
    "sweep": "dpd.api",
}
__all__ = ["Scene", "Simulation", "UserError", "draw", "extend", "load", "run", "sweep"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'dpd' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
