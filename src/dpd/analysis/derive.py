"""Derived values of a sweep's scenes, from the sweeps that measure them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.analysis.collect import first_scene
from dpd.analysis.structure import closest_contact
from dpd.errors import UserError, suggestion

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

    from dpd.analysis.collect import Sweep

DIGITS = 6  # of a value: rounding must not make runs anew


def _closest_contact(at):
    """2 r_0, refused where g(r) does not keep single configurations."""
    scene = first_scene(at)
    samples = scene.steps.sample // scene.observe["rdf"].every
    if samples != at.sizes["block"]:
        raise UserError(
            f"observe.rdf.every: {samples} configurations in {at.sizes['block']} blocks; "
            "closest_contact looks at single ones: sample at most that many"
        )
    return closest_contact(at).bin  # as the paper reads it


QUANTITIES = {"closest_contact": _closest_contact}  # those of `dpd.pipeline.paper.MEASURED`


def axes_of(source: xr.Dataset) -> tuple[str, ...]:
    """Names of the axes of a sweep that was collected or calculated."""
    dims = source["point_digest" if "point_digest" in source else "kT"].dims
    return tuple(map(str, dims))


def _value(at, quantity):
    """What one point of a sweep has measured or calculated."""
    if "point_digest" not in at:
        return QUANTITIES[quantity](at)
    numbers = [name for name in at.data_vars if name != "point_digest" and not at[name].dims]
    if quantity not in numbers:
        raise UserError(f"no number {quantity!r} is calculated; {suggestion(quantity, numbers)}")
    return float(at[quantity])


def derive(sweep: Sweep, sources: Mapping[str, xr.Dataset]) -> list[dict[str, str]]:
    """Derived values of all points of a sweep, see `dpd.pipeline.derived.write_derived`.

    ``sources``: collected sweeps, those that ``sweep.derived`` names.
    """
    names = [axis.name for axis in sweep.axes[:-1]]
    rows = []
    for point in sweep.points:
        for rule in sweep.derived:
            source = sources[rule.source]
            place = {n: v for n, v in zip(names, point.labels) if n in source.dims}
            # What is left are axes of one value, and replicas.
            at = source.sel(place)
            at = at.isel({d: 0 for d in axes_of(source) if d in at.dims and d != "replica"})
            try:
                value = _value(at, rule.quantity)
            except UserError as problem:
                raise UserError(f"sweep {rule.source}: {problem}") from None
            rows.append({
                "point": point.name,
                "key": rule.key,
                "value": f"{value:.{DIGITS}g}",
                "from": f"{rule.quantity} of {rule.source}",
            })  # fmt: skip
    return rows
