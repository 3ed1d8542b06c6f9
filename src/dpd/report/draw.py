"""Pictures of a configuration: beads as discs, bonds as strips, seen along an axis of the box."""

from __future__ import annotations

import math
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import EllipseCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from dpd.engine.space import nearest
from dpd.errors import UserError, shown
from dpd.files import check_output, replace_whole
from dpd.particles.fields import fields_of, read_fields
from dpd.particles.formats import read
from dpd.particles.netcdf import particles_of
from dpd.particles.particles import Particles, checked, molecules_of
from dpd.report.colours import LOOK, MANY, OF_SPECIES
from dpd.report.draw_fields import AXES, COLUMN, INCH, draw_fields, draw_legend

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.axes import Axes


SCREEN = 96  # pixels of a browser per inch
METADATA: dict[str, Any] = {".png": None, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
RASTER = 1000  # beads, from which on a PDF or SVG has them as pixels
TALLEST = 2.0  # height of a picture, in its widths
AROUND = 0.5  # inches that axes take beside the box
NEARER = {"x": 1, "y": -1, "z": 1}  # whether a larger coordinate is nearer to the viewer
DENSE, LARGEST, TOUCHING = 0.36, 0.4, 0.45  # radii: in mean distances, r_c, lengths of bonds
BOND = 0.7  # width of a bond, in radii of beads
LAYER, MOST_LAYERS = 0.5, 200  # thickness of what is drawn at once, in radii of beads
PALEST = 0.7  # share of white in the colour of what is farthest
RIM = 0.5  # share of black in the edge of a bead
GRAY = "#B4B4B4"  # beads without bonds among molecules
CLOSE = {2: 3.0, 3: 1.5}  # mean distances of beads within which molecules are neighbours


class Picture(Figure):
    """A figure that a notebook shows, once, whether or not it has imported pyplot."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """What IPython asks for: an image, and its width on the screen."""
        with BytesIO() as image:
            self.savefig(image, format="png")
            return image.getvalue(), {"width": round(SCREEN * self.get_figwidth())}


def draw(
    source: str | Path | Particles | xr.Dataset, frame: int | Sequence[int] = -1, *,
    slice: str | None = None, surface: str | Sequence[str] = (), smooth: float = 0.5,
    species: str | Sequence[str] = (), colour: str | None = None, view: str | None = None,
    slab: Sequence[Any] | None = None, radius: float | None = None, size: float | None = None,
    dpi: float = 300,
) -> Figure:  # fmt: skip
    """Draw a configuration; or, with ``slice`` or ``surface``, the density fields of a run.

    Parameters
    ----------
    source : path, Particles or xarray.Dataset
        A file that `dpd.particles.formats.read` knows, as ``run.nc`` or ``run.gsd``; or a
        configuration; or a run.
    frame
        Of a trajectory or of density fields; several of these stand side by side.
    slice
        The plane in which density fields are drawn, as ``z=5`` in r_c.
    surface
        What is drawn is denser than that, as ``A=0.4`` in beads per r_c^dimension.
    smooth
        Standard deviation in r_c of the Gaussian over which a density field is averaged.
    species
        Those that are drawn, if not all.
    colour
        What colours tell: ``species``; or ``molecule``, usual where all beads are of one species.
    view
        The axis along which beads are seen; that of the shortest edge if not given.
    slab
        Axis, low and high end in r_c of what is drawn of beads, seen along that axis.
    radius
        Of beads in r_c; without it such that neighbours can be told apart.
    size
        Width of the picture in cm: usually 8.6, or 17.8 of several panels.
    dpi
        Pixels per inch.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it where it is the last line of a cell.

    Raises
    ------
    UserError
        If the file cannot be read or does not hold what is drawn, or a choice is not allowed.
    """
    for name, value, least, most in (
        ("size", COLUMN if size is None else size, 2, 50), ("dpi", dpi, 20, 1200),
        ("radius", 1 if radius is None else radius, 1e-3, 1e3), ("smooth", smooth, 0, 1e3),
    ):  # fmt: skip
        if not least <= value <= most:
            raise UserError(f"{name}: {value:g} is out of range; allowed: {least:g} to {most:g}")
    species, surface = (tuple([v] if isinstance(v, str) else v) for v in (species, surface))
    frames = [int(number) for number in np.atleast_1d(frame)]
    path = source if isinstance(source, (str, Path)) else "the particles or the run"
    with mpl.rc_context(LOOK):
        figure = Picture(dpi=dpi, layout="constrained")
        if slice is not None or surface:
            if slice is not None and surface:
                raise UserError("slice, surface: one of both is drawn; leave the other out")
            of_beads = {"colour": colour, "view": view, "slab": slab, "radius": radius}
            for name in [name for name, value in of_beads.items() if value is not None]:
                raise UserError(f"{name}: has no effect on density fields; leave it out")
            fields = (
                read_fields(Path(source)) if source is path else fields_of(_variables(source), path)
            )
            draw_fields(figure, fields, frames, slice, surface, smooth, species, size, path)
            return figure
        if len(frames) != 1:
            raise UserError("frame: a picture of beads shows one; slices and surfaces show several")
        if isinstance(source, Particles):
            particles = checked(source, path)
        elif isinstance(source, (str, Path)):
            particles = read(source, frames[0])
        else:
            particles = particles_of(_variables(source), source.attrs, path)
        _draw_particles(figure, particles, species, colour, view, slab, radius, size, path)
    return figure


def _variables(source: Any) -> dict[str, np.ndarray]:
    """What the dataset of a run holds; a configuration holds no fields."""
    return {str(name): found.values for name, found in getattr(source, "variables", {}).items()}


def _draw_particles(
    figure: Figure, particles: Particles, species: tuple[str, ...], colour: str | None,
    view: str | None, slab: Sequence[Any] | None, radius: float | None, size: float | None,
    path: object,
) -> None:  # fmt: skip
    """Beads and bonds in the box with its scales, and a legend."""
    for name in species:
        if name not in particles.names:
            allowed = ", ".join(particles.names)
            raise UserError(f"{path}: no species is called {shown(name)}; allowed: {allowed}")
    axis, low, high = _seen(particles, view, slab, path)
    colours, legend = _colours(particles, colour, path)
    drawn = species or particles.names
    visible = np.isin(particles.species, [particles.names.index(name) for name in drawn])
    if axis:
        depth = particles.position[AXES.index(axis)]
        visible &= (depth >= low) & (depth <= high)
    right, up = (k for k in range(particles.dimension) if AXES[k] != axis)
    width, edges = (size or COLUMN) / INCH, particles.box
    height = (width - AROUND) * edges[up] / edges[right] + AROUND
    figure.set_size_inches(width, min(height + 0.2 * bool(legend), TALLEST * width))
    axes = figure.add_subplot(aspect="equal", axisbelow=False)
    axes.set(
        xlim=(0, edges[right]), ylim=(0, edges[up]), xlabel=f"${AXES[right]}$ / $r_c$",
        ylabel=f"${AXES[up]}$ / $r_c$",
        title="" if slab is None else f"{low:g} < ${axis}$ / $r_c$ < {high:g}",
    )  # fmt: skip
    _draw_beads(axes, particles, visible, axis, colours, radius or usual_radius(particles))
    draw_legend(figure, {name: legend[name] for name in legend if name in drawn})


def draw_file(source: str | Path, path: str | Path, **choices: Any) -> None:
    """Draw into a ``.png``, ``.pdf`` or ``.svg``.

    Parameters
    ----------
    **choices
        As for `draw`.

    Raises
    ------
    UserError
        As `draw` does, or if the picture cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in METADATA:
        raise UserError(
            f"{path}: its name does not say what kind of picture it is; allowed: "
            f"{', '.join(METADATA)}"
        )
    check_output(path, inputs=[source])
    figure = draw(source, **choices)
    with mpl.rc_context(LOOK):
        replace_whole(
            path,
            lambda draft: figure.savefig(
                draft, dpi="figure", format=suffix[1:], metadata=METADATA[suffix]
            ),
        )


def _seen(
    particles: Particles, view: str | None, slab: Sequence[Any] | None, path: object
) -> tuple[str, float, float]:
    """The axis along which beads are seen, none in two dimensions, and from where to where."""
    if particles.dimension == 2:
        if view is not None or slab is not None:
            raise UserError(f"{path}: two dimensions are drawn whole; leave view and slab out")
        return "", 0.0, 0.0
    edges = dict(zip(AXES, particles.box))
    try:
        axis, low, high = slab or (view or min("yxz", key=edges.__getitem__), 0, math.inf)
        low, high = float(low), min(float(high), edges[axis])
    except (TypeError, ValueError, KeyError):
        axis, low, high = "", 0.0, 0.0
    if not (axis and low < high and high > 0) or view not in (None, axis):
        raise UserError(
            f"{path}: slab {shown(slab)}, view {shown(view)}: not in the box; allowed: a view "
            f"along {', '.join(AXES)}, or as slab an axis and from where to where in r_c, as in "
            f"z 0 2; the edges are {', '.join(f'{edge:g}' for edge in particles.box)}"
        )
    return axis, max(low, 0.0), high


def usual_radius(particles: Particles) -> float:
    """Radius in r_c at which neighbours, and bonds between them, can be told apart."""
    spacing = (np.prod(particles.box) / particles.beads) ** (1 / particles.dimension)
    radius = min(DENSE * float(spacing), LARGEST)
    length = float(np.linalg.norm(_bonds(particles), axis=0).mean()) if len(particles.bonds) else 0
    return min(radius, TOUCHING * length) if length > 0 else radius


def _bonds(particles: Particles) -> np.ndarray:
    """(dimension, bonds) from the first to the second bead, at the nearest image."""
    one, other = particles.position[:, particles.bonds.T].swapaxes(0, 1)
    return nearest(other - one, particles.box)


# Colours.


def _colours(
    particles: Particles, colour: str | None, path: object
) -> tuple[np.ndarray, dict[str, str]]:
    """(n, 3) colours of beads, and what a legend says of them."""
    several, bonded = len(particles.names) > 1, len(particles.bonds) > 0
    colour = colour or ("species" if several or not bonded else "molecule")
    if colour not in ("species", "molecule") or (colour == "molecule" and not bonded):
        raise UserError(
            f"{path}: colour {shown(colour)}: allowed are species and, where beads are bonded, "
            "molecule"
        )
    if colour == "molecule":
        return np.array([to_rgb(name) for name in (*MANY, GRAY)])[_kinds(particles)], {}
    names = {name: OF_SPECIES[k % len(OF_SPECIES)] for k, name in enumerate(particles.names)}
    return np.array([to_rgb(name) for name in names.values()])[particles.species], (
        names if several else {}
    )


def _kinds(particles: Particles) -> np.ndarray:
    """(n,) numbers of colours; neighbouring molecules differ as far as there are colours.

    One after the other takes the colour that the fewest of its neighbours have, and among such the
    one that was taken least often. Beads without bonds have the last number.
    """
    from scipy.sparse import coo_array
    from scipy.spatial import cKDTree

    molecules = molecules_of(particles)
    spacing = (np.prod(particles.box) / particles.beads) ** (1 / particles.dimension)
    reach = min(CLOSE[particles.dimension] * spacing, 0.49 * min(particles.box))
    tree = cKDTree(particles.position.T, boxsize=particles.box)
    one, other = molecules[tree.query_pairs(reach, output_type="ndarray")].T
    count = molecules.max() + 1
    close = coo_array((np.ones(len(one)), (one, other)), (count, count))
    close = (close + close.T).tocsr()
    taken, often = np.full(count, len(MANY)), np.zeros(len(MANY))
    for molecule in np.flatnonzero(np.bincount(molecules) > 1):
        row = slice(*close.indptr[molecule : molecule + 2])
        near = taken[close.indices[row]]
        weights = np.bincount(near, close.data[row], len(MANY) + 1)[:-1]
        taken[molecule] = np.lexsort((often, weights))[0]
        often[taken[molecule]] += 1
    return taken[molecules]


# Beads and bonds.


def _draw_beads(
    axes: Axes, particles: Particles, visible: np.ndarray, axis: str, colours: np.ndarray,
    radius: float,
) -> None:  # fmt: skip
    """Draw from the farthest layer to the nearest: in each the bonds, then the beads."""
    plane = [number for number in range(particles.dimension) if AXES[number] != axis]
    place, beads = particles.position[plane].T, np.flatnonzero(visible)
    near = np.zeros(particles.beads)
    if axis:
        near = NEARER[axis] * particles.position[AXES.index(axis)]
    low, high = (near[beads].min(), near[beads].max()) if len(beads) else (0.0, 0.0)
    layers = int(np.clip((high - low) / (LAYER * radius), 1, MOST_LAYERS))
    share = (near - low) / (high - low) if high > low else np.ones_like(near)
    colours = 1 - (1 - colours) * (1 - PALEST * (1 - share[:, None]))
    layer = np.clip((share * layers).astype(int), 0, layers - 1)
    ends, owner = _half_bonds(particles, visible, plane)
    rasterized = len(beads) > RASTER
    for number in np.unique(layer[beads]):
        of_bonds = layer[owner] == number
        strips = PolyCollection(
            list(_strips(ends[of_bonds], BOND * radius)), facecolors=colours[owner[of_bonds]],
            linewidths=0, zorder=1 + number / layers, rasterized=rasterized,
        )  # fmt: skip
        axes.add_collection(strips, autolim=False)
        here = beads[layer[beads] == number]
        here = here[np.argsort(near[here], kind="stable")]
        width = np.full(len(here), 2 * radius)
        discs = EllipseCollection(
            width, width, np.zeros(len(here)), units="xy", offsets=place[here],
            offset_transform=axes.transData, facecolors=colours[here],
            edgecolors=colours[here] * (1 - RIM), linewidths=0.3, rasterized=rasterized,
            zorder=1 + (number + 0.5) / layers,
        )  # fmt: skip
        axes.add_collection(discs, autolim=False)


def _half_bonds(
    particles: Particles, visible: np.ndarray, plane: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """(m, 2, 2) ends in the plane of both halves of bonds, and the beads that they belong to.

    A bond that crosses a face is there twice, from each of its beads on.
    """
    shown = visible[particles.bonds].all(axis=1)
    one, other = particles.bonds[shown].T
    apart = _bonds(particles)[plane][:, shown].T
    first, last = (particles.position[plane][:, bead].T for bead in (one, other))
    crosses = (np.abs(first + apart - last) > 1e-6).any(axis=1)
    halves = [(first, apart, one, other), (last, -apart, other, one)]
    ends = [np.stack([begin, begin + way / 2], axis=1) for begin, way, _, _ in halves]
    ends += [
        np.stack([begin + way / 2, begin + way], axis=1)[crosses] for begin, way, _, _ in halves
    ]
    owner = [one, other, other[crosses], one[crosses]]
    return np.concatenate(ends), np.concatenate(owner)


def _strips(ends: np.ndarray, width: float) -> np.ndarray:
    """(m, 4, 2) corners of strips around lines, whose ends are (m, 2, 2)."""
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along.T)[:, None]
    across = along[:, ::-1] * [-0.5, 0.5] * width / np.where(length > 0, length, 1)
    begin, end = ends[:, 0], ends[:, 1]
    return np.stack([begin - across, end - across, end + across, begin + across], axis=1)
