"""Pictures of density fields: slices with a colour bar, at one time or several."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dpd.errors import UserError, shown
from dpd.particles.netcdf import Fields
from dpd.particles.particles import frame_number
from dpd.report.style import DOUBLE, SINGLE

AXES = "xyz"
MOST_FRAMES = 8  # in one picture
LEAST = 0.5  # width of a Gaussian in cells, at which the grid does not show
PIXEL, MOST_PIXELS = 0.05, 600  # r_c of a slice, and along an axis
AROUND = 0.45  # inches beside and below panels


def draw_fields(
    figure: Figure, fields: Fields, frames: Sequence[int], slice: str, smooth: float,
    species: Sequence[str], width: float | None, path: object,
) -> None:  # fmt: skip
    """Draw slices of density fields; see `draw`; ``width`` in inches.

    A row for each species with one scale of colours, a column for each time.
    """
    if not 0 < len(frames) <= MOST_FRAMES:
        raise UserError(f"frame: {len(frames)} of them in one picture; allowed: 1 to {MOST_FRAMES}")
    numbers = [frame_number(frame, len(fields.time), path) for frame in frames]
    refuse_unknown(species, fields.names, path)
    axis, _, place = slice.partition("=")
    edges = dict(zip(AXES, fields.box.max(axis=0))) if fields.dimension == 3 else {"z": 0.0}
    at = float(place) if place.replace(".", "", 1).isdigit() else math.nan
    if axis not in edges or not 0 <= at <= edges[axis]:  # z=0 is all of two dimensions
        inside = ", ".join(f"{name}=0 to {edge:g}" for name, edge in edges.items())
        raise UserError(f"{path}: slice {slice}: is no plane in the box; allowed: {inside}")
    names, across = tuple(species) or fields.names, AXES.index(axis)
    right, up = (k for k in range(3) if k != across)
    width, box = width or (DOUBLE if len(numbers) > 1 else SINGLE), fields.box[numbers].max(axis=0)
    panel = ((width - 2 * AROUND) / len(numbers)) * box[up] / box[right]
    figure.set_size_inches(width, len(names) * (panel + AROUND))
    panels = figure.subplots(len(names), len(numbers), squeeze=False, sharex=True, sharey=True)
    for row, name in zip(panels, names):
        density = fields.density[:, fields.names.index(name)]
        images = [slice_of(density[n], fields.box[n], across, at, smooth) for n in numbers]
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
        axes.set_title(rf"$t$ = {fields.time[number]:.4g} $\tau$")
    for axes in panels[-1]:
        axes.set_xlabel(f"${AXES[right]}$ / $r_c$")


def refuse_unknown(species: Iterable[str], names: Sequence[str], path: object) -> None:
    """Refuse species that are not there."""
    for name in species:
        if name not in names:
            allowed = ", ".join(names)
            raise UserError(f"{path}: no species is called {shown(name)}; allowed: {allowed}")


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


def slice_of(
    density: np.ndarray, box: np.ndarray, axis: int, place: float, width: float
) -> np.ndarray:
    """A smoothed density in a plane across an axis: an image for `matplotlib.pyplot.imshow`."""
    places = [middles(min(int(np.ceil(e / PIXEL)), MOST_PIXELS), e) for e in box]
    if len(box) == 3:
        places[axis] = np.array([place])
    return smoothed(density, box, places, width).squeeze().T
