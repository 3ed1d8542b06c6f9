"""What a workflow cost beside the simulations that it is for."""

import time
from pathlib import Path

from dpd.files import attribute

SIMULATED = ("runs/*/*/run.nc", "starts/*.nc")  # below the folder of a paper


def overhead(results, begun, cores):
    """One sentence on the wall clock of a workflow and the work of its simulations.

    Parameters
    ----------
    results : path
        Folder of a study.
    begun : float
        When the workflow began, as `time.time` has it; older files are not of its making.
    cores : int

    Returns
    -------
    str
        Empty if nothing was simulated. Simulation is what runs, and starts that take steps, say
        that they took; that Python starts, kernels compile and figures are drawn comes on top.
    """
    paths = [path for pattern in SIMULATED for path in Path(results).glob(f"*/{pattern}")]
    seconds = [attribute(path, "seconds") for path in paths if path.stat().st_mtime >= begun]
    if not seconds:
        return ""
    wall = time.time() - begun
    ideal = max(sum(seconds) / cores, max(seconds))  # one run has one core
    return (
        f"{len(seconds)} runs and starts: {sum(seconds):.0f} s of simulation, {wall:.0f} s of wall "
        f"clock on {cores} cores ({wall / ideal - 1:.0%} more than simulation alone)"
    )
