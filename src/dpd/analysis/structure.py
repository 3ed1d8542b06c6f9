"""What g(r) says: the place of its first peak, and how close beads come."""

import numpy as np

from dpd.analysis.statistics import block_mean_and_error

AROUND = 0.15  # r_c on either side of the highest bin, for the cubic through a peak
GROUPS = 10  # of blocks, left out in turn


def jackknife(blocks, function):
    """A function of the mean over blocks, and its standard error by leaving out groups.

    Parameters
    ----------
    blocks : (n, ...) array
    function : callable
        Of a (...) array.

    Returns
    -------
    value, error : float
    """
    count = min(GROUPS, len(blocks))
    groups = np.array_split(np.arange(len(blocks)), count)
    left_out = np.array(
        [function(np.delete(blocks, group, axis=0).mean(axis=0)) for group in groups]
    )
    spread = ((left_out - left_out.mean()) ** 2).sum()
    return float(function(blocks.mean(axis=0))), float(np.sqrt((count - 1) / count * spread))


def peak(r, g):
    """Distance of the maximum of g(r): of a cubic through the bins around the highest.

    A parabola is not enough: the peak is steeper on its near side, and its place would move
    with the width of the fit.
    """
    highest = r[np.argmax(g)]
    near = np.abs(r - highest) <= AROUND
    cubic, square, slope, _ = np.polyfit(r[near] - highest, g[near], 3)
    # The root of 3 c x^2 + 2 s x + b at which the second derivative is negative.
    return highest - slope / (square - np.sqrt(square**2 - 3 * cubic * slope))


def contact(r, g):
    """Lower edge of the first bin of g(r) that is not empty; NaN if all are."""
    seen = np.flatnonzero(g > 0)
    return r[seen[0]] - 0.5 * (r[1] - r[0]) if len(seen) else np.nan


def rise(r, g, level=0.05):
    """Distance at which g(r) first reaches a level, between bins by a straight line."""
    above = int(np.argmax(g >= level))
    if above == 0:
        return float(r[0])
    low, high = g[above - 1], g[above]
    return float(r[above - 1] + (level - low) / (high - low) * (r[above] - r[above - 1]))


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
