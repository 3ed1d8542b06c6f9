"""What a workflow says at its end: what failed, and what made it."""

import atexit
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from dpd.digest import ROOT
from dpd.errors import FAILED

LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")
MOST = 20  # sentences that are shown


def failures(logs: str | Path, begun: float) -> list[str]:
    """Sentences of the jobs that failed in a workflow, each once and with its first log.

    ``logs``: folder of the logs of a study. ``begun``: when the workflow began, as `time.time` has
    it; older logs are not of its making.
    """
    found: dict[str, Path] = {}
    for path in sorted(Path(logs).rglob("*.log")):
        if path.stat().st_mtime >= begun:
            for line in path.read_text(errors="replace").splitlines():
                if line.startswith(FAILED):
                    found.setdefault(line, path)
    return [f"{line} ({path})" for line, path in found.items()]


def say_at_exit(logs: str | Path, begun: float) -> None:
    """Print the first `failures` last, below all that Snakemake has to say of them."""
    if lines := failures(logs, begun)[:MOST]:
        atexit.register(lambda: print("", *lines, sep="\n", file=sys.stderr))


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
