"""Movies of trajectories."""

from __future__ import annotations

import subprocess
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from dpd.errors import UserError
from dpd.files import check_output, replace_whole
from dpd.particles.formats import read
from dpd.particles.gsd_files import trajectory_to_read
from dpd.progress import Progress
from dpd.report.pictures.draw import draw_into, fixed_of
from dpd.report.pictures.look import check_beads, look_of

MOVIES = (".gif", ".mp4")
FASTEST = 50  # frames per second; a GIF counts time in hundredths of a second
DPI = 150  # if not chosen: a quarter of a picture's pixels
MOST_BYTES = 2**31  # of a GIF's frames, which are in memory all at once


def movie(
    source: str | Path, path: str | Path, every: int = 1, rate: float = 20, **choices: Any
) -> int:
    """Make a movie of a trajectory.

    Parameters
    ----------
    source : path
        A GSD file.
    path : path
        Of the movie: ``.gif``, or ``.mp4``, for which the program ffmpeg is needed.
    every : int
        1 for all frames of the trajectory, 2 for every second one, and so on from the first.
    rate : float
        Frames per second.
    **choices
        As for `dpd.report.pictures.draw.draw`.

    Returns
    -------
    int
        Number of frames in the movie.

    Raises
    ------
    UserError
        If the trajectory cannot be read, or beads, bonds or box change in it; if the movie cannot
        be written; if ffmpeg is missing; or if a choice is not allowed.
    """
    path = Path(path)
    look = look_of({"dpi": DPI} | choices)
    if look.shows_fields:
        raise UserError("movie: shows beads; leave slice and surface out, or draw single frames")
    check_movie(path, source)
    if every < 1:
        raise UserError(f"every: {every} is out of range; allowed: whole numbers from 1")
    if not 0 < rate <= FASTEST:
        raise UserError(
            f"rate: {rate:g} is out of range; allowed: above 0, to {FASTEST} frames per second"
        )
    frames = range(0, _frames_in(Path(source)), every)
    with Progress(len(frames), str(path)) as progress:
        figures = _figures(_configurations(source, frames, look), look, progress)
        figure = next(figures)  # each time the same one, drawn anew
        write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
        _check_memory(path, figure, len(frames))
        replace_whole(path, lambda draft: write(path, draft, figure, figures, rate))
    return len(frames)


def check_movie(path: Path, source: str | Path) -> None:
    """Refuse what cannot become a movie, before anything is read.

    Raises
    ------
    UserError
        If the name says no kind of movie, if something else is in its place, or if the program
        that it takes is missing.
    """
    if path.suffix.lower() not in MOVIES:
        raise UserError(
            f"{path}: its name does not say what kind of movie it is; allowed: {', '.join(MOVIES)}"
        )
    check_output(path, inputs=[source])
    if path.suffix.lower() == ".mp4" and not FFMpegWriter.isAvailable():
        raise UserError(
            f"{path}: the program ffmpeg, which writes mp4, is not installed; install it, or make "
            "a .gif"
        )


def _frames_in(source):
    """Number of frames of a trajectory."""
    if source.suffix.lower() != ".gsd":
        raise UserError(
            f"{source}: a movie is made of a trajectory (.gsd), which a run writes if its scene "
            "says 'observe: [{trajectory: {every: 100}}]'"
        )
    with trajectory_to_read(source) as trajectory:
        if not len(trajectory):
            raise UserError(f"{source}: has no frames")
        return len(trajectory)


def _configurations(source, frames, look):
    """The configurations of some frames, all of the same beads in the same box."""
    first = read(source, frames[0])
    check_beads(look, first, source)
    yield first
    for frame in frames[1:]:
        particles = read(source, frame)
        if not _alike(particles, first):
            raise UserError(
                f"{source}: frame {frame} has other beads, bonds or edges of the box than the "
                "first; a movie needs the same in all frames"
            )
        yield particles


def _alike(one, other):
    return (
        one.box == other.box and one.names == other.names
        and np.array_equal(one.species, other.species) and np.array_equal(one.bonds, other.bonds)
    )  # fmt: skip


def _figures(configurations, look, progress):
    """One figure, drawn anew for each configuration."""
    figure = Figure(dpi=look.dpi, layout="none")
    FigureCanvasAgg(figure)
    fixed = None
    for done, particles in enumerate(configurations, 1):
        fixed = fixed or fixed_of(particles, look)
        draw_into(figure, particles, look, fixed)
        yield figure
        progress(done)


def _check_memory(path, figure, frames):
    width, height = figure.canvas.get_width_height()
    if path.suffix.lower() == ".gif" and frames * width * height > MOST_BYTES:
        raise UserError(
            f"{path}: {frames} frames of {width} x {height} pixels are too many for a GIF; take "
            "fewer frames (--every 10), a smaller --dpi, or make an .mp4"
        )


def _write_gif(path, draft, figure, others, rate):
    """Each frame with 256 colours of its own, as new ones may come in at any time."""
    rest = (_pixels(figure) for figure in others)
    hundredths = max(round(100 / rate), 2)
    _pixels(figure).save(
        draft, format="GIF", save_all=True, append_images=rest, duration=10 * hundredths, loop=0
    )


def _pixels(figure):
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    # Of the methods this one keeps white exactly as it is.
    return image.quantize(method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)


def _write_mp4(path, draft, figure, others, rate):
    """Frames piped to ffmpeg, which cannot tell the format from the name of a draft."""
    writer = FFMpegWriter(fps=rate, extra_args=["-f", "mp4"])
    try:
        with writer.saving(figure, str(draft.absolute()), figure.dpi):
            for _ in chain([figure], others):
                writer.grab_frame()
    except (BrokenPipeError, subprocess.CalledProcessError) as problem:
        said = (getattr(problem, "stderr", None) or "it ended too early").splitlines()[-1]
        raise UserError(f"{path}: ffmpeg could not write the movie: {said}") from None
