"""Fluids at rest: g(r), its first peak, how close beads come; excess pressure; ordered phases.

The phase of a block copolymer is named by the peaks of its structure factor. In an ordered phase
the density of a species a is a crystal on the scale of the chains. Then the amplitude |rho_a(q)| /
N_a at some wave vectors of the box is a large number, which does not fall with the size of the box.
Its square S_aa(q) / N_a is called the *strength* of q here: 0 to 1, and about 1 / N_a where there
is no order. The first-order vectors of a phase are the strongest ones, and its higher orders stand
at whole-numbered sums of them:

- lamellae have one vector q1, and peaks at 1 : 2 : 3 (of layers of equal thickness at 1 : 3);
- hexagonally packed cylinders (in two dimensions, discs) have three, at 60 degrees to each other
  in a plane, and peaks at 1 : sqrt(3) : 2 : sqrt(7).

A peak of higher order may be far weaker than the first, and in a small box little above the noise
of the beads. So it counts where it stands above every other wave vector of about its length, and
where there are enough of those: noise alone stands above n others with a chance of 1 / (n + 1) in a
single look, and the more rarely the more looks are averaged. (Of made-up runs with first-order
vectors and noise alone, 1 in 20 is named if it averages 10 independent looks, 1 in 100 with 40.)

This is how Groot and Madden, J. Chem. Phys. 108, 8713 (1998), name the phases of A_m B_n. The
limits below are ours. For sharp interfaces q1 has the strength 0.41 in symmetric lamellae and 0.30
in cylinders that fill 0.3 of the volume; fluctuations take a part of that. Where no rule fits, the
phase is called "none": it may be another one, as spheres or a gyroid, or not have settled. Layers
with holes, and two liquids in slabs, are lamellae here: look at the density field as well.
"""

from __future__ import annotations

from itertools import permutations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import block_mean_and_error, over_replicas
from dpd.errors import UserError, suggestion
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


FLANK = 4.0  # over and under a level, what counts as near it
AROUND = 0.15  # r_c on either side of a peak, for the cubic through it
TURNS, CLOSE = 50, 1e-7  # of the fit about its own maximum, until that moves by less, in r_c
LEAST_BINS = 8  # that a cubic is laid through
SHARE = 2 / 3  # of the way from a peak to a kink of g(r): as far as a cubic may reach
CONTACT_BEADS = 20_000  # in whose configurations closest contacts are defined
DIGITS = 6  # of a derived value: rounding must not make runs anew
ORDERED = 0.05  # strength of the strongest wave vector, from which on there is order
ALIKE = 0.25  # of the strongest one's strength, from which on another is of first order too
RISES = 1.2  # factor by which a peak of higher order stands above the others of its length
ABOUT_AS_LONG = 0.05  # share of |q| within which wave vectors are about as long
ENOUGH = 4  # of these, without which it cannot be said that a peak stands above them
STRAINED = 0.15  # share by which first-order vectors may differ in length, as a box is no crystal
SIGNS = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (1, -1, -1)])  # of three vectors
LAMELLAE, CYLINDERS, DISORDERED, NONE = "lamellae", "cylinders", "disordered", "none"


