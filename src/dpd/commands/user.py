"""Commands for a scene of one's own: from an example to a picture."""

import json
import shlex
import time
from argparse import Namespace
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from textwrap import fill

from dpd.commands import (
    CHECKPOINTS,
    OVERWRITE,
    THREADS,
    called,
    command,
    option,
    options_of,
    positive,
)
from dpd.errors import UserError, suggestion

WIDTH = 100  # of a line
PAGE = option(
    "--page", type=Path, metavar="FILE", action="append", default=[],
    help="a Python file with pages of your own, whose sections a scene may then have",
)  # fmt: skip
SETTINGS = option(
    "--set", metavar="KEY=VALUE", action="append", default=[],
    help="another value than the scene has, as integrator.dt=0.02 or 'repulsion.A A=30'",
)  # fmt: skip


@command(
    option("name", nargs="?", help="of the example; without it all are listed"),
    option("-o", "--output", type=Path, metavar="FILE", help="where to, if not NAME.yaml here"),
    option("--paper", metavar="NAME", help="write a paper of your own into this clone instead: a "
           "sweep, a figure, a published number that it is held against, and what to say of that"),
    OVERWRITE,
)  # fmt: skip
def new(options: Namespace) -> None:
    """Write an example scene to begin with, or list all."""
    from dpd.files import check_output
    from dpd.folders import PACKAGE

    if options.paper is not None:
        _new_paper(options.paper, options.overwrite)
        return
    known = {path.stem: path.read_text() for path in sorted((PACKAGE / "scenes").glob("*.yaml"))}
    said = {name: text.splitlines()[0].removeprefix("# ") for name, text in known.items()}
    if options.name is None:
        for name in known:
            print(fill(f"{name}: {said[name]}", WIDTH, subsequent_indent="    "))
        return
    if options.name not in known:
        raise UserError(f"new: no example {options.name!r}; {suggestion(options.name, known)}")
    path = options.output or Path(f"{options.name}.yaml")
    check_output(path, ".yaml")
    write_texts({path: known[options.name]}, options.overwrite)
    print(f"{path}: {said[options.name]}")
    print(f"to run it: {called()} run {path} -o {path.stem}.nc")


def _new_paper(name, overwrite):
    """The example paper under another name."""
    from dpd.folders import PAPERS_DIR, ROOT, shortened
    from dpd.pipeline.paper import check_name, check_repository

    check_repository()
    check_name("papers", name)
    papers, figures = ROOT / "config" / "papers", ROOT / "paper_figures"
    to, figures_to = (PAPERS_DIR, PAPERS_DIR) if PAPERS_DIR else (papers, figures)
    if name == "example":
        raise UserError(f"--paper: {name!r} is what is copied; take another name")
    _, title, rest = (papers / "example.yaml").read_text().partition("title:")
    written = {to / f"{name}.yaml": (title + rest).replace("/example/", f"/{name}/")}
    for path in sorted((figures / "example").iterdir()):
        if path.is_file():
            written[figures_to / name / path.name] = path.read_text()
    write_texts(written, overwrite)
    print("\n".join(shortened(path) for path in written))
    where = f" papers_dir={shlex.quote(str(PAPERS_DIR))}" if PAPERS_DIR else ""
    print(f"to make it: snakemake --cores 2 --config papers='[{name}]'{where}")


def write_texts(written: Mapping[Path, str], overwrite: bool = True) -> None:
    """Write texts by their paths; none where a file is there, unless that is to be replaced."""
    from dpd.files import refuse_to_replace, replace_whole

    for path in written if not overwrite else ():
        refuse_to_replace(path)
    for path, text in written.items():
        replace_whole(path, partial(Path.write_text, data=text))


def _output_for(given, suffix, options):
    """The output, if not named that beside what is given, which is not replaced unasked."""
    from dpd.files import refuse_to_replace

    path = options.output or Path(given).with_suffix(suffix)
    if not (options.output or options.overwrite):
        refuse_to_replace(path)
    return path


@command(
    "scene", CHECKPOINTS,
    option("--start", type=Path, metavar="FILE", help="first configuration: if the file is there, "
           "it is read (GSD, LAMMPS data, a run.nc or start.nc, a checkpoint), with its "
           "velocities; otherwise made and kept in it"),
    PAGE,
    SETTINGS,
    option("--engine", choices=("lammps",), help="what moves the beads, if not our own engine"),
    option("--ranks", metavar="N", help="processes of that engine, by MPI (default 1)"),
    THREADS, OVERWRITE, output="run.nc",
)  # fmt: skip
def run(options: Namespace) -> None:
    """Run a scene of your own."""
    from dpd.runs.run import run
    from dpd.scene.scene import Scene

    for name, value in (("name", options.engine), ("ranks", options.ranks)):
        options.set += [f"engine.{name}={value}"] if value is not None else []
    scene = Scene.read(options.scene, options.page, options.set)
    for sentence in scene.notes:
        print(sentence)
    how = options_of(options, own=True, label=options.scene)
    _print_summary(run(scene, options.output, options.start, how))


