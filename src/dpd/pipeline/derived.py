"""Values of a scene that another sweep measures first, as bonds at rest at twice the core radius.

A plan holds stand-ins for them. `dpd derive` writes what they came to, and whatever reads or makes
a run puts that into its scene.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dpd import files
from dpd.errors import UserError, suggestion
from dpd.scene.scene import Scene
from dpd.start import start_digest, start_is_shared

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from dpd.pipeline.sweep import Sweep

MEASURED = ("closest_contact",)  # of a sweep that is simulated, see `dpd.analysis.derive`
COLUMNS = ("point", "key", "value", "from")


def check_derived(
    name: str, given: dict[str, Any], axes: dict[str, dict[str, Any]], where: str
) -> None:
    """Refuse rules that name what is not there.

    Parameters
    ----------
    name : str
        The sweep whose rules these are.
    given : dict
        All sweeps of the paper, as its file has them.
    axes : dict
        Of each sweep: its axes with the values of the study.
    where : str
        File and key to name in messages.

    Raises
    ------
    UserError
        If a source is no sweep, is derived itself, shares no axis, lacks a value of a shared axis
        or has another axis of several values; or if the scene has no such key.
    """
    for key, rule in given[name].get("derive", {}).items():
        there, source = f"{where}.{key}", rule["from"]
        if source not in given:
            raise UserError(f"{there}.from: no sweep {source!r}; {suggestion(source, given)}")
        quantity = rule["quantity"]
        if "theory" not in given[source] and quantity not in MEASURED:
            raise UserError(
                f"{there}.quantity: no quantity {quantity!r}; {suggestion(quantity, MEASURED)}"
            )
        if given[source].get("derive"):
            raise UserError(
                f"{there}.from: {source!r} has derived values itself; name a sweep that has none"
            )
        if not _has(given[name]["scene"], key):
            raise UserError(
                f"{there}: the sweep's scene has no such key; give it there with a value to plan "
                "with, or correct the key"
            )
        shared = [axis for axis in axes[name] if axis in axes[source]]
        if not shared:
            raise UserError(
                f"{there}.from: {source!r} shares no axis with {name!r}; its axes: "
                f"{', '.join(axes[source]) or 'none'}"
            )
        for axis, described in axes[source].items():
            there_are = list(described["values"])
            if axis not in shared and len(there_are) > 1:
                raise UserError(
                    f"{there}.from: {source!r} has several values on the axis {axis!r}, which "
                    f"{name!r} has not; give it one"
                )
            for value in axes[name][axis]["values"] if axis in shared else ():
                if value not in there_are:
                    raise UserError(
                        f"{there}.from: {source!r} has no {axis} {value}, which {name!r} needs; "
                        f"it has {', '.join(map(str, there_are))}; add it there"
                    )


def _has(scene, key):
    """Whether a scene has a key of dotted parts."""
    for part in key.split("."):
        if not isinstance(scene, dict) or part not in scene:
            return False
        scene = scene[part]
    return True


def write_derived(rows: Iterable[Mapping[str, str]], path: str | Path) -> None:
    """Write derived values as a table that a person can read.

    Parameters
    ----------
    rows : list of dict
        With the keys `COLUMNS`.
    path : path
    """

    def fill(draft):
        with open(draft, "w", newline="") as file:
            table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            table.writeheader()
            table.writerows(rows)

    files.replace_whole(path, fill)


def read_derived(path: str | Path) -> dict[str, dict[str, float]]:
    """Derived values: name of the point to key to value.

    Raises
    ------
    UserError
        If the file is missing or is no such table.
    """
    if not Path(path).is_file():
        raise UserError(f"{path}: there is no such file; let snakemake make it, or `dpd derive`")
    values = {}  # type: dict[str, dict[str, float]]
    try:
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                values.setdefault(row["point"], {})[row["key"]] = float(row["value"])
    except (KeyError, TypeError, ValueError):
        raise UserError(
            f"{path}: not a table of {', '.join(COLUMNS)} with numbers as values; delete it and "
            "let snakemake make it again"
        ) from None
    return values


def resolved(sweep: Sweep, path: str | Path | None) -> Sweep:
    """A sweep with its derived values in place of the stand-ins.

    Parameters
    ----------
    sweep : dpd.pipeline.sweep.Sweep
    path : path or None
        From `write_derived`; not looked at where nothing is derived.

    Returns
    -------
    dpd.pipeline.sweep.Sweep

    Raises
    ------
    UserError
        If the table or a value is missing, or would change a start that runs share.
    """
    if not sweep.derived:
        return sweep
    if path is None:
        keys = ", ".join(rule.key for rule in sweep.derived)
        raise UserError(
            f"sweep {sweep.name}: other sweeps measure {keys} for it; name the table that "
            "`dpd derive` writes: --derived FILE"
        )
    values = read_derived(path)
    points = []
    for point in sweep.points:
        scene = point.scene.data
        for rule in sweep.derived:
            if rule.key not in values.get(point.name, {}):
                raise UserError(
                    f"{path}: no value of {rule.key} for the point {point.name}; delete the file "
                    "and let snakemake make it again"
                )
            scene = _with(scene, rule.key.split("."), values[point.name][rule.key])
        scene = Scene(scene, point.scene.where)
        if start_is_shared(point.scene) and start_digest(scene) != start_digest(point.scene):
            keys = ", ".join(rule.key for rule in sweep.derived)
            raise UserError(
                f"{point.scene.where}: derive: {keys} changes the first configuration, which is "
                "made before; give start.forces a value of its own"
            )
        points.append(replace(point, scene=scene))
    return replace(sweep, points=tuple(points))


def _with(scene, parts, value):
    """A scene with a value put under a key."""
    inner = value if len(parts) == 1 else _with(scene[parts[0]], parts[1:], value)
    return scene | {parts[0]: inner}
