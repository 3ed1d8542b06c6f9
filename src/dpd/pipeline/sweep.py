"""A sweep: what its file says, and from a scene or a theory and axes to points."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from itertools import product
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple
from zlib import crc32

from pydantic import Field

from dpd.digests import value_digest
from dpd.errors import UserError, shown, suggestion
from dpd.page import NAMES, OneOr, OneOrMore, Refusals, Section, inside, setting
from dpd.page.own import calculations_of
from dpd.scene.scene import Scene
from dpd.scene.yaml import changed, merge, read_section

MOST_POINTS = 5000  # of a sweep; Snakemake is slow from some thousand jobs on
LONGEST_NAME = 200  # letters of a point; a file system has names of up to 255
# What a collected sweep keeps beside the observables (see dpd.analysis.collect).
TAKEN = {
    "axis", "beads", "block", "kind", "kT", "number_density", "replica", "sample", "scene",
    "seconds", "seed", "steps", "time", "warning",
}  # fmt: skip
LABEL = re.compile(r"[A-Za-z0-9_.+-]+")
SIMULATED_ALONE = ("scene", "replicas", "series", "seeds", "derive", "sampling")
SERIES = Literal[
    "kT", "pressure", "excess_conservative", "excess_all", "pressure_tensor",
    "pressure_tensor_all", "pair_energy", "bond_energy", "total_energy", "volume",
]  # fmt: skip
AXIS = r"^[a-z_]+$"
NAMES[AXIS] = "small letters and _"
Value = int | float | str  # of an axis; whole numbers stay whole
Labelled = dict[Value, dict[Any, Any]]
Key = Annotated[str, Field(pattern=r"^[^.]+(\.[^.]+)*$")]


# --- what the file of a paper says


class Derive(Section):
    """A value of the scene that another sweep measures."""

    from_: str = Field(alias="from", description="Name of the sweep that measures it.")
    quantity: str = setting(
        "closest_contact: 2 r_0 of Liu et al. 2008, the lower edge of the first bin of g(r) that "
        "is not empty in one configuration, median over configurations. Of a sweep of theory: a "
        "number that it calculates, by its name in the sweep file."
    )


class SweptAxis(Section):
    """A swept parameter."""

    set: OneOrMore[Key] | None = setting(
        "Key or keys of the scene, or of the theory, that take the value, joined with dots; "
        "numbers count list items from 0.", None,
    )  # fmt: skip
    values: OneOr[list[Value], Labelled] = setting(
        "Numbers or names to put there; or a map from a label to the parts of the scene, or of the "
        "theory, that it changes."
    )
    labels: list[Value] | None = setting(
        "The labels of such a map that are taken; all if not given.", None, min_length=1
    )
    offset: float = setting(
        "Added to each value before it is set, so a label can be an excess.", 0.0
    )
    text: str | None = setting(
        'Text that the value is put into before it is set, as "A {}" for a chain length.', None,
        pattern=r"^[^{}]*\{\}[^{}]*$",
    )  # fmt: skip
    units: str = setting("Units of the axis.", "1")
    long_name: str | None = setting("Name for plots.", None)

    @property
    def taken(self) -> list[Value]:
        """Its labels."""
        return self.labels or list(self.values)

    @property
    def keys(self) -> list[str]:
        """What takes the value; nothing where labels change parts of the scene."""
        return [self.set] if isinstance(self.set, str) else self.set or []

    def conflicts(self) -> Refusals:
        """Labels that are none, that cannot name a folder, or cannot be told apart."""
        if isinstance(self.values, list):
            if self.labels is not None:
                yield "labels", "its values are a list; name those alone in it"
                return
            if self.set is None:
                yield "", "a list of values needs 'set', the key to put them in"
        for label in self.labels or ():
            if label not in self.values:
                yield "labels", f"no label {label!r}; {suggestion(label, self.values)}"
        if not self.taken:
            yield "values", "need at least one value"
        names: dict[str, Value] = {}
        for label in self.taken:
            name = text_of(label)
            if isinstance(label, bool) or not LABEL.fullmatch(name):
                text = (
                    f"{shown(label)} cannot be part of a point's name; allowed: numbers, and text "
                    "of letters, digits and _ . + -"
                )
                yield "values", text
            elif name in names:
                text = (
                    f"{names[name]!r} and {label!r} are both named {name!r}; need values whose "
                    "first six digits differ, none twice"
                )
                yield "values", text
            names[name] = label
            if self.offset and isinstance(label, str):
                yield "", f"{label!r} is text; an offset can be added to numbers only"

    def change(self, label: Value, key: str) -> dict[str, Any]:
        """The part of a scene that a label changes, as nested dicts."""
        if isinstance(self.values, dict):
            return self.values[label]
        value = label if isinstance(label, str) or not self.offset else label + _whole(self.offset)
        value = value if self.text is None else self.text.format(value)
        return changed({}, dict.fromkeys(self.keys, value), key)


class SweepFile(Section):
    """A family of runs, or of calculations."""

    scene: dict[Any, Any] | None = setting(
        "A scene, see below; the axes fill in what is swept. A sweep has this or `theory`.", None
    )
    theory: dict[Any, Any] | None = setting(
        "What is calculated where nothing is simulated: one calculation of the paper's own, which "
        "is a class in paper_figures/PAPER/calculations.py, with its arguments. Such a sweep has "
        "`axes` alone beside it. All points come together in sweeps/NAME.nc, as those of runs do.",
        None,
    )  # fmt: skip
    replicas: int = setting(
        "Number of runs of each point, each with a seed of its own.", 1, ge=1, le=1000
    )
    sampling: Annotated[float, Field(gt=0, le=1e6)] = setting(
        "Factor on the steps and durations of every run.", 1.0
    )
    series: list[SERIES] = setting(
        "Time series that the sweep file keeps whole, each NAME as NAME_series, if all runs share "
        "one time axis.", ["kT"],
    )  # fmt: skip
    seeds: str | None = setting(
        "Name from which the seeds follow, if it is not that of the sweep. After renaming a sweep, "
        "put its former name here, and its runs stay valid.", None,
    )  # fmt: skip
    derive: dict[Key, Derive] | None = setting(
        "Values of the scene that another sweep of the paper measures first, by the key that takes "
        "them. A point takes the result of the point of the other sweep that has the same values "
        "on the axes that both sweeps have. Until it is measured, the value in the scene serves "
        "for planning.", None,
    )  # fmt: skip
    axes: dict[Annotated[str, Field(pattern=AXIS)], SweptAxis] | None = setting(
        "Swept parameters; the points are all combinations.", None
    )

    def conflicts(self) -> Refusals:
        """A scene and a theory, or none; and what is wrong with an axis."""
        if (self.scene is None) == (self.theory is None):
            yield "", "need either 'scene' or 'theory', and not both"
            return
        for name in SIMULATED_ALONE if self.theory is not None else ():
            if name in self.model_fields_set:
                yield name, "the sweep is calculated and has no runs; take this key out"
        for name, axis in (self.axes or {}).items():
            if name in TAKEN:
                text = (
                    "a collected sweep has this name already; choose another one (taken: "
                    f"{', '.join(sorted(TAKEN))})"
                )
                yield f"axes.{name}", text
            yield from inside(f"axes.{name}", axis.conflicts())


def _whole(number):
    return int(number) if float(number).is_integer() else number


def text_of(label: float | str) -> str:
    """A label as it stands in the name of a point."""
    return f"{label:g}" if isinstance(label, float) else str(label)


# --- its points


class Point(NamedTuple):
    """One run of a sweep, or one calculation: its name, its place on the axes, and its scene."""

    name: str
    labels: tuple
    scene: Any  # a `Scene`; of a sweep of theory, a `Calculation`


class Axis(NamedTuple):
    """A swept parameter: name, labels, units, and a name for plots."""

    name: str
    labels: tuple
    units: str
    long_name: str


@dataclass(frozen=True)
class Sweep:
    """A family of runs, the last axis of which is ``replica``; or of calculations of one kind."""

    name: str
    axes: tuple
    points: tuple
    series: tuple = ("kT",)  # kept whole where all runs share one time axis
    derived: dict[str, Derive] = field(default_factory=dict)  # stand-ins until they are measured

    @property
    def calculated_digest(self) -> str:
        """Digest of all that a sweep of theory calculates, and of its axes."""
        points = [(p.name, value_digest(p.scene.plain())) for p in self.points]
        axes = [(axis.name, axis.units, axis.long_name) for axis in self.axes]
        return value_digest([self.points[0].scene.key, axes, points])

    def planned_digest(self, point: Point) -> str:
        """Digest of all that is known of a run before anything has run."""
        if not self.derived:
            return point.scene.digest
        rules = [(key, rule.from_, rule.quantity) for key, rule in self.derived.items()]
        return value_digest([point.scene.digest, *rules])

    def point(self, name: str) -> Point:
        """A point by name; `UserError` if the sweep has no such point."""
        points = {point.name: point for point in self.points}
        if name not in points:
            raise UserError(f"sweep {self.name}: no point {name!r}; {suggestion(name, points)}")
        return points[name]


def unfold(
    paper: str, name: str, given: SweepFile, key: str, folder: str | Path = "", seed: int = 1,
    only: Collection[str] = (),
) -> Sweep:  # fmt: skip
    """All points of a sweep, or ``only`` some; ``key`` for messages, ``folder`` for paths in it."""
    axes = [
        Axis(name, tuple(axis.taken), axis.units, axis.long_name or name.replace("_", " "))
        for name, axis in (given.axes or {}).items()
    ]
    if given.theory is None:
        axes.append(Axis("replica", tuple(range(given.replicas)), "1", "replica"))
    seeds = f"{paper}/{given.seeds or name}" + (f"/seed {seed}" if seed != 1 else "")
    points = []
    for at, labels, where in _places(axes, key, only):
        base = given.scene if given.theory is None else given.theory
        data = _placed(base, given, labels, key, where)
        if given.theory is None:
            scene = _run_of(data, given, (f"{seeds}/{at}", f"{seeds}/{labels[-1]}"), where, folder)
        else:
            scene = _calculation_of(data, paper, seed, where)
        points.append(Point(at, labels, scene))
    return Sweep(name, tuple(axes), tuple(points), tuple(given.series), given.derive or {})


def _places(axes: list[Axis], key: str, only: Collection[str]) -> Iterator[tuple[str, tuple, str]]:
    """Name and labels of each point on some axes, or of some, and what to call it in messages."""
    sizes = [len(axis.labels) for axis in axes]
    if prod(sizes) > MOST_POINTS:
        said = " x ".join(map(str, sizes))
        raise UserError(f"{key}: {said} make {prod(sizes)} points; allowed: <= {MOST_POINTS}")
    found = {
        ",".join(f"{axis.name}={text_of(v)}" for axis, v in zip(axes, labels)): labels
        for labels in product(*(axis.labels for axis in axes))
    }
    longest = max(found, key=len)
    if len(longest) > LONGEST_NAME:
        raise UserError(
            f"{key}.axes: a point would be named {shown(longest, str)}, with {len(longest)} "
            f"letters; allowed: <= {LONGEST_NAME}; give axes and labels shorter names"
        )
    for at in only if only and found.keys() >= set(only) else found:
        yield at, found[at], f"{key} ({at})" if at else key


def _placed(base: Any, given: SweepFile, labels: tuple, key: str, where: str) -> dict[str, Any]:
    """The scene or theory of a point, refused where an axis undoes the value of another one."""
    values = {}
    for (name, axis), label in zip((given.axes or {}).items(), labels):
        change = axis.change(label, f"{key}.axes.{name}")
        base = merge(base, change, where)
        if axis.keys:  # a map of labels may set defaults
            values[name] = change
    for name, change in values.items():
        if merge(base, change, where) != base:
            raise UserError(
                f"{key}.axes.{name}: another axis undoes its value at {where}; let each key have "
                "one axis"
            )
    return base


def _run_of(data, given, seeds, where, folder):
    """The scene of a point, with noise by its name alone, and one start for those of a replica."""
    scene = data
    try:
        factor = _whole(given.sampling)  # times as long
        steps, duration = scene.get("steps", {}), scene.get("duration", {})
        steps = {part: max(1, round(factor * n)) if n else 0 for part, n in steps.items()}
        duration = {part: factor * time for part, time in duration.items()}
        scene = merge(scene, {"steps": steps, "duration": duration})
        if factor != 1 and isinstance(schedule := scene.get("schedule"), list):
            scene["schedule"] = [each | {"step": round(factor * each["step"])} for each in schedule]
        own, start = ((scene.get("seed", 1) + crc32(of.encode())) % 2**31 for of in seeds)
        scene = merge(scene, {"seed": own, "start": {"seed": start}}, where)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        Scene(scene, where, folder)  # which says what is wrong with it
        raise
    return fixed(Scene(scene, where, folder))


def fixed(scene: Scene) -> Scene:
    """The scene, if it names its scheme: the points of a sweep must be comparable."""
    if scene.is_auto:
        raise UserError(
            f"{scene.where}: integrator.scheme: 'auto' is for scenes of your own (python -m dpd "
            "run), which says what it takes; in a sweep name scheme and dt"
        )
    return scene


def _calculation_of(theory, paper, seed, where):
    """The calculation of a point; the ``seed`` of the study is for what is sampled."""
    known = calculations_of(paper)
    name = next((each for each in theory if each not in known or len(theory) == 1), "")
    if theory.keys() != {name} or name not in known:
        said = ", ".join(theory) or "none"
        raise UserError(
            f"{where}: theory: need one calculation, not {said}; {suggestion(name, known)}"
        )
    calculation = read_section(known[name], theory[name], where, name)
    if seed != 1 and getattr(calculation, "seed", seed) is None:
        calculation = calculation.model_copy(update={"seed": seed})
    return calculation
