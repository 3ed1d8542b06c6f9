"""What g(r) says: the place of its first peak, and how close beads come."""

from typing import NamedTuple

import numpy as np

from dpd.analysis.statistics import block_mean_and_error, jackknife

AROUND = 0.15  # r_c on either side of the highest bin, for the cubic through a peak
LEAST_BINS = 8  # that a cubic is laid through
SHARE = 2 / 3  # of the way from a peak to a kink of g(r): as far as a cubic may reach


def peak(r, g, kink=0.0, share=SHARE):
    """Distance of the maximum of g(r): of a cubic through the bins around the highest.

    A parabola is not enough: the peak is steeper on its near side, and its place would move
    with the width of the fit.

    Parameters
    ----------
    r, g : (bins,) arrays
    kink : float
        Where g(r) has a kink below its peak, as at the edge of a rigid core, where the force jumps:
        the fit keeps away from it.
    share : float
        Of the way from the highest bin to the kink: the fit reaches no farther.

    Returns
    -------
    float
        The highest bin where the kink leaves too few bins for a fit; NaN if the cubic has no
        maximum.
    """
    highest = r[np.argmax(g)]
    near = np.abs(r - highest) <= min(AROUND, share * (highest - kink))
    if near.sum() < LEAST_BINS:
        return float(highest)
    cubic, square, slope, _ = np.polyfit(r[near] - highest, g[near], 3)
    # The root of 3 c x^2 + 2 s x + b at which the second derivative is negative.
    inside = square**2 - 3 * cubic * slope
    return highest - slope / (square - np.sqrt(inside)) if inside >= 0 else np.nan


def contact(r, g):
    """Lower edge of the first bin of g(r) that is not empty; NaN if all are."""
    seen = np.flatnonzero(g > 0)
    return r[seen[0]] - 0.5 * (r[1] - r[0]) if len(seen) else np.nan


CONTACT_BEADS = 20_000  # in whose configurations closest contacts are defined


class Contact(NamedTuple):
    """The distance of closest contact, its uncertainty, one bin, and why it is none, if so."""

    value: float
    bin: float
    undecided: str


def closest_contact(at):
    """2 r_0 of Liu et al. 2008: how close beads come in one configuration.

    The lower edge of the first bin of g(r) that is not empty in one configuration, median over
    configurations. It depends on the number of beads, which is the paper's, 20 000, and on the
    bins, which are 0.01 r_c wide: one bin is its uncertainty.

    Parameters
    ----------
    at : xarray.Dataset
        One point of a collected sweep with ``rdf``, a block for each configuration.

    Returns
    -------
    Contact
        In r_c.
    """
    r = at.r.values
    found = [contact(r, block) for block in blocks_of(at.rdf)]
    beads = int(at.beads.max())
    reason = f"2 r_0 is of {CONTACT_BEADS} beads, these runs have {beads}"
    undecided = "" if beads == CONTACT_BEADS else reason
    return Contact(float(np.median(found)), float(r[1] - r[0]), undecided)


def rise(r, g, level=0.05):
    """Distance at which g(r) first reaches a level, between bins by `crossing`."""
    above = int(np.argmax(g >= level))
    if above == 0:
        return float(r[0])
    return crossing(r[above - 1], g[above - 1], r[above], g[above], level)


def fall(length, density, level=0.05):
    """Length at which a density last falls to a level, between bins by `crossing`.

    NaN where it does not fall within the bins.
    """
    last = int(np.flatnonzero(density >= level)[-1])
    if last + 1 == len(density):
        return np.nan
    return crossing(length[last], density[last], length[last + 1], density[last + 1], level)


def crossing(x0, y0, x1, y1, level):
    """Where a flank between two bins has a level.

    Flanks of g(r) and of bond lengths are Boltzmann factors, so ln y is taken as straight: y
    as straight would be off by a few 1e-4 r_c. Where one bin is empty, y is.
    """
    if min(y0, y1) > 0:
        y0, y1, level = np.log([y0, y1, level])
    return float(x0 + (level - y0) / (y1 - y0) * (x1 - x0))


def criterion(at):
    """r_min and l_max of Nikunen et al. 2007, Eq. 5, each with its standard error.

    Parameters
    ----------
    at : xarray.Dataset
        One point of a collected sweep with ``rdf`` and ``bonds``.

    Returns
    -------
    (r_min, error), (l_max, error)
        In r_c, by leaving out blocks.
    """
    r, length = at.r.values, at.bond_length.values
    return (
        jackknife(blocks_of(at.rdf), lambda mean: rise(r, mean)),
        jackknife(blocks_of(at.bond_density), lambda mean: fall(length, mean)),
    )


def contact_over_sampling(r, blocks, samples):
    """How the distance of closest contact falls as more is sampled.

    Parameters
    ----------
    r : (bins,) array
    blocks : (n, bins) array
        g(r) in blocks.
    samples : float
        Bead-samples in one block.

    Returns
    -------
    (m,) array
        Bead-samples: one block, two, four, ... all.
    (m,) array
        `contact` of so many blocks, mean over all that there are without overlap.
    (m,) array
        Its standard error; NaN where there is only one.
    """
    counts, means, errors = [], [], []
    size = 1
    while size <= len(blocks):
        together = len(blocks) // size
        parts = blocks[: together * size].reshape(together, size, -1).mean(axis=1)
        found = np.array([contact(r, part) for part in parts])
        counts.append(size * samples)
        means.append(found.mean())
        errors.append(found.std(ddof=1) / np.sqrt(together) if together > 1 else np.nan)
        size *= 2
    return np.array(counts), np.array(means), np.array(errors)


def radial_distribution(runs):
    """g(r) of the replicas of one point, its standard error, and its blocks.

    Parameters
    ----------
    runs : xarray.Dataset
        One point of a collected sweep, with the dimension ``replica``.
    """
    blocks = blocks_of(runs.rdf)
    return (*block_mean_and_error(blocks), blocks)


def blocks_of(variable):
    """Blocks of all replicas of one point, (blocks, ...); those that a run has not are left out."""
    blocks = variable.stack(part=("replica", "block")).transpose("part", ...).values
    return blocks[np.isfinite(blocks).all(axis=tuple(range(1, blocks.ndim)))]
