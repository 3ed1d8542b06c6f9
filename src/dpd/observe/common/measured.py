"""All that is kept of what pages measure in a run, as they say in ``gives``."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dpd.engine.simulation import Simulation
from dpd.engine.simulation import Snapshot as Configuration
from dpd.engine.space import along_axes
from dpd.engine.state import State, Sums, System
from dpd.errors import LostRun, UserError, suggestion
from dpd.observe.common.accumulators import MultipleTau, Series
from dpd.observe.common.snapshot import Snapshot, snapshot_of
from dpd.page import Observable
from dpd.page import names as pages
from dpd.page.own import blaming
from dpd.scene.scene import Scene

# Name to (dimensions, array, units, long_name).
Variables = dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]
COMPARED = "compared"
TIMES = {
    "sample": "time since the end of equilibration",
    "frame": "time since the end of equilibration, mean of the looks of a frame",
    "lag": "time apart",
}
EVERY = 200  # steps between looks at long bonds: less than half a per cent of the run time
# Of an edge: a bond that reaches further along an axis may soon be nearer to another image of its
# bead than to its own. It may so in this share of all bonds and steps.
LONG = 0.48
MOST_LONG = 1e-4
FEW = 10  # finds that say nothing: so short a run knows its means far less well


def observables(
    scene: Scene, system: System, path: str | Path | None = None, state: State | None = None
) -> list[Any]:
    """The `Measured` of what a scene asks for, and of the watch over its bonds.

    ``path``: of the result beside which some write files of their own. ``state``: tells functions
    of one's own the shape of what they give, which is a number otherwise.
    """
    sidecars = {} if path is None else scene.files_beside(path)
    now = None if state is None else Snapshot(scene, Configuration(system, state))
    asked: list[Any] = []
    for name, page in scene.observe.items():
        page = page if now is None else page.shaped(now)
        kind = MeasuredSums if page.of_sums else Measured
        asked.append(kind(page, scene, system, sidecars.get(name)))
    if scene.page_files:
        _refuse_names_taken_twice(asked)
    if system.bond is not None:
        asked.append(Measured(Stretch(every=min(EVERY, scene.steps.sample)), scene, system))
    return asked


def _refuse_names_taken_twice(asked):
    """Refuse a page of one's own whose variables or coordinates have the names of others."""
    found = {each.key: each.variables() for each in asked}
    for own in found.keys() - pages(Observable):
        others = {name: one for key in found.keys() - {own} for name, one in found[key].items()}
        for name, (dimensions, values, *_) in found[own].items():
            other = others.get(name)  # the same coordinate, as that of species, may be there twice
            same = other and dimensions == other[0] != () and np.array_equal(values, other[1])
            if name.startswith("last_") or (other and not same):
                text = f"{name!r} is a variable of another observable, or of the last configuration"
                raise UserError(f"observe.{own}: {text}; take another name")