def _print_summary(found: Mapping[str, float]) -> None:
    for name, value in found.items():
        print(f"{name:32s} {value:.6g}")


@command(
    "run",
    option("--sample", type=int, required=True, metavar="STEPS", help="steps of sampling to add"),
    option("-o", "--output", type=Path, metavar="FILE",
           help="longer.nc (default: in the place of the run, once it is whole)"),
    CHECKPOINTS, THREADS, OVERWRITE,
)  # fmt: skip
def extend(options: Namespace) -> None:
    """Make a finished run longer.

    It comes to the same bits as if it had been planned that long. Killed or stopped, the same
    command goes on.
    """
    from dpd.runs.run import extend

    run = Path(options.run)
    how = options_of(options, own=True)
    _print_summary(extend(run, options.sample, options.output or run, how))


@command(
    option("path", nargs="?", type=Path, help="results of a study, as results/quick (default: of "
           "that in config/config.yaml); or run.nc of a run of your own, or its folder"),
    option("--papers", nargs="+", help="if not those of config/config.yaml"),
    option("--json", action="store_true", help="as one line of JSON, for scripts"),
)  # fmt: skip
def status(options: Namespace) -> None:
    """Say what runs, how far it is, what failed, and what is left.

    Of a study: its runs at work with step, kT, pressure and speed; what is done, waits, was stopped
    or failed, and why. Of runs of your own the same. It only reads.
    """
    from dataclasses import asdict

    from dpd.pipeline.status import as_text, seconds_left, status_of

    title, runs = status_of(options.path, options.papers)
    if options.json:
        found = {"time": time.time(), "seconds_left": seconds_left(runs)}
        print(json.dumps(found | {"runs": [asdict(run) for run in runs]}))
    else:
        print(as_text(runs, title))


@command(
    "file",
    option("-o", "--output", type=Path, metavar="FILE",
           help="picture (.png, .pdf, .svg; default: a .png beside the file)"),
    option("--frame", type=int, nargs="+", metavar="N", help="of a trajectory, from 0, or from the "
           "end: -1 is the last (default); of density fields also several, side by side"),
    option("--slice", metavar="AXIS=PLACE", help="draw the density of each species (or of "
           "--species) in a plane, as in z=5, in r_c; fields of two dimensions lie in z=0"),
    option("--smooth", type=float, metavar="R", help="width in r_c over which a density field is "
           "averaged for a picture (standard deviation of a Gaussian; default 0.5)"),
    option("--species", nargs="+", metavar="NAME", help="draw these only"),
    option("--colour", choices=("species", "molecule"), help="what the colours tell (default: "
           "molecule if all beads are of one species and some are bonded, otherwise species)"),
    option("--view", choices=("x", "y", "z"), help="axis along which one looks (default: that of "
           "the shortest edge, y if all are alike)"),
    option("--slab", nargs=3, metavar=("AXIS", "LOW", "HIGH"),
           help="draw a slice of the box, in r_c, as in z 0 2, and look along that axis"),
    option("--radius", type=float, metavar="R", help="of beads, in r_c"),
    option("--size", type=float, metavar="CM",
           help="width of the picture (default 8.6, a column; of several panels 17.8)"),
    option("--dpi", type=float, help="pixels per inch (default 300)"),
    OVERWRITE,
)  # fmt: skip
def draw(options: Namespace) -> None:
    """Draw the beads and bonds of a configuration, or density fields.

    That is the last one of a run.nc, a first one, a checkpoint, a frame of a trajectory (.gsd), or
    LAMMPS data; or the density fields of a run.nc, as slices. Movies and other views:
    OVITO opens the .gsd of a run, ParaView the .vti that 'convert' writes, with surfaces in it.
    """
    from dpd.report.draw import draw_file

    path = _output_for(options.file, ".png", options)
    own = ("command", "file", "output", "overwrite")
    choices = {k: value for k, value in vars(options).items() if k not in own and value is not None}
    draw_file(options.file, path, **choices)
    print(path)


