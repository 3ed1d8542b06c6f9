"""What is measured while a system runs: one file an observable.

A page that says what it ``gives`` measures with ``measure(now)``, and `Measured` keeps that. Others
keep it themselves: such an observable has ``every`` (steps between its samples), and
``sample(simulation)`` or ``record(sums)`` (see `dpd.engine.loop.run`), ``arrays`` (all that it
keeps, so that a checkpoint can hold it) and ``variables()`` (name to (dimensions, array, units,
long_name) for the file).

One that writes a file of its own (`dpd.scene.beside`) takes its path, and has ``file_bytes``, its
size, and ``file`` (None without a path). That goes on with what a former process has left
(``cut``), is whole up to each checkpoint (``flush``), and takes its place in the end (``finish``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dpd.engine.simulation import Snapshot as Configuration
from dpd.errors import UserError
from dpd.observe.common.measured import Measured
from dpd.observe.common.snapshot import Snapshot
from dpd.observe.common.stretch import Stretch
from dpd.scene.beside import files_beside

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from dpd.engine.state import State, System
    from dpd.scene.scene import Scene

    # Name to (dimensions, array, units, long_name).
    Variables = dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]

    class BondedSystem(System):
        """A system with bonds."""

        members: np.ndarray


def observables(
    scene: Scene, system: System, path: str | Path | None = None, state: State | None = None
) -> list[Any]:
    """The observables that a scene asks for, and the watch over its bonds.

    Parameters
    ----------
    scene : Scene
    system : System
    path : path or None
        Of the result, beside which some write files of their own; without it they do not.
    state : State or None
        Of the run, for a look at it: a function of one's own says so the shape of what it gives,
        which is a number otherwise.

    Returns
    -------
    list of Observable or Measured
    """
    beside = {} if path is None else files_beside(scene, path)
    now = None if state is None else Snapshot(scene, Configuration(system, state))
    asked: list[Any] = []
    for name, page in scene.observe.items():
        page = page if now is None else page.shaped(now)
        own = {"path": beside[name]} if name in beside else {}
        asked.append(Measured(page, scene) if page.gives else page.begin(scene, system, **own))
    _refuse_names_taken_twice(asked)
    if system.bond is None:
        return asked
    # A checker does not know that a system with a law of bonds has bonds.
    return [*asked, Stretch(scene, system)]  # type: ignore[arg-type]


def _refuse_names_taken_twice(asked):
    """Refuse a page of one's own whose variables or coordinates have the names of others."""
    for own in (each for each in asked if isinstance(each, Measured)):
        others = {name for each in asked if each is not own for name in each.variables()}
        for name in own.variables():
            if name in others or name.startswith("last_"):
                raise UserError(
                    f"observe.{own.key}: {name!r} is a variable of another observable, or of the "
                    "last configuration; take another name"
                )
