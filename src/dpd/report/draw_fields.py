"""Pictures of density fields: slices with a colour bar, and surfaces, at one time or several."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LightSource, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from dpd.errors import UserError, shown
from dpd.particles.netcdf import Fields
from dpd.particles.particles import frame_number
from dpd.report.style import DOUBLE, OF_SPECIES, SINGLE

AXES = "xyz"
MOST_FRAMES = 8  # in one picture
IN_A_ROW = 4  # panels of surfaces
LEAST = 0.5  # width of a Gaussian in cells, at which the grid does not show
PIXEL, MOST_PIXELS = 0.05, 600  # r_c of a slice, and along an axis
FINE, MOST_POINTS = 0.15, 90  # the same for a surface
LIGHT = LightSource(azdeg=150, altdeg=60)
PER_ROW = 4  # species in a row of the legend
AROUND = 0.45  # inches beside and below panels


def draw_fields(
    figure: Figure, fields: Fields, frames: Sequence[int], slice: str | None,
    surface: Sequence[str], smooth: float, species: Sequence[str], width: float | None,
    path: object,
) -> None:  # fmt: skip
    """Draw slices of density fields, or surfaces in them; see `draw`; ``width`` in inches."""
    if not 0 < len(frames) <= MOST_FRAMES:
        raise UserError(f"frame: {len(frames)} of them in one picture; allowed: 1 to {MOST_FRAMES}")
    numbers = [frame_number(frame, len(fields.time), path) for frame in frames]
    allowed = "a species and a density, as in A=0.4"
    levels = dict(_split("surface", word, allowed) for word in surface)
    refuse_unknown((*species, *levels), fields.names, path)
    names = tuple(species) or fields.names
    if slice:
        plane = _plane(fields, slice, path)
        right, up = (k for k in range(3) if k != plane[0])
        rows, columns = len(names), len(numbers)
        _draw_slices(figure, fields, numbers, names, plane, right, up, smooth)
    else:
        right, up = 0, fields.dimension - 1
        rows = -(-len(numbers) // IN_A_ROW)
        columns = -(-len(numbers) // rows)
        _draw_surfaces(figure, fields, numbers, levels, (rows, columns), smooth, path)
    width, box = width or (DOUBLE if len(numbers) > 1 else SINGLE), fields.box[numbers].max(axis=0)
    height = rows * (((width - 2 * AROUND) / columns) * box[up] / box[right] + AROUND)
    figure.set_size_inches(width, height)


def refuse_unknown(species: Iterable[str], names: Sequence[str], path: object) -> None:
    """Refuse species that are not there."""
    for name in species:
        if name not in names:
            allowed = ", ".join(names)
            raise UserError(f"{path}: no species is called {shown(name)}; allowed: {allowed}")


def _split(what, word, allowed):
    """Name and number of a word like ``A=0.4``."""
    name, _, number = str(word).partition("=")
    try:
        return name, float(number)
    except ValueError:
        raise UserError(f"{what}: {shown(word)}: allowed: {allowed}") from None


def _plane(fields, slice, path):
    """Number of the axis across a plane, and where that is; z=0 is all of two dimensions."""
    axis, place = _split("slice", slice, "an axis and a place in r_c, as in z=5")
    edges = dict(zip(AXES, fields.box.max(axis=0))) if fields.dimension == 3 else {"z": 0.0}
    if axis not in edges or not 0 <= place <= edges[axis]:
        inside = ", ".join(f"{name}=0 to {edge:g}" for name, edge in edges.items())
        raise UserError(f"{path}: slice {slice}: is outside of the box; allowed: {inside}")
    return AXES.index(axis), place


def smoothed(
    density: np.ndarray, box: Sequence[float] | np.ndarray, places: Sequence[np.ndarray],
    width: float,
) -> np.ndarray:  # fmt: skip
    """A density averaged with a Gaussian, at some places; the box repeats.

    Arrays have an axis of cells, or of places, for each axis of the box. ``box`` and ``places`` are
    in r_c, as ``width``, the standard deviation of the Gaussian: half a cell at least.
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    cell = np.array(box) / density.shape
    soft = gaussian_filter(density.astype(float), np.maximum(width / cell, LEAST), mode="wrap")
    at = np.meshgrid(*(p / c - 0.5 for p, c in zip(places, cell)), indexing="ij")
    return map_coordinates(soft, at, mode="grid-wrap")


def middles(count: int, edge: float) -> np.ndarray:
    """Middles of so many cells along an edge."""
    return (np.arange(count) + 0.5) * (edge / count)


def points_along(box: np.ndarray) -> list[np.ndarray]:
    """Where a density is looked at for a surface, from one face of the box to the other."""
    return [np.linspace(0, edge, min(int(np.ceil(edge / FINE)), MOST_POINTS) + 1) for edge in box]


def slice_of(
    density: np.ndarray, box: np.ndarray, axis: int, place: float, width: float
) -> np.ndarray:
    """A smoothed density in a plane across an axis: an image for `matplotlib.pyplot.imshow`."""
    places = [middles(min(int(np.ceil(e / PIXEL)), MOST_PIXELS), e) for e in box]
    if len(box) == 3:
        places[axis] = np.array([place])
    return smoothed(density, box, places, width).squeeze().T