def peak(r: np.ndarray, g: np.ndarray, kink: float = 0.0, share: float = SHARE) -> float:
    """Distance of the maximum of g(r): of a cubic through the (bins,) around it.

    The peak is steeper on its near side: the place of a parabola would move with the width of the
    fit. Bins about the maximum of the cubic count, not those about the highest bin, which noise
    decides; the farther they are the less.

    ``kink``: where g(r) has a kink below its peak, as at the edge of a rigid core: the fit reaches
    no farther than ``share`` of the way to it. Result: the highest bin where that leaves too few
    bins for a fit; NaN if the cubic has no maximum.
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


class Contact(NamedTuple):
    """The distance of closest contact, its standard error, and why it is none, if so."""

    value: float
    error: float
    undecided: str
    bin: float  # that distance as one reads it off g(r), to the width of a bin


def closest_contact(at: xr.Dataset) -> Contact:
    """2 r_0 in r_c, of Liu et al. 2008: how close beads come in one configuration.

    The lower edge of the first bin of g(r) that is not empty in one configuration, median over
    configurations, as of grouped data: within a bin, distances are taken as uniform. It depends on
    the number of beads, which is the paper's, 20 000. Its error is that of a median, which is that
    of a mean of normal values times sqrt(pi / 2), and of counts if all lie in one bin.

    ``at``: one point of a collected sweep with ``rdf``, a block for each configuration.
    """
    r = at.r.values
    width = r[1] - r[0]
    found = np.array([contact(r, block) for block in blocks_of(at.rdf)])
    _, of_mean = block_mean_and_error(found)
    error = np.hypot(np.sqrt(np.pi / 2) * of_mean, width / np.sqrt(4 * len(found)))
    middle = np.median(found)
    below, inside = np.mean(found < middle - width / 4), np.mean(abs(found - middle) < width / 4)
    # No value is inside where the median of an even number lies between two bins.
    value = middle + width * ((0.5 - below) / inside - 0.5) if inside else middle
    beads = int(at.beads.max())
    reason = f"2 r_0 is of {CONTACT_BEADS} beads, these runs have {beads}"
    undecided = "" if beads == CONTACT_BEADS else reason
    return Contact(float(value), float(error), undecided, float(middle))


def derive(sweep: Any, sources: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Derived values of a `dpd.pipeline.sweep.Sweep`; as CSV what `resolved` there reads.

    ``sources``: the sweeps, collected or calculated, that ``sweep.derived`` names.
    """
    names = [axis.name for axis in sweep.axes[:-1]]
    rows = []
    for point in sweep.points:
        for rule in sweep.derived:
            source = sources[rule.source]
            at = source.sel({n: v for n, v in zip(names, point.labels) if n in source.dims})
            try:
                value = _measured(at, rule.quantity)
            except UserError as problem:
                raise UserError(f"sweep {rule.source}: {problem}") from None
            said = f"{rule.quantity} of {rule.source}"
            rows.append((point.name, rule.key, f"{value:.{DIGITS}g}", said))
    return pd.DataFrame(rows, columns=["point", "key", "value", "from"])


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
        return closest_contact(at).bin  # as the paper reads it
    numbers = [name for name in at.data_vars if not at[name].dims]
    if quantity not in numbers:
        raise UserError(f"no number {quantity!r} is calculated; {suggestion(quantity, numbers)}")
    return float(at[quantity])


def rise(r: np.ndarray, g: np.ndarray, level: float = 0.05) -> float:
    """Distance at which g(r) first reaches a level, by `on_flank`."""
    above = int(np.argmax(g >= level))
    return float(r[0]) if above == 0 else on_flank(r, g, above - 1, above, level)


def fall(length: np.ndarray, density: np.ndarray, level: float = 0.05) -> float:
    """Length at which a density last falls to a level; NaN where it does not within the bins."""
    last = int(np.flatnonzero(density >= level)[-1])
    return np.nan if last + 1 == len(density) else on_flank(length, density, last, last + 1, level)


def on_flank(x: np.ndarray, y: np.ndarray, left: int, right: int, level: float) -> float:
    """Where a flank has a level, given the bins on either side of it.

    Flanks of g(r) and of bond lengths are Boltzmann factors of forces that are linear, so ln y is
    fitted with a parabola, over the bins on that flank whose y is within a factor `FLANK` of the
    level, weighted by y, as counts are. With fewer than five of them ln y is taken as straight
    between the two bins, and where one of those is empty, y is.
    """
    far = np.flatnonzero((y <= level / FLANK) | (y >= level * FLANK))
    # The stretch about the level, without what lies within the factor elsewhere.
    low = max(far[far <= left], default=-1)
    high = min(far[far >= right], default=len(y))
    part = slice(low + 1, high)
    if high - low - 1 >= 5:
        middle = 0.5 * (x[left] + x[right])
        c, b, a = np.polyfit(
            x[part] - middle, np.log(y[part] / level), 2, w=np.sqrt(y[part] / level)
        )
        root = b**2 - 4 * c * a
        if b != 0 and root > 0:
            return float(middle - 2 * a / (b + np.copysign(np.sqrt(root), b)))
    y0, y1 = y[left], y[right]
    if min(y0, y1) > 0:
        y0, y1, level = np.log([y0, y1, level])
    return float(x[left] + (level - y0) / (y1 - y0) * (x[right] - x[left]))


