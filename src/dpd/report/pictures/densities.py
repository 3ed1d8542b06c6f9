"""Pictures of density fields: slices with a colour map, and surfaces, at one time or several."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.ticker import MaxNLocator

from dpd.errors import UserError
from dpd.report.pictures.camera import camera_of
from dpd.report.pictures.colouring import BRIGHTER, PALER, mixed, species_colours
from dpd.report.pictures.frame import (
    LINE,
    PER_ROW,
    SMALL,
    TEXT,
    Margins,
    Picture,
    draw_edges,
    draw_legend,
    ink_of,
    layout_of,
)
from dpd.report.pictures.layers import depth_of
from dpd.report.pictures.look import AXES, COLUMN, INCH, SMOOTH
from dpd.report.pictures.smooth import middles, smoothed
from dpd.report.pictures.surfaces import (
    draw_surfaces,
    field_at_points,
    points_along,
    surface_of,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from dpd.particles.fields import Fields
    from dpd.report.pictures.look import Look

TWO_COLUMNS = 17.8  # cm, the usual width of several panels
IN_A_ROW = 4  # panels at most, but of slices
MOST_FRAMES = 8  # in one picture
PIXEL = 0.05  # r_c, of a slice
MOST_PIXELS = 600  # of a slice along an axis
COLOURS = "viridis"
STEPS = [1, 2, 5, 10]  # between the numbers on an axis, and times a power of ten
# In inches.
AROUND = Margins(left=0.42, right=0.08, bottom=0.36, top=0.08)
GAP, BAR, BESIDE_BAR = 0.18, 0.1, 0.45
PALE = 0.45  # share of the background in the colour of what is denser, in two dimensions


class Panels(NamedTuple):
    """Rows and columns of panels, all of one size, in a figure.

    Attributes
    ----------
    columns, rows : int
    width, height : float
        Of a panel in inches.
    margins : Margins
        Around all of them.
    beside, between : float
        Room between two columns and between two rows, in inches.
    """

    columns: int
    rows: int
    width: float
    height: float
    margins: Margins
    beside: float
    between: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the figure in inches."""
        left, right, bottom, top = self.margins
        return (
            left + right + self.columns * (self.width + self.beside) - self.beside,
            bottom + top + self.rows * (self.height + self.between) - self.between,
        )

    def place(self, row: int, column: int) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of a panel, as shares of the figure; row 0 is on top."""
        across, up = self.size
        left = self.margins.left + column * (self.width + self.beside)
        bottom = self.margins.bottom + (self.rows - 1 - row) * (self.height + self.between)
        return left / across, bottom / up, self.width / across, self.height / up


def draw_fields(fields: Fields, frames: Sequence[int], look: Look, path: object) -> Figure:
    """Draw slices of density fields, or surfaces in them.

    Parameters
    ----------
    fields : Fields
    frames : sequence of int
        From 0 or from the last one; each has a panel of its own.
    look : Look
        With a ``slice`` or with ``surface``.
    path : path
        Where the fields come from, for messages.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    UserError
        If there is no such frame, species or place, if there are too many frames, or a surface is
        nowhere.
    """
    if not 0 < len(frames) <= MOST_FRAMES:
        raise UserError(f"frame: {len(frames)} of them in one picture; allowed: 1 to {MOST_FRAMES}")
    numbers = [fields.number(frame, path) for frame in frames]
    _check(fields, look, path)
    look = look._replace(
        size=look.size or (COLUMN if len(numbers) == 1 else TWO_COLUMNS),
        smooth=SMOOTH if look.smooth is None else look.smooth,
    )
    figure = _blank(look)
    if look.slice is not None:
        _draw_slices(figure, fields, numbers, look)
    elif fields.dimension == 2:
        _draw_contours(figure, fields, numbers, look, path)
    else:
        _draw_bodies(figure, fields, numbers, look, path)
    return figure


def _blank(look):
    """A figure without panels."""
    paper, _ = ink_of(look)
    return Picture(dpi=look.dpi, layout="none", facecolor=paper)


def _check(fields, look, path):
    """Refuse what these fields do not have."""
    for name in (*look.species, *(surface.species for surface in look.surface)):
        if name not in fields.names:
            raise UserError(
                f"{path}: no species is called {name!r}; allowed: {', '.join(fields.names)}"
            )
    if look.view is not None and (fields.dimension == 2 or look.slice is not None):
        raise UserError(f"{path}: a plane is seen from one side only; leave the view out")
    if look.slice is None:
        return
    axis, place = look.slice
    if fields.dimension == 2:
        if (axis, place) != ("z", 0):
            raise UserError(
                f"{path}: slice {axis}={place:g}: two dimensions lie in the plane z=0; allowed: z=0"
            )
        return
    edge = fields.box[:, AXES.index(axis)].max()
    if not 0 <= place <= edge:
        raise UserError(
            f"{path}: slice {axis}={place:g} is outside of the box; allowed: {axis}=0 to "
            f"{axis}={edge:g}"
        )


# Slices.


def _draw_slices(figure, fields, numbers, look):
    """A row for each species, a column for each time; one scale of colours for each row."""
    names = look.species or fields.names
    across, up = _axes_of_slice(look)
    box = fields.box[numbers].max(axis=0)
    margins = AROUND._replace(right=GAP + BAR + BESIDE_BAR, top=LINE + 0.06)
    panels = _panels(len(numbers), len(names), box[up] / box[across], margins, look)
    figure.set_size_inches(panels.size)
    for row, name in enumerate(names):
        images = [_slice(fields, number, fields.names.index(name), look) for number in numbers]
        most = max(float(image.max()) for image in images) or 1.0
        for column, (number, image) in enumerate(zip(numbers, images)):
            axes = figure.add_axes(panels.place(row, column))
            edges = fields.box[number]
            drawn = axes.imshow(
                image.T, origin="lower", extent=(0, edges[across], 0, edges[up]), vmin=0,
                vmax=most, cmap=COLOURS, interpolation="bilinear", aspect="equal",
            )  # fmt: skip
            axes.set(xlim=(0, box[across]), ylim=(0, box[up]))
            _scales(axes, row == len(names) - 1, column == 0, (AXES[across], AXES[up]), look)
            if row == 0:
                _title(axes, fields, number, look)
        _colour_bar(figure, panels, row, drawn, f"density of {name}", fields.dimension, look)


def _axes_of_slice(look):
    """Numbers of the axes to the right and upwards."""
    return [number for number, axis in enumerate(AXES) if axis != look.slice.axis]


def _slice(fields, number, species, look):
    """The density in the plane of a slice, at the middles of pixels."""
    box = fields.box[number]
    places = [middles(count, edge) for edge, count in zip(box, _pixels(box))]
    if fields.dimension == 2:
        return smoothed(fields.density[number, species], box, places, look.smooth)
    axis = AXES.index(look.slice.axis)
    places[axis] = np.array([look.slice.place])
    return smoothed(fields.density[number, species], box, places, look.smooth).squeeze(axis)


def _pixels(box):
    return [min(int(np.ceil(edge / PIXEL)), MOST_PIXELS) for edge in box]


def _colour_bar(figure, panels, row, drawn, what, dimension, look):
    _, ink = ink_of(look)
    left, bottom, width, height = panels.place(row, panels.columns - 1)
    across, _ = panels.size
    axes = figure.add_axes((left + width + GAP / across, bottom, BAR / across, height))
    bar = figure.colorbar(drawn, cax=axes)
    bar.set_label(f"{what} / $r_c^{{-{dimension}}}$", fontsize=SMALL, color=ink)
    bar.ax.yaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    bar.ax.tick_params(labelsize=SMALL, color=ink, labelcolor=ink, width=0.7, direction="in")
    bar.outline.set(color=ink, linewidth=0.7)


# Surfaces in two dimensions, which are lines.


def _draw_contours(figure, fields, numbers, look, path):
    """What is denser than asked for, filled, with a line around it."""
    paper, ink = ink_of(look)
    colours = _colours(fields, look)
    box = fields.box[numbers].max(axis=0)
    lines = -(-len(look.surface) // PER_ROW)
    margins = AROUND._replace(top=LINE * (1 + lines) + 0.06)
    panels = _panels(_columns(numbers), _rows(numbers), box[1] / box[0], margins, look)
    figure.set_size_inches(panels.size)
    levels = _levels(fields, numbers, look, path)
    for place, number in enumerate(numbers):
        row, column = divmod(place, panels.columns)
        axes = figure.add_axes(panels.place(row, column), facecolor=paper)
        points = points_along(fields.box[number])
        for surface, field, colour in zip(look.surface, levels[place], colours):
            if field.max() > surface.value:
                pale = mixed(colour, np.array(to_rgb(paper)), PALE)
                most = [surface.value, np.inf]
                axes.contourf(*points, field.T, most, colors=[tuple(pale)])
                axes.contour(
                    *points, field.T, [surface.value], colors=[tuple(colour)], linewidths=1
                )
        axes.set(xlim=(0, box[0]), ylim=(0, box[1]), aspect="equal")
        below = place + panels.columns >= len(numbers)
        _scales(axes, below, column == 0, AXES[:2], look)
        _title(axes, fields, number, look)
    draw_legend(figure, _legend(look, colours), ink)


# Surfaces in three dimensions.


def _draw_bodies(figure, fields, numbers, look, path):
    """Each time in a box of its own."""
    paper, ink = ink_of(look)
    colours = _colours(fields, look)
    columns = _columns(numbers)
    of_one = look._replace(size=look.size / columns, caption=False)
    region = np.stack([np.zeros(3), fields.box[numbers].max(axis=0)], axis=1)
    layout = layout_of(region, camera_of(region, look), 0.0, of_one, 0)
    lines = -(-len(look.surface) // PER_ROW)
    title = LINE
    panels = Panels(
        columns, _rows(numbers), layout.width, layout.height + title,
        Margins(0.0, 0.0, 0.0, LINE * lines), 0.0, 0.0,
    )  # fmt: skip
    figure.set_size_inches(panels.size)
    levels = _levels(fields, numbers, look, path)
    for place, number in enumerate(numbers):
        left, bottom, _, _ = panels.place(*divmod(place, columns))
        across, up = panels.size
        inner = layout.margins
        axes = figure.add_axes((
            left + inner.left / across, bottom + inner.bottom / up,
            (layout.width - inner.left - inner.right) / across,
            (layout.height - inner.bottom - inner.top) / up,
        ))  # fmt: skip
        axes.set(xlim=(layout.low[0], layout.high[0]), ylim=(layout.low[1], layout.high[1]))
        box = fields.box[number]
        own = np.stack([np.zeros(3), box], axis=1)
        camera = camera_of(own, look)
        surfaces = [
            surface_of(field, box, surface.value)
            for surface, field in zip(look.surface, levels[place])
        ]
        depth = depth_of(own, camera, np.array(to_rgb(paper)))
        draw_surfaces(axes, surfaces, colours, camera, depth)
        axes.set_rasterization_zorder(1.5)
        draw_edges(axes, own, camera, 0.0, ink)
        _title(axes, fields, number, look)
    draw_legend(figure, _legend(look, colours), ink)


# What they share.


def _panels(columns, rows, height, margins, look):
    """Panels as wide as the figure has room for; ``height`` is that of one over its width."""
    room = look.size / INCH - margins.left - margins.right - GAP * (columns - 1)
    # In rows of several times each has a title, and the last one may be shorter than the others.
    between = GAP if look.slice is not None else GAP + 2 * LINE
    return Panels(columns, rows, room / columns, room / columns * height, margins, GAP, between)


def _rows(numbers):
    return -(-len(numbers) // IN_A_ROW)


def _columns(numbers):
    return -(-len(numbers) // _rows(numbers))


def _levels(fields, numbers, look, path):
    """Densities at points, for each frame and each surface; refuses a surface that is nowhere."""
    found = [
        [
            field_at_points(
                fields.density[number, fields.names.index(surface.species)], fields.box[number],
                look.smooth,
            )
            for surface in look.surface
        ]
        for number in numbers
    ]  # fmt: skip
    for place, surface in enumerate(look.surface):
        low = min(float(levels[place].min()) for levels in found)
        high = max(float(levels[place].max()) for levels in found)
        if not low < surface.value < high:
            raise UserError(
                f"{path}: surface {surface.species}={surface.value:g}: the density of "
                f"{surface.species}, smoothed over {look.smooth:g} r_c, has no such value; "
                f"allowed: between {low:.3g} and {high:.3g}"
            )
    return found


def _colours(fields, look):
    """Of the surfaces, by their species; a second one of a species is paler."""
    palette = species_colours(2 * len(fields.names))
    seen, colours = [], []
    for surface in look.surface:
        number = fields.names.index(surface.species)
        again = seen.count(surface.species)
        colours.append(mixed(palette[number], np.ones(3), PALER) if again else palette[number])
        seen.append(surface.species)
    return mixed(np.array(colours), np.ones(3), BRIGHTER * look.dark)


def _legend(look, colours):
    return {
        f"{surface.species} > {surface.value:g}": colour
        for surface, colour in zip(look.surface, colours)
    }


def _scales(axes: Axes, below: bool, left: bool, names: Sequence[str], look: Look) -> None:
    """Axes with their numbers: at the rim of all panels only."""
    _, ink = ink_of(look)
    axes.tick_params(
        direction="in", top=True, right=True, labelsize=SMALL, color=ink, labelcolor=ink, width=0.7,
        labelbottom=below, labelleft=left,
    )  # fmt: skip
    for direction in (axes.xaxis, axes.yaxis):
        direction.set_major_locator(MaxNLocator(4, steps=STEPS))
    if below:
        axes.set_xlabel(f"${names[0]}$ / $r_c$", fontsize=TEXT, color=ink, labelpad=2)
    if left:
        axes.set_ylabel(f"${names[1]}$ / $r_c$", fontsize=TEXT, color=ink, labelpad=2)
    for spine in axes.spines.values():
        spine.set(color=ink, linewidth=0.7)


def _title(axes, fields, number, look):
    _, ink = ink_of(look)
    time = f"{fields.time[number]:.4g}"
    axes.set_title(rf"$t$ = {time} $\tau$", fontsize=SMALL, color=ink, pad=2.5)
