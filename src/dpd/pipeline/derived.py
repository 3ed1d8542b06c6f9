"""Values of a scene that another sweep measures first, as bonds at rest at twice the core radius.

A plan holds stand-ins for them. `dpd derive` writes what they came to, and whatever reads or makes
a run puts that into its scene.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from dpd import files
from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.start import start_digest, start_is_shared

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from dpd.pipeline.sweep import Sweep

COLUMNS = ("point", "key", "value", "from")


def write_derived(rows: Iterable[Mapping[str, str]], path: str | Path) -> None:
    """Write derived values as a table that a person can read; rows have the keys `COLUMNS`."""

    def fill(draft):
        with open(draft, "w", newline="") as file:
            table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            table.writeheader()
            table.writerows(rows)

    files.replace_whole(path, fill)


def read_derived(path: str | Path) -> dict[str, dict[str, float]]:
    """Derived values: name of the point to key to value."""
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
    """A sweep with its derived values, a table of `write_derived`, in place of the stand-ins.

    Raises `UserError` if a value is missing, or would change a start that runs share.
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
