"""Beads as discs and bonds as strips, the farthest first."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.collections import EllipseCollection, PathCollection
from matplotlib.path import Path

from dpd.report.pictures.camera import corners, seen
from dpd.report.pictures.colouring import Colours, mixed
from dpd.report.pictures.shapes import pieces_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes

    from dpd.particles.particles import Particles
    from dpd.report.pictures.camera import Camera

BOND = 0.8  # width of a bond, in radii of beads
LAYER = 0.5  # thickness of a layer, in radii of beads
MOST_LAYERS = 300
HIDDEN = 0.9  # of its radius that a bead in three dimensions hides of a bond
FAINTEST = 0.6  # share of the background in the colour of what is farthest


class Disc(NamedTuple):
    """One of the discs that a bead is drawn as.

    Attributes
    ----------
    radius : float
        In radii of the bead.
    shift : float
        To the left and upwards, in radii of the bead.
    white : float
        Share of white in its colour; of black where it is negative.
    """

    radius: float
    shift: float
    white: float


FLAT = (Disc(1.0, 0.0, -0.5), Disc(0.84, 0.0, 0.0))
SPHERE = (*FLAT, Disc(0.5, 0.2, 0.2), Disc(0.22, 0.32, 0.55))
STRIPS = ((1.0, -0.5), (0.7, 0.0))  # of a bond: their shares of its width, and white as above
STRIP = (Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY)


class Fixed(NamedTuple):
    """What stays the same in all frames of a movie.

    Attributes
    ----------
    radius : float
        Of beads in r_c.
    colours : Colours
    """

    radius: float
    colours: Colours


class Balls(NamedTuple):
    """Beads as they are seen: place (2, n), nearness (n,), radius (n,), colour (n, 3)."""

    place: np.ndarray
    nearness: np.ndarray
    radius: np.ndarray
    colour: np.ndarray


class Sticks(NamedTuple):
    """Pieces of bonds as they are seen.

    Attributes
    ----------
    ends : (2, 2, m) array
        Axis, end, piece.
    width : (2, m) array
        At both ends, in r_c.
    nearness : (m,) array
    kind : (m,) array
        Numbers of colours.
    palette : (colours, 3) array
    """

    ends: np.ndarray
    width: np.ndarray
    nearness: np.ndarray
    kind: np.ndarray
    palette: np.ndarray


class Depth(NamedTuple):
    """How the region is deep, and what that does to colours.

    Attributes
    ----------
    nearest, farthest : float
        Nearness of its nearest and farthest corner, in r_c.
    paper : (3,) array
        Colour of the background.
    """

    nearest: float
    farthest: float
    paper: np.ndarray

    @property
    def thickness(self) -> float:
        """Between these corners, in r_c; 0 in two dimensions."""
        return self.nearest - self.farthest

    def faded(self, colour: np.ndarray, nearness: np.ndarray) -> np.ndarray:
        """Colours that are the more like the background the farther they are."""
        share = 1.0 - self._share(nearness)
        return mixed(colour, self.paper, FAINTEST * share[:, None])

    def layer(self, nearness: np.ndarray, layers: int) -> np.ndarray:
        """Numbers of the layers that something is in, the farthest 0."""
        return np.minimum((self._share(nearness) * layers).astype(int), layers - 1)

    def _share(self, nearness):
        """0 for what is farthest, 1 for what is nearest; 1 in two dimensions."""
        if not self.thickness:
            return np.ones(nearness.shape)
        return np.clip((nearness - self.farthest) / self.thickness, 0, 1)


def depth_of(region: np.ndarray, camera: Camera | None, paper: np.ndarray) -> Depth:
    """The depth of a region; none in two dimensions."""
    nearness = seen(corners(region), camera).nearness
    return Depth(float(nearness.max()), float(nearness.min()), paper)


def balls_of(
    particles: Particles, visible: np.ndarray, camera: Camera | None, fixed: Fixed
) -> Balls:
    """The visible beads."""
    found = seen(particles.position[:, visible], camera)
    colours = fixed.colours
    return Balls(
        found.place, found.nearness, fixed.radius * found.scale,
        colours.palette[colours.kind[visible]],
    )  # fmt: skip


def sticks_of(
    particles: Particles, visible: np.ndarray, camera: Camera | None, fixed: Fixed
) -> Sticks:
    """The bonds between visible beads."""
    hidden = 0.0 if camera is None else HIDDEN * fixed.radius
    pieces = pieces_of(particles, visible, hidden)
    first, last = seen(pieces.first, camera), seen(pieces.last, camera)
    return Sticks(
        ends=np.stack([first.place, last.place], axis=1),
        width=BOND * fixed.radius * np.stack([first.scale, last.scale]),
        nearness=0.5 * (first.nearness + last.nearness),
        kind=fixed.colours.kind[pieces.bead],
        palette=fixed.colours.palette,
    )


def draw_layers(axes: Axes, balls: Balls, sticks: Sticks, depth: Depth) -> None:
    """Draw from the farthest layer to the nearest: in each the bonds, then the beads."""
    if not balls.nearness.size:
        return
    discs = SPHERE if depth.thickness else FLAT
    thinnest = LAYER * float(balls.radius.min())
    layers = int(np.clip(depth.thickness / thinnest, 1, MOST_LAYERS))
    for layer, members in _split(depth.layer(sticks.nearness, layers), sticks.nearness):
        axes.add_collection(_strips(sticks, members, depth, 1 + layer), autolim=False)
    for layer, members in _split(depth.layer(balls.nearness, layers), balls.nearness):
        axes.add_collection(_discs(axes, balls, members, depth, discs, 1.5 + layer), autolim=False)


def _split(layer: np.ndarray, nearness: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """The members of each layer, the farthest first."""
    order = np.argsort(nearness, kind="stable")
    numbers, begins = np.unique(layer[order], return_index=True)
    yield from zip(numbers.tolist(), np.split(order, begins[1:]))


def _strips(sticks, members, depth, zorder):
    """The bonds of a layer, all of a colour as one path: first the rims, then the bonds."""
    nearness = sticks.nearness[members].mean(keepdims=True)
    paths, colours = [], []
    for share, white in STRIPS:
        for kind in np.unique(sticks.kind[members]):
            some = members[sticks.kind[members] == kind]
            paths.append(_path(sticks.ends[..., some], share * sticks.width[:, some]))
            colour = depth.faded(sticks.palette[kind : kind + 1], nearness)
            colours.append(_lighter(colour, white)[0])
    return PathCollection(
        paths, facecolors=np.array(colours), linewidths=0, zorder=zorder, clip_on=False
    )


def _path(ends, width):
    """Strips between two ends, all turned the same way round, so that none cuts out another.

    Parameters
    ----------
    ends : (2, 2, m) array
        Axis, end, strip.
    width : (2, m) array
        At both ends.
    """
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along)
    across = np.stack([-along[1], along[0]]) / np.where(length > 0, length, 1.0)
    one, other = 0.5 * across * width[0], 0.5 * across * width[1]
    begin, end = ends[:, 0], ends[:, 1]
    vertices = np.stack([begin - one, end - other, end + other, begin + one, begin - one])
    return Path(np.moveaxis(vertices, 2, 0).reshape(-1, 2), np.tile(STRIP, ends.shape[2]))


def _discs(axes, balls, members, depth, discs, zorder):
    """The beads of a layer, each with all its discs before the next one."""
    place, radius = balls.place[:, members].T, balls.radius[members]
    colour = depth.faded(balls.colour[members], balls.nearness[members])
    up_left = np.array([-1.0, 1.0])
    offsets = np.stack([place + shift * radius[:, None] * up_left for _, shift, _ in discs], axis=1)
    across = np.stack([2 * share * radius for share, _, _ in discs], axis=1).ravel()
    colours = np.stack([_lighter(colour, white) for _, _, white in discs], axis=1)
    return EllipseCollection(
        across, across, np.zeros(across.size), units="xy", offsets=offsets.reshape(-1, 2),
        offset_transform=axes.transData, facecolors=colours.reshape(-1, 3), linewidths=0,
        zorder=zorder, clip_on=False,
    )  # fmt: skip


def _lighter(colour, white):
    return mixed(colour, np.ones(3) if white > 0 else np.zeros(3), abs(white))
