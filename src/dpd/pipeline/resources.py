"""What a job asks of a cluster: minutes, memory, and the batch in which it is submitted.

A cluster ends a job that takes more than it asked for. A run that is ended keeps a checkpoint, and
the next try asks for more; still it is cheaper to ask for enough. So a job asks for `GENEROUS`
times what is expected, in its second try for twice that, in its third for three times.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

# Bead-steps per second on one core: nine of ten runs of the study `quick` are faster, and the
# slowest of them, which follows displacements in many beads, has 1.1e6.
RATE = 3e6
GENEROUS = 3  # times what is expected
BEGINNING = 1.0  # minutes: Snakemake and Python start and read kernels, on a slow disk
BYTES_PER_BEAD = 312  # of a run, measured; with DPD-VV and a list 750, within what is GENEROUS
PROCESSES = 1000  # MB of a run without beads, 200 measured, and of the Snakemakes that start it
BATCHES = {"short": 1.0, "medium": 10.0}  # to the minutes that a run of it takes at most


def start_bead_steps(scene: Scene) -> int:
    """Work of a first configuration, as `dpd.scene.scene.Scene.work` has that of a run."""
    return scene.beads * (scene.relaxing + scene.start.work)


def minutes(bead_steps: float, attempt: int, longest: int) -> int:
    """Minutes of wall clock to ask for.

    Parameters
    ----------
    bead_steps : float
        The work, on one core.
    attempt : int
        The number of the try, from 1.
    longest : int
        What the cluster allows.

    Returns
    -------
    int
        At most ``longest``: a run that needs more goes on in its next try.
    """
    asked = math.ceil(BEGINNING + GENEROUS * _expected_minutes(bead_steps))
    return min(attempt * asked, longest)


def megabytes(beads: int, attempt: int) -> int:
    """MB of memory to ask for, `GENEROUS` times those of the beads.

    Parameters
    ----------
    beads, attempt : int
        The number of the try counts from 1.
    """
    return attempt * (PROCESSES + math.ceil(GENEROUS * BYTES_PER_BEAD * beads / 1e6))


def batch(bead_steps: float) -> str | None:
    """Name of the batch that takes such a job, of `BATCHES`; None for one that is long enough.

    Snakemake submits several jobs of one batch together, as many as the profile says.
    """
    expected = _expected_minutes(bead_steps)
    return next((name for name, most in BATCHES.items() if expected < most), None)


def _expected_minutes(bead_steps):
    return bead_steps / RATE / 60
