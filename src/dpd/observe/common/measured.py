"""What an observable that says what it ``gives`` keeps: a series or blocks for each variable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from dpd.errors import UserError, suggestion
from dpd.observe.common.blocks import BlockSums, places_for
from dpd.observe.common.snapshot import snapshot_of
from dpd.own import told_of

if TYPE_CHECKING:
    from dpd.engine.simulation import Simulation
    from dpd.observe import Variables
    from dpd.page import Observable
    from dpd.scene.scene import Scene


class Measured:
    """All that has been measured by a page in a run.

    Parameters
    ----------
    page : Observable
    scene : Scene

    Attributes
    ----------
    key : str
        Of the page.
    every : int
        Steps between samples.
    arrays : dict of str to array
        All that it keeps.
    """

    def __init__(self, page: Observable, scene: Scene) -> None:
        self._page, self._scene, self._axes = page, scene, dict(page.axes(scene))
        self.every, self.key = page.every, page.key
        self._samples = page.watched(scene) // page.every
        self._blocks: dict[str, BlockSums] = {}
        self.arrays: dict[str, np.ndarray] = {"taken": np.zeros(1, np.int64)}
        places = places_for(*map(self._shape, page.gives))  # the same blocks for all
        for name, (dimensions, _, _) in page.gives.items():
            if dimensions[0] == "block":
                self._blocks[name] = BlockSums(self._shape(name), places)
                own = self._blocks[name].arrays
                self.arrays |= {f"{name}_{key}": own[key] for key in ("sums", "each")}
                own["taken"] = self.arrays["taken"]
            else:
                self.arrays[name] = np.full((self._samples, *self._shape(name)), np.nan)

    def _shape(self, name):
        """Of a sample of a variable, without the dimension of samples or blocks."""
        dimensions = self._page.gives[name][0][1:]
        if unknown := [each for each in dimensions if each not in self._axes]:
            raise UserError(
                f"observe.{self._page.key}: the dimension {unknown[0]!r} of {name!r} is none of "
                f"its axes; {suggestion(unknown[0], list(self._axes))}"
            )
        return tuple(len(self._axes[each][0]) for each in dimensions)

    def sample(self, simulation: Simulation) -> None:
        """Let the page look.

        Raises
        ------
        UserError
            If it fails, or gives something else than it says.
        """
        page, taken = self._page, int(self.arrays["taken"][0])
        try:
            found = page.measure(snapshot_of(self._scene, simulation))
        except UserError:
            raise
        except (Exception, SystemExit) as problem:  # whatever a page of someone's own may raise
            raise UserError(f"observe.{page.key}: {told_of(problem, type(page))}") from None
        if not isinstance(found, Mapping):
            found = {next(iter(page.gives)): found}
        if found.keys() != page.gives.keys():
            raise UserError(
                f"observe.{page.key}: it gives {', '.join(map(repr, found))}, and 'gives' says: "
                f"{', '.join(map(repr, page.gives))}"
            )
        values = {name: self._value(name, value) for name, value in found.items()}
        for name, value in values.items():
            if name in self._blocks:
                self._blocks[name].add(value)
                self.arrays["taken"][0] = taken  # which all of them share
            else:
                self.arrays[name][taken] = value
        self.arrays["taken"][0] = taken + 1

    def _value(self, name, value):
        try:
            value = np.asarray(value, float)
        except (TypeError, ValueError):
            raise UserError(f"observe.{self._page.key}: {name!r} is no number or array") from None
        if value.shape != self._shape(name) or not np.isfinite(value).all():
            what = f"has the shape {value.shape} instead of {self._shape(name)}"
            if value.shape == self._shape(name):
                what = "has values that are not finite numbers"
            raise UserError(f"observe.{self._page.key}: {name!r} {what}")
        return value

    def variables(self) -> Variables:
        """For the file: coordinates, then what the page gives."""
        return dict(self._variables())

    def _variables(self):
        for name, (values, units, text) in self._axes.items():
            yield name, ((name,), np.asarray(values), units, text)
        series, key = f"{self._page.key}_sample", self._page.key
        if len(self._blocks) < len(self._page.gives):
            steps = np.arange(1, self._samples + 1) * self._page.every
            time = self._scene.tau(steps, self._scene.steps.equilibrate)
            yield f"{key}_time", ((series,), time, "tau", f"time of the samples of {key}")
        for name, (dimensions, units, text) in self._page.gives.items():
            if name in self._blocks:
                yield name, (dimensions, self._blocks[name].means(), units, text)
            else:
                yield name, ((series, *dimensions[1:]), self.arrays[name], units, text)
