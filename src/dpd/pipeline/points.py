"""Checks of a sweep: axes whose points have names of their own, scenes before they are built."""

from __future__ import annotations

import re
from math import prod
from typing import TYPE_CHECKING, Any

from dpd.errors import UserError, shown

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

LONGEST = 1e12  # steps or tau of a run, before a study's factor
MOST_POINTS = 5000  # of a sweep; Snakemake is slow from some thousand jobs on
# What a collected sweep keeps beside the observables (see dpd.analysis.collect).
TAKEN = {
    "axis", "beads", "block", "kind", "kT", "number_density", "replica", "sample", "scene",
    "seconds", "seed", "steps", "time", "warning",
}  # fmt: skip
LONGEST_NAME = 200  # letters of a point; a file system has names of up to 255
LABEL = re.compile(r"[A-Za-z0-9_.+-]+")


def text_of(label: float | str) -> str:
    """A label as it stands in the name of a point."""
    return f"{label:g}" if isinstance(label, float) else str(label)


def check_axes(described: dict[str, dict[str, Any]], replicas: int, key: str) -> None:
    """Refuse axes whose points cannot be told apart, or are too many, before they unfold.

    Parameters
    ----------
    described : dict
        Axes by name, as `dpd.pipeline.sections.SweptAxis` has them.
    replicas : int
    key : str
        File and key to name in messages.

    Raises
    ------
    UserError
    """
    for name, rule in described.items():
        if name in TAKEN:
            raise UserError(
                f"{key}.axes.{name}: a collected sweep has this name already; choose another one "
                f"(taken: {', '.join(sorted(TAKEN))})"
            )
        _check_labels(list(rule["values"]), f"{key}.axes.{name}.values")
    points = replicas * prod(len(rule["values"]) for rule in described.values())
    if points > MOST_POINTS:
        sizes = " x ".join(str(len(rule["values"])) for rule in described.values())
        raise UserError(
            f"{key}: {sizes or 1} values and {replicas} replicas make {points} points; allowed: "
            f"<= {MOST_POINTS}"
        )
    _check_lengths(described, replicas, key)
    _check_targets(described, key)


def _check_lengths(described, replicas, key):
    """Points whose names are folders, and names of logs."""
    longest = [
        f"{name}={max((text_of(label) for label in rule['values']), key=len)}"
        for name, rule in described.items()
    ]
    name = ",".join([*longest, f"replica={replicas - 1}"])
    if len(name) > LONGEST_NAME:
        raise UserError(
            f"{key}.axes: a point would be named {shown(name, str)}, with {len(name)} letters; "
            f"allowed: <= {LONGEST_NAME}; give axes and labels shorter names"
        )


def _check_labels(labels, key):
    """Labels that name folders and stand beside each other in a file."""
    seen = {}
    for label in labels:
        text = text_of(label)
        if isinstance(label, bool) or not LABEL.fullmatch(text):
            raise UserError(
                f"{key}: {shown(label)} cannot be part of a point's name; allowed: numbers, and "
                "text of letters, digits and _ . + -"
            )
        if text in seen:
            raise UserError(
                f"{key}: {seen[text]!r} and {label!r} are both named {text!r}; need values whose "
                "first six digits differ, none twice"
            )
        seen[text] = label
    if not labels:
        raise UserError(f"{key}: need at least one value")


def _check_targets(described, key):
    """An axis that later ones undo: what its label says would not be so.

    A map of labels may set defaults, some of which a later axis changes.
    """
    names = list(described)
    targets = {name: _targets(described[name]) for name in names}
    for place, name in enumerate(names):
        for other in names[place + 1 :]:
            undone = {one for one in targets[name] if any(_meet(one, it) for it in targets[other])}
            default = isinstance(described[name]["values"], dict) and undone < targets[name]
            if undone and not default:
                raise UserError(
                    f"{key}.axes.{other}: sets {'.'.join(min(undone))}, as the axis {name!r} does, "
                    "and would undo it; let each key have one axis"
                )


def _meet(one, other):
    """Whether one of two keys is the other, or lies inside of it."""
    shorter = min(len(one), len(other))
    return one[:shorter] == other[:shorter]


def _targets(rule):
    """Keys that an axis sets, each as a tuple of its parts."""
    if not isinstance(rule["values"], dict):
        given = rule.get("set", [])
        return {tuple(one.split(".")) for one in ([given] if isinstance(given, str) else given)}
    changes = (change for change in rule["values"].values() if change)  # a label may change nothing
    return {leaf for change in changes for leaf in _leaves(change, ())}


def _leaves(change, inside):
    """Keys of nested dicts that hold something else."""
    if isinstance(change, dict) and change:
        for part, value in change.items():
            yield from _leaves(value, (*inside, str(part)))
    else:
        yield inside


def check_blocks(scene: dict[str, Any], where: str) -> None:
    """Refuse what is no mapping where one is read or completed before the scene is checked."""
    for key in ("steps", "duration", "start"):
        block = scene.get(key, {})
        if not isinstance(block, dict):
            raise UserError(
                f"{where}: {key}: {shown(block)} is not of type object (keys and values)"
            )
    for key in ("steps", "duration"):
        for part, value in scene.get(key, {}).items():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value <= LONGEST:
                raise UserError(
                    f"{where}: {key}.{part}: {shown(value)} is out of range; allowed: 0 to "
                    f"{LONGEST:.0e}"
                )
    if isinstance(scene.get("seed", 1), bool) or not isinstance(scene.get("seed", 1), int):
        raise UserError(f"{where}: seed: {shown(scene['seed'])} is not of type integer")


def fixed(scene: Scene) -> Scene:
    """The scene, if it names its scheme: the points of a sweep must be comparable."""
    if scene.is_auto:
        raise UserError(
            f"{scene.where}: integrator.scheme: 'auto' is for scenes of your own (python -m dpd "
            "run), which says what it takes; in a sweep name scheme and dt"
        )
    return scene
