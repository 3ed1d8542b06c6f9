"""What made a report, an archive or a measurement: commit, versions of libraries, processor."""

import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

from dpd.digest import ROOT

LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")


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
