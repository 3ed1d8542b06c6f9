"""What figures of the manual of 1998 share: densities as pictures, and error bars of profiles."""

import numpy as np
from matplotlib.colors import LightSource, to_rgb
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from skimage.measure import marching_cubes

from dpd.analysis.statistics import block_mean_and_error
from dpd.report.draw_fields import smoothed

SMOOTH = 0.5  # r_c over which densities are averaged for a picture
FINE, MOST_POINTS = 0.15, 90  # r_c between points of a surface, and how many along an axis
LIGHT = LightSource(azdeg=150, altdeg=60)


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


def points_along(box):
    """Where a density is looked at for a surface, from one face of the box to the other."""
    return [np.linspace(0, edge, min(int(np.ceil(edge / FINE)), MOST_POINTS) + 1) for edge in box]


def triangles_around(field, value, box):
    """The surface of what is denser than a value, closed where the box ends.

    ``field`` is over `points_along` the axes of the box. Returned are triangles, (n, 3, 3) by
    triangle, corner and axis, in r_c, anticlockwise from outside.
    """
    if field.max() <= value:
        return np.empty((0, 3, 3))
    # Nothing is dense outside: so steep a fall that the surface is found at the face itself.
    padded = np.pad(field, 1, constant_values=value - 1e6 * (field.max() - value))
    spacing = np.array(box) / (np.array(field.shape) - 1)
    vertices, triangles, _, _ = marching_cubes(
        padded, value, spacing=tuple(spacing), gradient_direction="ascent"
    )
    return np.clip(vertices - spacing, 0, box)[triangles]


def draw_isodensity(axes, density, value, edges, color):
    """Draw the bodies in the box that are denser than a value, in the box with its scales.

    ``density``: (nx, ny, nz) array. ``edges``: (3,) array; of the box in r_c.
    """
    field = smoothed(density, edges, points_along(edges), SMOOTH)
    triangles = triangles_around(field, value, edges)
    if len(triangles):
        axes.add_collection3d(Poly3DCollection(
            triangles, facecolors=[to_rgb(color)] * len(triangles), shade=True, lightsource=LIGHT,
            linewidths=0, antialiased=False, rasterized=True,
        ))  # fmt: skip
    axes.patch.set_visible(False)  # it would cover the labels of the panel before
    axes.set_box_aspect(tuple(edges), zoom=1.0)
    axes.set_proj_type("persp", focal_length=0.6)
    for name, edge in zip("xyz", edges):
        axes.set(**{f"{name}lim": (0, edge)})
        along = getattr(axes, f"{name}axis")
        along.set_major_locator(MaxNLocator(3))
        along.set_label_text(f"${name}$ / $r_c$")
        along.labelpad = -10
    axes.tick_params(pad=-4)
