"""Surfaces on which a density has one value, as bodies that the faces of the box cut off."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.collections import PolyCollection
from scipy.ndimage import map_coordinates

from dpd.errors import UserError
from dpd.report.pictures.camera import seen
from dpd.report.pictures.colouring import mixed
from dpd.report.pictures.smooth import smoothed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from dpd.report.pictures.camera import Camera
    from dpd.report.pictures.layers import Depth

FINE = 0.15  # r_c between the points at which a density is looked at
MOST_POINTS = 90  # of them along an axis
LIGHT = np.array([-0.35, 0.55, 0.76])  # from where it comes: right, upwards, to the viewer
DIMMEST = 0.45  # share of black on what is turned away from the light
CUT = 0.4  # share of white where a face of the box cuts a body
NEAR_FACE = 1e-5  # of an edge
GLOSS, SHARP = 0.35, 12  # share of white in the reflection of the light, and how small that is


class Triangles(NamedTuple):
    """A surface made of triangles.

    Attributes
    ----------
    corners : (3, 3, n) array
        Axis, corner, triangle, in r_c.
    normal : (3, n) array
        Unit vectors out of what is denser.
    cut : (n,) bool array
        Whether it lies in a face of the box, which cuts what is denser.
    """

    corners: np.ndarray
    normal: np.ndarray
    cut: np.ndarray


def points_along(box: np.ndarray) -> list[np.ndarray]:
    """Where a density is looked at along each axis, from one face of the box to the other."""
    return [np.linspace(0, edge, min(int(np.ceil(edge / FINE)), MOST_POINTS) + 1) for edge in box]


def field_at_points(density: np.ndarray, box: np.ndarray, width: float) -> np.ndarray:
    """A density at `points_along` each axis; see `dpd.report.pictures.smooth.smoothed`."""
    return smoothed(density, box, points_along(box), width)


def surface_of(field: np.ndarray, box: np.ndarray, value: float) -> Triangles:
    """The surface around all that is denser than a value.

    The box repeats, so the surface goes on at the opposite face. Here it ends: each face of the box
    closes it, as if it were cut.

    Parameters
    ----------
    field : (...) array
        From `field_at_points`.
    box : (3,) array
    value : float

    Returns
    -------
    Triangles
        No triangle if nothing is as dense.

    Raises
    ------
    UserError
        If the library that finds surfaces is not installed.
    """
    try:
        from skimage.measure import marching_cubes
    except ModuleNotFoundError:
        raise UserError(
            "surface: the library scikit-image, which finds surfaces, is not installed: pip "
            "install 'dpd-papers[draw]'"
        ) from None
    if field.max() <= value:
        return Triangles(np.empty((3, 3, 0)), np.empty((3, 0)), np.empty(0, bool))
    # Outside of the box nothing is dense. The fall to that is so steep that the surface is found
    # at the face itself.
    outside = value - 1e6 * (field.max() - value)
    padded = np.pad(field, 1, constant_values=outside)
    spacing = np.array(box) / (np.array(field.shape) - 1)
    vertices, faces, _, _ = marching_cubes(
        padded, value, spacing=tuple(spacing), gradient_direction="ascent"
    )
    corners = np.moveaxis((vertices - spacing)[faces], (0, 1, 2), (2, 1, 0))
    edges = np.array(box)[:, None, None]
    corners = np.clip(corners, 0, edges)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], axis=0)
    cut = np.zeros(corners.shape[2], bool)
    for face in (0.0, edges):
        cut |= (np.abs(corners - face) < NEAR_FACE * edges).all(axis=1).any(axis=0)
    # Triangles of the grid are of all shapes; the slope of the density is smoother than they are.
    normal[:, ~cut] = _downhill(field, spacing, corners[:, :, ~cut].mean(axis=1))
    length = np.linalg.norm(normal, axis=0)
    there = length > 0
    return Triangles(corners[..., there], normal[:, there] / length[there], cut[there])


def _downhill(field, spacing, places):
    """The direction in which a density falls, at (3, n) places in r_c."""
    repeated = np.pad(field[:-1, :-1, :-1], (1, 2), mode="wrap")  # a point beyond each face
    slopes = np.gradient(repeated, *spacing)
    at = 1 + places / spacing[:, None]
    return -np.array([map_coordinates(slope, at, order=1, mode="nearest") for slope in slopes])


def draw_surfaces(
    axes: Axes, surfaces: list[Triangles], colours: np.ndarray, camera: Camera, depth: Depth
) -> None:
    """Draw what of surfaces is turned to the viewer, the farthest first.

    Faces of the box that are turned to the viewer have nothing before them. So what they cut is
    drawn last, surface after surface.

    Parameters
    ----------
    axes : Axes
    surfaces : list of Triangles
        Of one species those around what is denser later.
    colours : (n, 3) array
        One for each surface.
    camera : Camera
    depth : Depth
    """
    corners = np.concatenate([surface.corners for surface in surfaces], axis=2)
    normal = np.concatenate([surface.normal for surface in surfaces], axis=1)
    cut = np.concatenate([surface.cut for surface in surfaces])
    number = np.repeat(np.arange(len(surfaces)), [s.normal.shape[1] for s in surfaces])
    found = seen(corners.reshape(3, -1), camera)
    place = found.place.reshape(2, 3, -1)
    nearness = found.nearness.reshape(3, -1).mean(axis=0)
    middle = corners.mean(axis=1)
    towards = camera.centre + camera.distance * camera.axes[2][:, None] - middle
    front = np.flatnonzero((normal * towards).sum(axis=0) > 0)
    order = front[np.lexsort((nearness[front], (cut * number)[front], cut[front]))]
    if not len(order):
        return
    shaded = _shaded(colours[number[order]], camera.axes @ normal[:, order], cut[order])
    colour = depth.faded(shaded, nearness[order])
    axes.add_collection(_polygons(place[:, :, order].transpose(2, 1, 0), colour), autolim=False)


def _polygons(places, colour):
    """Triangles with edges of their own colour, without which the background shines through."""
    return PolyCollection(
        places, facecolors=colour, edgecolors=colour, linewidths=0.25, zorder=1, clip_on=False
    )


def _shaded(colour, normal, cut):
    """Colours in the light: Lambert's law, and a reflection; flat and pale where a body is cut."""
    facing = np.clip(LIGHT @ normal / np.linalg.norm(LIGHT), 0, 1)[:, None]
    matt = mixed(colour, np.zeros(3), DIMMEST * (1 - facing))
    round = mixed(matt, np.ones(3), GLOSS * facing**SHARP)
    return np.where(cut[:, None], mixed(colour, np.ones(3), CUT), round)