class RadialDistribution(NamedTuple):
    """g(r) of the replicas of one point of a collected sweep."""

    g: Any  # (bins,)
    error: Any
    blocks: np.ndarray  # (blocks, bins)


def radial_distribution(runs: xr.Dataset) -> RadialDistribution:
    """g(r) of the replicas of one point of a collected sweep, its error, and its blocks."""
    blocks = blocks_of(runs.rdf)
    return RadialDistribution(*block_mean_and_error(blocks), blocks)


def blocks_of(variable: xr.DataArray, since: float = 0.0) -> np.ndarray:
    """Blocks of all replicas of one point, (blocks, ...); those that a run has not are left out.

    ``variable``: with the dimensions replica and block, or block_18 or the like where observables
    of a run differ in their number. ``since``: share of them that is left out at the beginning.
    """
    axis = next(name for name in variable.dims if str(name).startswith("block"))
    late = variable.isel({axis: slice(int(since * variable.sizes[axis]), None)})
    blocks = late.stack(part=("replica", axis)).transpose("part", ...).values
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


class Order(NamedTuple):
    """Peaks of one order of a phase."""

    ratio: float  # of the mean length of its wave vectors to that of the first order
    strength: float  # mean over them
    # Largest of the wave vectors about as long that belong to no order; NaN below `ENOUGH` of them.
    others: float

    @property
    def is_peak(self) -> bool:
        return bool(self.strength > RISES * self.others)


class Phase(NamedTuple):
    """What a structure factor says of a phase."""

    # lamellae, cylinders (in two dimensions, hexagonally packed discs), disordered or none
    name: str
    reason: str  # in a sentence
    # (n, dimension), the first-order wave vectors, the strongest first; none if disordered
    first: np.ndarray
    orders: tuple[Order, ...]  # those that the name rests on, the first order first
    spacing: float  # of layers, or of neighbouring cylinders, in r_c; NaN for other phases


class Strengths(NamedTuple):
    """Wave vectors, (n, dimension), one of each q and -q, and the strength of each, (n,)."""

    vectors: np.ndarray
    strength: np.ndarray


def strengths_of(runs: xr.Dataset, species: str, after: float = 0.5) -> Strengths:
    """The strengths of one species in a run, or in the replicas of one point of a sweep.

    Replicas have their crystals in different directions, so name the phase of one at a time.
    ``runs``: with ``structure_factor``. ``after``: share of the run that is left out at its
    beginning.
    """
    single = "scene" in runs.attrs
    scene = Scene.of_result(runs.attrs["scene"], "run") if single else first_scene(runs)
    beads = int((scene.kinds == scene.species.index(species)).sum())
    pair = list(runs.species_pair.values.ravel()).index(f"{species} {species}")
    if single:
        runs = runs.expand_dims("replica")
    settled = slice(int(after * runs.sizes["block"]), None)
    blocks = blocks_of(runs.structure_factor_wave.isel(species_pair=pair, block=settled))
    vectors = runs.wave_vector.values.reshape(-1, scene.dimension)[: runs.sizes["wave"]]
    return Strengths(vectors, blocks.mean(axis=0) / beads)