class Measured:
    """All that has been measured by a page in a run, an observer of `dpd.engine.loop.run`.

    ``arrays`` are all that a checkpoint has to hold. ``file`` is the page's own, at ``path``.
    """

    def __init__(
        self, page: Observable, scene: Scene, system: System, path: Path | None = None
    ) -> None:
        self._page, self._scene, self._system = page, scene, system
        self.key, self.every = page.key, page.every
        self.equilibration = getattr(page, "equilibration", False)
        self.needs_forces = page.needs_forces  # whether it reads virial or energy
        self._samples = page.watched(scene) // page.every
        with blaming(page):
            self._gives, self._axes = page.given(scene), dict(page.axes(scene))
            self._kept = {name: np.atleast_1d(array) for name, array in page.keeps(scene).items()}
            self.file = None if path is None else page.opened(path)
        shapes, self._names = {}, dict[str, list[str]]()  # names of what is given, by kind
        for name, ((kind, *along), _, _) in self._gives.items():
            self._names.setdefault(kind, []).append(name)
            if kind not in ("lag", "part"):
                shapes[name] = kind, self._lengths(name, along)
        self._series = Series(shapes, self._samples, getattr(page, "average", 1), page.single)
        self._shapes = {name: shape for name, (_, shape) in shapes.items()}
        self._lags = None
        if "lag" in self._names:
            shape = self._shapes[COMPARED] = self._lengths(COMPARED, page.compared)
            self._lags = MultipleTau(self._samples, shape, len(self._names["lag"]))
        each = {"each": self._series.each} if {"block", "largest"} & self._names.keys() else {}
        lags = self._lags.arrays if self._lags else {}
        self.arrays: dict[str, np.ndarray] = {"taken": np.zeros(1, np.int64)}
        for arrays in (each, self._series.arrays, lags, self._kept):
            for twice in sorted(self.arrays.keys() & arrays.keys()):
                self._refuse(f"{twice!r} is the name of something else that it keeps; take another")
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
                self._refuse(f"{text}; {suggestion(each, [*self._axes, *known])}")
            self._axes.setdefault(each, known.get(each))
        found = (self._axes[each] for each in dimensions)
        return tuple(each if isinstance(each, int | np.integer) else len(each[0]) for each in found)

    def _refuse(self, text):
        raise UserError(f"observe.{self.key}: {text}") from None

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
        self._series.add(taken, values)
        self.arrays["taken"][0] = taken + 1

    def _named(self, found):
        if not isinstance(found, Mapping):
            found = {next(iter(self._shapes)): found}
        known = self._shapes.keys() | self._page.gives.keys()
        if not self._shapes.keys() <= found.keys() <= known:
            here, said = (", ".join(map(repr, each)) for each in (found, self._shapes))
            self._refuse(f"it gives {here}, and 'gives' says: {said}")
        return {name: found[name] for name in self._shapes}

    def _value(self, name, value):
        try:
            value = np.asarray(value, float)
        except (TypeError, ValueError):
            self._refuse(f"{name!r} is no number or array")
        if value.shape != self._shapes[name]:
            self._refuse(f"{name!r} has the shape {value.shape} instead of {self._shapes[name]}")
        if not np.isfinite(value).all():
            self._refuse(f"{name!r} has values that are not finite numbers")
        return value

    def variables(self) -> Variables:
        """For the file: coordinates, then what the page gives."""
        made: Variables = {}
        for name, values in self._axes.items():
            if not isinstance(values, int | np.integer):
                array, units, text, *along = values
                made[name] = along[0] if along else (name,), np.asarray(array), units, text
        results, times = self._results()
        for kind, time in times.items():
            along, name = self._over(kind)
            text = "time since the first sample" if self._page.from_first else TIMES[kind]
            made[name] = (along,), time, "tau", text
        shapes = {name: array.shape for name, array in results.items()}
        with blaming(self._page):
            finished: Any = dict(self._page.finish(self._scene, results))
        for name, (dimensions, units, text) in self._gives.items():
            if name.startswith("_"):
                continue
            if np.shape(finished.get(name)) != shapes[name]:
                text = f"'finish' should return {name!r} with the shape that it had"
                self._refuse(f"{text}, {shapes[name]}")
            kind, *others = dimensions
            first = {"largest": ("block",), "run": (), "last": ()}.get(kind, (kind,))
            along = tuple(self._over(e)[0] if e in TIMES else e for e in (*first, *others))
            made[name] = along, finished[name], units, text
        return made

    def _results(self):
        taken, samples = int(self.arrays["taken"][0]), np.arange(1, self._samples + 1)
        found, times = self._series.results(taken), {}
        if "sample" in self._names:
            times["sample"] = self._tau(samples - self._page.from_first)
        if "frame" in self._names:
            looks = self._series.looks(self._samples)
            times["frame"] = self._tau(1 + np.cumsum(looks) - looks + 0.5 * (looks - 1))
        if self._lags:
            lag, means, counts, sums = self._lags.results(taken)
            times["lag"] = self._tau(lag)
            found |= zip(self._names["lag"], np.moveaxis(means, 1, 0))
            found |= zip(self._names.get("part", ()), [counts, *np.moveaxis(sums, 2, 0)])
        return found, times

    def _tau(self, samples):
        return self._scene.tau(samples, self._scene.steps.equilibrate, self.every)

    def _over(self, kind):
        """Names of the dimension and of the times of samples, frames or lags."""
        time = "time" if kind == "sample" else f"{kind}_time"
        return self._page.over.get(kind, (f"{self.key}_{kind}", f"{self.key}_{time}"))


class Sampled(NamedTuple):
    """What a page sees that measures sums, of some samples."""

    scene: Scene
    system: System
    sums: Sums


class MeasuredSums(Measured):
    """The same by a page that measures sums, which the loop adds up on its way."""

    def record(self, sums: Sums) -> None:
        """Let the page look at some samples."""
        taken = int(self.arrays["taken"][0])
        end = self.arrays["taken"][0] = taken + len(sums.step)
        with blaming(self._page):
            found = self._page.measure(Sampled(self._scene, self._system, sums))
        for name, values in self._named(found).items():
            self.arrays[name][taken:end] = values


class Stretch(Observable, key="stretch"):
    """Ends a run in which bonds reach across half the box more than once in a while.

    A bond longer than half an edge along an axis flips to another image; before and after that it
    reaches over `LONG` of the edge. As long as less than `MOST_LONG` of all bonds do, the mean
    square length of harmonic bonds without a rest length is less than 3e-4 too small.
    """

    def keeps(self, scene: Any) -> Any:
        return {"count": 0}

    def measure(self, now: Any) -> Any:
        bonds, looks = len(now.bond_vectors), now.scene.steps.sample // self.every
        now.kept["count"] += reaching_over(now.bond_vectors.T, now.lattice)
        count, allowed = int(now.kept["count"][0]), max(FEW, MOST_LONG * bonds * looks)
        if count > allowed:
            edges = " x ".join(f"{edge:g}" for edge in now.box)
            raise LostRun(
                f"bonds are too long for the box of {edges} r_c: by step {now.step}, {count} "
                f"were found to reach over {LONG:.0%} of an edge, beyond half of which they "
                f"pull at another image (allowed in the run: {round(allowed)}). Take a larger "
                "box, or stiffer or shorter bonds",
                now.step,
            )
        return {}


def reaching_over(bonds: np.ndarray, box: tuple[float, ...]) -> int:
    """Number of bonds, once for each axis, along which they reach over `LONG` of an edge.

    (dimension, bonds) vectors, at nearest images; where images slide, axes are those of the box.
    """
    return int((np.abs(along_axes(bonds, box)) > LONG * np.array(box)[:, None]).sum())
