"""Pictures of a configuration: beads as discs, bonds as strips, seen along an axis of the box."""

from __future__ import annotations

import math
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dpd.engine.space import nearest
from dpd.errors import UserError, shown
from dpd.files import check_output, replace_whole
from dpd.particles import read
from dpd.particles.netcdf import fields_of, particles_of, read_fields
from dpd.particles.particles import Particles
from dpd.report.draw_fields import AXES, draw_fields, refuse_unknown
from dpd.report.style import LOOK, MANY, OF_SPECIES, SINGLE

if TYPE_CHECKING:
    import xarray as xr

SCREEN = 96  # pixels of a browser per inch
METADATA: dict[str, Any] = {".png": None, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
RASTER = 1000  # beads, from which on a PDF or SVG has them as pixels
TALLEST = 2.0  # height of a picture, in its widths
AROUND = 0.5  # inches that axes take beside the box
DENSE, LARGEST, OF_BOND = 0.36, 0.4, 0.45  # radii: in mean distances, r_c, lengths of bonds
BOND = 0.7  # width of a bond, in radii of beads
PALEST = 0.7  # share of white in the colour of what is farthest
RIM = 0.5  # share of black in the edge of a bead
CORNERS = 40  # of a disc
PER_ROW = 4  # species in a row of the legend
GRAY = "#B4B4B4"  # beads without bonds among molecules


class Picture(Figure):
    """A figure that a notebook shows, once, whether or not it has imported pyplot."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """What IPython asks for: an image, and its width on the screen."""
        with BytesIO() as image:
            self.savefig(image, format="png")
            return image.getvalue(), {"width": round(SCREEN * self.get_figwidth())}


def draw(
    source: str | Path | Particles | xr.Dataset, frame: int | Sequence[int] = -1, *,
    slice: str | None = None, smooth: float = 0.5,
    species: str | Sequence[str] = (), colour: str | None = None, view: str | None = None,
    slab: Sequence[Any] | None = None, radius: float | None = None, size: float | None = None,
    dpi: float = 300,
) -> Figure:  # fmt: skip
    """Draw a configuration; or, with ``slice``, the density fields of a run.

    A notebook shows the figure where it is the last line of a cell. `UserError` if the file cannot
    be read or does not hold what is drawn, or a choice is not allowed.

    Parameters
    ----------
    source
        A file that `dpd.particles.read` knows, as ``run.nc`` or ``run.gsd``; or a
        configuration; or a run.
    frame
        Of a trajectory or of density fields; several of these stand side by side.
    slice
        The plane in which density fields are drawn, as ``z=5`` in r_c.
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
    """
    for name, value, least, most in (
        ("size", size, 2, 50), ("dpi", dpi, 20, 1200), ("radius", radius, 1e-3, 1e3),
        ("smooth", smooth, 0, 1e3),
    ):  # fmt: skip
        if value is not None and not least <= value <= most:
            raise UserError(f"{name}: {value:g} is out of range; allowed: {least:g} to {most:g}")
    width = size and size / 2.54
    species = tuple([species] if isinstance(species, str) else species)
    frames = [int(number) for number in np.atleast_1d(frame)]
    path = source if isinstance(source, (str, Path)) else "the particles or the run"
    # What the dataset of a run holds; a configuration holds no fields.
    held = {str(name): found.values for name, found in getattr(source, "variables", {}).items()}
    with mpl.rc_context(LOOK):
        figure = Picture(dpi=dpi, layout="constrained")
        if slice is not None:
            of_beads = {"colour": colour, "view": view, "slab": slab, "radius": radius}
            for name in [name for name, value in of_beads.items() if value is not None]:
                raise UserError(f"{name}: has no effect on density fields; leave it out")
            fields = read_fields(Path(path)) if source is path else fields_of(held, path)
            draw_fields(figure, fields, frames, slice, smooth, species, width, path)
            return figure
        if len(frames) != 1:
            raise UserError(
                "frame: a picture of beads shows one; slices of density fields show several"
            )
        if isinstance(source, Particles):
            particles = source.checked(path)
        elif isinstance(source, (str, Path)):
            particles = read(source, frames[0])
        else:
            particles = particles_of(held, source.attrs, path)
        _draw_particles(figure, particles, species, colour, view, slab, radius, width, path)
    return figure


def draw_file(source: str | Path, path: str | Path, **choices: Any) -> None:
    """Draw into a ``.png``, ``.pdf`` or ``.svg``, with choices and errors as of `draw`."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in METADATA:
        allowed = f"allowed: {', '.join(METADATA)}"
        raise UserError(f"{path}: its name does not say what kind of picture it is; {allowed}")
    check_output(path, inputs=[source])
    figure, about = draw(source, **choices), {"metadata": METADATA[suffix], "dpi": "figure"}
    with mpl.rc_context(LOOK):
        replace_whole(path, lambda draft: figure.savefig(draft, format=suffix[1:], **about))


def _draw_particles(figure, particles, species, colour, view, slab, radius, width, path):
    """Beads and bonds in the box with its scales, and a legend."""
    refuse_unknown(species, particles.names, path)
    axis, low, high = _seen(particles, view, slab, path)
    colours, legend = _colours(particles, colour, path)
    drawn = species or particles.names
    visible = np.isin(particles.species, [particles.names.index(name) for name in drawn])
    depth = np.zeros(particles.beads)
    if axis:
        depth = particles.position[AXES.index(axis)]
        visible &= (depth >= low) & (depth <= high)
        depth = -depth if axis == "y" else depth  # so that all axes are right-handed
    right, up = [k for k in range(particles.dimension) if AXES[k] != axis]
    width, edges = width or SINGLE, particles.box
    height = (width - AROUND) * edges[up] / edges[right] + AROUND
    figure.set_size_inches(width, min(height + 0.2 * bool(legend), TALLEST * width))
    axes = figure.add_subplot(aspect="equal", axisbelow=False)
    axes.set(
        xlim=(0, edges[right]), ylim=(0, edges[up]), xlabel=f"${AXES[right]}$ / $r_c$",
        ylabel=f"${AXES[up]}$ / $r_c$",
        title="" if slab is None else f"{low:g} < ${axis}$ / $r_c$ < {high:g}",
    )  # fmt: skip
    if visible.any():
        beads = _beads(particles, [right, up], visible, depth, colours, radius)
        axes.add_collection(beads, autolim=False)
    if legend := {name: legend[name] for name in legend if name in drawn}:
        dots = [Line2D([], [], ls="none", marker="o", ms=5, color=c) for c in legend.values()]
        place = {"loc": "outside upper center", "ncols": PER_ROW, "handletextpad": 0.1}
        texts = figure.legend(dots, [" "] * len(dots), **place).get_texts()
        for text, name in zip(texts, legend):
            text.set_parse_math(False)  # names come from files, and may begin with an underscore
            text.set_text(name)


def _seen(particles, view, slab, path):
    """The axis along which beads are seen, none in two dimensions, and from where to where."""
    if particles.dimension == 2:
        if view is not None or slab is not None:
            raise UserError(f"{path}: two dimensions are drawn whole; leave view and slab out")
        return "", 0.0, 0.0
    edges = dict(zip(AXES, particles.box))
    axis, low, high = slab or (view or min("yxz", key=edges.__getitem__), 0, math.inf)
    try:
        low, high = max(float(low), 0.0), min(float(high), edges[axis])
    except (ValueError, KeyError):
        low = high = 0.0
    if not low < high or view not in (None, axis):
        raise UserError(
            f"{path}: slab {shown(slab)}, view {shown(view)}: not in the box; allowed: a view "
            f"along {', '.join(AXES)}, or as slab an axis and from where to where in r_c, as in "
            f"z 0 2; the edges are {', '.join(f'{edge:g}' for edge in particles.box)}"
        )
    return axis, low, high


def _colours(particles, colour, path):
    """(n, 3) colours of beads, and what a legend says of them."""
    several, bonded = len(particles.names) > 1, len(particles.bonds) > 0
    colour = colour or ("species" if several or not bonded else "molecule")
    if colour not in ("species", "molecule")[: 1 + bonded]:
        allowed = "allowed are species and, where beads are bonded, molecule"
        raise UserError(f"{path}: colour {shown(colour)}: {allowed}")
    if colour == "molecule":
        molecules = particles.molecules
        alone = np.bincount(molecules)[molecules] == 1
        chosen = np.where(alone, len(MANY), molecules % len(MANY))
        return to_rgba_array([*MANY, GRAY])[chosen, :3], {}
    names = {name: OF_SPECIES[k % len(OF_SPECIES)] for k, name in enumerate(particles.names)}
    found = to_rgba_array(list(names.values()))[particles.species, :3]
    return found, names if several else {}


def _beads(particles, plane, visible, depth, colours, radius):
    """Discs, each before the halves of its bonds, from the farthest to the nearest."""
    one, other = particles.bonds.T
    apart = nearest(particles.position[:, other] - particles.position[:, one], particles.box)
    if radius is None:  # such that neighbours, and bonds between them, can be told apart
        spacing = (np.prod(particles.box) / particles.beads) ** (1 / particles.dimension)
        length = np.linalg.norm(apart, axis=0).mean() if len(one) else math.inf
        radius = min(DENSE * float(spacing), LARGEST, OF_BOND * float(length) or LARGEST)
    beads, place = np.flatnonzero(visible), particles.position[plane].T
    both = visible[particles.bonds].all(axis=1)
    half, one, other = apart[plane][:, both].T / 2, one[both], other[both]
    # Each bead has its half of a bond: one that crosses a face leaves the box at both ends.
    owner, ways = np.concatenate([one, other]), np.concatenate([half, -half])
    length = np.hypot(*ways.T)[:, None]
    across = ways[:, ::-1] * [-0.5, 0.5] * BOND * radius / np.where(length > 0, length, 1)
    strips = place[owner][:, None] + np.stack([-across, ways - across, ways + across, across], 1)
    angle = np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    circle = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    shapes = [*strips, *(place[beads][:, None] + circle)]
    whose = np.concatenate([owner, beads])
    order = np.lexsort((np.arange(len(whose)) >= len(owner), whose, depth[whose]))
    low, high = depth[beads].min(), depth[beads].max()
    share = (depth - low) / (high - low) if high > low else np.ones_like(depth)
    colours = (1 - (1 - colours) * (1 - PALEST * (1 - share[:, None])))[whose[order]]
    return PolyCollection(
        [shapes[k] for k in order], facecolors=colours, edgecolors=colours * (1 - RIM),
        linewidths=np.where(order < len(owner), 0, 0.3), rasterized=len(beads) > RASTER,
    )  # fmt: skip
