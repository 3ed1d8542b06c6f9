"""Draw one configuration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_rgb

from dpd.errors import UserError
from dpd.files import check_output, replace_whole
from dpd.particles.fields import fields_of, read_fields
from dpd.particles.formats import read
from dpd.particles.netcdf import particles_of
from dpd.particles.particles import Particles, checked
from dpd.report.pictures.camera import camera_of, region_of
from dpd.report.pictures.colouring import BRIGHTER, coloured_by, colours_of, mixed
from dpd.report.pictures.densities import draw_fields
from dpd.report.pictures.frame import (
    BEFORE,
    Picture,
    axes_of,
    draw_caption,
    draw_edges,
    draw_legend,
    draw_scales,
    ink_of,
    layout_of,
)
from dpd.report.pictures.layers import Fixed, balls_of, depth_of, draw_layers, sticks_of
from dpd.report.pictures.look import Look, check_beads, look_of
from dpd.report.pictures.shapes import usual_radius, visible_beads

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.figure import Figure

    from dpd.particles.fields import Fields

PICTURES = (".png", ".pdf", ".svg")
WITHOUT_DATE = {".png": None, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
SAVED: Any = {"pdf.fonttype": 42, "svg.hashsalt": "dpd-papers"}  # the same bytes each time
RASTER = 1000  # beads, from which on a PDF or SVG has them as pixels


def draw(
    source: str | Path | Particles | xr.Dataset, frame: int | Sequence[int] = -1, **choices: Any
) -> Figure:
    """Draw a configuration; or, with ``slice`` or ``surface``, the density fields of a run.

    Parameters
    ----------
    source : path, Particles or xarray.Dataset
        A file that `dpd.particles.formats.read` knows, as ``run.nc`` or ``run.gsd``; or a
        configuration; or a run with the last configuration in it.
    frame : int or sequence of int
        Of a trajectory or of density fields; the last one if not given. Several frames of density
        fields stand side by side.
    **choices
        Attributes of `dpd.report.pictures.look.Look`: colour, species, slab, view, radius, caption,
        dark, size, dpi, and of density fields slice, surface, smooth. A slice is ``"z=5"`` or
        ``("z", 5)``; surfaces are ``"A=0.4"``, several of these, or ``{"A": 0.4, "B": 1}``.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it where it is the last line of a cell.

    Raises
    ------
    UserError
        If the file cannot be read or holds no configuration, or a choice is not allowed.
    """
    look = look_of(choices)
    if look.shows_fields:
        fields, where = _fields(source)
        return draw_fields(fields, _several(frame), look, where)
    if isinstance(source, (str, Path)):
        return _figure(read(source, _single(frame)), look, source)
    if not isinstance(source, Particles):
        variables = {str(name): variable.values for name, variable in source.variables.items()}
        source = particles_of(variables, source.attrs, "the run")
    return _figure(checked(source, "the particles"), look, "the particles")


def draw_file(
    source: str | Path, path: str | Path, frame: int | Sequence[int] = -1, **choices: Any
) -> Particles | Fields:
    """Draw a configuration, or density fields, into a file.

    Parameters
    ----------
    source : path
    path : path
        Of the picture: ``.png``, ``.pdf`` or ``.svg``.
    frame, **choices
        As for `draw`.

    Returns
    -------
    Particles or Fields
        What was drawn, or of which some frames were.

    Raises
    ------
    UserError
        As `draw` does, or if the picture cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in PICTURES:
        raise UserError(
            f"{path}: its name does not say what kind of picture it is; allowed: "
            f"{', '.join(PICTURES)}"
        )
    check_output(path, inputs=[source])
    look = look_of(choices)
    drawn: Particles | Fields
    if look.shows_fields:
        drawn = read_fields(Path(source))
        figure = draw_fields(drawn, _several(frame), look, source)
    else:
        drawn = read(source, _single(frame))
        figure = _figure(drawn, look, source)
    with mpl.rc_context(SAVED):
        replace_whole(
            path,
            lambda draft: figure.savefig(
                draft, format=suffix[1:], dpi=look.dpi, metadata=WITHOUT_DATE[suffix]
            ),
        )
    return drawn


def _fields(source):
    """The density fields of a file or a dataset, and what to call that in messages."""
    if isinstance(source, (str, Path)):
        return read_fields(Path(source)), source
    if isinstance(source, Particles):
        raise UserError("the particles have no density fields; draw the run.nc that has them")
    variables = {str(name): variable.values for name, variable in source.variables.items()}
    return fields_of(variables, "the run"), "the run"


def _several(frame):
    """The frames of a picture of density fields."""
    return [int(number) for number in np.atleast_1d(frame)]


def _single(frame):
    """The one frame of a picture of beads."""
    if np.size(frame) != 1:
        raise UserError("frame: a picture of beads shows one; several are for a slice or surfaces")
    return _several(frame)[0]


def _figure(particles, look, path):
    check_beads(look, particles, path)
    figure = Picture(dpi=look.dpi, layout="none")
    draw_into(figure, particles, look, fixed_of(particles, look))
    return figure


def fixed_of(particles: Particles, look: Look) -> Fixed:
    """Size and colours of beads."""
    colours = colours_of(particles, look)
    if look.dark:
        colours = colours._replace(palette=mixed(colours.palette, np.ones(3), BRIGHTER))
    return Fixed(look.radius or usual_radius(particles), colours)


def draw_into(figure: Figure, particles: Particles, look: Look, fixed: Fixed) -> None:
    """Draw a configuration into a figure, in the place of what is there.

    Parameters
    ----------
    figure : Figure
    particles : Particles
    look : Look
        Checked against these particles by `check_beads`.
    fixed : Fixed
    """
    region = region_of(particles.box, look)
    camera = camera_of(region, look)
    visible = visible_beads(particles, region, look)
    legend = _legend(particles, look, fixed)
    layout = layout_of(region, camera, fixed.radius, look, len(legend))
    paper, ink = ink_of(look)
    figure.clear()
    figure.set(facecolor=paper, figwidth=layout.width, figheight=layout.height)
    axes = axes_of(figure, layout)
    axes.set_facecolor(paper)
    if visible.sum() > RASTER:
        axes.set_rasterization_zorder(BEFORE)
    draw_layers(
        axes,
        balls_of(particles, visible, camera, fixed),
        sticks_of(particles, visible, camera, fixed),
        depth_of(region, camera, np.array(to_rgb(paper))),
    )
    if camera is None:
        draw_scales(axes, ink)
    else:
        draw_edges(axes, region, camera, fixed.radius, ink)
    draw_legend(figure, legend, ink)
    if look.caption:
        draw_caption(figure, particles, int(visible.sum()), ink)


def _legend(particles, look, fixed):
    """Species and colours: none where the colours tell something else, or there is one only."""
    if len(particles.names) == 1 or coloured_by(particles, look) != "species":
        return {}
    colours = zip(particles.names, fixed.colours.palette)
    return {name: colour for name, colour in colours if not look.species or name in look.species}
