"""What is measured while a system runs: one file an observable.

A page says what it ``gives`` and how to ``measure`` that; `dpd.observe.common.measured.Measured`
keeps it in a run: series, means over blocks, correlations.

One that writes a file of its own (`Scene.files_beside`) says how it is ``opened``, and its size,
``file_bytes``. That goes on with what a former process has left (``cut``), is whole up to each
checkpoint (``flush``), and takes its place in the end (``finish``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.errors import UserError
from dpd.observe.common.measured import Measured, MeasuredSums
from dpd.observe.common.snapshot import Snapshot
from dpd.page import Observable
from dpd.page import names as pages

if TYPE_CHECKING:
    from pathlib import Path

    from dpd.engine.state import State, System
    from dpd.scene.scene import Scene

    # Name to (dimensions, array, units, long_name).
    Variables = dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]


def observables(
    scene: Scene, system: System, path: str | Path | None = None, state: State | None = None
) -> list[Any]:
    """The `Measured` of what a scene asks for, and of the watch over its bonds.

    Some write files of their own beside a result at ``path``, if there is one. A function of one's
    own looks at the ``state`` to know the shape of what it gives, which is a number otherwise.
    """
    from dpd.engine.simulation import Snapshot as Configuration  # with Numba: to read takes none

    beside = {} if path is None else scene.files_beside(path)
    now = None if state is None else Snapshot(scene, Configuration(system, state))
    asked: list[Any] = []
    for name, page in scene.observe.items():
        page = page if now is None else page.shaped(now)
        kind = MeasuredSums if page.of_sums else Measured
        asked.append(kind(page, scene, system, beside.get(name)))
    if scene.page_files:
        _refuse_names_taken_twice(asked)
    if system.bond is not None:
        from dpd.observe.common.stretch import EVERY, Stretch

        asked.append(Measured(Stretch(every=min(EVERY, scene.steps.sample)), scene, system))
    return asked


def _refuse_names_taken_twice(asked):
    """Refuse a page of one's own whose variables or coordinates have the names of others."""
    found = {each.key: each.variables() for each in asked}
    for own in found.keys() - pages(Observable):
        others = {n: each for key in found.keys() - {own} for n, each in found[key].items()}
        for name, variable in found[own].items():
            if name.startswith("last_") or (
                name in others and not _is_same(variable, others[name])
            ):
                raise UserError(
                    f"observe.{own}: {name!r} is a variable of another observable, or of the last "
                    "configuration; take another name"
                )


def _is_same(one, other):
    """Whether both are the same coordinate, as that of species."""
    return one[0] == other[0] and len(one[1]) > 0 and np.array_equal(one[1], other[1])
