"""What surrounds the beads: room for it, edges of the box, axes, legend, caption."""

from __future__ import annotations

from io import BytesIO
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dpd.report.pictures.camera import corners, seen
from dpd.report.pictures.look import AXES, COLUMN, INCH

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

    from dpd.particles.particles import Particles
    from dpd.report.pictures.camera import Camera
    from dpd.report.pictures.look import Look

TEXT, SMALL = 8, 7  # points
SCREEN = 96  # pixels of a browser per inch
LINE = 0.17  # inches that a line of text takes
PER_ROW = 4  # species in a row of the legend
WIDE = 0.55  # inches of a label
LONGEST = 18  # characters of a species in the legend
TALLEST = 2.0  # height of what is drawn, in widths of the picture
UPRIGHT, LEVEL = 2.0, 0.1  # slopes of edges
FORESHORTENED = 0.35  # edges that are seen shorter than this share of their length have no label
BEHIND, BEFORE = 0.5, 1e6  # zorder of edges; layers of beads have 1, 2, ...


class Picture(Figure):
    """A figure that a notebook shows, once, whether or not it has imported pyplot."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """What IPython asks for: an image, and its width on the screen."""
        with BytesIO() as image:
            self.savefig(image, format="png")
            return image.getvalue(), {"width": round(SCREEN * self.get_figwidth())}


class Label(NamedTuple):
    """Name and length of an edge, beside its middle.

    Attributes
    ----------
    text : str
    place : (2,) array
        Near the middle of the edge, in r_c.
    right, up : int
        On which side of that the label stands: -1, 0 or 1.
    """

    text: str
    place: np.ndarray
    right: int
    up: int


class Margins(NamedTuple):
    """Room around what is drawn, in inches."""

    left: float
    right: float
    bottom: float
    top: float


class Layout(NamedTuple):
    """Where the beads are in the picture.

    Attributes
    ----------
    low, high : (2,) array
        Ends of what is drawn, in r_c.
    margins : Margins
    width, height : float
        Of the picture in inches.
    """

    low: np.ndarray
    high: np.ndarray
    margins: Margins
    width: float
    height: float


SCALES = Margins(left=0.42, right=0.1, bottom=0.36, top=0.08)  # for the axes of two dimensions
PLAIN = Margins(left=0.06, right=0.06, bottom=0.06, top=0.06)


def layout_of(
    region: np.ndarray, camera: Camera | None, radius: float, look: Look, legend: int
) -> Layout:
    """A layout in which the whole region is seen, with all that stands around it.

    Parameters
    ----------
    region : (dimension, 2) array
    camera : Camera or None
    radius : float
        Of beads, which stand out of the box by that in three dimensions.
    look : Look
    legend : int
        Species in it.
    """
    ends = seen(corners(region), camera).place
    beyond = 0.0 if camera is None else 1.2 * radius
    low, high = ends.min(axis=1) - beyond, ends.max(axis=1) + beyond
    width, (across, up) = (look.size or COLUMN) / INCH, high - low
    margins = (
        SCALES if camera is None else _around(labels_of(region, camera, radius), low, high, width)
    )
    margins = margins._replace(
        bottom=margins.bottom + LINE * look.caption,
        top=margins.top + LINE * -(-legend // PER_ROW),
    )
    room = width - margins.left - margins.right
    inches = min(room / across, TALLEST * width / up)
    spare = (room / inches - across) / 2  # where the height decides: on both sides
    aside = np.array([spare, 0.0])
    height = float(margins.bottom + margins.top + inches * up)
    return Layout(low - aside, high + aside, margins, width, height)


def _around(labels, low, high, width):
    """Margins in which labels of edges have room."""
    inches = width / (high[0] - low[0])
    sides = [PLAIN]
    for label in labels:
        x, y = label.place
        sides.append(
            Margins(
                left=(WIDE if label.up else LINE) * (label.right < 0) - (x - low[0]) * inches,
                right=WIDE * (label.right > 0) - (high[0] - x) * inches,
                bottom=1.2 * LINE * (label.up < 0) - (y - low[1]) * inches,
                top=0.0,
            )
        )
    return Margins(*map(max, zip(*sides)))


def axes_of(figure: Figure, layout: Layout) -> Axes:
    """Axes in which one r_c has the same length in both directions."""
    margins, width, height = layout.margins, layout.width, layout.height
    across = width - margins.left - margins.right
    up = height - margins.bottom - margins.top
    axes = figure.add_axes(
        (margins.left / width, margins.bottom / height, across / width, up / height)
    )
    axes.set(xlim=(layout.low[0], layout.high[0]), ylim=(layout.low[1], layout.high[1]))
    return axes


def ink_of(look: Look) -> tuple[str, str]:
    """Colours of the background and of lines and letters on it."""
    return ("black", "#D8D8D8") if look.dark else ("white", "black")


def draw_edges(axes: Axes, region: np.ndarray, camera: Camera, radius: float, ink: str) -> None:
    """Edges of the region: those at its farthest corner behind the beads, the others before."""
    ends = seen(corners(region), camera)
    far = int(np.argmin(ends.nearness))
    lines: dict[float, list[np.ndarray]] = {BEHIND: [], BEFORE: []}
    for one, other in _edges():
        zorder = BEHIND if far in (one, other) else BEFORE
        lines[zorder].append(ends.place[:, [one, other]].T)
    for zorder, segments in lines.items():
        axes.add_collection(
            LineCollection(
                segments, colors=ink, linewidths=0.6, alpha=0.7, zorder=zorder, clip_on=False,
                capstyle="round",
            ),
            autolim=False,
        )  # fmt: skip
    for label in labels_of(region, camera, radius):
        upright = not label.up
        axes.annotate(
            label.text, tuple(label.place), xytext=(3 * label.right, 3 * label.up),
            textcoords="offset points", color=ink, fontsize=SMALL,
            ha={-1: "right", 0: "center", 1: "left"}[label.right],
            va="center" if upright else "top", rotation=90 if upright else 0,
            annotation_clip=False, zorder=BEFORE,
        )  # fmt: skip
    axes.set_axis_off()


def labels_of(region: np.ndarray, camera: Camera, radius: float) -> list[Label]:
    """Labels of one edge along each axis, at the rim of the picture.

    They stand below, or at the left where the edge is upright, by a radius of beads, which stand
    out of the box as well. An edge that is seen from its end has none.
    """
    ends = seen(corners(region), camera)
    found = []
    for axis, (low, high) in enumerate(region):
        digit = 1 << (2 - axis)
        pairs = [pair for pair in _edges() if pair[0] ^ pair[1] == digit]
        middles = np.array([ends.place[:, pair].mean(axis=1) for pair in pairs])
        along = np.array([ends.place[:, other] - ends.place[:, one] for one, other in pairs])
        upright = abs(along[0, 1]) > UPRIGHT * abs(along[0, 0])
        outer = int(np.argmin(middles[:, 0] if upright else middles[:, 1]))
        if np.hypot(*along[outer]) < FORESHORTENED * (high - low):
            continue
        text = f"${AXES[axis]}$: {high - low:g} $r_c$"
        slope = along[outer, 1] / along[outer, 0] if along[outer, 0] else 0.0
        right = -1 if upright else int(np.sign(slope)) * (abs(slope) > LEVEL)
        up = 0 if upright else -1
        found.append(Label(text, middles[outer] + radius * np.array([right, up]), right, up))
    return found


def _edges():
    """Pairs of corners that an edge joins: their binary numbers differ in one digit."""
    return [pair for pair in combinations(range(8), 2) if (pair[0] ^ pair[1]).bit_count() == 1]


def draw_scales(axes: Axes, ink: str) -> None:
    """Axes of two dimensions with their numbers."""
    axes.set_xlabel("$x$ / $r_c$", fontsize=TEXT, color=ink, labelpad=2)
    axes.set_ylabel("$y$ / $r_c$", fontsize=TEXT, color=ink, labelpad=2)
    axes.tick_params(
        direction="in", top=True, right=True, labelsize=SMALL, color=ink, labelcolor=ink, width=0.7,
        zorder=BEFORE,
    )  # fmt: skip
    axes.set_axisbelow(False)
    for spine in axes.spines.values():
        spine.set(color=ink, linewidth=0.7, zorder=BEFORE)


def draw_legend(figure: Figure, colours: Mapping[str, np.ndarray], ink: str) -> None:
    """The colours of species above the picture.

    Parameters
    ----------
    figure : Figure
    colours : dict of str to (3,) array
        Nothing is drawn if there are none.
    ink : str
    """
    if not colours:
        return
    dots = [
        Line2D([], [], linestyle="none", marker="o", markersize=5, color=tuple(colour))
        for colour in colours.values()
    ]
    legend = figure.legend(
        dots, [" "] * len(dots), loc="upper center", ncols=min(len(dots), PER_ROW), frameon=False,
        fontsize=SMALL, handletextpad=0.1, columnspacing=1.0, borderaxespad=0.2, labelcolor=ink,
    )  # fmt: skip
    for text, name in zip(legend.get_texts(), colours):
        text.set_parse_math(False)  # names come from files
        text.set_text(name if len(name) <= LONGEST else f"{name[: LONGEST - 3]}...")


def draw_caption(figure: Figure, particles: Particles, visible: int, ink: str) -> None:
    """A line below: beads, density, step.

    Parameters
    ----------
    figure : Figure
    particles : Particles
    visible : int
        How many of them are drawn.
    ink : str
    """
    density = particles.beads / np.prod(particles.box)
    beads = f"{_grouped(particles.beads)} beads"
    if visible < particles.beads:
        beads = f"{_grouped(visible)} of {beads}"
    figure.text(
        0.5, 0.05 / figure.get_figheight(),
        f"{beads}, density {density:.3g} $r_c^{{-{particles.dimension}}}$, "
        f"step {_grouped(particles.step)}",
        ha="center", va="bottom", fontsize=SMALL, color=ink,
    )  # fmt: skip


def _grouped(number):
    """A whole number with its digits in groups of three."""
    return f"{number:,}".replace(",", "\u2009")