def _draw_slices(figure, fields, numbers, names, plane, right, up, width):
    """A row for each species with one scale of colours, a column for each time."""
    panels = figure.subplots(len(names), len(numbers), squeeze=False, sharex=True, sharey=True)
    for row, name in zip(panels, names):
        density = fields.density[:, fields.names.index(name)]
        images = [slice_of(density[n], fields.box[n], *plane, width) for n in numbers]
        for axes, number, image in zip(row, numbers, images):
            box = fields.box[number]
            drawn = axes.imshow(
                image, origin="lower", extent=(0, box[right], 0, box[up]), vmin=0,
                vmax=max(map(np.max, images)) or 1, interpolation="bilinear",
            )  # fmt: skip
        row[0].set_ylabel(f"${AXES[up]}$ / $r_c$")
        bar = figure.colorbar(drawn, ax=list(row), pad=0.02, aspect=25)
        bar.set_label(f"density of {name} / $r_c^{{-{fields.dimension}}}$")
        bar.locator = MaxNLocator(5)
    for axes, number in zip(panels[0], numbers):
        axes.set_title(_time(fields, number))
    for axes in panels[-1]:
        axes.set_xlabel(f"${AXES[right]}$ / $r_c$")


def _time(fields, number):
    return rf"$t$ = {fields.time[number]:.4g} $\tau$"


def _draw_surfaces(figure, fields, numbers, levels, shape, width, path):
    """What is denser than asked for: as bodies, in two dimensions as areas with a line around."""
    colours = {name: OF_SPECIES[fields.names.index(name) % len(OF_SPECIES)] for name in levels}
    found = {}
    for name, value in levels.items():
        densities = fields.density[:, fields.names.index(name)]
        boxes = [(n, fields.box[n]) for n in numbers]
        found[name] = [smoothed(densities[n], box, points_along(box), width) for n, box in boxes]
        low, high = min(map(np.min, found[name])), max(map(np.max, found[name]))
        if not low < value < high:
            raise UserError(
                f"{path}: surface {name}={value:g}: the density of {name}, smoothed over "
                f"{width:g} r_c, has no such value; allowed: between {low:.3g} and {high:.3g}"
            )
    for place, number in enumerate(numbers):
        box = fields.box[number]
        here = [(found[name][place], levels[name], colours[name]) for name in levels]
        if fields.dimension == 3:
            axes = figure.add_subplot(*shape, place + 1, projection="3d")
            draw_bodies(axes, [(triangles_around(f, v, box), c) for f, v, c in here], box)
        else:
            axes = figure.add_subplot(*shape, place + 1, aspect="equal")
            for field, value, colour in here:
                points = points_along(box)
                axes.contourf(*points, field.T, [value, np.inf], colors=[colour], alpha=0.5)
                axes.contour(*points, field.T, [value], colors=[colour], linewidths=1)
            axes.set(xlabel="$x$ / $r_c$", ylabel="$y$ / $r_c$")
        axes.set_title(_time(fields, number))
    draw_legend(figure, {f"{name} > {value:g}": colours[name] for name, value in levels.items()})


def triangles_around(
    field: np.ndarray, value: float, box: Sequence[float] | np.ndarray
) -> np.ndarray:
    """The surface of what is denser than a value, closed where the box ends.

    ``field`` is over `points_along` the axes of the box. Returned are triangles, (n, 3, 3) by
    triangle, corner and axis, in r_c, anticlockwise from outside. `UserError` without scikit-image.
    """
    try:
        from skimage.measure import marching_cubes
    except ModuleNotFoundError:
        remedy = "is not installed: pip install 'dpd-papers[draw]'"
        raise UserError(f"surface: scikit-image, which finds surfaces, {remedy}") from None
    if field.max() <= value:
        return np.empty((0, 3, 3))
    # Nothing is dense outside: so steep a fall that the surface is found at the face itself.
    padded = np.pad(field, 1, constant_values=value - 1e6 * (field.max() - value))
    spacing = np.array(box) / (np.array(field.shape) - 1)
    vertices, triangles, _, _ = marching_cubes(
        padded, value, spacing=tuple(spacing), gradient_direction="ascent"
    )
    return np.clip(vertices - spacing, 0, box)[triangles]


def draw_bodies(
    axes: Any, bodies: Sequence[tuple[np.ndarray, Any]], box: Sequence[float] | np.ndarray
) -> None:
    """Draw surfaces, (triangles, colour) from `triangles_around`, in the box with its scales."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colours = [rgb for triangles, colour in bodies for rgb in [to_rgb(colour)] * len(triangles)]
    corners = np.concatenate([triangles for triangles, _ in bodies])
    if len(corners):
        axes.add_collection3d(Poly3DCollection(
            corners, facecolors=colours, shade=True, lightsource=LIGHT, linewidths=0,
            antialiased=False, rasterized=True,
        ))  # fmt: skip
    axes.patch.set_visible(False)  # it would cover the labels of the panel before
    axes.set_box_aspect(tuple(box), zoom=1.0)
    axes.set_proj_type("persp", focal_length=0.6)
    for name, edge in zip(AXES, box):
        axes.set(**{f"{name}lim": (0, edge)})
        along = getattr(axes, f"{name}axis")
        along.set_major_locator(MaxNLocator(3))
        along.set_label_text(f"${name}$ / $r_c$")
        along.labelpad = -10
    axes.tick_params(pad=-4)


def draw_legend(figure: Figure, colours: Mapping[str, Any]) -> None:
    """The colours of species above the picture; nothing if there are none."""
    if not colours:
        return
    dots = [Line2D([], [], ls="none", marker="o", ms=5, color=c) for c in colours.values()]
    legend = figure.legend(
        dots, [" "] * len(dots), loc="outside upper center", ncols=PER_ROW, handletextpad=0.1,
    )  # fmt: skip
    for text, name in zip(legend.get_texts(), colours):
        text.set_parse_math(False)  # names come from files, and may begin with an underscore
        text.set_text(name)
