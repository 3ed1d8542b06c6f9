"""Phases of block copolymers, by the peaks of the structure factor.

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
from typing import NamedTuple

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.structure import blocks_of

ORDERED = 0.05  # strength of the strongest wave vector, from which on there is order
ALIKE = 0.25  # of the strongest one's strength, from which on another is of first order too
RISES = 1.2  # factor by which a peak of higher order stands above the others of its length
ABOUT_AS_LONG = 0.05  # share of |q| within which wave vectors are about as long
ENOUGH = 4  # of these, without which it cannot be said that a peak stands above them
STRAINED = 0.15  # share by which first-order vectors may differ in length, as a box is no crystal
SIGNS = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (1, -1, -1)])  # of three vectors
LAMELLAE, CYLINDERS, DISORDERED, NONE = "lamellae", "cylinders", "disordered", "none"


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
    if "scene" in runs.attrs:
        runs = runs.expand_dims("replica").assign(scene=runs.attrs["scene"])
    scene = first_scene(runs)
    beads = int((scene.kinds == scene.species.index(species)).sum())
    pair = list(runs.species_pair.values.ravel()).index(f"{species} {species}")
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
