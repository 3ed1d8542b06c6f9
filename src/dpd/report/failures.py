"""What went wrong in a workflow: the sentences of its jobs, apart from what Snakemake says."""

import atexit
import sys
from pathlib import Path

from dpd.errors import FAILED

MOST = 20  # sentences that are shown


def failures(logs: str | Path, begun: float) -> list[str]:
    """Sentences of the jobs that failed in a workflow, each once and with its log.

    Parameters
    ----------
    logs : path
        Folder of the logs of a study.
    begun : float
        When the workflow began, as `time.time` has it; older logs are not of its making.

    Returns
    -------
    list of str
    """
    found: dict[str, dict[Path, None]] = {}
    for path in sorted(Path(logs).rglob("*.log")):
        if path.stat().st_mtime < begun:
            continue
        for line in path.read_text(errors="replace").splitlines():
            if line.startswith(FAILED):
                found.setdefault(line, {})[path] = None
    lines = [f"{line} ({_named(list(paths))})" for line, paths in found.items()]
    more = len(lines) - MOST
    return lines if more <= 0 else [*lines[:MOST], f"and {more} more in {logs}"]


def _named(paths):
    """The first of some logs, and how many others there are."""
    others = f" and {len(paths) - 1} other logs" if len(paths) > 1 else ""
    return f"{paths[0]}{others}"


def say_at_exit(logs: str | Path, begun: float) -> None:
    """Print the `failures` last, below all that Snakemake has to say of them."""
    lines = failures(logs, begun)
    if lines:
        atexit.register(lambda: print("", *lines, sep="\n", file=sys.stderr))
