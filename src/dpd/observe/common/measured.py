"""All that is kept of what a page measures in a run, as it says in ``gives``."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.errors import UserError, suggestion
from dpd.observe.common.blocks import KINDS, Blocks, Rows
from dpd.observe.common.multitau import MultipleTau
from dpd.observe.common.snapshot import snapshot_of
from dpd.own import told_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from dpd.engine.simulation import Simulation
    from dpd.engine.state import Sums, System
    from dpd.observe import Variables
    from dpd.page import Observable
    from dpd.scene.scene import Scene

COMPARED = "compared"
TIMES = {
    "sample": "time since the end of equilibration",
    "frame": "time since the end of equilibration, mean of the looks of a frame",
    "lag": "time apart",
}


class Sampled(NamedTuple):
    """What a page sees that measures sums, of some samples."""

    scene: Scene
    system: System
    sums: Sums


@contextmanager
def blaming(page: Observable) -> Iterator[None]:
    """Say in a sentence where in its file a page fails."""
    try:
        yield
    except UserError:
        raise
    except (Exception, SystemExit) as problem:  # whatever a page of someone's own may raise
        raise UserError(f"observe.{page.key}: {told_of(problem, type(page))}") from None


class Measured:
    """All that has been measured by a page in a run, an observer of `dpd.engine.loop.run`.

    ``arrays`` are all that a checkpoint has to hold: ``taken``, the number of samples, and what
    these have left. ``file`` is the page's own, at ``path``, ``file_bytes`` its size in the end.
    """

    def __init__(
        self, page: Observable, scene: Scene, system: System, path: Path | None = None
    ) -> None:
        self._page, self._scene, self._system = page, scene, system
        self.key, self.every = page.key, page.every
        self.equilibration = getattr(page, "equilibration", False)
        self._samples = page.watched(scene) // page.every
        with blaming(page):
            self._gives, self._axes = page.given(scene), dict(page.axes(scene))
            self._kept = {name: np.atleast_1d(array) for name, array in page.keeps(scene).items()}
            self.file = None if path is None else page.opened(path)
            self.file_bytes = page.file_bytes(scene)
        rows: dict[str, tuple[str, tuple[int, ...]]] = {}
        blocks: dict[str, tuple[str, tuple[int, ...]]] = {}
        self._shapes, self._quantities = {}, []
        for name, ((kind, *along), _, _) in self._gives.items():
            if kind == "lag":
                self._quantities.append(name)
            if kind not in ("lag", "part"):
                shape = self._shapes[name] = self._lengths(name, along)
                (rows if kind in KINDS else blocks)[name] = kind, shape
        self._kinds = {given[0][0] for given in self._gives.values()}
        average = getattr(page, "average", 1)
        self._rows = Rows(rows, self._samples, average, page.single)
        self._blocks = Blocks(blocks)
        self._lags = None
        if self._quantities:
            shape = self._shapes[COMPARED] = self._lengths(COMPARED, page.compared)
            self._lags = MultipleTau(self._samples, shape, len(self._quantities))
        self.arrays: dict[str, np.ndarray] = {"taken": np.zeros(1, np.int64)}
        for each in (self._rows, self._blocks, self._lags):
            self._add(each.arrays if each else {})
        self._add(self._kept)

    def _add(self, arrays):
        if twice := self.arrays.keys() & arrays.keys():
            text = f"{min(twice)!r} is the name of something else that it keeps; take another name"
            raise UserError(f"observe.{self.key}: {text}")
        self.arrays |= arrays

    def _lengths(self, name, dimensions):
        scene = self._scene
        known = {
            "axis": scene.dimension, "axis2": scene.dimension, "bead": scene.beads,
            "molecule": len(scene.lengths), "kind": len(scene.molecules),
            "species": (np.array(scene.species), "1", "species"),
        }  # fmt: skip
        for each in dimensions:
            if each not in self._axes and each not in known:
                text = f"the dimension {each!r} of {name!r} is none of its axes"
                allowed = suggestion(each, [*self._axes, *known])
                raise UserError(f"observe.{self.key}: {text}; {allowed}")
            self._axes.setdefault(each, known.get(each))
        found = (self._axes[each] for each in dimensions)
        return tuple(each if isinstance(each, int | np.integer) else len(each[0]) for each in found)

    def sample(self, simulation: Simulation) -> None:
        """Let the page look; a UserError if it fails, or gives something else than it says."""
        page, taken = self._page, int(self.arrays["taken"][0])
        now = snapshot_of(self._scene, simulation)
        now.sample, now.kept, now.file = taken, self._kept, self.file
        with blaming(page):
            found = self._named(page.measure(now))
            values = {name: self._value(name, value) for name, value in found.items()}
            if self._lags:
                self._lags.add(taken, values[COMPARED], page.compare)
        self._rows.add(taken, values)
        self._blocks.add(taken, values)
        self.arrays["taken"][0] = taken + 1

    def _named(self, found):
        if not isinstance(found, Mapping):
            found = {next(iter(self._shapes)): found}
        known = self._shapes.keys() | self._page.gives.keys()
        if not self._shapes.keys() <= found.keys() <= known:
            raise UserError(
                f"observe.{self.key}: it gives {', '.join(map(repr, found))}, and 'gives' says: "
                f"{', '.join(map(repr, self._shapes))}"
            )
        return {name: found[name] for name in self._shapes}

    def _value(self, name, value):
        try:
            value = np.asarray(value, float)
        except (TypeError, ValueError):
            raise UserError(f"observe.{self.key}: {name!r} is no number or array") from None
        if value.shape != self._shapes[name] or not np.isfinite(value).all():
            what = f"has the shape {value.shape} instead of {self._shapes[name]}"
            if value.shape == self._shapes[name]:
                what = "has values that are not finite numbers"
            raise UserError(f"observe.{self.key}: {name!r} {what}")
        return value

    def variables(self) -> Variables:
        """For the file: coordinates, then what the page gives."""
        return dict(self._variables())

    def _variables(self):
        for name, values in self._axes.items():
            if not isinstance(values, int | np.integer):
                array, units, text, *along = values
                yield name, (along[0] if along else (name,), np.asarray(array), units, text)
        results, times = self._results()
        for kind, time in times.items():
            along, name = self._over(kind)
            text = "time since the first sample" if self._page.from_first else TIMES[kind]
            yield name, ((along,), time, "tau", text)
        shapes = {name: array.shape for name, array in results.items()}
        with blaming(self._page):
            finished = dict(self._page.finish(self._scene, results))
        for name, (dimensions, units, text) in self._gives.items():
            if name.startswith("_"):
                continue
            if np.shape(finished.get(name)) != shapes[name]:
                where = f"observe.{self.key}: 'finish' should return {name!r}"
                raise UserError(f"{where} with the shape that it had, {shapes[name]}")
            yield name, (self._along(*dimensions), finished[name], units, text)

    def _results(self):
        taken, samples = int(self.arrays["taken"][0]), np.arange(1, self._samples + 1)
        found, times = self._rows.results(taken) | self._blocks.results(taken), {}
        if "sample" in self._kinds:
            times["sample"] = self._tau(samples - self._page.from_first)
        if "frame" in self._kinds:
            looks = self._rows.looks(self._samples)
            times["frame"] = self._tau(1 + np.cumsum(looks) - looks + 0.5 * (looks - 1))
        if self._lags:
            lag, means, counts, sums = self._lags.results(taken)
            times["lag"] = self._tau(lag)
            found |= zip(self._quantities, np.moveaxis(means, 1, 0))
            parts = [name for name, ((kind, *_), _, _) in self._gives.items() if kind == "part"]
            found |= zip(parts, [counts, *np.moveaxis(sums, 2, 0)])
        return found, times

    def _tau(self, samples):
        return self._scene.tau(samples, self._scene.steps.equilibrate, self.every)

    def _over(self, kind):
        """Names of the dimension and of the times of samples, frames or lags."""
        time = "time" if kind == "sample" else f"{kind}_time"
        return self._page.over.get(kind, (f"{self.key}_{kind}", f"{self.key}_{time}"))

    def _along(self, kind, *dimensions):
        first = {"largest": ("block",), "run": (), "last": ()}.get(kind, (kind,))
        return tuple(
            self._over(each)[0] if each in TIMES else each for each in (*first, *dimensions)
        )


class MeasuredSums(Measured):
    """The same by a page that measures sums, which the loop adds up on its way."""

    @property
    def needs_forces(self) -> bool:
        """Whether the page reads virial or energy."""
        return self._page.needs_forces()

    def record(self, sums: Sums) -> None:
        """Let the page look at some samples."""
        taken = int(self.arrays["taken"][0])
        end = self.arrays["taken"][0] = taken + len(sums.step)
        with blaming(self._page):
            found = self._page.measure(Sampled(self._scene, self._system, sums))
        for name, values in self._named(found).items():
            self.arrays[name][taken:end] = values