@command(
    option("of", help="run.nc of a run; or a study, of which the rest says more"),
    option("papers", nargs="*", help="of a study"),
    option("--results", type=Path, metavar="FOLDER", help="of a study"),
    option("--archived", type=Path, metavar="FILE", help="verdicts of a long study"),
    option("-o", "--output", type=Path, metavar="FILE",
           help="report.html (default: beside the run)"),
    OVERWRITE,
)  # fmt: skip
def report(options: Namespace) -> None:
    """Write a page on a run: its means, panels of all that was measured, and what is off.

    Of a study the report, from the figures that are made so far.
    """
    from dpd.files import check_output

    output = _output_for(options.of, ".html", options)
    check_output(output, ".html")
    if options.of.endswith(".nc"):
        from dpd.report.run_page import write_run_page

        write_run_page(Path(options.of), output)
        print(output)
        return
    if not (options.papers and options.results and options.output):
        raise UserError(
            f"{options.of}: is no run.nc; of a study, name its papers, --results and -o; "
            "'snakemake --cores 2' writes its report"
        )
    from dpd.pipeline.paper import read_paper, read_study
    from dpd.report.page import write_page

    papers = [read_paper(name, options.of, only=[]) for name in options.papers]
    description = read_study(options.of).description
    write_page(options.of, description, papers, options.results, output, options.archived)


@command(
    "source", "target",
    option("--frame", type=int, default=-1, metavar="N", help="of a trajectory or a density field, "
           "from 0, or from the end: -1 is the last (default)"),
    OVERWRITE,
)  # fmt: skip
def convert(options: Namespace) -> None:
    """Turn one configuration of beads into a file of another kind.

    GSD (.gsd), LAMMPS data (.data, .lmp, data.NAME) or NetCDF (.nc); checkpoints are read as well.
    Or the density field of a run.nc into VTK image data (.vti), for ParaView.
    """
    from dpd.files import check_output, refuse_to_replace
    from dpd.particles import WRITTEN, read, refuse_suffix, write
    from dpd.particles.netcdf import IMAGE, read_fields, write_image
    from dpd.particles.particles import frame_number

    refuse_suffix(options.target, (*WRITTEN, IMAGE))
    check_output(options.target, inputs=[options.source])
    if not options.overwrite:
        refuse_to_replace(options.target)
    if Path(options.target).suffix.lower() == IMAGE:
        fields = read_fields(Path(options.source))
        frame = frame_number(options.frame, len(fields.time), options.source)
        write_image(fields, frame, options.target)
        print(f"{options.target}: frame {frame} of {fields}, at t = {fields.time[frame]:g} tau")
        return
    particles = read(options.source, options.frame)
    sentences = [*particles.left_out, *write(particles, options.target)]
    print("\n".join([f"{options.target}: {particles}", *sentences]))


@command(
    "scene",
    option("input", type=Path, help="in.lammps; beside it, by the same name, the files it reads"),
    PAGE, SETTINGS, OVERWRITE,
)  # fmt: skip
def export(options: Namespace) -> None:
    """Write a scene with its first configuration as an input of LAMMPS, to go on there."""
    from dpd.lammps.input import input_of
    from dpd.scene.scene import Scene
    from dpd.start.common.make import make_start

    settings = [*options.set, "engine={name: lammps}"]  # so that it is refused if it cannot be
    scene, path = Scene.read(options.scene, options.page, settings), options.input
    if not (name := path.name.removeprefix("in.")) or name.split() != [name]:
        raise UserError(f"{path}: LAMMPS reads names of one word; choose one, as in.melt")
    lines, beside = input_of(scene, make_start(scene), name)
    runs = [f"run {steps}" for steps in scene.steps if steps]
    text = "\n".join(
        [f"# {options.scene}, written by dpd-papers", *lines, "thermo 1000", *runs, ""]
    )
    written = {path: text} | {path.with_name(name): each for name, each in beside.items()}
    write_texts(written, options.overwrite)
    print("\n".join(map(str, written)))


@command(option("section", nargs="?", help="such as walls, steps or rdf"), PAGE)
def keys(options: Namespace) -> None:
    """Say what a scene may say: all sections, or the keys of one."""
    from dpd.report.keys import scene_rows

    rows, section = scene_rows(_pages(options)), options.section
    if section is None:
        for row in rows:
            if "." not in row.key.removeprefix("observe[]."):
                print(fill(f"{row.key}: {row.meaning}", WIDTH, subsequent_indent="    "))
        return
    tops = [row.key.removeprefix("observe[].").split(".")[0].removesuffix("[]") for row in rows]
    if section not in tops:
        raise UserError(f"keys: no section {section!r}; {suggestion(section, sorted(set(tops)))}")
    for row in [row for row, top in zip(rows, tops) if top == section]:
        allowed = " ".join(filter(None, (row.allowed, row.unit and f"[{row.unit}]")))
        default = row.default
        if default and default != "required":
            default = f"if not given: {default}"
        print("; ".join(filter(None, [f"{row.key}: {allowed}", default])))
        print(fill(row.meaning, WIDTH, initial_indent="    ", subsequent_indent="    "))


