"""What a study will cost, before anything of it runs."""

import time

import numpy as np

from dpd.compiling import quick_to_start
from dpd.engine.simulation import Simulation, Unstable
from dpd.observe import observables
from dpd.start import make_start, system_of

WARM = 50  # steps before the clock starts, in which kernels compile
LEAST_SECONDS = 1.0  # that a rate is measured over
BASE_MEMORY = 200.0  # MiB of a process that has imported all and compiled nothing
COPIES = 4  # of the state while it moves: its own, those sorted, those of a checkpoint


def plan(papers, measure_seconds=LEAST_SECONDS, progress=None):
    """Cost of every sweep of some papers.

    A sweep's rate is measured here and now on its middle point, from random positions and
    with one core; growing the melts of a sweep and starting its jobs is not in it.

    Parameters
    ----------
    papers : list of dpd.study.Paper
    measure_seconds : float
        Wall clock for each rate.
    progress : callable or None
        Called with the number of sweeps done.

    Returns
    -------
    list of dict
        One per sweep: ``paper``, ``sweep``, ``runs``, ``beads`` of the largest, ``bead_steps``
        of all, ``rate`` in bead-steps per second, ``core_hours``, ``longest`` hours of one
        run, ``memory`` MiB of the largest job, ``disk`` MiB of all results at most.
    """
    rows = []
    for paper in papers:
        for sweep in paper.sweeps.values():
            scenes = [point.scene for point in sweep.points]
            work = np.array([scene.work for scene in scenes], dtype=float)
            rate = measured_rate(scenes[len(scenes) // 2], measure_seconds)
            sizes = [sizes_of(scene) for scene in scenes]
            rows.append({
                "paper": paper.name,
                "sweep": sweep.name,
                "runs": len(scenes),
                "beads": max(scene.beads for scene in scenes),
                "bead_steps": work.sum(),
                "rate": rate,
                "core_hours": work.sum() / rate / 3600,
                "longest": work.max() / rate / 3600,
                "memory": BASE_MEMORY + max(COPIES * state + kept for state, kept in sizes),
                "disk": sum(state + kept for state, kept in sizes),
            })  # fmt: skip
            if progress is not None:
                progress(len(rows))
    return rows


def measured_rate(scene, seconds):
    """Bead-steps per second of a scene without its observables, one thread."""
    simulation = Simulation(system_of(scene), make_start(quick_to_start(scene, grow=False)))
    steps, spent, done = WARM, 0.0, 0
    try:
        simulation.advance(WARM)
        while spent < seconds:
            begun = time.perf_counter()
            simulation.advance(steps)
            spent += time.perf_counter() - begun
            done += steps
            steps = min(4 * steps, 2000)
    except Unstable:  # as a stability map's runs may
        if not done:
            return np.nan
    return scene.beads * done / spent


def sizes_of(scene):
    """MiB of a scene's state, and of what its observables keep."""
    state = 8.0 * scene.beads * (4 * scene.dimension + 2)
    kept = sum(a.nbytes for o in observables(scene, system_of(scene)) for a in o.arrays.values())
    return state / 2**20, kept / 2**20


HEADER = (
    f"{'paper':20s} {'sweep':24s} {'runs':>5s} {'beads':>7s} {'bead-steps':>10s} {'10^6/s':>7s} "
    f"{'core-h':>8s} {'longest h':>9s} {'MiB/job':>8s} {'disk MiB':>8s}"
)


def as_text(rows, cores):
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
            f"{row['bead_steps']:10.2e} {row['rate'] / 1e6:7.2f} {row['core_hours']:8.2f} "
            f"{row['longest']:9.2f} {row['memory']:8.0f} {row['disk']:8.1f}"
        )
    hours = np.nansum([row["core_hours"] for row in rows])
    disk = sum(row["disk"] for row in rows)
    longest = np.nanmax([0.0, *(row["longest"] for row in rows)])
    lines.append(
        f"{sum(row['runs'] for row in rows)} runs: {hours:.1f} core-hours, "
        f"{max(hours / cores, longest):.1f} hours on {cores} cores at best; "
        f"{disk:.0f} MiB of results at most"
    )
    return "\n".join(lines)
