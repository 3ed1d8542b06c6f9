"""What figures of the manual of 1998 share."""

from itertools import product

import numpy as np

from dpd.report.style import mpl


def isodensity(field, level, edges):
    """The surface in a periodic box on which a density has one value.

    Parameters
    ----------
    field : (nx, ny, nz) array
        Mean densities in cells.
    level : float
    edges : (3,) array
        Of the box in r_c.

    Returns
    -------
    corners : (n, 3) array
        In r_c, within the box.
    faces : (m, 3) array of int
        Numbers of corners. The surface ends where it meets a face of the box, and goes on at the
        opposite one.
    """
    from skimage.measure import marching_cubes

    # At the corners of cells, each the mean of the eight cells around it.
    wrapped = np.pad(field, 1, mode="wrap")
    count = np.array(field.shape) + 1
    around = [
        wrapped[x : x + count[0], y : y + count[1], z : z + count[2]]
        for x, y, z in product((0, 1), repeat=3)
    ]
    corners, faces, _, _ = marching_cubes(np.mean(around, axis=0), level)
    return corners * edges / field.shape, faces


def draw_isodensity(axes, field, level, edges, color):
    """Draw that surface, and the edges of the box, in three-dimensional axes."""
    corners, faces = isodensity(field, level, edges)
    axes.plot_trisurf(
        *corners.T[:2], faces, corners.T[2], color=color, linewidth=0, antialiased=False,
        lightsource=mpl.colors.LightSource(azdeg=225, altdeg=45),
    )  # fmt: skip
    for along in range(3):
        for low, high in product((0, 1), repeat=2):
            line = np.empty((3, 2))
            line[along] = 0, edges[along]
            line[(along + 1) % 3] = low * edges[(along + 1) % 3]
            line[(along + 2) % 3] = high * edges[(along + 2) % 3]
            axes.plot(*line, color="0.4", linewidth=0.5)
    axes.set_box_aspect(edges, zoom=1.3)
    axes.set_axis_off()
