"""A run: alone on its output, started, resumed or made longer, stopped when asked, and written."""

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np

from dpd import files
from dpd.digests import run_sources
from dpd.engine.loop import Checkpoint, refuse_other_file, stored_in
from dpd.engine.loop import run as run_steps
from dpd.engine.simulation import Simulation
from dpd.engine.state import State
from dpd.errors import LostRun, Stopped, UserError
from dpd.files import remove_drafts, unfinished
from dpd.jit import COMPILING
from dpd.observe.common.measured import observables
from dpd.runs import Progress, alone, result
from dpd.scene.scene import Scene
from dpd.start import start_digest, start_work
from dpd.start.common.make import make_start, system_of

WARNING = "warning: "
THREADS_PER_CORE = 4  # more only wait for each other
TOGETHER = 0.5  # s within which two signals count as one: make and snakemake pass them on
LAST_START: dict[str, State] = {}  # by its digest: runs that share a job often begin alike
STOPPING = b"stopping after the steps under way; a second Ctrl-C ends at once\n"


def warn(sentence: str) -> None:
    """A warning to the terminal, if anybody reads that; nothing for an empty one."""
    with suppress(OSError):
        if sentence:
            print(f"{WARNING}{sentence}", file=sys.stderr, flush=True)


def tell(sentence: str) -> None:
    """A sentence on what is done, to whoever reads it."""
    with suppress(OSError):
        print(sentence, flush=True)


@dataclass(frozen=True)
class Options:
    """How a run is carried out; none of it changes a bit of what it measures."""

    threads: int = 1
    every_seconds: float | None = None  # of wall clock between checkpoints; None keeps no state
    overwrite: bool = False  # what is in the place of the result, see `dpd.runs.result`
    # A run of one's own keeps its end for longer ones, begins with any file, and is refused where
    # another is at work. Otherwise it is Snakemake's: it waits for the other, leaves a result of
    # the same scene and sources as it is, and replaces any other.
    own: bool = False
    label: str = ""  # for progress
    signals: tuple[int, ...] = (signal.SIGINT,)  # that ask it to stop
    say: Callable[[str], None] = warn  # called with a warning
    tell: Callable[[str], None] = tell  # called with a sentence on what is done
    of_start: Callable[[str], None] = tell  # and on what is other in a start than in its file
    progress: Callable[..., Progress] = Progress

    def __post_init__(self) -> None:
        whole("threads", self.threads, THREADS_PER_CORE * len(os.sched_getaffinity(0)))


def whole(name: str, given: object, most: int = 10**12) -> int:
    """A whole number from 1 to the most that is allowed, also one of NumPy's; or `UserError`."""
    number = given.item() if isinstance(given, np.generic) else given
    if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= most:
        raise UserError(f"{name}: {given!r} is out of range; allowed: 1 to {most}")
    return number


def run(
    scene: Scene, output: Path, start: Path | None = None, options: Options = Options()
) -> dict[str, float]:
    """Run a scene, go on with one that was stopped or killed, or wait for one that is at work.

    A ``start`` that is not given, or not there, is made. Returns `dpd.runs.result.summary`. Raises
    `UserError` if it cannot be, or would replace something unasked; `Stopped` by a signal.
    """
    inputs = [start] if start else []
    inputs += [Path(scene.where)] if Path(scene.where).is_file() else []
    sidecars = _sidecars(scene, output, inputs)
    with (
        stop_on(options.signals) as stopping,
        alone(output, options.say, not options.own, partial(_stoppable, stopping)) as lock,
    ):
        if (made := _made(scene, output, start, options)) is not None:
            return _as_it_is(made, output)
        begun, COMPILING.tell = time.perf_counter(), options.tell
        _resumed(output, sidecars)
        with options.progress(start_work(scene), f"{options.label}: start", lock=lock) as shown:
            scene, state = _first(scene, start, options, partial(_stoppable, stopping, shown))
        if scene.is_auto:
            from dpd.runs.auto import settle

            stored = stored_in(sidecars[0])
            before = stored.note.get("chosen") if stored else None
            scene = settle(scene, state, partial(_stoppable, stopping), before)
            options.tell((scene.chosen or {})["said"])
        with options.progress(sum(scene.steps), options.label, lock=lock) as progress:
            return simulate(scene, output, state, options, progress, stopping, begun)


