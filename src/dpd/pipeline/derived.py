"""Values of a scene that another sweep measures first, as bonds at rest at twice the core radius.

A plan holds stand-ins for them. `dpd derive` writes what they came to, and whatever reads or makes
a run puts that into its scene.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from dpd.errors import UserError
from dpd.scene.scene import Scene
from dpd.scene.yaml import changed
from dpd.start import start_digest, start_is_shared

if TYPE_CHECKING:
    from dpd.pipeline.sweep import Sweep


def resolved(sweep: Sweep, path: str | Path | None) -> Sweep:
    """A sweep with its derived values, a table of `dpd derive`, in place of the stand-ins.

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
    if not Path(path).is_file():
        raise UserError(f"{path}: there is no such file; let snakemake make it, or `dpd derive`")
    anew = "delete the file and let snakemake make it again"
    try:
        with open(path, newline="") as file:
            rows = {(row["point"], row["key"]): row["value"] for row in csv.DictReader(file)}
        values = {place: float(text) for place, text in rows.items()}
    except (KeyError, TypeError, ValueError):
        raise UserError(f"{path}: not a table of points, keys and values; {anew}") from None
    points = []
    for point in sweep.points:
        data, where = point.scene.data, point.scene.where
        for rule in sweep.derived:
            if (point.name, rule.key) not in values:
                raise UserError(f"{path}: no value of {rule.key} for {point.name}; {anew}")
            data = changed(data, {rule.key: values[point.name, rule.key]}, where)
        scene = Scene(data, where)
        if start_is_shared(point.scene) and start_digest(scene) != start_digest(point.scene):
            keys = ", ".join(rule.key for rule in sweep.derived)
            raise UserError(
                f"{where}: derive: {keys} changes the first configuration, which is made before; "
                "give start.forces a value of its own"
            )
        points.append(replace(point, scene=scene))
    return replace(sweep, points=tuple(points))
