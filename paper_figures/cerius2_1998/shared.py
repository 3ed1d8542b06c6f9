"""What figures of the manual of 1998 share: densities as pictures, and error bars of profiles."""

import numpy as np

from dpd.analysis.statistics import block_mean_and_error
from dpd.report.draw_fields import draw_bodies, points_along, smoothed, triangles_around

SMOOTH = 0.5  # r_c over which densities are averaged for a picture


def profile_and_errors(blocks):
    """Means of the bins of a profile over blocks, and standard errors that vary smoothly.

    How long a bin remembers cannot be told from the blocks of one run bin by bin: it scatters, and
    shows as spikes. So all bins have the median of what their correlations make of their errors;
    NaN where most of them are not known.

    ``blocks``: (n, ..., bins) array. Returns ``mean``, ``error``: (..., bins) arrays.
    """
    mean, error = block_mean_and_error(blocks)
    alone = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
    longer = np.divide(error, alone, out=np.full(error.shape, np.nan), where=alone > 0)
    longer = np.nanmedian(np.where(np.isnan(error), np.inf, longer), axis=-1, keepdims=True)
    return mean, alone * np.where(np.isfinite(longer), longer, np.nan)


def draw_isodensity(axes, density, value, edges, color):
    """Draw the bodies in the box that are denser than a value.

    ``density``: (nx, ny, nz) array. ``edges``: (3,) array; of the box in r_c.
    """
    field = smoothed(density, edges, points_along(edges), SMOOTH)
    draw_bodies(axes, [(triangles_around(field, value, edges), color)], edges)
