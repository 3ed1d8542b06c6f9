"""A run of a scene of your own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dpd.commands.options import (
    add_checkpoints,
    add_overwrite,
    add_threads,
    options_of,
    print_summary,
)

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    run = stages.add("run", _run, "run a scene of your own", "scene", output="run.nc")
    add_checkpoints(run)
    run.add_argument(
        "--start", type=Path, metavar="FILE",
        help="first configuration: if the file is there, it is read (GSD, LAMMPS data, a run.nc or "
        "start.nc, a checkpoint), with its velocities; otherwise made and kept in it",
    )  # fmt: skip
    run.add_argument(
        "--page", type=Path, metavar="FILE", action="append", default=[],
        help="a Python file with pages of your own, which the scene may then name",
    )  # fmt: skip
    run.add_argument(
        "--set", metavar="KEY=VALUE", action="append", default=[],
        help="another value than the scene has, as integrator.dt=0.02 or 'repulsion.A A=30'",
    )  # fmt: skip
    add_threads(run)
    add_overwrite(run)


def _run(options: Namespace) -> None:
    from dpd.files import check_output
    from dpd.runs.run import run
    from dpd.scene.scene import Scene

    check_output(options.output, ".nc", [options.scene])
    scene = Scene.read(options.scene, options.page, options.set)
    for sentence in scene.notes:
        print(sentence)
    how = options_of(options, own=True, label=options.scene)
    print_summary(run(scene, options.output, options.start, how))
