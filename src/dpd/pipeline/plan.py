"""What a study will cost, before anything of it runs."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.digest import value_digest
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.errors import LostRun
from dpd.observe import observables
from dpd.pipeline.compiling import compile_observables
from dpd.start.common.make import make_start, random_start, system_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from dpd.pipeline.study import Paper
    from dpd.scene.scene import Scene

WARM = 50  # steps before the clock starts, in which kernels compile
LEAST_SECONDS = 1.0  # that a rate is measured over
BASE_MEMORY = 200.0  # MiB of a process that has imported all and compiled nothing
COPIES = 4  # of the state while it moves: its own, those sorted, those of a checkpoint
BUSY = 0.9  # of a core: a process that gets less has others beside it


@dataclass(frozen=True)
class Speed:
    """Of one scene, with one thread.

    Attributes
    ----------
    equilibrating, sampling : float
        Bead-steps per second of processor time, without and with the scene's observables; NaN
        for a run that blew up at once.
    share : float
        Processor time over wall clock: how much of a core the measurement got.
    """

    equilibrating: float
    sampling: float
    share: float

    def seconds(self, scene: Scene) -> float:
        """Of processor time that a run of a scene of this kind takes."""
        equilibrate, sample = scene.steps
        return scene.beads * (equilibrate / self.equilibrating + sample / self.sampling)


class _Timing(NamedTuple):
    """Steps that were done, their processor time and their wall clock in seconds."""

    steps: int
    processor: float
    wall: float

    def rate(self, beads: int) -> float:
        """Bead-steps per second of processor time; NaN if no step was done."""
        return beads * self.steps / self.processor if self.steps else np.nan


def plan(
    papers: Iterable[Paper],
    measure_seconds: float = LEAST_SECONDS,
    progress: Callable[[int], None] | None = None,
) -> list[dict[str, Any]]:
    """Cost of every sweep of some papers.

    A sweep's speed is measured here and now on its middle point, from random positions (on another
    point, if those blow up), with one
    core, and with its observables as the run samples them; points that differ in those have a
    middle each. It is counted in processor time, which is that of a core left alone. Growing the
    melts of a sweep and starting its jobs is not in it.

    Parameters
    ----------
    papers : list of dpd.pipeline.study.Paper
    measure_seconds : float
        Wall clock for each of two rates a sweep.
    progress : callable or None
        Called with the number of sweeps done.

    Returns
    -------
    list of dict
        One per sweep: ``paper``, ``sweep``, ``runs``, ``beads`` of the largest, ``bead_steps``
        of all, ``rate`` in bead-steps per second (a sweep of theory has points in the place of
        runs, no beads, and NaN here), ``core_hours``, ``longest`` hours of one
        run, ``memory`` MiB of the largest job, ``disk`` MiB of all results at most, ``share`` of
        a core that its measurement got.
    """
    rows = []
    for paper in papers:
        for sweep in paper.sweeps.values():
            scenes = [point.scene for point in sweep.points]
            work = np.array([scene.work for scene in scenes], dtype=float)
            speeds = _speeds(scenes, measure_seconds)
            seconds = np.array([speeds[_watched(scene)].seconds(scene) for scene in scenes])
            sizes = [sizes_of(scene) for scene in scenes]
            rows.append({
                "paper": paper.name,
                "sweep": sweep.name,
                "runs": len(scenes),
                "beads": max(scene.beads for scene in scenes),
                "bead_steps": work.sum(),
                "rate": work.sum() / seconds.sum(),
                "core_hours": seconds.sum() / 3600,
                "longest": seconds.max() / 3600,
                "memory": BASE_MEMORY + max(COPIES * each.state + each.kept for each in sizes),
                "disk": sum(sum(each) for each in sizes),
                "share": np.mean([speed.share for speed in speeds.values()]),
            })  # fmt: skip
            if progress is not None:
                progress(len(rows))
        for theory in paper.theory.values():
            rows.append(_calculation(paper.name, theory))
            if progress is not None:
                progress(len(rows))
    return rows


def _calculation(paper, sweep):
    """The row of a sweep of theory: its middle point is calculated, and its time counts for all."""
    from dpd.pipeline.calculate import calculated  # brings what no run needs

    middle = sweep.points[len(sweep.points) // 2]
    calculated(middle)  # kernels compile
    processor, clock = time.process_time(), time.perf_counter()
    calculated(middle)
    processor, clock = time.process_time() - processor, time.perf_counter() - clock
    hours = len(sweep.points) * processor / 3600
    return {
        "paper": paper, "sweep": sweep.name, "runs": len(sweep.points), "beads": 0,
        "bead_steps": 0.0, "rate": np.nan, "core_hours": hours, "longest": hours,
        "memory": BASE_MEMORY, "disk": 0.0, "share": min(1.0, processor / clock),
    }  # fmt: skip


def _speeds(scenes, seconds):
    """`Speed` of the middle one of all scenes that have the same observables, by those."""
    alike = {}
    for scene in scenes:
        alike.setdefault(_watched(scene), []).append(scene)
    return {watched: _speed_of_one(some, seconds) for watched, some in alike.items()}


def _speed_of_one(scenes, seconds):
    """`Speed` of the middle scene; of another, if that one blows up from random positions."""
    middle = len(scenes) // 2
    for scene in scenes[middle::-1] + scenes[middle + 1 :]:
        speed = measured_speed(scene, seconds)
        if np.isfinite([speed.equilibrating, speed.sampling]).all():
            break
    return speed


def _watched(scene):
    """What a scene says of its observables, as a key."""
    return value_digest(scene.data["observe"])


def measured_speed(scene: Scene, seconds: float) -> Speed:
    """The `Speed` of a scene, measured for some seconds without its observables and with them."""
    simulation = Simulation(system_of(scene), make_start(random_start(scene)))
    system, most = system_of(scene), scene.steps.sample
    compile_observables(scene, simulation)
    observers = observables(scene, system, None, simulation.state)

    def watched(steps):
        run(simulation, (begun, min(simulation.state.step - begun + steps, most)), observers)

    bare = _timed(simulation, simulation.advance, seconds, np.inf)
    begun = simulation.state.step
    sampled = _timed(simulation, watched, seconds, most)
    wall = bare.wall + sampled.wall
    share = (bare.processor + sampled.processor) / wall if wall else 1.0
    return Speed(bare.rate(scene.beads), sampled.rate(scene.beads), share)


def _timed(simulation, advance, seconds, limit):
    """The `_Timing` of what is done within some seconds.

    As many steps as the sampling of a run at most; none if the run blows up at once.
    """
    steps, done, processor, wall = WARM, 0, 0.0, 0.0
    try:
        if limit == np.inf:
            advance(WARM)  # kernels compile
        while wall < seconds and done < limit:
            before, cpu, clock = simulation.state.step, time.process_time(), time.perf_counter()
            advance(steps)
            wall += time.perf_counter() - clock
            processor += time.process_time() - cpu
            done += simulation.state.step - before
            steps = min(4 * steps, 2000)
    except LostRun:  # as a stability map's runs may
        pass
    return _Timing(done, min(processor, wall), wall)


class Sizes(NamedTuple):
    """MiB of a scene's state, of what its observables keep, and of files that they write."""

    state: float
    kept: float
    beside: float


