"""Configurations of beads in files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dpd.commands.options import add_overwrite

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    convert = stages.add(
        "convert", _convert,
        "turn one configuration of beads into a file of another kind: GSD (.gsd), LAMMPS data "
        "(.data, .lmp, data.NAME) or NetCDF (.nc); checkpoints are read as well. Or the density "
        "field of a run.nc into VTK image data (.vti), for ParaView", "source", "target",
    )  # fmt: skip
    convert.add_argument(
        "--frame", type=int, default=-1, metavar="N",
        help="of a trajectory or a density field, from 0, or from the end: -1 is the last "
        "(default)",
    )  # fmt: skip
    add_overwrite(convert)


def _convert(options: Namespace) -> None:
    from dpd.files import check_output, refuse_to_replace
    from dpd.particles.fields import IMAGE
    from dpd.particles.formats import WRITTEN, read, refuse_suffix, write

    refuse_suffix(options.target, (*WRITTEN, IMAGE))
    check_output(options.target, inputs=[options.source])
    if not options.overwrite:
        refuse_to_replace(options.target)
    if Path(options.target).suffix.lower() == IMAGE:
        _convert_field(options)
        return
    particles = read(options.source, options.frame)
    sentences = [*particles.left_out, *write(particles, options.target)]
    print(f"{options.target}: {particles}")
    for sentence in sentences:
        print(sentence)


def _convert_field(options):
    from dpd.particles.fields import read_fields, write_image

    fields = read_fields(Path(options.source))
    frame = fields.number(options.frame, options.source)
    write_image(fields, frame, options.target)
    print(f"{options.target}: frame {frame} of {fields}, at t = {fields.time[frame]:g} tau")