def extend(
    run: Path, sample: int, output: Path, options: Options = Options(own=True)
) -> dict[str, float]:
    """Make a run longer by steps of sampling, in its place or another, or go on; see `run`."""
    sample, shorter = whole("sample", sample), result.read_former(run).scene
    inputs = [] if output == run else [run, *shorter.files_beside(run).values()]
    sidecars = _sidecars(shorter, output, inputs)
    with stop_on(options.signals) as stopping, alone(output, options.say) as lock:
        former = result.read_former(run)  # now nobody else is at work on it
        steps = former.scene.data["steps"] | {"sample": former.scene.steps.sample + sample}
        scene, there = Scene(former.scene.data | {"steps": steps}, former.scene.where), None
        scene.chosen, step = former.scene.chosen, former.state.step
        before = int(former.attributes.get("extended_from_step", step))
        if output != run:
            there = None if options.overwrite else result.result_there(scene, output, options.say)
        elif result.remove_left(sidecars[0], former.scene) and step == before + sample:
            there = former.scene
            options.say(f"{run}: has been made longer before, by a command that was killed then")
        elif not options.overwrite:
            result.refuse_to_lose(scene, sidecars[0])
        if there is not None:
            return _as_it_is(there, output)
        if former.attributes.get("sources") != run_sources(scene):
            options.say(
                f"{run}: made by other sources than today's, so its last bits may differ from "
                "those of a run that was made today"
            )
        _resumed(output, sidecars)
        with options.progress(sum(scene.steps), f"{run}: longer", lock=lock) as progress:
            progress(step)  # so that the lock says how long it is to become
            return simulate(scene, output, former.state, options, progress, stopping, former=former)


def _sidecars(scene, output, inputs):
    """The checkpoint of a result, then its sidecar files; refused where a file would be lost."""
    sidecars = [result.checkpoint_path(output), *scene.files_beside(output).values()]
    for path in (output, *sidecars):
        files.check_output(path, ".nc" if path == output else "", inputs)
    refuse_other_file(sidecars[0])
    return sidecars


def _resumed(output, sidecars):
    """Remove what a killed run left half written; tell a person that there may be one to resume."""
    for path in (output, *sidecars, *map(unfinished, sidecars[1:])):
        remove_drafts(path)
    if sidecars[0].exists():
        with suppress(OSError):
            print(f"a run to resume may be in {sidecars[0]}", file=sys.stderr)


def _first(scene, start, options, progress):
    """The scene with its first configuration; one from a file of another scene is part of it."""
    if start is not None:
        from dpd.start.common.files import begin, read_start

        if options.own:
            return begin(scene, start, progress, options.of_start)
        return scene, read_start(scene, start)
    if options.own:
        return scene, make_start(scene, progress, options.of_start)
    if (digest := start_digest(scene)) not in LAST_START:
        LAST_START.clear()
        LAST_START[digest] = make_start(scene, progress, options.of_start)
    return scene, deepcopy(LAST_START[digest])


def _as_it_is(scene, output):
    """The summary of a result that stays; a checkpoint of its run is of no more use."""
    result.remove_left(result.checkpoint_path(output), scene)
    return result.summary(scene, *files.read(output))


@contextmanager
def stop_on(signals: Sequence[int]) -> Iterator[Callable[[], int]]:
    """While a run looks whether it is asked to stop: yields what returns that signal, or 0.

    The first one asks, a second Ctrl-C does what it did before; what is ignored, as by nohup, stays
    so. Python tells its main thread alone of signals: nobody asks a run in another one.
    """
    came: list[tuple[int, float]] = []

    def ask(number, frame):
        if not came:
            came.append((number, time.monotonic()))
            with suppress(OSError):
                os.write(2, STOPPING)
        elif number == signal.SIGINT and time.monotonic() - came[0][1] > TOGETHER:
            former[number](number, frame)

    is_main = threading.current_thread() is threading.main_thread()
    former = {number: signal.getsignal(number) for number in signals if is_main}
    former = {n: was for n, was in former.items() if was not in (signal.SIG_IGN, None)}
    try:
        for number in former:
            signal.signal(number, ask)
        yield lambda: came[0][0] if came else 0
    finally:
        for number, was in former.items():
            signal.signal(number, was)