def sizes_of(scene: Scene) -> Sizes:
    """The `Sizes` of a scene."""
    observers = observables(scene, system_of(scene))
    kept = sum(array.nbytes for observer in observers for array in observer.arrays.values())
    beside = sum(getattr(observer, "file_bytes", 0) for observer in observers)
    state = 8 * scene.beads * (4 * scene.dimension + 2)
    return Sizes(*(size / 2**20 for size in (state, kept, beside)))


HEADER = (
    f"{'paper':20s} {'sweep':24s} {'runs':>5s} {'beads':>7s} {'bead-steps':>10s} {'10^6/s':>7s} "
    f"{'core-h':>8s} {'longest h':>9s} {'MiB/job':>8s} {'disk MiB':>8s}"
)


def _millions(rate):
    """A rate in 10^6/s; a dash where nothing is simulated."""
    return f"{'-':>7s}" if np.isnan(rate) else f"{rate / 1e6:7.2f}"


def as_text(rows: Sequence[Mapping[str, Any]], cores: int) -> str:
    """The plan as a table with a sum.

    Parameters
    ----------
    rows : list of dict
        From `plan`.
    cores : int
        Cores that the sum is divided by.
    """
    lines = [HEADER]
    for row in rows:
        lines.append(
            f"{row['paper']:20s} {row['sweep']:24s} {row['runs']:5d} {row['beads']:7d} "
            f"{row['bead_steps']:10.2e} {_millions(row['rate'])} {row['core_hours']:8.2f} "
            f"{row['longest']:9.2f} {row['memory']:8.0f} {row['disk']:8.1f}"
        )
    hours = np.nansum([row["core_hours"] for row in rows])
    disk = sum(row["disk"] for row in rows)
    longest = np.nanmax([0.0, *(row["longest"] for row in rows)])
    best = max(hours / cores, longest)
    lines.append(
        f"{sum(row['runs'] for row in rows)} runs: {hours:.1f} core-hours, "
        f"{best:.1f} hours on {cores} cores at best; {disk:.0f} MiB of results at most"
    )
    if unknown := [row["sweep"] for row in rows if np.isnan(row["core_hours"])]:
        lines.append(f"Without {', '.join(unknown)}: from random positions these blow up at once.")
    share = np.mean([row["share"] for row in rows]) if rows else 1.0
    if share < BUSY:
        lines.append(
            f"This machine is busy: while its speed was measured this process got {share:.2f} of a "
            "core. The table counts processor time, as on a machine left alone; if it stays as "
            f"busy, the {best:.1f} hours become {best / share:.1f}. Others also take memory "
            "bandwidth, which no such count shows: measure again when they are gone."
        )
    return "\n".join(lines)
