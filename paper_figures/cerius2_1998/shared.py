"""What figures of the manual of 1998 share: densities as pictures, and error bars of profiles."""

import numpy as np

from dpd.analysis.statistics import block_mean_and_error
from dpd.report.pictures.camera import camera_of, corners, seen
from dpd.report.pictures.frame import draw_edges
from dpd.report.pictures.layers import depth_of
from dpd.report.pictures.look import SMOOTH, Look
from dpd.report.pictures.smooth import middles, smoothed
from dpd.report.pictures.surfaces import draw_surfaces, field_at_points, surface_of
from dpd.report.style import BLACK, mpl

PIXELS = 120  # of a slice along an axis
SMOOTHED = f"smoothed over {SMOOTH:g} r_c"


def profile_and_errors(blocks):
    """Means of the bins of a profile over blocks, and standard errors that vary smoothly.

    How long a bin remembers cannot be told from the blocks of one run bin by bin: it scatters, and
    shows as spikes. So all bins have the median of what their correlations make of their errors;
    NaN where most of them are not known.

    Parameters
    ----------
    blocks : (n, ..., bins) array

    Returns
    -------
    mean, error : (..., bins) arrays
    """
    mean, error = block_mean_and_error(blocks)
    alone = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
    longer = np.divide(error, alone, out=np.full(error.shape, np.nan), where=alone > 0)
    longer = np.nanmedian(np.where(np.isnan(error), np.inf, longer), axis=-1, keepdims=True)
    return mean, alone * np.where(np.isfinite(longer), longer, np.nan)


def middle_slice(density, edges):
    """A density in the plane half way up the box, smoothed.

    Parameters
    ----------
    density : (nx, ny, nz) array
    edges : (3,) array
        Of the box in r_c.

    Returns
    -------
    (PIXELS, PIXELS) array
    """
    places = [middles(count, edge) for count, edge in zip((PIXELS, PIXELS, 1), edges)]
    return smoothed(density, edges, places, SMOOTH)[:, :, 0]


def smoothed_cells(density, edges):
    """The same in the cells of the density, an array of its shape."""
    places = [middles(count, edge) for count, edge in zip(density.shape, edges)]
    return smoothed(density, edges, places, SMOOTH)


def draw_isodensity(axes, density, value, edges, color):
    """Draw the box and the bodies in it that are denser than a value.

    Parameters
    ----------
    axes : Axes
    density : (nx, ny, nz) array
    value : float
    edges : (3,) array
        Of the box in r_c.
    color : str
    """
    region = np.stack([np.zeros(3), edges], axis=1)
    camera = camera_of(region, Look())
    surface = surface_of(field_at_points(density, edges, SMOOTH), edges, value)
    palette = np.array([mpl.colors.to_rgb(color)])
    draw_surfaces(axes, [surface], palette, camera, depth_of(region, camera, np.ones(3)))
    axes.set_rasterization_zorder(1.5)
    draw_edges(axes, region, camera, 0.0, BLACK)
    across, up = seen(corners(region), camera).place
    axes.set(xlim=(across.min(), across.max()), ylim=(up.min(), up.max()), aspect="equal")
