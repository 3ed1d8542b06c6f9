"""What a workflow says at its end: what failed, what it cost, what made it."""

import atexit
import glob
import platform
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

from dpd.digest import ROOT
from dpd.errors import FAILED
from dpd.files import attribute
from dpd.pipeline.paths import Results

LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")
MOST = 20  # sentences that are shown


def failures(logs: str | Path, begun: float) -> list[str]:
    """Sentences of the jobs that failed in a workflow, each once and with its log.

    ``logs``: folder of the logs of a study. ``begun``: when the workflow began, as `time.time` has
    it; older logs are not of its making.
    """
    found: dict[str, dict[Path, None]] = {}
    for path in sorted(Path(logs).rglob("*.log")):
        if path.stat().st_mtime < begun:
            continue
        for line in path.read_text(errors="replace").splitlines():
            if line.startswith(FAILED):
                found.setdefault(line, {})[path] = None
    lines = []
    for line, paths in found.items():
        first, *others = paths
        lines.append(f"{line} ({first}{f' and {len(others)} other logs' if others else ''})")
    more = len(lines) - MOST
    return lines if more <= 0 else [*lines[:MOST], f"and {more} more in {logs}"]


def say_at_exit(logs: str | Path, begun: float) -> None:
    """Print the `failures` last, below all that Snakemake has to say of them."""
    if lines := failures(logs, begun):
        atexit.register(lambda: print("", *lines, sep="\n", file=sys.stderr))


def overhead(folder: str | Path, begun: float, cores: int) -> str:
    """One sentence on the wall clock of a workflow and the work of its simulations.

    ``folder``: of the results of a study. ``begun``: as of `failures`. Empty if nothing was
    simulated or measured. Without a comparison where some of the work was done before the workflow
    began, as after a resume. Simulation is what runs, and starts that take steps, say that they
    took; that Python starts, kernels compile and figures are drawn comes on top.
    """
    results = Results(glob.escape(str(folder)))
    simulated = _seconds(begun, results.run("*", "*", "*"), results.start("*", "*"))
    measured = _seconds(begun, results.measurement("*", "*"))  # each with all cores to itself
    if not simulated and not measured:
        return ""
    wall = time.time() - begun
    # One run has one core.
    ideal = max(sum(simulated) / cores, max(simulated, default=0.0)) + sum(measured)
    said = f"simulation {sum(simulated):.0f} s (runs and starts: {len(simulated)})"
    if measured:
        said += f", measurements {sum(measured):.0f} s on all cores"
    said += f", wall clock {wall:.0f} s on {cores} cores"
    if wall < ideal:
        return f"{said}: some of that was done before this workflow began"
    return f"{said}: {wall / ideal - 1:.0%} more than that alone"


def _seconds(begun, *patterns):
    """Of each file of some patterns that the workflow made, the seconds it says that it took.

    What took longer than there was time since it began was taken over from an earlier one.
    """
    paths = [Path(path) for pattern in patterns for path in glob.glob(pattern)]
    there = {path: path.stat().st_mtime - begun for path in paths}
    took = {path: attribute(path, "seconds") for path, since in there.items() if since >= 0}
    return [seconds for path, seconds in took.items() if seconds <= there[path]]


def library_versions() -> dict[str, str]:
    """Version of each library and of Python, by name."""
    return {name: version(name) for name in LIBRARIES} | {"Python": platform.python_version()}


def commit() -> str:
    """The commit that the sources stand on, with a mark if they were edited."""
    command = ["git", "describe", "--always", "--dirty"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown: git not found"
    return found.stdout.strip() or "not under version control"


def processor() -> str:
    """What the machine calls its processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
