"""What a workflow cost beside the simulations that it is for."""

import glob
import time
from pathlib import Path

from dpd.files import attribute
from dpd.pipeline.paths import Results


def overhead(folder: str | Path, begun: float, cores: int) -> str:
    """One sentence on the wall clock of a workflow and the work of its simulations.

    Parameters
    ----------
    folder : path
        Of the results of a study.
    begun : float
        When the workflow began, as `time.time` has it; older files are not of its making.
    cores : int

    Returns
    -------
    str
        Empty if nothing was simulated or measured. Without a comparison where some of the work was
        done before the workflow began, as after a resume. Simulation is what runs, and starts that
        take steps, say that they took; that Python starts, kernels compile and figures are drawn
        comes on top.
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

    What took longer than there was time since the workflow began was taken over from an earlier
    one.
    """
    paths = [Path(path) for pattern in patterns for path in glob.glob(pattern)]
    there = {path: path.stat().st_mtime - begun for path in paths}
    took = {path: attribute(path, "seconds") for path, since in there.items() if since >= 0}
    return [seconds for path, seconds in took.items() if seconds <= there[path]]
