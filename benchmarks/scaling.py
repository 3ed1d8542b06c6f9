"""How speed and memory go with the number of beads, the density and the threads."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import yaml

from benchmarks.systems import FLUID
from benchmarks.timing import TURNS, in_turns, labelled, seconds_of, simulation_of
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start

BEADS = (1000, 3000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000)
DENSITIES = (1, 2, 3, 4, 5, 6, 7, 8)
AT = 24_000  # beads, for the densities
WORK, LEAST = 3e6, 10  # bead-steps in a turn, and steps at least
SETTLE = 180  # steps at density 1 that take the heat of random positions away; fewer at higher
SETTLE_STEP = 0.02  # tau
HOTTEST = 1.5  # kT; hotter, beads would not stand as in a fluid at rest
THREADS = (1, 2)
MANY = 15  # turns of rates, which are short: what disturbs them for a moment is outvoted
TINY = FLUID | {"box": 4, "start": {}, "steps": {"sample": 1}, "observe": ["thermo"]}


def scaling(
    beads=BEADS, densities=DENSITIES, at=AT, work=WORK, turns=MANY, begins=TURNS, say=print
):
    """Rates over size and density with one thread and two, peak memory, time to start.

    All sizes have a go in every turn, so that the rate of one over another's is of one time. Two
    threads are NaN on a machine with one core.

    Parameters
    ----------
    beads : sequence of int
        Sizes at density 3, increasing.
    densities : sequence of float
        In r_c^-3, with ``at`` beads.
    at : int
    work : float
        Bead-steps in a turn.
    turns, begins : int
        Turns, and starts of the program.
    say : callable
    """
    memory = np.full(len(beads), np.nan)
    for k in range(max(0, len(beads) - 2), len(beads)):
        say(f"memory of {beads[k]} beads")
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            memory[k] = pool.submit(peak_memory, beads[k]).result()
    say("time to start")
    begin = start_up(begins)
    fluids = [fluid(n, 3.0) for n in beads]
    by_size = rates(fluids, work, turns, say)
    by_density = rates([fluid(at, rho) for rho in densities], work, turns, say)
    sizes = [scene.beads for scene in fluids]
    along, rate = ("threads", "turn"), ("1 / s", "bead-steps per second")
    return labelled(
        {
            "beads": (("beads",), sizes, "1", "number of beads"),
            "density": (("density",), list(map(float, densities)), "1 / r_c^3", "number density"),
            "threads": (("threads",), list(THREADS), "1", "threads"),
            "rate": (("beads", *along), by_size, *rate),
            "density_rate": (("density", *along), by_density, *rate),
            "memory": (("beads",), memory, "B", "peak memory of a process; the two largest"),
            "start_up": (("begin",), begin, "s", "wall clock of a run of one step"),
        },
        f"standard fluid (a 25, gamma 4.5, dt 0.04), {turns} turns; densities with {at} beads.",
    )


def fluid(beads, density):
    """Standard fluid of about so many beads in a cube, settled for a moment."""
    edge = float((beads / density) ** (1 / 3))
    relax = {"steps": max(SETTLE // 3, round(SETTLE / density)), "dt": SETTLE_STEP}
    data = FLUID | {
        "box": edge,
        "molecules": [{"architecture": "A", "density": float(density)}],
        "start": {"relax": relax},
    }
    return Scene(data, f"standard fluid of {beads} beads")


def rates(scenes, work, turns, say):
    """(scenes, threads, turns) bead-steps per second of some fluids, all of them in every turn."""
    usable = [n for n in THREADS if n <= len(os.sched_getaffinity(0))]
    advances = [advance for scene in scenes for advance in ready(scene, usable, say)]
    steps = [max(LEAST, round(work / scene.beads)) for scene in scenes for _ in usable]
    done = np.array([scene.beads for scene in scenes for _ in usable]) * steps
    say(f"{len(advances)} runs in turns, {turns} turns")
    found = np.full((len(scenes), len(THREADS), turns), np.nan)
    rate = done[:, None] / in_turns(advances, steps, turns)
    found[:, : len(usable)] = rate.reshape(len(scenes), len(usable), turns)
    return found


def ready(scene, threads, say):
    """What advances a fluid with each number of threads, compiled; UserError if it is still hot."""
    say(f"{scene.beads} beads, density {scene.density:.3g}")
    start = make_start(scene)
    kT = float(np.mean(start.velocity**2))
    if not kT < HOTTEST:
        raise UserError(f"{scene.where}: kT {kT:.3g} before timing; allowed: below {HOTTEST:g}")
    advances = [simulation_of(scene, start, n).advance for n in threads]
    for advance in advances:
        advance(LEAST)
    return advances


def peak_memory(beads):
    """Bytes that this process has had in memory at most, once a fluid has moved in it.

    Not ru_maxrss, which a new process takes over from the one that started it.
    """
    scene = fluid(beads, 3.0)
    still = Scene(scene.data | {"start": {}}, scene.where)
    system = simulation_of(still, make_start(still))
    system.advance(2)
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.is_file() else []
    peaks = [1024.0 * int(line.split()[1]) for line in lines if line.startswith("VmHWM")]
    return peaks[0] if peaks else np.nan


def start_up(turns):
    """(turns,) array: seconds that `python -m dpd run` takes for one step of a tiny scene."""
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(yaml.safe_dump(TINY))
        command = [sys.executable, "-m", "dpd", "run", str(scene), "-o", f"{folder}/run.nc"]

        def begin(_):
            subprocess.run(command, env=environment, check=True, capture_output=True)

        begin(1)  # compiles what is not compiled yet
        return np.array([seconds_of(begin, 1) for _ in range(turns)])