@command(PAGE)
def schema(options: Namespace) -> None:
    """Print the JSON schema of scenes, by which editors complete keys.

    In a file schema.json it is that of a scene beside it that begins with the line
    '# yaml-language-server: $schema=schema.json', as VS Code has it.
    """
    from dpd.report.keys import scene_schema

    print(json.dumps(scene_schema(_pages(options)), indent=1))


def _pages(options):
    """The pages of the files that are named."""
    from dpd.page.own import load

    return {k: v for page in options.page for k, v in load(page.absolute(), "--page")[0].items()}


@command(
    option("--chi", type=positive, required=True, help="of two beads, chi_AB"),
    option("--density", type=positive, default=3.0, metavar="RHO",
           help="beads per r_c^3: 3 (default) or 5"),
    option("--length", type=int, default=1, metavar="N",
           help="beads of a molecule of A, and of one of B: 1 (default) to 10"),
    option("--kT", type=positive, default=1.0, help="temperature (default 1)"),
)  # fmt: skip
def repulsion(options: Namespace) -> None:
    """Say which repulsions give two species a Flory-Huggins parameter chi."""
    from dpd.theory.repulsion import LEAST, like_repulsion, relation_at, unlike_repulsion

    chi, length = options.chi, options.length
    try:
        relation = relation_at(options.density, length)
        like = like_repulsion(options.density, options.kT)
        unlike = unlike_repulsion(chi, options.density, length, options.kT)
    except ValueError as problem:
        raise UserError(f"repulsion: {problem}") from None
    lowest, highest = relation.chi_range(length)
    print(
        f"a_AA = a_BB  {like:.6g} kT / r_c, 75 kT / density: the compressibility of water\n"
        f"a_AB         {unlike:.6g} kT / r_c\n"
        f"chi N        {chi * length:.6g}\n"
        f"relation     {relation}\n"
        f"range        chi from {lowest:.3g} (chi N = {LEAST:g}) to {highest:g}\n"
        f"in a scene   repulsion: {{A A: {like:.6g}, B B: {like:.6g}, A B: {unlike:.6g}}}"
    )


@command(
    option("--density", type=positive, required=True, metavar="RHO",
           help="molecules (not beads) per r_c^3"),
    option("--pressure", type=positive, required=True, help="in kT / r_c^3"),
    option("--beads", type=int, default=1, metavar="M", help="of a molecule (default 1)"),
    option("--length", type=float, metavar="L",
           help="of a bond, in r_c; needed for 2 beads and more"),
)  # fmt: skip
def parameters(options: Namespace) -> None:
    """Say which repulsion gives a fluid a pressure, by three equations of state.

    GW: Groot and Warren 1997; rGW: Liyana-Arachchi et al. 2015; crGW: Minkara et al. 2019, which
    alone knows of bonds.
    """
    from dpd.theory.equation_of_state import crgw, gw, repulsion_of, rgw

    rho, m, wanted = options.density, options.beads, options.pressure
    if m > 1 and options.length is None:
        raise UserError(f"parameters: --length is missing; molecules of {m} beads have bonds")
    length = options.length or 0.0
    try:
        repulsions = {
            "GW": repulsion_of(wanted, gw, m * rho),
            "rGW": repulsion_of(wanted, rgw, m * rho),
            "crGW": repulsion_of(wanted, crgw, rho, m, length),
        }
        pressures = [crgw(rho, a, m, length) for a in repulsions.values()]
    except ValueError as problem:
        raise UserError(f"parameters: {problem}") from None
    bonds = f" with bonds of {length:g} r_c" if m > 1 else ""
    print(f"molecules of {m} bead{'s' if m > 1 else ''}{bonds}, {rho:g} per r_c^3")
    print(f"beads     {m * rho:.6g} per r_c^3")
    print(f"pressure  {wanted:g} kT / r_c^3\n")
    print("equation  a in kT / r_c  pressure by crGW at this a")
    for (name, a), pressure in zip(repulsions.items(), pressures, strict=True):
        print(f"{name:8s}  {a:13.4g}  {pressure:26.4g}")
