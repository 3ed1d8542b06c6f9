"""Fluids at rest: g(r), its first peak, how close beads come; excess pressure; derived values."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import block_mean_and_error, over_replicas, taped
from dpd.errors import UserError, suggestion
from dpd.scene.scene import Scene
from dpd.scene.yaml import changed

FLANK = 4.0  # over and under a level, what counts as near it
AROUND = 0.15  # r_c on either side of a peak, for the cubic through it
TURNS, CLOSE = 50, 1e-7  # of the fit about its own maximum, until that moves by less, in r_c
LEAST_BINS = 8  # that a cubic is laid through
SHARE = 2 / 3  # of the way from a peak to a kink of g(r): as far as a cubic may reach
DIGITS = 6  # of a derived value: rounding must not make runs anew


def peak(r: np.ndarray, g: np.ndarray, kink: float = 0.0, share: float = SHARE) -> float:
    """Distance of the maximum of g(r): of a cubic through the (bins,) around it.

    The peak is steeper on its near side: the place of a parabola would move with the width of the
    fit. Bins about the maximum of the cubic count, as noise decides which is the highest.

    ``kink``: of g(r) below its peak, as at the edge of a rigid core: the fit reaches ``share`` of
    the way to it. Result: the highest bin where too few are left for a fit; NaN if the cubic has
    no maximum.
    """
    highest = middle = r[np.argmax(g)]
    for _ in range(TURNS):
        reach = min(AROUND, share * (middle - kink))
        near = np.abs(r - middle) < reach
        if near.sum() < LEAST_BINS:
            return float(highest)
        x = r[near] - middle
        cubic, square, slope, _ = np.polyfit(x, g[near], 3, w=1 - (x / reach) ** 2)
        # The root of 3 c x^2 + 2 s x + b at which the second derivative is negative.
        inside = square**2 - 3 * cubic * slope
        if inside < 0:
            return np.nan
        step = -slope / (square - np.sqrt(inside))
        middle += np.clip(step, -reach / 2, reach / 2)
        if abs(step) < CLOSE:
            break
    return float(middle)


def contact(r: np.ndarray, g: np.ndarray) -> float:
    """Lower edge of the first bin of g(r) that is not empty; NaN if all are."""
    seen = np.flatnonzero(g > 0)
    return r[seen[0]] - 0.5 * (r[1] - r[0]) if len(seen) else np.nan


@taped
def contacts(at: xr.Dataset) -> np.ndarray:
    """(configurations,) array: the `contact` of each, in r_c.

    ``at``: one point of a collected sweep with ``rdf``, a block for each configuration.
    """
    return np.array([contact(at.r.values, block) for block in blocks_of(at.rdf)])


def derive(sweep: Any, sources: Mapping[str, xr.Dataset]) -> Any:
    """A `dpd.pipeline.sweep.Sweep` with its derived values in the place of the stand-ins.

    ``sources``: the sweeps, collected or calculated, that ``sweep.derived`` names.
    """
    names = [axis.name for axis in sweep.axes[:-1]]
    points = []
    for point in sweep.points:
        data, where = point.scene.data, point.scene.where
        for key, rule in sweep.derived.items():
            source = sources[rule.from_]
            place = {n: v for n, v in zip(names, point.labels) if n in source.dims}
            try:
                value = _measured(source.sel(place), rule.quantity)
            except KeyError as missing:
                raise UserError(f"sweep {rule.from_}: has no {missing}; make it again") from None
            except UserError as problem:
                raise UserError(f"sweep {rule.from_}: {problem}") from None
            data = changed(data, {key: float(f"{value:.{DIGITS}g}")}, where)
        points.append(point._replace(scene=Scene(data, where)))
    return replace(sweep, points=tuple(points))


def _measured(at, quantity):
    """What one point of a sweep has measured or calculated; other axes have one value each."""
    calculated = "calculation" in at.attrs
    axes = at.axes.split() if calculated else at["kT"].dims
    at = at.isel({axis: 0 for axis in axes if axis in at.dims and axis != "replica"})
    if not calculated:  # `dpd.pipeline.paper.MEASURED` has no other quantity
        scene = first_scene(at)
        samples = scene.steps.sample // scene.observe["rdf"].every
        if samples != at.sizes["block"]:
            raise UserError(
                f"observe.rdf.every: {samples} configurations in {at.sizes['block']} blocks; "
                "closest_contact looks at single ones: sample at most that many"
            )
        return float(np.median(contacts(at)))  # 2 r_0, as Liu et al. 2008 read it
    numbers = [name for name in at.data_vars if not at[name].dims]
    if quantity not in numbers:
        raise UserError(f"no number {quantity!r} is calculated; {suggestion(quantity, numbers)}")
    return float(at[quantity])


def rise(r: np.ndarray, g: np.ndarray, level: float = 0.05) -> float:
    """Distance at which g(r) first reaches a level, by `on_flank`."""
    above = int(np.argmax(g >= level))
    return float(r[0]) if above == 0 else on_flank(r, g, above - 1, above, level)


def on_flank(x: np.ndarray, y: np.ndarray, left: int, right: int, level: float) -> float:
    """Where a flank has a level, given the bins on either side of it.

    Flanks of g(r) and of bond lengths are Boltzmann factors of linear forces, so ln y is fitted
    with a parabola over the bins there within a factor `FLANK` of the level, weighted as counts.
    With fewer than five ln y is taken as straight between the two bins, or y if one is empty.
    """
    far = np.flatnonzero((y <= level / FLANK) | (y >= level * FLANK))
    # The stretch about the level, without what lies within the factor elsewhere.
    low = max(far[far <= left], default=-1)
    high = min(far[far >= right], default=len(y))
    part = slice(low + 1, high)
    if high - low - 1 >= 5:
        middle = 0.5 * (x[left] + x[right])
        over = y[part] / level
        c, b, a = np.polyfit(x[part] - middle, np.log(over), 2, w=np.sqrt(over))
        root = b**2 - 4 * c * a
        if b != 0 and root > 0:
            return float(middle - 2 * a / (b + np.copysign(np.sqrt(root), b)))
    y0, y1 = y[left], y[right]
    if min(y0, y1) > 0:
        y0, y1, level = np.log([y0, y1, level])
    return float(x[left] + (level - y0) / (y1 - y0) * (x[right] - x[left]))


def radial_distribution(runs: xr.Dataset) -> tuple[Any, Any, np.ndarray]:
    """g(r) of the runs with ``rdf`` at one point of a collected sweep, (bins,), its error, blocks.

    Blocks are a (blocks, bins) array.
    """
    blocks = blocks_of(runs.rdf)
    return *block_mean_and_error(blocks), blocks


def blocks_of(variable: xr.DataArray, since: float = 0.0) -> np.ndarray:
    """Blocks of all replicas of one point, (blocks, ...); those that a run has not are left out.

    ``variable``: with the dimensions replica and block, or block_18 or the like where observables
    of a run differ in their number. ``since``: share of them that is left out at the beginning.
    """
    dims = [str(name)[:5] for name in variable.dims]
    blocks = np.moveaxis(variable.values, (dims.index("repli"), dims.index("block")), (0, 1))
    blocks = blocks[:, int(since * blocks.shape[1]) :].reshape(-1, *blocks.shape[2:])
    return blocks[np.isfinite(blocks).all(axis=tuple(range(1, blocks.ndim)))]


def excess_pressure(sweeps: Sequence[xr.Dataset], axis: str = "repulsion") -> xr.Dataset:
    """Excess pressure of several sweeps over an axis and density, as one dataset.

    ``axis``: ``repulsion``, or another one where all have the same repulsion. Result: ``excess``
    with ``excess_error``, NaN where no run was made; ``scaled`` and ``scaled_error`` are divided by
    a rho^2.
    """
    along, parts = (axis, "density"), []
    for sweep in sweeps:
        found = over_replicas(
            sweep.excess_conservative.values, sweep.excess_conservative_error.values, -1
        )
        named = {name: (along, each) for name, each in zip(("excess", "excess_error"), found)}
        parts.append(xr.Dataset(named, {name: sweep[name].astype(float) for name in along}))
    data = xr.concat(parts, axis, join="outer").sortby(axis)
    scene = first_scene(sweeps[0])
    repulsion = data.repulsion if axis == "repulsion" else scene.data["repulsion"]["A A"]
    scale = repulsion * data.density**2
    data["scaled"], data["scaled_error"] = data.excess / scale, data.excess_error / scale
    d = scene.dimension
    for name, unit in (("excess", f"kT / r_c^{d}"), ("scaled", f"r_c^{d + 1}")):
        data[name].attrs = {"units": unit, "long_name": f"{name} pressure, conservative virial"}
        data[f"{name}_error"].attrs = {"units": unit, "long_name": "standard error"}
    return data
