"""Pictures and movies of beads and bonds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dpd.arguments import steps
from dpd.commands.options import add_overwrite
from dpd.errors import UserError

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.parser import Stages

CHOICES = (
    "colour", "species", "slab", "view", "radius", "caption", "dark", "size", "dpi",
    "slice", "surface", "smooth",
)  # fmt: skip


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    draw = stages.add(
        "draw", _draw, "draw the beads and bonds of a configuration, or density fields", "file"
    )
    draw.description = (
        "Draw a configuration: the last one of a run.nc, a first one, a checkpoint, a frame of a "
        "trajectory (.gsd), or LAMMPS data. Or draw the density fields of a run.nc, as slices or "
        "surfaces."
    )
    draw.add_argument(
        "--slice", metavar="AXIS=PLACE",
        help="draw the density of each species (or of --species) in a plane, as in z=5, in r_c; "
        "fields of two dimensions lie in z=0",
    )  # fmt: skip
    draw.add_argument(
        "--surface", nargs="+", metavar="SPECIES=DENSITY",
        help="draw the surface around all that is denser, as in A=0.4, in beads per r_c^3; in two "
        "dimensions a line",
    )  # fmt: skip
    draw.add_argument(
        "--smooth", type=float, metavar="R",
        help="width in r_c over which a density field is averaged for a picture (standard "
        "deviation of a Gaussian; default 0.5)",
    )  # fmt: skip
    draw.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="picture (.png, .pdf, .svg; default: a .png beside the file)",
    )  # fmt: skip
    draw.add_argument(
        "--colour", choices=("species", "molecule"),
        help="what the colours tell (default: molecule if all beads are of one species and some "
        "are bonded, otherwise species)",
    )  # fmt: skip
    draw.add_argument("--species", nargs="+", metavar="NAME", help="draw these only")
    draw.add_argument(
        "--slab", nargs=3, metavar=("AXIS", "LOW", "HIGH"),
        help="draw a slice of the box, in r_c, as in z 0 2, and look straight at it",
    )  # fmt: skip
    draw.add_argument(
        "--view", nargs=2, metavar=("AZIMUTH", "ELEVATION"),
        help="from where to look, in degrees (default 25 20): 0 0 looks along y with z upwards, "
        "90 0 from the end of the x axis, 0 90 from above",
    )  # fmt: skip
    draw.add_argument("--radius", type=float, metavar="R", help="of beads, in r_c")
    draw.add_argument(
        "--caption", action="store_true", help="say beads, density and step below the picture"
    )
    draw.add_argument("--dark", action="store_true", help="draw on black")
    draw.add_argument(
        "--size",
        type=float,
        metavar="CM",
        help="width of the picture (default 8.6, a column; of several panels 17.8)",
    )
    draw.add_argument("--dpi", type=float, help="pixels per inch (default 300; of a movie 150)")
    draw.add_argument(
        "--frame", type=int, nargs="+", default=[-1], metavar="N",
        help="of a trajectory, from 0, or from the end: -1 is the last (default); of density "
        "fields also several, side by side",
    )  # fmt: skip
    draw.add_argument(
        "--movie", type=Path, metavar="FILE",
        help="make a movie of a trajectory instead (.gif; .mp4 needs the program ffmpeg)",
    )  # fmt: skip
    draw.add_argument(
        "--every", type=steps, default=1, metavar="N", help="frames of the trajectory from one of "
        "the movie to the next (default 1)",
    )  # fmt: skip
    draw.add_argument(
        "--rate", type=float, default=20, metavar="N", help="frames per second (default 20)"
    )
    add_overwrite(draw)


def _draw(options: Namespace) -> None:
    given = {name: getattr(options, name) for name in CHOICES}
    choices = {name: value for name, value in given.items() if value is not None}
    if options.movie:
        _movie(options, choices)
        return
    from dpd.files import refuse_to_replace
    from dpd.report.pictures.draw import draw_file

    path = options.output or Path(options.file).with_suffix(".png")
    if not (options.output or options.overwrite):  # nobody has named the picture
        refuse_to_replace(path)
    particles = draw_file(options.file, path, options.frame, **choices)
    print(f"{path}: {particles}")


def _movie(options, choices):
    from dpd.report.pictures.movie import movie

    if options.output:
        raise UserError("-o and --movie: a picture or a movie is made, not both; leave one out")
    frames = movie(options.file, options.movie, options.every, options.rate, **choices)
    print(f"{options.movie}: {frames} frames")