def phase_of(found: Strengths) -> Phase:
    """Name the phase by the species that makes the domains.

    Averaged over a time in which they stood still, and over ten independent looks or more: in a
    single one some wave vector may by chance stand above all others of its length.
    """
    strongest = found.strength.max()
    nowhere = np.empty((0, 0))
    if not np.isfinite(strongest):
        return Phase(NONE, "there are no samples", nowhere, (), np.nan)
    if strongest < ORDERED:
        reason = f"the strongest wave vector has {strongest:.2g}, below {ORDERED:g}"
        return Phase(DISORDERED, reason, nowhere, (), np.nan)
    first = _first_order(found)
    if len(first) == 1:
        return _lamellae(found, first)
    if len(first) == 3:
        return _cylinders(found, first)
    return _unnamed(first, f"{len(first)} wave vectors are about as strong as the strongest")


def _unnamed(first, reason):
    return Phase(NONE, reason, first, (), np.nan)


def _first_order(found):
    """The strongest wave vectors, less those that are twice or three times another one."""
    order = np.argsort(-found.strength, kind="stable")
    strong = order[found.strength[order] >= ALIKE * found.strength[order[0]]]
    vectors = found.vectors[strong]
    multiples = [_same(vectors[:, None], factor * vectors).any(axis=1) for factor in (2, 3)]
    return vectors[~np.any(multiples, axis=0)]


def _lamellae(found, first):
    orders = _orders(found, first, [[[factor]] for factor in (1, 2, 3)])
    seen = _peaks(orders)
    if not seen:
        return _unnamed(first, "one wave vector is strong, without a peak at 2 or 3 times it")
    spacing = 2 * np.pi / np.linalg.norm(first[0])
    return Phase(LAMELLAE, f"peaks along one direction at {seen}", first, orders, float(spacing))


def _peaks(orders):
    """The ratios of the first order and of the peaks above it; nothing without any."""
    higher = [order for order in orders[1:] if order.is_peak]
    return " : ".join(f"{order.ratio:.3g}" for order in (orders[0], *higher)) if higher else ""


def _cylinders(found, first):
    lengths = np.linalg.norm(first, axis=1)
    signs = next((s for s in SIGNS if _same(s @ first, 0 * first[0])), None)
    if signs is None or lengths.max() > (1 + STRAINED) * lengths.min():
        return _unnamed(first, "three wave vectors are strong, which are not at 60 degrees")
    one, two, three = signs[:, None] * np.eye(3)  # whose sum is zero
    apart = [one - two, two - three, three - one]
    far = [2 * a - b for a, b in permutations((one, two, three), 2)]
    orders = _orders(found, first, [np.eye(3), apart, 2 * np.eye(3), far])
    seen = _peaks(orders)
    if not seen:
        why = "three vectors at 60 degrees are strong, without peaks at sqrt(3), 2 or sqrt(7)"
        return _unnamed(first, why)
    spacing = 4 * np.pi / (np.sqrt(3) * lengths.mean())
    return Phase(CYLINDERS, f"hexagonal peaks at {seen}", first, orders, float(spacing))


def _orders(found, first, sums_of_orders):
    """Each order whose wave vectors, sums of the first ones, are all known."""
    places = [
        [_place(found, np.asarray(numbers) @ first) for numbers in several]
        for several in sums_of_orders
    ]
    own = {place for several in places for place in several if place is not None}
    return tuple(_order(found, several, own, first) for several in places if None not in several)


def _order(found, places, own, first):
    length = np.linalg.norm(found.vectors, axis=1)
    mean = length[places].mean()
    others = np.setdiff1d(np.flatnonzero(np.abs(length / mean - 1) < ABOUT_AS_LONG), list(own))
    highest = float(found.strength[others].max()) if len(others) >= ENOUGH else np.nan
    ratio = float(mean / np.linalg.norm(first, axis=1).mean())
    return Order(ratio, float(found.strength[places].mean()), highest)


def _place(found, vector):
    """The number of a wave vector, or of its opposite; None if it is longer than the longest."""
    same = np.flatnonzero(_same(found.vectors, vector))
    return int(same[0]) if len(same) else None


def _same(one, other):
    """Whether wave vectors, (..., dimension), are others, or the opposite of those."""
    apart = [np.abs(one - sign * other).max(axis=-1) for sign in (1, -1)]
    return np.minimum(*apart) < 1e-6
