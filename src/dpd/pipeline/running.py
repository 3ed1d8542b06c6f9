"""A run as a command: alone on its output, started, resumed, and stopped when asked."""

import os
import sys
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from dpd.compiling import COMPILING
from dpd.drafts import remove_drafts, unfinished
from dpd.engine.checkpoint import note_of, refuse_other_file
from dpd.errors import Stopped, UserError
from dpd.files import check_output, read
from dpd.interrupts import asked, listening
from dpd.pipeline.beginning import Begun, begins_with, begun
from dpd.pipeline.lock import alone
from dpd.pipeline.pace import RUN, START, Pace
from dpd.pipeline.resources import BYTES_PER_BEAD
from dpd.pipeline.simulate import (
    RunSettings,
    checkpoint_path,
    is_made,
    simulate,
    summary,
)
from dpd.pipeline.there import remove_left, result_there
from dpd.progress import Progress
from dpd.scene.scene import Scene
from dpd.scene.start import start_work
from dpd.start.common.files import read_start


def say(sentence: str) -> None:
    """A warning to the terminal; nothing for an empty one."""
    if sentence:
        print(f"warning: {sentence}", file=sys.stderr, flush=True)


@dataclass(frozen=True)
class Order:
    """What to run and how.

    Attributes
    ----------
    scene : Scene
    output : Path
        The NetCDF file to write.
    label : str
        For progress.
    start : Path or None
        First configuration; without one it is made.
    keep_start : bool
        As for a run of one's own: make the file of the start where it is not there, and take one of
        any origin that holds the beads of the scene. Otherwise it must be the start of this scene.
    keep : bool
        See `dpd.pipeline.simulate.RunSettings`.
    threads : int
    every_seconds : float
        Wall clock between checkpoints.
    inputs : tuple of Path
        Files that are read: nothing is written in the place of one.
    checkpoints : bool
        Keep the state beside the result while it runs.
    overwrite : bool
        Replace what is in the place of the result, see `dpd.pipeline.there`.
    wait : bool
        As Snakemake does: wait for another run on the same output, leave a result of the same scene
        and sources as it is, and replace any other.
    stopping : callable or None
        Whether to stop; signals ask for it if there is none.
    say, tell : callable
        Called with a warning, and with a sentence on what is done.
    progress : callable
        Makes a `dpd.progress.Progress` from a number of steps and a label.
    """

    scene: Scene
    output: Path
    label: str
    start: Path | None = None
    keep_start: bool = False
    keep: bool = True
    threads: int = 1
    every_seconds: float = 60.0
    inputs: tuple = ()
    checkpoints: bool = True
    overwrite: bool = False
    wait: bool = False
    stopping: Callable[[], int] | None = None
    say: Callable[[str], None] = say
    tell: Callable[[str], None] = print
    progress: Callable[[int, str], Progress] = Progress

    def stop_if_asked(self, at_work: str) -> None:
        """Raise `Stopped` where nothing is kept of what is at work."""
        if (self.stopping or asked)():
            raise Stopped(f"stopped while {at_work}, as asked")


def run_alone(order: Order) -> dict[str, float]:
    """Run a scene, go on with one that was stopped or killed, or wait for one that is at work.

    Returns
    -------
    dict
        Summary, see `dpd.pipeline.simulate.simulate`.

    Raises
    ------
    UserError
        If it cannot be, see `dpd.pipeline.lock.alone` and `dpd.pipeline.simulate.simulate`, or
        would replace something unasked, see `dpd.pipeline.there`.
    Stopped
        If a signal asked for it.
    """
    checkpoint = checkpoint_path(order.output)
    _, *beside = _results(order)
    for path in (checkpoint, *beside):
        check_output(path, "", order.inputs)
    refuse_other_file(checkpoint)
    with alone(order.output, order.say, order.wait) as report:
        if (made := _made(order)) is not None:
            remove_left(checkpoint, made)
            return summary(made, *read(order.output))
        for path in (order.output, checkpoint, *beside, *map(unfinished, beside)):
            remove_drafts(path)
        with listening():
            return _run(order, checkpoint, report)


def _results(order):
    """All files that a run leaves: its result, and what lies beside it."""
    return [order.output, *order.scene.files_beside(order.output).values()]


def _made(order):
    """The scene of a result that is there already and stays.

    For Snakemake it is of the same sources too. Another run has made it while this one waited; or
    a Snakemake that was killed, or whose job of many runs was, asks again for those that were done.
    Or what the scene takes from other sweeps was measured anew, and came out as before.
    """
    if not order.wait:
        scene = begins_with(order.scene, order.start, lambda sentence: None)
        return None if order.overwrite else result_there(scene, order.output, order.say)
    if not is_made(order.scene, order.output):
        return None
    for place in _results(order):
        os.utime(place)  # newer than what it is made from
    order.tell(f"{order.output}: is there already, of the same scene and the same sources")
    return order.scene


def _refuse_too_large(scene):
    """Refuse beads for which this machine has no memory: the system would end the process."""
    needed = BYTES_PER_BEAD * scene.beads
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > there:
        raise UserError(
            f"{scene.where}: {scene.beads} beads take about {needed / 2**30:.3g} GiB of memory, "
            f"and this machine has {there / 2**30:.3g}; take a smaller box or fewer molecules"
        )


def _run(order, checkpoint, report):
    scene, since = order.scene, time.perf_counter()
    _refuse_too_large(scene)
    say_if_resumed(checkpoint)
    work, COMPILING.tell = start_work(scene), order.tell
    shown = Pace(order.progress(work, f"{order.label}: start"), report, START, work)
    with _stoppable(order, shown) as progress:
        if order.start and not order.keep_start:
            scene, state = Begun(scene, read_start(scene, order.start))
        else:
            scene, state = begun(scene, order.start, progress, order.tell)
    scene = _settled(scene, state, checkpoint, order)
    if scene.chosen:
        order.tell(scene.chosen["said"])
    steps = sum(scene.steps)
    with Pace(order.progress(steps, order.label), report, RUN, steps) as progress:
        settings = RunSettings(
            checkpoint if order.checkpoints else None, order.every_seconds, order.threads, progress,
            order.stopping or asked, order.say, since, order.keep,
        )  # fmt: skip
        return simulate(scene, order.output, state, settings)


def say_if_resumed(checkpoint: Path) -> None:
    """Tell a person that there may be a run to resume."""
    if checkpoint.exists():
        print(f"a run to resume may be in {checkpoint}", file=sys.stderr)


def _settled(scene, state, checkpoint, order):
    """The scene with the time step that it names, that it began with, or that is found now."""
    if not scene.is_auto:
        return scene
    from dpd.pipeline.probing import settle, settled_before

    note = note_of(checkpoint)
    before = settled_before(scene, note.get("chosen") if isinstance(note, dict) else None)
    look = partial(order.stop_if_asked, "a time step was looked for")
    return before or settle(scene, state, look)


@contextmanager
def _stoppable(order, progress):
    """Progress of work that keeps no state: it ends where a run would be stopped."""

    def step(done):
        order.stop_if_asked("the first configuration was made")
        progress(done)

    with progress:
        yield step
