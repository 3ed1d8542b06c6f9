"""How a configuration is drawn: what a person can choose."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from dpd.errors import UserError, shown

if TYPE_CHECKING:
    from dpd.particles.particles import Particles

COLUMN = 8.6  # cm, one column of a journal
INCH = 2.54  # cm
MOST_PIXELS = 10_000  # of the width
AXES = "xyz"
COLOURS = ("species", "molecule")
# Least and most of what is a number.
RANGES = {"size": (2.0, 100.0), "dpi": (20, 2400), "radius": (1e-3, 1e3), "smooth": (0, 1e3)}
SMOOTH = 0.5  # r_c, over which a density field is averaged if not chosen
# Choices that decide nothing in a picture of density fields, and those that do only there.
OF_BEADS, OF_FIELDS = ("colour", "slab", "radius", "caption"), ("smooth",)


class Slab(NamedTuple):
    """A slice of the box, from ``low`` to ``high`` along an axis, in r_c."""

    axis: str
    low: float
    high: float


class Slice(NamedTuple):
    """A plane across an axis, at a place in r_c."""

    axis: str
    place: float


class Surface(NamedTuple):
    """Where a species has a density, in beads per r_c^dimension."""

    species: str
    value: float


class View(NamedTuple):
    """Where one looks from, in degrees.

    At (0, 0) one looks along y, with x to the right and z upwards. A positive azimuth moves the
    viewer around z, from the side of low y to that of high x. At the elevation 90 one looks down
    along z.
    """

    azimuth: float
    elevation: float


class Look(NamedTuple):
    """What a person can choose of a picture.

    Attributes
    ----------
    colour : str or None
        What the colours tell: ``species`` or ``molecule``. Without it, molecules where all beads
        are of one species and some are bonded, otherwise species.
    species : tuple of str
        The species that are drawn; all of them if empty.
    slab : Slab or None
        The slice of the box that is drawn; all of it without.
    view : View or None
        Without it, from above the front edge of the box, or straight at the slab.
    radius : float or None
        Of beads as they are drawn, in r_c. Without it, such that neighbours can be told apart.
    caption : bool
        Whether a line below the picture says beads, density and step.
    dark : bool
        Whether the background is black.
    size : float or None
        Width of the picture in cm. Without it, a column of a journal, or two for several panels.
    dpi : float
        Pixels per inch.
    slice : Slice or None
        The plane in which density fields are drawn, in place of beads.
    surface : tuple of Surface
        The surfaces in density fields that are drawn, in place of beads; by increasing value.
    smooth : float or None
        Standard deviation in r_c of the Gaussian over which a density field is averaged; `SMOOTH`
        without it. Half a cell at least.
    """

    colour: str | None = None
    species: tuple[str, ...] = ()
    slab: Slab | None = None
    view: View | None = None
    radius: float | None = None
    caption: bool = False
    dark: bool = False
    size: float | None = None
    dpi: float = 300
    slice: Slice | None = None
    surface: tuple[Surface, ...] = ()
    smooth: float | None = None

    @property
    def shows_fields(self) -> bool:
        """Whether density fields are drawn, in place of beads."""
        return self.slice is not None or bool(self.surface)


def look_of(choices: dict[str, Any]) -> Look:
    """The choices of a person, checked as far as that goes without beads.

    Parameters
    ----------
    choices : dict
        Names and values of some attributes of `Look`; plain tuples for ``slab`` and ``view``.

    Raises
    ------
    UserError
        If a name is unknown, or a value is not allowed.
    """
    for name in choices:
        if name not in Look._fields:
            raise UserError(
                f"there is no choice {name!r} for a picture; allowed: {', '.join(Look._fields)}"
            )
    look = Look(**choices)
    if look.colour not in (None, *COLOURS):
        raise UserError(f"colour: {shown(look.colour)} is unknown; allowed: {', '.join(COLOURS)}")
    for name, (least, most) in RANGES.items():
        value = getattr(look, name)
        if value is not None and not (_is_number(value) and least <= value <= most):
            raise UserError(
                f"{name}: {shown(value)} is out of range; allowed: {least:g} to {most:g}"
            )
    size = look.size or COLUMN
    if size / INCH * look.dpi > MOST_PIXELS:
        raise UserError(
            f"a picture of {size:g} cm with {look.dpi:g} pixels per inch would be wider than "
            f"{MOST_PIXELS} pixels; make 'size' or 'dpi' smaller"
        )
    one = (look.species,) if isinstance(look.species, str) else look.species
    look = look._replace(
        species=tuple(one),
        slab=None if look.slab is None else _slab_of(look.slab),
        view=None if look.view is None else _view_of(look.view),
        slice=None if look.slice is None else _slice_of(look.slice),
        surface=_surfaces_of(look.surface),
    )
    _check_together(look, choices)
    return look


def check_beads(look: Look, particles: Particles, path: object) -> None:
    """Refuse choices that do not fit to some beads.

    Parameters
    ----------
    look : Look
    particles : Particles
    path : path
        Where they come from, for messages.

    Raises
    ------
    UserError
        If a species is not there, if two dimensions are to have a third, if the slab lies outside
        of the box, or if the colours of molecules are asked for where there are none.
    """
    for name in look.species:
        if name not in particles.names:
            raise UserError(
                f"{path}: no species is called {shown(name)}; allowed: {', '.join(particles.names)}"
            )
    if look.colour == "molecule" and not len(particles.bonds):
        raise UserError(f"{path}: no beads are bonded, so there are no molecules; colour species")
    if look.view is not None and particles.dimension == 2:
        raise UserError(f"{path}: two dimensions are seen from one side only; leave the view out")
    if look.slab is not None:
        axes = AXES[: particles.dimension]
        if look.slab.axis not in axes:
            raise UserError(
                f"{path}: there is no axis {shown(look.slab.axis)} to cut a slab along; allowed: "
                f"{', '.join(axes)}"
            )
        edge = particles.box[axes.index(look.slab.axis)]
        if look.slab.low >= edge or look.slab.high <= 0:
            raise UserError(
                f"{path}: the slab from {look.slab.low:g} to {look.slab.high:g} is outside of the "
                f"box, which goes from 0 to {edge:g} along {look.slab.axis}"
            )


def _slab_of(given: Any) -> Slab:
    try:
        axis, low, high = given
        slab = Slab(str(axis), float(low), float(high))
    except (TypeError, ValueError):
        slab = Slab("", math.nan, math.nan)
    if slab.axis not in tuple(AXES) or not -math.inf < slab.low < slab.high < math.inf:
        raise UserError(
            f"slab: {shown(given)} is no slice of a box; allowed: an axis, and from where to where "
            "in r_c, as in z 0 2"
        )
    return slab


def _check_together(look, choices):
    """Refuse choices that have no effect beside others."""
    if look.slice is not None and look.surface:
        raise UserError("a slice or surfaces are drawn, not both; leave one out")
    if look.surface and look.species:
        raise UserError("species: the surfaces say which ones are drawn; leave it out")
    idle = OF_BEADS if look.shows_fields else OF_FIELDS
    for name in idle:
        if choices.get(name):
            what = "density fields" if look.shows_fields else "beads"
            raise UserError(f"{name}: has no effect on a picture of {what}; leave it out")


def _slice_of(given: Any) -> Slice:
    try:
        axis, place = given.split("=") if isinstance(given, str) else given
        found = Slice(str(axis), float(place))
    except (TypeError, ValueError):
        found = Slice("", math.nan)
    if found.axis not in tuple(AXES) or not math.isfinite(found.place):
        raise UserError(
            f"slice: {shown(given)} is no plane; allowed: an axis and a place in r_c, as in z=5"
        )
    return found


def _surfaces_of(given: Any) -> tuple[Surface, ...]:
    """Surfaces from a mapping of species to a density, or from words as A=0.4, or from one."""
    if isinstance(given, Mapping):
        given = tuple(given.items())
    if isinstance(given, str):
        given = (given,)
    found = []
    for one in given:
        try:
            species, value = one.split("=") if isinstance(one, str) else one
            surface = Surface(str(species), float(value))
        except (TypeError, ValueError):
            surface = Surface("", math.nan)
        if not surface.species or not 0 < surface.value < math.inf:
            raise UserError(
                f"surface: {shown(one)} is none; allowed: a species and a density above 0, as in "
                "A=0.4"
            )
        found.append(surface)
    return tuple(sorted(found, key=lambda surface: surface.value))


def _view_of(given: Any) -> View:
    try:
        azimuth, elevation = given
        view = View(float(azimuth), float(elevation))
    except (TypeError, ValueError):
        view = View(math.nan, math.nan)
    if not (abs(view.azimuth) <= 360 and abs(view.elevation) <= 90):
        raise UserError(
            f"view: {shown(given)} is no direction; allowed: an azimuth from -360 to 360 and an "
            "elevation from -90 to 90 degrees, as in 25 20"
        )
    return view


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
