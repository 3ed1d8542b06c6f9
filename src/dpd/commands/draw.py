"""Pictures of beads and bonds, and of density fields."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dpd.commands.options import add_overwrite

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages

CHOICES = (
    "frame", "slice", "surface", "smooth", "species", "colour", "view", "slab", "radius", "size",
    "dpi",
)  # fmt: skip


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    draw = stages.add(
        "draw", _draw, "draw the beads and bonds of a configuration, or density fields", "file"
    )
    draw.description = (
        "Draw a configuration: the last one of a run.nc, a first one, a checkpoint, a frame of a "
        "trajectory (.gsd), or LAMMPS data. Or draw the density fields of a run.nc, as slices or "
        "surfaces. Movies and other views: OVITO opens the .gsd of a run, ParaView the .vti that "
        "'convert' writes."
    )
    draw.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="picture (.png, .pdf, .svg; default: a .png beside the file)",
    )  # fmt: skip
    draw.add_argument(
        "--frame", type=int, nargs="+", metavar="N",
        help="of a trajectory, from 0, or from the end: -1 is the last (default); of density "
        "fields also several, side by side",
    )  # fmt: skip
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
    draw.add_argument("--species", nargs="+", metavar="NAME", help="draw these only")
    draw.add_argument(
        "--colour", choices=("species", "molecule"),
        help="what the colours tell (default: molecule if all beads are of one species and some "
        "are bonded, otherwise species)",
    )  # fmt: skip
    draw.add_argument(
        "--view",
        choices=tuple("xyz"),
        help="axis along which one looks (default: that of the shortest edge, y if all are alike)",
    )
    draw.add_argument(
        "--slab", nargs=3, metavar=("AXIS", "LOW", "HIGH"),
        help="draw a slice of the box, in r_c, as in z 0 2, and look along that axis",
    )  # fmt: skip
    draw.add_argument("--radius", type=float, metavar="R", help="of beads, in r_c")
    draw.add_argument(
        "--size", type=float, metavar="CM",
        help="width of the picture (default 8.6, a column; of several panels 17.8)",
    )  # fmt: skip
    draw.add_argument("--dpi", type=float, help="pixels per inch (default 300)")
    add_overwrite(draw)


def _draw(options: Namespace) -> None:
    from dpd.files import refuse_to_replace
    from dpd.report.draw import draw_file

    path = options.output or Path(options.file).with_suffix(".png")
    if not (options.output or options.overwrite):  # nobody has named the picture
        refuse_to_replace(path)
    given = {name: getattr(options, name) for name in CHOICES}
    choices = {name: value for name, value in given.items() if value is not None}
    draw_file(options.file, path, **choices)
    print(path)
