"""A sweep: from a scene and axes to points, one a run."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import astuple, dataclass
from itertools import product
from pathlib import Path
from typing import Any
from zlib import crc32

from dpd.digest import value_digest
from dpd.errors import UserError, suggestion
from dpd.pipeline.points import check_axes, check_blocks, fixed, text_of
from dpd.scene.scene import Scene
from dpd.scene.yaml import changed, merge


@dataclass(frozen=True)
class Point:
    """One run of a sweep: its name, its place on the axes, and its scene."""

    name: str
    labels: tuple
    scene: Scene


@dataclass(frozen=True)
class Axis:
    """A swept parameter: name, labels, units, and a name for plots."""

    name: str
    labels: tuple
    units: str
    long_name: str


@dataclass(frozen=True)
class Derived:
    """A value of a scene that another sweep measures: which key, from which sweep, and what."""

    key: str
    source: str
    quantity: str


@dataclass(frozen=True)
class Sweep:
    """A family of runs; the last axis is always ``replica``.

    ``series`` names the time series that are kept whole where all runs share one time axis.
    Until the sweeps that ``derived`` names have run, the scenes hold stand-ins for those values.
    """

    name: str
    axes: tuple
    points: tuple
    series: tuple = ("kT",)
    derived: tuple = ()

    def planned_digest(self, point: Point) -> str:
        """Digest of all that is known of a run before anything has run."""
        if not self.derived:
            return point.scene.digest
        return value_digest([point.scene.digest, *map(astuple, self.derived)])

    def point(self, name: str) -> Point:
        """A point by name.

        Raises
        ------
        UserError
            If the sweep has no such point.
        """
        for point in self.points:
            if point.name == name:
                return point
        names = [point.name for point in self.points]
        raise UserError(f"sweep {self.name}: no point {name!r}; {suggestion(name, names)}")


def described_axes(given: dict[str, Any], key: str) -> dict[str, dict[str, Any]]:
    """The axes of a sweep, each with those of its labels that are taken."""
    described = {}
    for axis, rule in given.get("axes", {}).items():
        values = rule["values"]
        if "labels" in rule and not isinstance(values, dict):
            raise UserError(f"{key}.{axis}.labels: its values are a list; name those alone in it")
        for label in rule.get("labels", ()):
            if label not in values:
                there = f"{key}.{axis}.labels"
                raise UserError(f"{there}: no label {label!r}; {suggestion(label, values)}")
        if "labels" in rule:
            values = {label: values[label] for label in rule["labels"]}
        described[axis] = rule | {"values": values}
    return described


def narrowed(
    described: dict[str, dict[str, Any]], points: Collection[str]
) -> dict[str, dict[str, Any]]:
    """The axes with the labels of named points alone; with all if there is no such point."""
    named = {tuple(part.partition("=")[::2]) for point in points for part in point.split(",")}
    narrow = {}
    for axis, rule in described.items():
        own = [value for value in rule["values"] if (axis, text_of(value)) in named]
        if not own:
            return described
        values = rule["values"]
        kept = {label: values[label] for label in own} if isinstance(values, dict) else own
        narrow[axis] = rule | {"values": kept}
    return narrow


def unfold(
    paper: str, name: str, given: dict[str, Any], key: str, described: dict[str, dict[str, Any]],
    folder: str | Path = "", seed: int = 1,
) -> Sweep:  # fmt: skip
    """All points of a sweep; paths of files to start from count from a folder."""
    given = dict[str, Any]({"replicas": 1, "series": ["kT"], "sampling": 1}) | given
    check_axes(described, given["replicas"], key)
    replicas = Axis("replica", tuple(range(given["replicas"])), "1", "replica")
    axes = [*axes_of(described, key), replicas]
    seeds = f"{paper}/{given.get('seeds', name)}" + (f"/seed {seed}" if seed != 1 else "")
    points = []
    for at, labels, where in places(axes, key):
        scene = placed(given["scene"], described, labels, key, where)
        check_blocks(scene, where)
        scene = _sampled(scene, given["sampling"])
        scene = _with_seeds(scene, seeds, at, labels[-1])
        points.append(Point(at, labels, fixed(Scene(scene, where, folder))))
    derived = tuple(
        Derived(target, rule["from"], rule["quantity"])
        for target, rule in given.get("derive", {}).items()
    )
    return Sweep(name, tuple(axes), tuple(points), tuple(given["series"]), derived)


def axes_of(described: dict[str, dict[str, Any]], key: str) -> list[Axis]:
    """The axes that a sweep describes."""
    return [_axis(name, rule, key) for name, rule in described.items()]


def places(axes: Sequence[Axis], key: str) -> Iterator[tuple[str, tuple, str]]:
    """Name and labels of each point on some axes, and what to call it in messages.

    Parameters
    ----------
    axes : list of Axis
    key : str
        File and key of the sweep.
    """
    for labels in product(*(axis.labels for axis in axes)):
        at = ",".join(f"{axis.name}={text_of(v)}" for axis, v in zip(axes, labels))
        yield at, labels, f"{key} ({at})" if at else key


def placed(
    base: dict[str, Any], described: dict[str, dict[str, Any]], labels: tuple, key: str, where: str
) -> dict[str, Any]:
    """The scene or theory of a point: the sweep's own, with what the labels of its axes change."""
    for (axis, rule), label in zip(described.items(), labels):
        base = merge(base, _changes(rule, label, f"{key}.axes.{axis}"), where)
    return base


def _axis(name, rule, key):
    values = rule["values"]
    if isinstance(values, list) and "set" not in rule:
        raise UserError(f"{key}.axes.{name}: a list of values needs 'set', the key to put them in")
    units, long_name = rule.get("units", "1"), rule.get("long_name", name.replace("_", " "))
    return Axis(name, tuple(values), units, long_name)


def _changes(rule, label, key):
    """The part of a scene that a label changes, as nested dicts."""
    if isinstance(rule["values"], dict):
        return rule["values"][label]
    if rule.get("offset") and isinstance(label, str):
        raise UserError(f"{key}: {label!r} is text; an offset can be added to numbers only")
    value = label + rule["offset"] if rule.get("offset") else label
    value = rule["text"].format(value) if "text" in rule else value
    targets = [rule["set"]] if isinstance(rule["set"], str) else rule["set"]
    return changed({}, dict.fromkeys(targets, value), key)


def _sampled(scene, factor):
    """A scene that runs ``factor`` times as long."""
    steps, duration = scene.get("steps", {}), scene.get("duration", {})
    steps = {part: max(1, round(factor * n)) if n else 0 for part, n in steps.items()}
    duration = {part: factor * time for part, time in duration.items()}
    longer = merge(scene, {"steps": steps, "duration": duration})
    if factor != 1 and isinstance(schedule := scene.get("schedule"), list):
        longer["schedule"] = [
            each | {"step": round(factor * each["step"])} if "step" in each else each
            for each in schedule
        ]
    return longer


def _with_seeds(scene, sweep, at, replica):
    """Noise seeds of their own for all points; one start for the points of a replica.

    The seeds follow from the names alone, so a point keeps its own when others are added.
    """
    seed = scene.get("seed", 1)
    own = (seed + crc32(f"{sweep}/{at}".encode())) % 2**31
    start = (seed + crc32(f"{sweep}/{replica}".encode())) % 2**31
    return merge(scene, {"seed": own, "start": {"seed": start}})
