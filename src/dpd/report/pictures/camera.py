"""From places in the box to places in the picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.report.pictures.look import AXES, View

if TYPE_CHECKING:
    from dpd.report.pictures.look import Look

OBLIQUE = View(25.0, 20.0)  # of a whole box
STRAIGHT = {"x": View(90.0, 0.0), "y": View(0.0, 0.0), "z": View(0.0, 90.0)}  # of a slab
DISTANCE = 4.0  # of the viewer from the centre, in half diagonals of what is drawn


class Seen(NamedTuple):
    """Points as they are seen.

    Attributes
    ----------
    place : (2, n) array
        In the picture, in r_c at the distance of the box's centre.
    nearness : (n,) array
        How much nearer to the viewer than the centre, in r_c; 0 in two dimensions.
    scale : (n,) array
        By how much larger than at the centre.
    """

    place: np.ndarray
    nearness: np.ndarray
    scale: np.ndarray


class Camera(NamedTuple):
    """A viewer of a box of three dimensions, with a weak perspective.

    Attributes
    ----------
    axes : (3, 3) array
        Unit vectors to the right, upwards and to the viewer, as rows.
    centre : (3, 1) array
        Of what is drawn, in r_c.
    distance : float
        Of the viewer from there.
    """

    axes: np.ndarray
    centre: np.ndarray
    distance: float


def region_of(box: tuple[float, ...], look: Look) -> np.ndarray:
    """Low and high ends of what is drawn: the box, or the slab in it.

    Returns
    -------
    (dimension, 2) array
    """
    region = np.array([(0.0, edge) for edge in box])
    if look.slab is not None:
        axis = AXES.index(look.slab.axis)
        region[axis] = max(look.slab.low, 0.0), min(look.slab.high, box[axis])
    return region


def camera_of(region: np.ndarray, look: Look) -> Camera | None:
    """The viewer of a region; None in two dimensions."""
    if len(region) == 2:
        return None
    usual = OBLIQUE if look.slab is None else STRAIGHT[look.slab.axis]
    azimuth, elevation = np.radians(look.view or usual)
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    towards = np.array(
        [
            np.sin(azimuth) * np.cos(elevation),
            -np.cos(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )
    half_diagonal = 0.5 * np.linalg.norm(np.diff(region))
    return Camera(
        axes=np.array([right, np.cross(towards, right), towards]),
        centre=region.mean(axis=1, keepdims=True),
        distance=DISTANCE * float(half_diagonal),
    )


def seen(points: np.ndarray, camera: Camera | None) -> Seen:
    """Where points are seen.

    Parameters
    ----------
    points : (dimension, n) array
        In r_c.
    camera : Camera or None
        None in two dimensions.
    """
    if camera is None:
        count = points.shape[1]
        return Seen(points, np.zeros(count), np.ones(count))
    right, up, nearness = camera.axes @ (points - camera.centre)
    scale = camera.distance / (camera.distance - nearness)
    return Seen(np.array([right, up]) * scale, nearness, scale)


def corners(region: np.ndarray) -> np.ndarray:
    """Corners of a region, in the order of the binary numbers: the last axis changes first.

    Returns
    -------
    (dimension, 2 ** dimension) array
    """
    return np.stack([axis.ravel() for axis in np.meshgrid(*region, indexing="ij")])
