"""What figures of the manual of 1998 share: densities as pictures."""

import numpy as np

from dpd.report.pictures.camera import camera_of, corners, seen
from dpd.report.pictures.frame import draw_edges
from dpd.report.pictures.layers import depth_of
from dpd.report.pictures.look import SMOOTH, Look
from dpd.report.pictures.smooth import middles, smoothed
from dpd.report.pictures.surfaces import draw_surfaces, field_at_points, surface_of
from dpd.report.style import BLACK, mpl

PIXELS = 120  # of a slice along an axis
SMOOTHED = f"smoothed over {SMOOTH:g} r_c"


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