def _stoppable(stopping, shown=None, done=0):
    """Progress of work that keeps no state: it ends where a run would be stopped."""
    if number := stopping():
        raise Stopped("stopped before the first step, as asked", number)
    if shown is not None:
        shown(done)


def _made(scene, output, start, options):
    """The scene of a result that is there and stays; for Snakemake, of the same sources, too."""
    if options.own:
        if start is not None and start.exists():
            from dpd.start.common.files import begins_with

            scene = begins_with(scene, start, lambda sentence: None)
        return None if options.overwrite else result.result_there(scene, output, options.say)
    if not result.is_made(scene, output):
        return None
    options.tell(f"{output}: is there already, of the same scene and the same sources")
    return scene


def simulate(
    scene: Scene,
    path: str | Path,
    state: State,
    options: Options = Options(),
    progress: Callable[[int], object] | None = None,
    stopping: Callable[[], int] | None = None,
    begun: float | None = None,
    former: result.Former | None = None,
) -> dict[str, float]:
    """Run a scene from a start, or from the end of ``former``, and write what it observed, whole.

    For ``progress`` and ``stopping`` see `dpd.engine.loop.run`; ``begun``: by `time.perf_counter`.
    Raises `UserError` if the run blows up or is stopped; the last checkpoint stays.
    """
    begun = time.perf_counter() if begun is None else begun
    systems = [(stage.step, system_of(stage.scene)) for stage in scene.stages]
    if "engine" in scene.data:  # by name: where it is edited, runs that do not need it stay
        lammps = import_module("dpd.lammps.engine").Lammps
        simulation = lammps(scene, systems[0][1], state, scene.ranks, options.threads)
    else:
        simulation = Simulation(systems[0][1], state, options.threads)
    observers = observables(scene, systems[0][1], path, state)
    if former:
        result.go_on_after(former, observers)
    keeper, keeps = None, scene.data.get("keep_state", options.own)
    if options.every_seconds is not None:
        key = {"scene": scene.digest, "sources": run_sources(scene), "kept": keeps}
        note = {"chosen": scene.chosen, "scene": json.dumps(scene.data)}
        keeper = Checkpoint(result.checkpoint_path(path), key, note)
    running, lost = time.perf_counter() - COMPILING.duration, -1
    try:
        done = run_steps(
            simulation, scene.steps, observers, keeper, progress, options.every_seconds or 0.0,
            stopping, options.say, systems,
        )  # fmt: skip
    except UserError as problem:
        if not isinstance(problem, LostRun) or scene.data["unstable"] != "record":
            raise _with_place(problem, scene, keeper) from None
        done = lost = problem.step
    finally:
        simulation.close()
    now, compiled = time.perf_counter(), COMPILING.duration
    timed = {
        "lost_step": lost,
        "seconds": now - begun,
        "bead_steps_per_second": scene.beads * done / max(now - compiled - running, 1e-9),
    }
    if "engine" in scene.data:
        resumed = lost < 0 and done < sum(scene.steps) - state.step
        said = "; resumed, so to the same averages and not the same bits" if resumed else ""
        timed["engine"] = f"{simulation.called}{said}"
    if former:
        timed["extended_from_step"] = state.step
    save = partial(keeper.save, simulation, observers) if keeper and lost < 0 else None
    keeps = keeps and lost < 0
    try:
        found, warnings = result.write_result(
            Path(path), scene, simulation, observers, timed, keeps, save
        )
    except UserError as problem:
        if save and (unsaved := save()):
            problem = UserError(f"{problem}; {unsaved}")
        raise _with_place(problem, scene, keeper) from None
    if keeper:
        keeper.discard()
    for sentence in warnings:
        options.say(sentence)  # now: where warnings are errors, it raises
    return found


def _with_place(problem, scene, keeper):
    """A problem of a run, with the scene's file and where the last good state is."""
    kept = keeper is not None and keeper.is_ours and keeper.path.exists()
    last = f"; its last good state is in {keeper.path}" if kept else ""
    text = f"{scene.where}: {str(problem).rstrip('.')}{last}"
    return Stopped(text, problem.signal) if isinstance(problem, Stopped) else UserError(text)
